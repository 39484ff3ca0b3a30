// Big layers of small prims are read by several threads: what they hold, and every error, must be
// what one thread finds.

#include "layer_text.h"
#include "support/files.h"
#include "support/same_for_threads.h"

#include "base/hash.h"

enum {
    TEXT_BYTES = 4 << 20,
    PRIMS = 1000,  // of 250 bytes or so: enough to be divided
    EVERY_FILE = 8 // of the corpus; more add nothing but time
};

static Text begin(void)
{
    Text text = begin_text(TEXT_BYTES);
    add(&text, "#usda 1.0\n(\n    doc = \"\"\"a { brace\n}}\n\"\"\"\n)\n\n");
    return text;
}

static void add_prim(Text *text, const char *name, int number)
{
    add(text, "    def Sphere \"%s%d\" (\n        kind = \"component\"\n        customData = {\n",
        name, number);
    add(text, "            int id = %d\n        }\n    )\n    {\n", number);
    add(text, "        double radius = %d.5\n        float x.timeSamples = { 1: 2, 3: %d }\n",
        number, number % 9);
    add(text,
        "        rel binding = <../M%d>\n        def \"child\"\n        {\n        }\n    }\n",
        number % 7);
}

// Prims, the one of number `at` followed by something else.
static void add_prims(Text *text, int count, int at, const char *odd)
{
    for (int i = 0; i < count; i++) {
        add_prim(text, "p", i);
        if (i == at)
            add(text, "%s\n", odd);
    }
}

static void check(const Text *text, const CohortStageOptions *options)
{
    static const uint32_t threads[] = {2, 3, 8};
    for (size_t i = 0; i < sizeof threads / sizeof *threads; i++)
        assert_true(same_for_threads(text->text, text->length, options, threads[i]));
}

static bool is_read(const Text *text)
{
    CoLayer *layer = co_layer_parse("t.usda", text->text, text->length, NULL, NULL, NULL, NULL);
    co_layer_destroy(layer);
    return layer != NULL;
}

// ---- Good layers -------------------------------------------------------------------------------

static void prims_of_any_parent(void **state)
{
    (void)state;
    static const char *const before[] = {
        "",
        "def \"World\"\n{\n    int a = 1\n",
        "def \"World\" { def \"Geo\" { over \"x\" {\n",
        "def \"World\"\n{\n    variantSet \"v\" = {\n    \"a\" {\n",
    };
    static const char *const after[] = {"", "}\n", "}\n}\n}\n", "}\n\"b\" {}\n}\n}\n"};
    for (size_t i = 0; i < 4; i++) {
        Text text = begin();
        add(&text, "%s", before[i]);
        add_prims(&text, PRIMS, -1, "");
        add(&text, "%sover \"last\" {\n}", after[i]);
        assert_true(is_read(&text));
        check(&text, NULL);
        free(text.text);
    }
}

static void groups_of_all_sizes(void **state)
{
    (void)state;
    static const int sizes[] = {3, 40, 300, 2000, 5, 700, 20, 1};
    Text text = begin();
    add(&text, "def \"World\"\n{\n");
    for (int i = 0; i < 8; i++) {
        add(&text, "def \"group%d\"\n{\n", i);
        add_prims(&text, sizes[i], -1, "");
        add(&text, "    int after = 3\n}\n");
        add_prim(&text, "between", i);
    }
    add(&text, "}\n");
    assert_true(is_read(&text));
    check(&text, NULL);
    free(text.text);
}

static void any_layout(void **state)
{
    (void)state;
    Text text = begin();
    add(&text, "class \"World\"{\n");
    for (int i = 0; i < 6000; i++)
        add(&text,
            i % 5 ? "def \"p%d\"{int a=%d;int b=2;}\n" : "\tdef/**/ \"p%d\"\r\n{int a=%d;}\r\n", i,
            i);
    add(&text, "}\n");
    assert_true(is_read(&text));
    check(&text, NULL);
    free(text.text);
}

// Text that looks like prims and braces, where it says nothing.
static void what_stands_in_strings_and_comments(void **state)
{
    (void)state;
    static const char *const odd[] = {
        "    string s = \"}\"",
        "    string s = '{'",
        "    asset a = @{{@",
        "    asset a = @@@}}}@@@",
        "    # {{{",
        "    # }}}\n",
        "    /* } */",
        "    // {",
        "    string s = \"\"\"\n    def \"p5\"\n    {\n    }\n\"\"\"",
        "    string s = '''\n    }\n    def \"p5\"\n'''",
        "    /*\n    def \"p5\"\n    {\n    */",
        "    reorder nameChildren = [\"p3\", \"p2\"]",
        "    int plain = 3",
        "    variantSet \"v\" = { \"a\" { def \"p1\" {\n}\n} }",
        "",
    };
    static const int places[] = {0, 333, PRIMS - 1};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        Text text = begin();
        add(&text, "def \"World\"\n{\n");
        add_prims(&text, PRIMS, places[i % 3], odd[i]);
        add(&text, "}\n");
        assert_true(is_read(&text));
        check(&text, NULL);
        free(text.text);
    }
}

// ---- Bad layers --------------------------------------------------------------------------------

static void errors_are_found_in_their_place(void **state)
{
    (void)state;
    static const char *const odd[] = {
        "    }",
        "    {",
        "}\n}",
        "    def \"open\"\n    {",
        "    string s = \"open",
        "    string s = \"\"\"open",
        "    string s = '''open\n    def \"x\" {}",
        "    asset a = @open",
        "    /* open",
        "    int a = ",
        "    def \"p7\"\n    {\n    }",
        "    def \"p999\"\n    {\n    }",
        "    over \"1bad\" {}",
        "    def \"x\" {} def \"y\" {}",
        "    def",
        "    def \"x\" (",
        "    ;;;",
        "    rel r = </a//b>",
        "    int a = 1\n    float a = 2",
        "    )",
        "    \"\"\"",
        "    \x80",
    };
    static const int places[] = {0, 1, 470, PRIMS - 2, PRIMS - 1};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++)
        for (size_t j = 0; j < 2; j++) {
            Text text = begin();
            if (j)
                add(&text, "def \"World\"\n{\n");
            add_prims(&text, PRIMS, places[(2 * i + j) % 5], odd[i]);
            if (j)
                add(&text, "}\n");
            check(&text, NULL);
            free(text.text);
        }
}

static void many_errors_end_in_the_same_place(void **state)
{
    (void)state;
    for (int every = 3; every <= 400; every += 97) {
        Text text = begin();
        for (int i = 0; i < PRIMS; i++) {
            add_prim(&text, "p", i);
            if (i % every == 0)
                add_prim(&text, "p", i / 2);
        }
        check(&text, NULL);
        free(text.text);
    }
}

static void random_damage(void **state)
{
    (void)state;
    static const char marks[] = "{}\"'@#()[]<>/*\\\n; =d\x80";
    Text text = begin();
    add(&text, "def \"World\"\n{\n");
    add_prims(&text, PRIMS / 2, -1, "");
    add(&text, "}\n");
    add_prims(&text, PRIMS / 2, -1, "");
    char *good = malloc(text.length);
    assert_non_null(good);
    memcpy(good, text.text, text.length);
    for (uint64_t i = 0; i < 60; i++) {
        for (uint64_t j = 0; j <= i % 3; j++) {
            uint64_t random = co_hash64(i * 8 + j);
            text.text[random % text.length] = marks[(random >> 40) % (sizeof marks - 1)];
        }
        assert_true(same_for_threads(text.text, text.length, NULL, 2 + (uint32_t)(i % 3)));
        memcpy(text.text, good, text.length);
    }
    free(good);
    free(text.text);
}

static void limits_hold_in_their_place(void **state)
{
    (void)state;
    Text text = begin();
    add(&text, "def \"World\"\n{\n");
    add_prims(&text, PRIMS, 800, "    def \"a\" { def \"b\" { def \"c\" {\n}\n}\n}");
    add(&text, "}\n");
    for (uint64_t most = 1; most < 2 * PRIMS + 10; most = most * 2 + 1)
        check(&text, &(CohortStageOptions){.max_prims = most});
    for (uint64_t most = 2 * PRIMS; most < 2 * PRIMS + 8; most++)
        check(&text, &(CohortStageOptions){.max_prims = most});
    for (uint64_t most = 1; most < 7; most++)
        check(&text, &(CohortStageOptions){.max_depth = most});
    free(text.text);
}

static void failing_memory_is_reported(void **state)
{
    (void)state;
    Text text = begin();
    add_prims(&text, PRIMS, -1, "");
    const CohortStageOptions options = {.threads = 3};
    assert_true(is_read(&text)); // tokens stay for good
    size_t live = co_memory_live(CO_MEMORY_USDA);
    bool done = false;
    for (uint64_t n = 1; n < 1000 && !done; n++) {
        CohortError err = {0};
        co_memory_fail_after(n);
        CoLayer *layer =
            co_layer_parse("t.usda", text.text, text.length, &options, NULL, NULL, &err);
        co_memory_fail_after(0);
        done = layer != NULL;
        assert_int_equal(err.code, layer ? COHORT_OK : COHORT_ERROR_OUT_OF_MEMORY);
        co_layer_destroy(layer);
        assert_int_equal(co_memory_live(CO_MEMORY_USDA), live);
    }
    assert_true(done);
    free(text.text);
}

// ---- The corpus --------------------------------------------------------------------------------

// What stands behind the layer's metadata, as a prim's contents many times over.
static void check_file(const char *path)
{
    size_t size;
    char *all = test_read_file(path, &size);
    assert_non_null(all);
    assert_true(same_for_threads(all, size, NULL, 3));
    const char *body = strstr(all, "\ndef "), *over = strstr(all, "\nover ");
    body = body && (!over || body < over) ? body : over;
    Text text = begin();
    for (int i = 0; body && strlen(all) == size && text.length < 128 << 10; i++)
        add(&text, "def \"copy%d\"\n{\n%s\n}\n", i, body);
    assert_true(same_for_threads(text.text, text.length, NULL, 3));
    free(text.text);
    free(all);
}

// One of `every` files, and how many were met.
typedef struct Corpus {
    size_t every, met;
} Corpus;

static void check_some(void *context, const char *path)
{
    Corpus *corpus = context;
    struct stat info;
    if (strstr(strrchr(path, '/'), ".usd") && stat(path, &info) == 0 &&
        info.st_size < TEXT_BYTES / 4 && corpus->met++ % corpus->every == 0)
        check_file(path);
}

static void the_corpus_many_times_over(void **state)
{
    (void)state;
    Corpus own = {.every = 1}, shared = {.every = EVERY_FILE};
    test_each_file(COHORT_TEST_DATA_DIR, check_some, &own);
    assert_true(own.met > 10);
    test_each_file(COHORT_SHARED_DIR "/usd/corpus", check_some, &shared);
    print_message("%zu files\n", own.met + shared.met);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(prims_of_any_parent),
        cmocka_unit_test(groups_of_all_sizes),
        cmocka_unit_test(any_layout),
        cmocka_unit_test(what_stands_in_strings_and_comments),
        cmocka_unit_test(errors_are_found_in_their_place),
        cmocka_unit_test(many_errors_end_in_the_same_place),
        cmocka_unit_test(random_damage),
        cmocka_unit_test(limits_hold_in_their_place),
        cmocka_unit_test(failing_memory_is_reported),
        cmocka_unit_test(the_corpus_many_times_over),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
