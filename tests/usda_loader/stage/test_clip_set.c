// Which clips metadata makes a set, and what is said of that which does not.

#include "usda_loader/stage/memory_files.h"

static void malformed_sets_are_named_and_left_out(void **state)
{
    (void)state;
    static const char *const said[][2] = {
        {"/NoPath|", "no absolute primPath"},
        {"/NoFiles|", "names no files"},
        {"/NoActive|", "which clip is active"},
        {"/BadIndex|", "has no file"},
        {"/NaNTime|", "not finite"},
        {"/Missing|", "none.usda"},
        {"/NoHash|", "no run of #"},
        {"/TooMany|", "too many clips"},
        {"/NoMatch|", "matches no file"},
        {"/NoStride|", "makes no sense"},
    };
    Reports reports = {0};
    CohortStage *stage = test_open("clip_faults.usda", &reports);
    for (size_t i = 0; i < sizeof said / sizeof *said; i++) {
        if (!test_was_reported(&reports, said[i][0], said[i][1]))
            print_error("%s %s\n", said[i][0], said[i][1]);
        assert_true(test_was_reported(&reports, said[i][0], said[i][1]));
    }
    // What the attribute says itself still stands.
    assert_true(cohort_prim_double(test_prim(stage, "/NoFiles"), "a", 1, 0) == 5);
    cohort_stage_destroy(stage);
}

static void sound_sets_are_silent_and_their_layers_counted(void **state)
{
    (void)state;
    Reports reports = {0};
    CohortStage *stage = test_open("clip_sets.usda", &reports);
    assert_int_equal(reports.count, 0);
    CohortStageInfo info;
    cohort_stage_info(stage, &info);
    assert_int_equal(info.layer_count, 6); // the root, one, two, the manifest, two parts
    cohort_stage_destroy(stage);
}

static void strict_opening_refuses_a_malformed_set(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortStageOptions options = {.strict = true};
    assert_null(cohort_stage_open(DATA "clip_faults.usda", &options, &err));
    assert_non_null(strstr(err.message, "clip"));
}

#define CLIP(name, value) \
    { \
        "/mem/" name ".usda", \
            "#usda 1.0\ndef \"A\"\n{\n float x.timeSamples = {0: " value "}\n}\n" \
    }
#define SET(name) \
    "dictionary " name " = {\n double2[] active = [(0, 0)]\n asset[] assetPaths = [@./" name \
    ".usda@]\n asset manifestAssetPath = @./manifest.usda@\n string primPath = \"/A\"\n}\n"

// Which of the clip sets c1, c2, c3 comes first; 0: none.
static int first_set(const char *weak, const char *strong)
{
    char below[2048], above[512];
    snprintf(below, sizeof below,
             "#usda 1.0\ndef \"A\" (\nclips = {\n" SET("c1") SET("c2")
                 SET("c3") "}\n%s)\n{\n float x\n}\n",
             weak);
    snprintf(above, sizeof above,
             "#usda 1.0\n(subLayers = [@./weak.usda@])\nover \"A\" (\n%s)\n{\n}\n", strong);
    const MemoryFile list[] = {
        {"/mem/strong.usda", above},
        {"/mem/weak.usda", below},
        CLIP("c1", "1"),
        CLIP("c2", "2"),
        CLIP("c3", "3"),
        {"/mem/manifest.usda", "#usda 1.0\ndef \"A\"\n{\n float x\n}\n"},
    };
    MemoryFiles files = FILES(list);
    CohortStage *stage = memory_stage(&files, NULL, NULL);
    assert_non_null(stage);
    double value = cohort_prim_double(test_prim(stage, "/A"), "x", 0, 0);
    cohort_stage_destroy(stage);
    return (int)value;
}

// The figures are the reference's.
static void clip_sets_are_edited_over_all_layers(void **state)
{
    (void)state;
    static const struct {
        const char *weak, *strong;
        int first;
    } cases[] = {
        {"", "", 1},
        {"clipSets = [\"c2\"]\n", "", 2},
        {"clipSets = []\n", "", 0},
        {"prepend clipSets = [\"c2\"]\n", "", 2},
        {"append clipSets = [\"c2\"]\n", "", 1},
        {"delete clipSets = [\"c1\"]\n", "", 2},
        {"prepend clipSets = [\"unknown\"]\n", "", 1},
        {"prepend clipSets = [\"c2\", \"c3\"]\n", "delete clipSets = [\"c2\"]\n", 3},
        {"clipSets = [\"c1\", \"c2\", \"c3\"]\n", "delete clipSets = [\"c1\"]\n", 2},
        {"clipSets = [\"c2\"]\n", "prepend clipSets = [\"c3\"]\n", 3},
        {"clipSets = [\"c2\"]\n", "append clipSets = [\"c3\"]\n", 2},
        {"prepend clipSets = [\"c2\"]\n", "append clipSets = [\"c2\"]\n", 1},
        {"delete clipSets = [\"c1\"]\n", "delete clipSets = [\"c2\"]\n", 3},
        {"", "prepend clipSets = [\"c3\"]\n", 3},
        {"clipSets = [\"c2\"]\n", "clipSets = None\n", 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int first = first_set(cases[i].weak, cases[i].strong);
        if (first != cases[i].first)
            print_error("%s%s: %d\n", cases[i].weak, cases[i].strong, first);
        assert_int_equal(first, cases[i].first);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(malformed_sets_are_named_and_left_out),
        cmocka_unit_test(sound_sets_are_silent_and_their_layers_counted),
        cmocka_unit_test(strict_opening_refuses_a_malformed_set),
        cmocka_unit_test(clip_sets_are_edited_over_all_layers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
