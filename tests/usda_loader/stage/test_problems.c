// What composition goes on without is told by kind, with the arc that caused it.

#include "usda_loader/stage/memory_files.h"

static const MemoryFile layers[] = {
    {"/mem/root.usda",
     "#usda 1.0\n(\n subLayers = [@./gone.usda@, @./loop.usda@ (scale = -1), @`${X}`@]\n"
     " relocates = {\n  </A>: </B/C>,\n  </M/P>: </M/Q>,\n  </M/Q>: </M/R>,\n"
     "  </N/P>: </N/S>,\n  </N/Q>: </N/S>,\n  </R/Kid>: </R/Moved>\n }\n)\n"
     "def \"A\" (\n references = [@./none.usda@</X>, </Nowhere>]\n)\n{\n}\n"
     "def \"Loop\" (\n inherits = </Loop/Kid>\n)\n{\n}\n"
     "def \"O\" (\n references = </Class> (scale = 0)\n payload = @./muted.usda@\n)\n{\n}\n"
     "def \"R\" (\n references = </Class>\n)\n{\n over \"Kid\"\n {\n }\n}\n"
     "def \"V\" (\n clips = { dictionary default = { string primPath = \"/V\" } }\n)\n{\n}\n"
     "class \"Class\"\n{\n def \"Kid\"\n {\n }\n}\n"},
    {"/mem/loop.usda", "#usda 1.0\n(\n subLayers = [@./root.usda@]\n)\n"},
    {"/mem/muted.usda", "#usda 1.0\n"},
};

static void every_kind_has_its_place(void **state)
{
    (void)state;
    static const char *const muted[] = {"/mem/muted.usda"};
    static const struct {
        CohortProblemKind kind;
        const char *prim, *part;
    } wanted[] = {
        {COHORT_PROBLEM_ARC_CYCLE, "/Loop", "</Loop/Kid>"},
        {COHORT_PROBLEM_UNRESOLVED_PRIM_PATH, "/A", "</Nowhere>"},
        {COHORT_PROBLEM_INVALID_ASSET_PATH, "/A", "@./none.usda@</X>"},
        {COHORT_PROBLEM_MUTED_ASSET_PATH, "/O", "muted.usda"},
        {COHORT_PROBLEM_INVALID_REFERENCE_OFFSET, "/O", "offset"},
        {COHORT_PROBLEM_INVALID_SUBLAYER_OFFSET, "", "loop.usda"},
        {COHORT_PROBLEM_INVALID_SUBLAYER_PATH, "", "gone.usda"},
        {COHORT_PROBLEM_SUBLAYER_CYCLE, "", "root.usda"},
        {COHORT_PROBLEM_INVALID_RELOCATE, "/A", "root prim"},
        {COHORT_PROBLEM_CONFLICTING_RELOCATE, "/M/P", "</M/Q>"},
        {COHORT_PROBLEM_SAME_TARGET_RELOCATES, "/N/P", "</N/Q>"},
        {COHORT_PROBLEM_OPINION_AT_RELOCATION_SOURCE, "/R/Moved", "relocate"},
        {COHORT_PROBLEM_VARIABLE_EXPRESSION, "", "${X}"},
        {COHORT_PROBLEM_CLIPS, "/V", "clip set"},
    };
    MemoryFiles files = FILES(layers);
    CohortStageOptions options = {.muted = {muted, 1}};
    CohortStage *stage = memory_stage(&files, &options, NULL);
    assert_non_null(stage);
    size_t count = cohort_stage_problem_count(stage);
    for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++) {
        bool found = false;
        for (size_t i = 0; i < count && !found; i++) {
            CohortProblem problem;
            assert_true(cohort_stage_problem(stage, i, &problem));
            found = problem.kind == wanted[k].kind && !strcmp(problem.prim, wanted[k].prim) &&
                    strstr(problem.text, wanted[k].part) && problem.line > 0 && *problem.layer;
        }
        if (!found)
            print_error("no problem of kind %d at <%s>\n", (int)wanted[k].kind, wanted[k].prim);
        assert_true(found);
    }
    CohortProblem beyond;
    assert_false(cohort_stage_problem(stage, count, &beyond));
    cohort_stage_destroy(stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_kind_has_its_place)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
