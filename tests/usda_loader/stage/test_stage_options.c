// What the options of a stage leave out, bring in and put on top. Also tests population.c.

#include "usda_loader/stage/memory_files.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const MemoryFile shop[] = {
    {"/mem/shop.usda", "#usda 1.0\n"
                       "(\n timeCodesPerSecond = 24\n subLayers = [@./sub.usda@]\n"
                       " defaultPrim = \"World\"\n)\n"
                       "def \"World\"\n{\n"
                       " def \"A\" (payload = @./thing.usda@)\n {\n  def \"In\" (payload = "
                       "@./thing.usda@)\n  {\n  }\n }\n"
                       " def \"B\" (payload = @./thing.usda@)\n {\n }\n"
                       " def \"C\" (references = @parts/part.usda@)\n {\n }\n"
                       " double x = 1\n}\n"},
    {"/mem/sub.usda", "#usda 1.0\nover \"World\"\n{\n double x = 2\n double y = 2\n}\n"},
    {"/mem/thing.usda",
     "#usda 1.0\n(\n defaultPrim = \"T\"\n)\ndef \"T\"\n{\n def \"Leaf\"\n {\n }\n}\n"},
    {"/lib/parts/part.usda",
     "#usda 1.0\n(\n defaultPrim = \"P\"\n)\ndef \"P\"\n{\n def \"Leaf\"\n {\n }\n}\n"},
    {"/mem/session.usda",
     "#usda 1.0\n(\n metersPerUnit = 7\n defaultPrim = \"No\"\n timeCodesPerSecond = 48\n)\n"
     "over \"World\"\n{\n double x = 3\n}\n"},
};

static bool has(const CohortStage *stage, const char *path)
{
    return cohort_stage_prim(stage, path) != NULL;
}

static double number(const CohortStage *stage, const char *name)
{
    return cohort_prim_double(test_prim(stage, "/World"), name, COHORT_TIME_DEFAULT, -1);
}

static void layers_come_from_memory(void **state)
{
    (void)state;
    MemoryFiles files = FILES(shop);
    Reports reports = {0};
    CohortStage *stage = memory_stage(&files, NULL, &reports);
    assert_non_null(stage);
    assert_int_equal(files.opened, 3);
    assert_int_equal(files.released, 3);
    assert_true(has(stage, "/World/A/Leaf"));
    assert_true(has(stage, "/World/A/In/Leaf"));
    assert_true(number(stage, "x") == 1 && number(stage, "y") == 2);
    assert_true(test_was_reported(&reports, "/World/C", "part.usda"));
    cohort_stage_destroy(stage);
}

static void binary_bytes_are_refused_by_name(void **state)
{
    (void)state;
    static const MemoryFile crate[] = {{"/mem/a.usd", "PXR-USDC and so on"}};
    MemoryFiles files = FILES(crate);
    Reports reports = {0};
    assert_null(memory_stage(&files, NULL, &reports));
    assert_non_null(strstr(reports.text[0], "binary crate"));
    assert_int_equal(files.released, 1);
}

static void search_paths_find_what_lies_elsewhere(void **state)
{
    (void)state;
    static const char *const folders[] = {"/nowhere", "/lib"};
    MemoryFiles files = FILES(shop);
    CohortStageOptions options = {.search_paths = {folders, 2}};
    CohortStage *stage = memory_stage(&files, &options, NULL);
    assert_true(has(stage, "/World/C/Leaf"));
    cohort_stage_destroy(stage);
}

// What is looked for at all is looked for at the current folder too, before the search paths.
static void the_current_folder_is_searched(void **state)
{
    (void)state;
    static const char *const folders[] = {"/lib"};
    char here[4096], part[4200];
    assert_non_null(getcwd(here, sizeof here));
    snprintf(part, sizeof part, "%s/parts/part.usda", strcmp(here, "/") ? here : "");
    const MemoryFile found[] = {
        {"/mem/shop.usda", "#usda 1.0\n"
                           "def 'A' (references = @parts/part.usda@</P>) {\n}\n"
                           "def 'B' (references = @./parts/part.usda@</P>) {\n}\n"},
        {part, "#usda 1.0\ndef 'P' {\ndef 'Here' {\n}\n}\n"},
        {"/lib/parts/part.usda", "#usda 1.0\ndef 'P' {\ndef 'There' {\n}\n}\n"},
    };
    MemoryFiles files = FILES(found);
    CohortStageOptions options = {.search_paths = {folders, 1}};
    CohortStage *stage = memory_stage(&files, &options, NULL);
    assert_true(has(stage, "/A/Here"));
    assert_false(has(stage, "/A/There") || has(stage, "/B/Here"));
    cohort_stage_destroy(stage);
}

static void a_session_layer_is_the_strongest(void **state)
{
    (void)state;
    MemoryFiles files = FILES(shop);
    CohortStageOptions options = {.session = "/mem/session.usda"};
    CohortStage *stage = memory_stage(&files, &options, NULL);
    assert_true(number(stage, "x") == 3 && number(stage, "y") == 2);
    CohortStageInfo info;
    cohort_stage_info(stage, &info);
    assert_string_equal(info.default_prim, "World");
    assert_true(info.meters_per_unit == 7 && info.time_codes_per_second == 48);
    cohort_stage_destroy(stage);
    options.session = "/mem/absent.usda";
    assert_null(memory_stage(&files, &options, NULL));
}

static void muted_layers_say_nothing(void **state)
{
    (void)state;
    static const char *const muted[] = {"/mem/sub.usda", "/mem/thing.usda", "/mem/shop.usda",
                                        "/mem/absent.usda"};
    MemoryFiles files = FILES(shop);
    Reports reports = {0};
    CohortStageOptions options = {.muted = {muted, 4}};
    CohortStage *stage = memory_stage(&files, &options, &reports);
    assert_int_equal(files.opened, 1);
    assert_true(number(stage, "x") == 1 && number(stage, "y") == -1);
    assert_false(has(stage, "/World/A/Leaf"));
    assert_true(test_was_reported(&reports, "/World/A", "muted"));
    for (size_t i = 0; i < 5; i++) // the root layer is never muted
        assert_int_equal(cohort_stage_met_muted(stage, i), i < 2);
    cohort_stage_destroy(stage);
}

// As the root layer would name them, by search paths if need be.
static void muted_layers_are_looked_for_beside_the_root(void **state)
{
    (void)state;
    static const char *const muted[] = {"./sub.usda", "../mem/thing.usda", "parts/part.usda",
                                        "./parts/part.usda", "shop.usda"};
    static const char *const folders[] = {"/lib"};
    MemoryFiles files = FILES(shop);
    CohortStageOptions options = {.muted = {muted, 5}, .search_paths = {folders, 1}};
    CohortStage *stage = memory_stage(&files, &options, NULL);
    assert_int_equal(files.opened, 1);
    assert_true(number(stage, "x") == 1 && number(stage, "y") == -1);
    assert_false(has(stage, "/World/A/Leaf") || has(stage, "/World/C/Leaf"));
    for (size_t i = 0; i < 5; i++)
        assert_int_equal(cohort_stage_met_muted(stage, i), i < 3);
    cohort_stage_destroy(stage);
}

static void a_mask_keeps_what_leads_there(void **state)
{
    (void)state;
    static const char *const mask[] = {"/World/A/In"};
    MemoryFiles files = FILES(shop);
    CohortStageOptions options = {.mask = {mask, 1}};
    CohortStage *stage = memory_stage(&files, &options, NULL);
    assert_true(has(stage, "/World/A/In/Leaf"));
    assert_false(has(stage, "/World/A/Leaf"));
    assert_false(has(stage, "/World/B"));
    assert_int_equal(cohort_prim_child_count(test_prim(stage, "/World")), 1);
    assert_true(number(stage, "x") == 1);
    cohort_stage_destroy(stage);
    static const char *const wrong[] = {"World"};
    options.mask = (CohortPaths){wrong, 1};
    assert_null(memory_stage(&files, &options, NULL));
}

static void payloads_come_by_rule(void **state)
{
    (void)state;
    static const char *const in[] = {"/World/A/In"}, *const b[] = {"/World/B"};
    MemoryFiles files = FILES(shop);
    CohortStageOptions options = {.no_payloads = true};
    CohortStage *stage = memory_stage(&files, &options, NULL);
    assert_false(has(stage, "/World/A/Leaf"));
    cohort_stage_destroy(stage);
    options.loads = (CohortPaths){in, 1};
    stage = memory_stage(&files, &options, NULL);
    assert_true(has(stage, "/World/A/Leaf") && has(stage, "/World/A/In/Leaf"));
    assert_false(has(stage, "/World/B/Leaf"));
    cohort_stage_destroy(stage);
    options = (CohortStageOptions){.unloads = {b, 1}};
    stage = memory_stage(&files, &options, NULL);
    assert_true(has(stage, "/World/A/Leaf"));
    assert_false(has(stage, "/World/B/Leaf"));
    cohort_stage_destroy(stage);
}

static void payloads_of_instances_are_told_apart(void **state)
{
    (void)state;
    static const MemoryFile files_[] = {
        {"/mem/i.usda", "#usda 1.0\nclass \"Model\"\n{\n def \"P\" (payload = </Part>)\n {\n }\n}\n"
                        "class \"Part\"\n{\n def \"Leaf\"\n {\n }\n}\n"
                        "def \"A\" (instanceable = true\n inherits = </Model>)\n{\n}\n"
                        "def \"B\" (instanceable = true\n inherits = </Model>)\n{\n}\n"}};
    static const char *const unloads[] = {"/A/P"};
    MemoryFiles files = FILES(files_);
    CohortStageOptions options = {.unloads = {unloads, 1}};
    CohortStage *stage = memory_stage(&files, &options, NULL);
    assert_false(has(stage, "/A/P/Leaf"));
    assert_true(has(stage, "/B/P/Leaf"));
    cohort_stage_destroy(stage);
}

static void fallbacks_select_where_nothing_does(void **state)
{
    (void)state;
    static const MemoryFile sets[] = {
        {"/mem/v.usda",
         "#usda 1.0\n"
         "def \"Open\" (variants = {\n string v = \"\"\n}\n prepend variantSets = \"v\")\n{\n"
         " variantSet \"v\" = {\n \"a\" {\n int x = 1\n }\n \"b\" {\n int x = 2\n }\n }\n}\n"
         "def \"Said\" (variants = {\n string v = \"q\"\n}\n prepend variantSets = \"v\")\n{\n"
         " variantSet \"v\" = {\n \"a\" {\n int x = 1\n }\n \"b\" {\n int x = 2\n }\n }\n}\n"}};
    static const CohortVariantFallback fallbacks[] = {
        {"w", "a"}, {"v", "z"}, {"v", "b"}, {"v", "a"}};
    MemoryFiles files = FILES(sets);
    CohortStageOptions options = {.fallbacks = fallbacks, .fallback_count = 4};
    CohortStage *stage = memory_stage(&files, &options, NULL);
    const CohortPrim *open = test_prim(stage, "/Open"), *said = test_prim(stage, "/Said");
    assert_true(cohort_prim_double(open, "x", COHORT_TIME_DEFAULT, -1) == 2);
    assert_true(cohort_prim_double(said, "x", COHORT_TIME_DEFAULT, -1) == -1);
    cohort_stage_destroy(stage);
}

// Whose flag goes up at the n-th thing that the opener is asked for or told of.
typedef struct Impatience {
    MemoryFiles files;
    volatile int stop;
    int patience;
} Impatience;

static void wait_less(Impatience *host)
{
    host->stop = host->patience-- <= 0;
}

static bool impatient_open(void *cookie, const char *path, CohortBytes *out)
{
    Impatience *host = cookie;
    wait_less(host);
    return memory_open(&host->files, path, out);
}

static void impatient_release(void *cookie, const CohortBytes *bytes)
{
    Impatience *host = cookie;
    wait_less(host);
    memory_release(&host->files, bytes);
}

static void a_stop_ends_the_opening_wherever_it_is(void **state)
{
    (void)state;
    int ended = 0, patience = 0;
    for (bool done = false; !done; patience++) {
        Impatience host = {.files = FILES(shop), .stop = patience == 0, .patience = patience};
        Reports reports = {0};
        CohortError err = {0};
        CohortStageOptions options = {.open = impatient_open,
                                      .release = impatient_release,
                                      .open_cookie = &host,
                                      .threads = 1,
                                      .stop = &host.stop,
                                      .report = test_report,
                                      .cookie = &reports};
        CohortStage *stage = cohort_stage_open(shop[0].path, &options, &err);
        assert_int_equal(host.files.opened, host.files.released);
        done = !host.stop;
        ended += !stage;
        assert_int_equal(err.code, stage ? COHORT_OK : COHORT_ERROR_CANCELLED);
        for (int i = 0; i < reports.count; i++) // of what is missing, never of the stop
            assert_null(strstr(reports.text[i], "stopped"));
        if (stage)
            cohort_stage_destroy(stage);
    }
    assert_true(ended >= 4); // in each of the layers
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layers_come_from_memory),
        cmocka_unit_test(binary_bytes_are_refused_by_name),
        cmocka_unit_test(search_paths_find_what_lies_elsewhere),
        cmocka_unit_test(the_current_folder_is_searched),
        cmocka_unit_test(a_session_layer_is_the_strongest),
        cmocka_unit_test(muted_layers_say_nothing),
        cmocka_unit_test(muted_layers_are_looked_for_beside_the_root),
        cmocka_unit_test(a_mask_keeps_what_leads_there),
        cmocka_unit_test(payloads_come_by_rule),
        cmocka_unit_test(payloads_of_instances_are_told_apart),
        cmocka_unit_test(fallbacks_select_where_nothing_does),
        cmocka_unit_test(a_stop_ends_the_opening_wherever_it_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
