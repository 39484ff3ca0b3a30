// Where the prims beside one begin, as far as braces tell.

#include "layer_text.h"
#include "parse/siblings.h"

#include "base/parallel.h"

#include <string.h>

enum {
    TEXT_BYTES = 1 << 20
};

// Prims of about 1 KB with a child each.
static void add_prims(Text *text, int count, const char *more)
{
    for (int i = 0; i < count; i++)
        add(text,
            "    def Xform \"p%d\"\n    {\n%s        def \"child\"\n        {\n%900s\n        }\n  "
            "  }\n",
            i, more, "");
}

static CoCuts find(const Text *text, const char *from, uint32_t threads)
{
    CoCuts cuts = {0};
    co_worker_count_set(threads);
    const char *at = strstr(text->text, from);
    assert_non_null(at);
    assert_true(co_cuts_find(&cuts, (CoCut){at, 10}, text->text + text->length));
    co_worker_count_set(0);
    return cuts;
}

static void clear(Text *text, CoCuts *cuts)
{
    co_free(CO_MEMORY_USDA, cuts->cuts, cuts->capacity * sizeof *cuts->cuts);
    free(text->text);
}

// Each is a prim at the depth of the first, on the line it says.
static void assert_siblings(const Text *text, const CoCuts *cuts, const char *prefix)
{
    for (size_t i = 0; i < cuts->count; i++) {
        uint32_t line = 10;
        for (const char *at = cuts->cuts[0].at; at < cuts->cuts[i].at; at++)
            line += *at == '\n';
        assert_int_equal(cuts->cuts[i].line, line);
        assert_memory_equal(cuts->cuts[i].at, prefix, strlen(prefix));
        assert_true(!i || cuts->cuts[i].at > cuts->cuts[i - 1].at);
        assert_true(cuts->cuts[i].at < text->text + text->length);
    }
}

static void siblings_are_found(void **state)
{
    (void)state;
    for (uint32_t threads = 1; threads <= 3; threads++) {
        Text text = begin_text(TEXT_BYTES);
        add_prims(&text, 500, "");
        CoCuts cuts = find(&text, "def", threads);
        assert_true(cuts.count >= text.length / CO_CUT_BYTES);
        assert_true(cuts.count <= text.length / CO_CUT_BYTES + 2);
        assert_siblings(&text, &cuts, "def Xform \"p");
        assert_false(cuts.is_closed);
        assert_ptr_equal(cuts.looked, text.text + text.length);
        clear(&text, &cuts);
    }
}

static void the_search_ends_with_the_parent(void **state)
{
    (void)state;
    Text text = begin_text(TEXT_BYTES);
    add_prims(&text, 60, "");
    const size_t closing = text.length;
    add(&text, "}\ndef \"other\"\n{\n");
    add_prims(&text, 60, "");
    CoCuts cuts = find(&text, "def", 2);
    assert_true(cuts.is_closed);
    assert_ptr_equal(cuts.looked, text.text + closing);
    assert_true(cuts.count >= 3);
    assert_true(cuts.cuts[cuts.count - 1].at < cuts.looked);
    assert_siblings(&text, &cuts, "def Xform \"p");
    clear(&text, &cuts);
}

static void one_that_holds_all_has_none_beside_it(void **state)
{
    (void)state;
    Text text = begin_text(TEXT_BYTES);
    add(&text, "def \"World\"\n{\n");
    add_prims(&text, 100, "");
    CoCuts cuts = find(&text, "def", 2);
    assert_int_equal(cuts.count, 1);
    clear(&text, &cuts);
    text = begin_text(TEXT_BYTES);
    add(&text, "def \"World\"\n{\n");
    add_prims(&text, 100, "");
    cuts = find(&text, "def Xform", 2);
    assert_true(cuts.count > 4);
    assert_siblings(&text, &cuts, "def Xform \"p");
    clear(&text, &cuts);
}

static void balanced_braces_in_strings_do_not_matter(void **state)
{
    (void)state;
    Text text = begin_text(TEXT_BYTES);
    add_prims(&text, 100, "        string s = \"{0} {\" # }\n        asset a = @{x}@\n");
    CoCuts cuts = find(&text, "def", 2);
    assert_true(cuts.count > 4);
    assert_siblings(&text, &cuts, "def Xform \"p");
    clear(&text, &cuts);
}

static void words_that_begin_like_prims_are_none(void **state)
{
    (void)state;
    Text text = begin_text(TEXT_BYTES);
    add(&text, "over \"first\" {}\n");
    for (int i = 0; i < 2000; i++)
        add(&text, "default x%d\n  over%d x\n class\n\n", i, i);
    add(&text, "\t class C \"last\" {}\n");
    for (int i = 0; i < 2000; i++)
        add(&text, "int a%d = 1\n", i);
    add(&text, "def");
    CoCuts cuts = find(&text, "over", 2);
    assert_int_equal(cuts.count, 2);
    assert_memory_equal(cuts.cuts[1].at, "class C \"last\"", 14);
    clear(&text, &cuts);
}

static void failing_memory_is_said(void **state)
{
    (void)state;
    Text text = begin_text(TEXT_BYTES);
    add_prims(&text, 50, "");
    for (uint64_t n = 1; n <= 2; n++) {
        CoCuts cuts = {0};
        co_memory_fail_after(n);
        assert_false(co_cuts_find(&cuts, (CoCut){text.text + 4, 1}, text.text + text.length));
        co_memory_fail_after(0);
        assert_null(cuts.cuts);
    }
    free(text.text);
    assert_int_equal(co_memory_live(CO_MEMORY_USDA), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(siblings_are_found),
        cmocka_unit_test(the_search_ends_with_the_parent),
        cmocka_unit_test(one_that_holds_all_has_none_beside_it),
        cmocka_unit_test(balanced_braces_in_strings_do_not_matter),
        cmocka_unit_test(words_that_begin_like_prims_are_none),
        cmocka_unit_test(failing_memory_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
