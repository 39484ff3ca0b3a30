// Rules of composition that show only where arcs meet: each as usd-core 26.11 answers. Also
// tests index_check.c and index_map.c.

#include "usda_loader/stage/memory_files.h"

static CohortStage *open_layers(const MemoryFile *layers, size_t count)
{
    MemoryFiles files = {.items = layers, .count = count};
    CohortStage *stage = memory_stage(&files, NULL, NULL);
    assert_non_null(stage);
    return stage;
}

#define OPEN(list) open_layers(list, sizeof list / sizeof *list)

static void assert_first_sample(const CohortStage *stage, const char *prim, double time)
{
    const double *times;
    assert_int_equal(cohort_prim_time_samples(test_prim(stage, prim), "d", &times), 1);
    assert_true(times[0] == time);
}

// Only an arc that leads to another stack starts from the times of the layer that says it.
static void internal_arcs_are_in_the_times_of_the_stack(void **state)
{
    (void)state;
    static const MemoryFile layers[] = {
        {"/mem/root.usda", "#usda 1.0\n(\n subLayers = [@./s.usda@ (offset = 100; scale = 3)]\n)\n"
                           "def \"C\"\n{\n double d.timeSamples = { 1: 1 }\n}\n"},
        {"/mem/s.usda",
         "#usda 1.0\n"
         "def \"I\" (\n references = </C> (offset = 10; scale = 2)\n)\n{\n}\n"
         "def \"J\" (\n payload = </K> (offset = 10; scale = 2)\n)\n{\n}\n"
         "def \"K\"\n{\n double d.timeSamples = { 1: 1 }\n}\n"
         "def \"X\" (\n references = @./x.usda@</C> (offset = 10; scale = 2)\n)\n{\n}\n"},
        {"/mem/x.usda", "#usda 1.0\ndef \"C\"\n{\n double d.timeSamples = { 1: 1 }\n}\n"},
    };
    CohortStage *stage = OPEN(layers);
    assert_first_sample(stage, "/I", 12);
    assert_first_sample(stage, "/J", 216);
    assert_first_sample(stage, "/X", 136);
    cohort_stage_destroy(stage);
}

// The stage's own stack has a session, even an empty one: what is referred to by path has none.
static void the_root_layer_by_its_path_is_another_stack(void **state)
{
    (void)state;
    static const MemoryFile layers[] = {
        {"/mem/root.usda",
         "#usda 1.0\n"
         "def \"A\"\n{\n def \"B\" (\n  references = @./l.usda@</B>\n )\n {\n }\n}\n"},
        {"/mem/l.usda", "#usda 1.0\ndef \"B\" (\n references = @./root.usda@</A>\n)\n{\n}\n"},
    };
    CohortStage *stage = OPEN(layers);
    test_prim(stage, "/A/B/B");
    assert_null(cohort_stage_prim(stage, "/A/B/B/B"));
    cohort_stage_destroy(stage);
}

// </X> of the asset is not the scene's </X>, which is what the asset's </P> has become.
static void a_class_is_not_implied_where_its_name_is_taken(void **state)
{
    (void)state;
    static const MemoryFile layers[] = {
        {"/mem/root.usda", "#usda 1.0\n"
                           "def \"X\" (\n references = @./l.usda@</P>\n)\n{\n}\n"
                           "def \"Y\" (\n references = @./l.usda@</P>\n)\n{\n}\n"
                           "class \"P\"\n{\n def \"FromP\"\n {\n }\n}\n"},
        {"/mem/l.usda", "#usda 1.0\n"
                        "def \"P\" (\n references = </D>\n)\n{\n}\n"
                        "def \"D\" (\n inherits = </X>\n)\n{\n}\n"
                        "class \"X\"\n{\n def \"FromX\"\n {\n }\n}\n"},
    };
    CohortStage *stage = OPEN(layers);
    test_prim(stage, "/X/FromX");
    assert_null(cohort_stage_prim(stage, "/X/FromP"));
    test_prim(stage, "/Y/FromX");
    cohort_stage_destroy(stage);
}

// A layer that says nothing of a prim moves nothing below it, unless the arc to it is right there.
static void relocates_reach_as_far_as_their_layer_speaks(void **state)
{
    (void)state;
    static const MemoryFile layers[] = {
        {"/mem/root.usda", "#usda 1.0\n"
                           "def \"A\" (\n references = @./l.usda@</A>\n)\n"
                           "{\n def \"B\"\n {\n  def \"C\"\n  {\n  }\n }\n def \"D\"\n {\n }\n}\n"},
        {"/mem/l.usda",
         "#usda 1.0\n(\n relocates = {\n  </A/B/C>: </A/B/N>,\n  </A/D>: </A/E>\n }\n)\n"},
    };
    CohortStage *stage = OPEN(layers);
    test_prim(stage, "/A/B/C");
    assert_null(cohort_stage_prim(stage, "/A/B/N"));
    assert_null(cohort_stage_prim(stage, "/A/D"));
    cohort_stage_destroy(stage);
}

// An instance ignores what is said of its descendants, also when an arc leads there; unless all it
// brings in comes by way of an ancestor of what its own arc leads to.
static void arcs_into_instances_see_their_overs_or_not(void **state)
{
    (void)state;
    static const MemoryFile layers[] = {
        {"/mem/root.usda", "#usda 1.0\n"
                           "def \"I\" (\n instanceable = true\n references = </R>\n)\n"
                           "{\n over \"x\"\n {\n  string u = \"over\"\n }\n}\n"
                           "def \"J\" (\n instanceable = true\n references = </Q/R>\n)\n"
                           "{\n over \"x\"\n {\n  string u = \"over\"\n }\n}\n"
                           "def \"Q\" (\n references = @./p.usda@</P>\n)\n{\n}\n"
                           "class \"R\"\n{\n def \"x\"\n {\n }\n}\n"
                           "def \"ToI\" (\n references = </I/x>\n)\n{\n}\n"
                           "def \"ToJ\" (\n references = </J/x>\n)\n{\n}\n"},
        {"/mem/p.usda", "#usda 1.0\ndef \"P\"\n{\n def \"R\"\n {\n  def \"x\"\n  {\n  }\n }\n}\n"},
    };
    CohortStage *stage = OPEN(layers);
    assert_true(cohort_prim_is_instance(test_prim(stage, "/I")));
    assert_true(cohort_prim_is_instance(test_prim(stage, "/J")));
    test_text(stage, "/I/x", "u", "<none>");
    test_text(stage, "/J/x", "u", "<none>");
    test_text(stage, "/ToI", "u", "<none>");
    test_text(stage, "/ToJ", "u", "over");
    cohort_stage_destroy(stage);
}

// Maps are exact only from arc to arc where relocates take part: </_B> is not </_A>'s own name.
static void targets_of_heirs_keep_names_that_are_free_again(void **state)
{
    (void)state;
    static const MemoryFile layers[] = {
        {"/mem/root.usda", "#usda 1.0\n"
                           "class \"_A\" (\n references = </T>\n)\n{\n}\n"
                           "def \"T\"\n{\n append rel r = </_A>\n}\n"
                           "class \"_B\" (\n specializes = </_A>\n)\n{\n}\n"},
    };
    CohortStage *stage = OPEN(layers);
    const char *const *targets;
    assert_int_equal(cohort_prim_targets(test_prim(stage, "/_A"), "r", &targets), 0);
    assert_int_equal(cohort_prim_targets(test_prim(stage, "/_B"), "r", &targets), 1);
    assert_string_equal(targets[0], "/_A");
    cohort_stage_destroy(stage);
}

// What a specialize brings in does not meet the arcs that led to it: </B> is no circle there.
static void specializes_stand_by_themselves(void **state)
{
    (void)state;
    static const MemoryFile layers[] = {
        {"/mem/root.usda",
         "#usda 1.0\n"
         "over \"C\" (\n variants = { string w = \"x\" }\n prepend variantSets = \"w\"\n)\n"
         "{\n variantSet \"w\" = {\n  \"x\" {\n   def Mesh \"B\"\n   {\n   }\n  }\n }\n}\n"
         "def \"A\" (\n payload = </B>\n)\n{\n}\n"
         "over \"D\"\n{\n over \"B\" (\n  variants = { string v = \"x\" }\n"
         "  prepend variantSets = \"v\"\n )\n {\n  variantSet \"v\" = {\n"
         "   \"x\" (\n    payload = [</B>, </A>]\n   ) {\n   }\n  }\n }\n}\n"
         "def Xform \"B\" (\n references = @./l.usda@</A>\n)\n{\n}\n"},
        {"/mem/l.usda", "#usda 1.0\ndef \"A\" (\n specializes = [</D>, </C>]\n)\n{\n}\n"},
    };
    CohortStage *stage = OPEN(layers);
    assert_string_equal(cohort_prim_type(test_prim(stage, "/A/B")), "Xform");
    test_prim(stage, "/A/B/B");
    cohort_stage_destroy(stage);
}

// Of specializes, that below a stronger arc is stronger than the prim's own.
static void specializes_below_references_come_first(void **state)
{
    (void)state;
    static const MemoryFile layers[] = {
        {"/mem/root.usda", "#usda 1.0\n"
                           "def \"B\"\n{\n string t = \"own\"\n}\n"
                           "def \"C\" (\n references = @./l.usda@</A>\n"
                           " specializes = </O>\n)\n{\n}\n"
                           "def \"O\"\n{\n string t = \"other\"\n}\n"},
        {"/mem/l.usda", "#usda 1.0\n"
                        "def \"A\" (\n specializes = </B>\n)\n{\n}\n"
                        "def \"B\"\n{\n string t = \"far\"\n string u = \"far\"\n}\n"},
    };
    CohortStage *stage = OPEN(layers);
    test_text(stage, "/C", "t", "own");
    test_text(stage, "/C", "u", "far");
    cohort_stage_destroy(stage);
}

// A class that is specialized makes a class of what only says over; one that is inherited does not.
static void specialized_classes_are_classes(void **state)
{
    (void)state;
    static const MemoryFile layers[] = {
        {"/mem/root.usda", "#usda 1.0\n"
                           "def \"A\"\n{\n}\n"
                           "class \"_C\" (\n references = </A>\n)\n{\n}\n"
                           "over \"S\" (\n specializes = </_C>\n)\n{\n}\n"
                           "over \"I\" (\n inherits = </_C>\n)\n{\n}\n"},
    };
    CohortStage *stage = OPEN(layers);
    assert_int_equal(cohort_prim_specifier(test_prim(stage, "/S")), COHORT_SPECIFIER_CLASS);
    assert_int_equal(cohort_prim_specifier(test_prim(stage, "/I")), COHORT_SPECIFIER_DEF);
    cohort_stage_destroy(stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(internal_arcs_are_in_the_times_of_the_stack),
        cmocka_unit_test(the_root_layer_by_its_path_is_another_stack),
        cmocka_unit_test(a_class_is_not_implied_where_its_name_is_taken),
        cmocka_unit_test(relocates_reach_as_far_as_their_layer_speaks),
        cmocka_unit_test(arcs_into_instances_see_their_overs_or_not),
        cmocka_unit_test(targets_of_heirs_keep_names_that_are_free_again),
        cmocka_unit_test(specializes_stand_by_themselves),
        cmocka_unit_test(specializes_below_references_come_first),
        cmocka_unit_test(specialized_classes_are_classes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
