// Each arc, and all of them against each other. Also tests arc_inherit.c, arc_reference.c,
// arc_relocate.c, arc_variant.c, composer.c, graph.c, index_task.c, prim_index.c and site.c.

#include "usda_loader/stage/usda_stage_fixture.h"

#include <stdlib.h>
#include <unistd.h>

static void strength_is_liverps(void **state)
{
    (void)state;
    Reports reports = {0};
    CohortStage *stage = test_open("liverps.usda", &reports);
    test_text(stage, "/P", "a0", "local");
    test_text(stage, "/P", "a1", "sublayer");
    test_text(stage, "/P", "a2", "inherit");
    test_text(stage, "/P", "a3", "variant");
    test_text(stage, "/P", "a4", "reference");
    test_text(stage, "/P", "a5", "payload");
    test_text(stage, "/P", "a6", "specialize");
    assert_string_equal(cohort_prim_type(test_prim(stage, "/P")), "Xform");
    test_prim(stage, "/P/Child");
    test_prim(stage, "/P/FromPayload");
    assert_int_equal(reports.count, 0);
    cohort_stage_destroy(stage);
}

static void payloads_can_stay_out(void **state)
{
    (void)state;
    CohortStageOptions options = {.no_payloads = true};
    CohortStage *stage = cohort_stage_open(DATA "liverps.usda", &options, NULL);
    assert_non_null(stage);
    assert_null(cohort_stage_prim(stage, "/P/FromPayload"));
    test_text(stage, "/P", "a5", "specialize");
    cohort_stage_destroy(stage);
}

static void classes_are_implied_across_references(void **state)
{
    (void)state;
    CohortStage *stage = test_open("implied.usda", NULL);
    test_text(stage, "/Forest/T", "tone", "scene");
    test_text(stage, "/Forest/T", "bark", "asset");
    // A specialized class, even the scene's own, is weaker than what the asset says.
    test_text(stage, "/Forest/T", "grain", "oak");
    cohort_stage_destroy(stage);
}

static void variants_nest_and_stronger_selections_win(void **state)
{
    (void)state;
    CohortStage *stage = test_open("variants.usda", NULL);
    const CohortPrim *car = test_prim(stage, "/Car");
    assert_string_equal(cohort_prim_type(test_prim(stage, "/Car/Body")), "Sphere");
    test_text(stage, "/Car", "paint", "red"); // selected by the variant of the other set
    assert_string_equal(cohort_prim_variant_selection(car, "shape"), "round");
    assert_string_equal(cohort_prim_variant_selection(car, "trim"), "");
    assert_int_equal(cohort_prim_variant_count(car, "shape"), 2);
    assert_string_equal(cohort_prim_variant(car, "shape", 1), "square");
    assert_null(cohort_prim_variant(car, "shape", 2));
    assert_int_equal(cohort_prim_variant_set_count(car), 3);
    assert_string_equal(cohort_prim_type(test_prim(stage, "/Garage/Mine/Body")), "Cube");
    test_text(stage, "/Garage/Mine", "paint", "blue");
    // A reference to a prim that only a variant of its parent has.
    assert_string_equal(cohort_prim_type(test_prim(stage, "/Garage/BodyOnly")), "Sphere");
    cohort_stage_destroy(stage);
}

static void choices_from_outside_beat_all(void **state)
{
    (void)state;
    const CohortVariantChoice choices[] = {
        {"/Car", "trim", "gold"}, {"/Garage/Mine", "shape", "round"}, {"/Car", "paint", "blue"}};
    CohortStageOptions options = {.variants = choices, .variant_count = 3};
    CohortStage *stage = cohort_stage_open(DATA "variants.usda", &options, NULL);
    assert_non_null(stage);
    test_text(stage, "/Car", "trim", "gold");
    test_text(stage, "/Car", "paint", "blue");
    assert_string_equal(cohort_prim_type(test_prim(stage, "/Garage/Mine/Body")), "Sphere");
    cohort_stage_destroy(stage);
}

static void equal_instances_share_their_children(void **state)
{
    (void)state;
    CohortStage *stage = test_open("instances.usda", NULL);
    const CohortPrim *a = test_prim(stage, "/World/T1"), *b = test_prim(stage, "/World/T2");
    const CohortPrim *c = test_prim(stage, "/World/T3"), *d = test_prim(stage, "/World/T4");
    assert_true(cohort_prim_is_instance(a) && cohort_prim_is_instance(b));
    assert_ptr_equal(cohort_prim_prototype(a), a);
    assert_ptr_equal(cohort_prim_prototype(b), a);
    assert_ptr_equal(cohort_prim_child(a, 0), cohort_prim_child(b, 0));
    assert_ptr_equal(cohort_stage_prim(stage, "/World/T2/Leaf"), cohort_prim_child(a, 0));
    assert_false(cohort_prim_is_instance(c));
    assert_null(cohort_prim_prototype(c));
    assert_ptr_not_equal(cohort_prim_child(c, 0), cohort_prim_child(a, 0));
    assert_ptr_equal(cohort_prim_prototype(d), d); // another time offset, another prototype
    assert_false(cohort_prim_has_attribute(cohort_prim_child(a, 0), "note"));
    // What an instance says about itself is its own.
    double moved[3];
    assert_true(cohort_prim_numbers(b, "xformOp:translate", 0, moved, 3));
    assert_true(moved[0] == 2);
    cohort_stage_destroy(stage);
}

// The first instances met stand inside a class and show nothing: they are no prototypes for the
// rest.
static void instances_inside_classes_serve_only_classes(void **state)
{
    (void)state;
    CohortStage *stage = test_open("class_instances.usda", NULL);
    const CohortPrim *oak = test_prim(stage, "/Oak");
    assert_int_equal(cohort_prim_child_count(oak), 2);
    for (size_t i = 0; i < 2; i++) {
        const CohortPrim *leaf = cohort_prim_child(oak, i);
        assert_true(cohort_prim_is_instance(leaf));
        assert_int_equal(cohort_prim_child_count(leaf), 1);
        assert_string_equal(cohort_prim_type(cohort_prim_child(leaf, 0)), "Mesh");
    }
    cohort_stage_destroy(stage);
}

static void relocates_move_and_remove(void **state)
{
    (void)state;
    Reports reports = {0};
    CohortStage *stage = test_open("relocates.usda", &reports);
    test_text(stage, "/World/Arm", "made", "rig");
    test_text(stage, "/World/Arm", "note", "after the move");
    assert_string_equal(cohort_prim_type(test_prim(stage, "/World/Arm")), "Xform");
    test_prim(stage, "/World/Arm/Hand");
    assert_null(cohort_stage_prim(stage, "/World/Rig/Arm"));
    assert_null(cohort_stage_prim(stage, "/World/Rig/Gone"));
    const char *const *targets;
    assert_int_equal(cohort_prim_targets(test_prim(stage, "/World/Rig/Pose"), "arm", &targets), 1);
    assert_string_equal(targets[0], "/World/Arm/Hand");
    assert_int_equal(reports.count, 0);
    cohort_stage_destroy(stage);
}

static void what_is_broken_is_reported_and_the_rest_stands(void **state)
{
    (void)state;
    Reports reports = {0};
    CohortStage *stage = test_open("broken.usda", &reports);
    assert_true(test_was_reported(&reports, "/Self|10|", "itself"));
    assert_true(test_was_reported(&reports, "/A|", "itself"));
    assert_true(test_was_reported(&reports, "/B|", "itself"));
    assert_true(test_was_reported(&reports, "/Inward|", "itself"));
    assert_true(test_was_reported(&reports, "/MissingLayer|", "nowhere.usda"));
    assert_true(test_was_reported(&reports, "/MissingPrim|", "leads to no prim"));
    assert_true(test_was_reported(&reports, "/NoDefault|", "default prim"));
    assert_true(test_was_reported(&reports, "|5|", "nowhere_sub.usda"));
    assert_true(test_was_reported(&reports, "|4|", "itself"));
    test_text(stage, "/A", "b", "B");
    test_text(stage, "/B", "a", "A");
    test_prim(stage, "/FromLoop");
    assert_true(cohort_prim_double(test_prim(stage, "/MissingLayer"), "still", 0, 0) == 1);
    cohort_stage_destroy(stage);
}

static void what_is_unsupported_is_named(void **state)
{
    (void)state;
    Reports reports = {0};
    CohortStage *stage = test_open("materialx.usda", &reports);
    assert_true(test_was_reported(&reports, "/Looks|", "MaterialX"));
    assert_int_equal(reports.count, 1);
    cohort_stage_destroy(stage);
}

static void many_children_are_found_by_name(void **state)
{
    (void)state;
    char path[] = "/tmp/cohort_wide_XXXXXX.usda", name[64];
    int fd = mkstemps(path, 5);
    assert_true(fd >= 0);
    FILE *file = fdopen(fd, "w");
    fputs("#usda 1.0\n", file);
    for (int i = 0; i < 300; i++)
        fprintf(file, "def \"P%d\"\n{\n    def \"Q\"\n    {\n    }\n}\n", i);
    fclose(file);
    CohortStage *stage = cohort_stage_open(path, NULL, NULL);
    unlink(path);
    assert_non_null(stage);
    for (int i = 0; i < 300; i++) {
        snprintf(name, sizeof name, "/P%d/Q", i);
        assert_string_equal(cohort_prim_path(test_prim(stage, name)), name);
    }
    assert_null(cohort_stage_prim(stage, "/P300"));
    assert_int_equal(cohort_prim_child_count(cohort_stage_root(stage)), 300);
    cohort_stage_destroy(stage);
}

static void strict_turns_warnings_into_failure(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortStageOptions options = {.strict = true};
    assert_null(cohort_stage_open(DATA "broken.usda", &options, &err));
    assert_int_equal(err.code, COHORT_ERROR_COMPOSITION);
    assert_true(err.line > 0);
    CohortStage *stage = cohort_stage_open(DATA "liverps.usda", &options, &err);
    assert_non_null(stage);
    cohort_stage_destroy(stage);
}

static void iteration_shows_active_defined_prims_in_order(void **state)
{
    (void)state;
    CohortStage *stage = test_open("lists.usda", NULL);
    const CohortPrim *root = cohort_stage_root(stage);
    assert_int_equal(cohort_prim_child_count(root), 1);
    assert_string_equal(cohort_prim_path(cohort_prim_child(root, 0)), "/P");
    assert_null(cohort_prim_child(root, 1));
    assert_false(cohort_prim_is_active(test_prim(stage, "/Q")));
    assert_null(cohort_stage_prim(stage, "/Q/Below"));
    assert_false(cohort_prim_is_defined(test_prim(stage, "/Undefined")));
    const CohortPrim *inside = test_prim(stage, "/Abstract/Inside");
    assert_true(cohort_prim_is_abstract(inside));
    assert_int_equal(cohort_prim_specifier(inside), COHORT_SPECIFIER_DEF);
    assert_int_equal(cohort_prim_specifier(test_prim(stage, "/Abstract")), COHORT_SPECIFIER_CLASS);
    assert_string_equal(cohort_prim_name(cohort_prim_parent(inside)), "Abstract");
    assert_null(cohort_prim_parent(root));
    cohort_stage_destroy(stage);
}

// Under a relocate a class whose name is the relocate's own source is none, and nothing leads back.
static void relocated_classes_come_to_an_end(void **state)
{
    (void)state;
    Reports reports = {0};
    CohortStage *stage = test_open("relocate_loop.usda", &reports);
    assert_true(test_was_reported(&reports, "/World/Looped/Z", "leads to no prim"));
    assert_false(test_was_reported(&reports, "/World/Looped/Z", "leads back to itself"));
    assert_non_null(cohort_stage_prim(stage, "/World/Looped/Z"));
    cohort_stage_destroy(stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(strength_is_liverps),
        cmocka_unit_test(payloads_can_stay_out),
        cmocka_unit_test(classes_are_implied_across_references),
        cmocka_unit_test(variants_nest_and_stronger_selections_win),
        cmocka_unit_test(choices_from_outside_beat_all),
        cmocka_unit_test(equal_instances_share_their_children),
        cmocka_unit_test(instances_inside_classes_serve_only_classes),
        cmocka_unit_test(relocates_move_and_remove),
        cmocka_unit_test(relocated_classes_come_to_an_end),
        cmocka_unit_test(what_is_broken_is_reported_and_the_rest_stands),
        cmocka_unit_test(what_is_unsupported_is_named),
        cmocka_unit_test(many_children_are_found_by_name),
        cmocka_unit_test(strict_turns_warnings_into_failure),
        cmocka_unit_test(iteration_shows_active_defined_prims_in_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
