// Displacement at commit: how far points go, which way, and how often.

#include "support/scenes.h"

#include <math.h>

// A level-1 quad from -1 to 1 that faces +Z, with a primvar of heights.
static CohortScene *make_scene(const CohortInput *displacement, uint32_t *object, CohortError *err)
{
    static const float heights[] = {0.0f, 0.25f, 1.0f, -0.5f};
    CohortScene *scene = test_scene(err);
    CohortMaterialDesc material = cohort_material_default();
    material.displacement = *displacement;
    uint32_t id = cohort_scene_new_material(scene, err);
    TEST_OK(cohort_scene_set_material(scene, id, &material, err), err);
    CohortPrimvarDesc primvar = {.name = "height",
                                 .interpolation = COHORT_INTERPOLATION_VERTEX,
                                 .components = 1,
                                 .values = heights,
                                 .value_count = 4};
    CohortMeshDesc desc = test_square(NULL);
    desc.scheme = COHORT_SCHEME_BILINEAR;
    desc.level = 1;
    desc.primvars = &primvar;
    desc.primvar_count = 1;
    desc.material = id;
    *object = test_mesh(scene, &desc, err);
    CohortInstanceDesc place = test_place(*object, 0, 0, 0, 1);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, err), err);
    test_camera(scene, 0, 0, 5, 0.1, err);
    TEST_OK(cohort_scene_commit(scene, NULL, err), err);
    return scene;
}

static void assert_heights(const CohortScene *scene, double lo, double hi)
{
    double box[6];
    assert_true(cohort_scene_bounds(scene, box));
    assert_true(fabs(box[2] - lo) < 1e-5 && fabs(box[5] - hi) < 1e-5);
    assert_true(fabs(box[0] + 1.0) < 1e-5 && fabs(box[4] - 1.0) < 1e-5); // along the normal alone
}

static void assert_counts(const CohortScene *scene, uint64_t meshes, uint64_t points)
{
    CohortSceneCounts counts;
    cohort_scene_counts(scene, &counts);
    assert_int_equal(counts.displaced_meshes, meshes);
    assert_int_equal(counts.displaced_points, points);
}

static void a_constant_moves_all(void **state)
{
    (void)state;
    CohortError err = {0};
    uint32_t object;
    CohortInput half = {.value = {0.5f}};
    CohortScene *scene = make_scene(&half, &object, &err);
    assert_heights(scene, 0.5, 0.5);
    assert_counts(scene, 1, 9);
    cohort_scene_destroy(scene);
}

static void a_primvar_moves_each_point_by_its_own(void **state)
{
    (void)state;
    CohortError err = {0};
    uint32_t object;
    CohortInput height = {.kind = COHORT_INPUT_PRIMVAR, .primvar = "height", .value = {9}};
    CohortScene *scene = make_scene(&height, &object, &err);
    assert_heights(scene, -0.5, 1.0);
    cohort_scene_destroy(scene);
    CohortInput other = {.kind = COHORT_INPUT_PRIMVAR, .primvar = "none", .value = {0.125f}};
    scene = make_scene(&other, &object, &err); // the mesh has none: the input's own
    assert_heights(scene, 0.125, 0.125);
    cohort_scene_destroy(scene);
}

static void nothing_moves_nothing(void **state)
{
    (void)state;
    CohortError err = {0};
    uint32_t object;
    CohortInput zero = {.value = {0}};
    CohortScene *scene = make_scene(&zero, &object, &err);
    assert_heights(scene, 0.0, 0.0);
    assert_counts(scene, 0, 0);
    cohort_scene_destroy(scene);
}

// What is displaced stays as it is, however often the scene is committed.
static void points_are_moved_once(void **state)
{
    (void)state;
    CohortError err = {0};
    uint32_t object;
    CohortInput half = {.value = {0.5f}};
    CohortScene *scene = make_scene(&half, &object, &err);
    CohortInstanceDesc place = test_place(object, 0, 0, 1, 1);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, &err), &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    assert_heights(scene, 1.5, 1.5);
    assert_counts(scene, 1, 9);
    cohort_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_constant_moves_all),
        cmocka_unit_test(a_primvar_moves_each_point_by_its_own),
        cmocka_unit_test(nothing_moves_nothing),
        cmocka_unit_test(points_are_moved_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
