// Other materials for a mesh that stands: new colors, nothing built again.

#include "support/scenes.h"

#include "base/memory.h"

// Two quads side by side, seen by a pixel each.
static const float points[] = {-1, -1, 0, 0, -1, 0, 1, -1, 0, -1, 1, 0, 0, 1, 0, 1, 1, 0};
static const int32_t indices[] = {0, 1, 4, 3, 1, 2, 5, 4};

typedef struct Wall {
    CohortScene *scene;
    uint32_t object, glow[3]; // materials that emit 0.25, 0.5, 1
} Wall;

static Wall make_wall(double x, uint32_t subset_count)
{
    CohortError err = {0};
    Wall wall = {.scene = test_scene(&err)};
    for (int i = 0; i < 3; i++)
        wall.glow[i] = test_matte(wall.scene, 0.0f, 0.25f * (float)(1 << i), &err);
    float moved[18];
    for (int i = 0; i < 18; i++)
        moved[i] = points[i] + (i % 3 == 0 ? (float)x : 0.0f);
    static const int32_t counts[] = {4, 4}, right[] = {1};
    CohortSubsetDesc subset = {right, 1, wall.glow[1]};
    CohortMeshDesc desc = test_cage(moved, 6, counts, 2, indices, 8);
    desc.subsets = subset_count ? &subset : NULL;
    desc.subset_count = subset_count;
    desc.material = wall.glow[0];
    wall.object = test_mesh(wall.scene, &desc, &err);
    CohortInstanceDesc place = test_place(wall.object, -x, 0, 0, 1);
    TEST_OK(cohort_scene_set_group(wall.scene, 0, &place, 1, &err), &err);
    CohortCameraDesc camera = {.window = {-1, 1, -1, 1}, .clip_near = 0.1, .clip_far = 10};
    camera.orthographic = true;
    test_identity(camera.transform);
    camera.transform[3][2] = 1.0;
    TEST_OK(cohort_scene_set_camera(wall.scene, &camera, &err), &err);
    return wall;
}

static void expect(const Wall *wall, float left, float right)
{
    CohortError err = {0};
    TEST_OK(cohort_scene_commit(wall->scene, NULL, &err), &err);
    CohortRenderSettings settings = {
        .width = 2, .height = 1, .spp = 1, .max_depth = 1, .filter = COHORT_FILTER_BOX};
    float *pixels = test_render(wall->scene, &settings, NULL, &err);
    assert_float_equal(pixels[0], left, 1e-6);
    assert_float_equal(pixels[4], right, 1e-6);
    free(pixels);
}

static void materials_change_and_the_mesh_stays(void **state)
{
    (void)state;
    // At x = 1000 the scene moves the mesh towards its own origin.
    for (double x = 0.0; x <= 1000.0; x += 1000.0) {
        Wall wall = make_wall(x, 1);
        expect(&wall, 0.25f, 0.5f);
        CohortError err = {0};
        TEST_OK(cohort_scene_set_mesh_materials(wall.scene, wall.object, wall.glow[2],
                                                &wall.glow[0], 1, &err),
                &err);
        expect(&wall, 1.0f, 0.25f);
        uint32_t none = COHORT_INVALID_ID;
        TEST_OK(cohort_scene_set_mesh_materials(wall.scene, wall.object, none, &none, 1, &err),
                &err);
        expect(&wall, 0.0f, 0.0f);
        CohortSceneCounts counts;
        cohort_scene_counts(wall.scene, &counts);
        assert_int_equal(counts.mesh_builds, 1);
        assert_int_equal(counts.group_builds, 1);
        assert_int_equal(counts.material_binds, 2);
        cohort_scene_destroy(wall.scene);
    }
    assert_int_equal(co_memory_live(CO_MEMORY_SCENE), 0);
}

static void another_number_of_subsets_is_refused(void **state)
{
    (void)state;
    Wall wall = make_wall(0.0, 0);
    CohortError err = {0};
    assert_false(cohort_scene_set_mesh_materials(wall.scene, wall.object, wall.glow[2],
                                                 &wall.glow[0], 1, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_false(cohort_scene_set_mesh_materials(wall.scene, 0, wall.glow[2], NULL, 0, NULL));
    assert_false(cohort_scene_set_mesh_materials(wall.scene, 99, wall.glow[2], NULL, 0, NULL));
    expect(&wall, 0.25f, 0.25f);
    cohort_scene_destroy(wall.scene);
}

static void out_of_memory_leaves_an_empty_object(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t object = cohort_scene_new_object(scene, &err);
    static const int32_t counts[] = {4, 4}, right[] = {1};
    CohortSubsetDesc subset = {right, 1, 0};
    CohortMeshDesc desc = test_cage(points, 6, counts, 2, indices, 8);
    desc.subsets = &subset;
    desc.subset_count = 1;
    bool is_made = false;
    for (uint64_t n = 1; n < 64 && !is_made; n++) {
        CohortError failure = {0};
        co_memory_fail_after(n);
        is_made = cohort_scene_set_mesh(scene, object, &desc, &failure);
        co_memory_fail_after(0);
        assert_int_equal(failure.code, is_made ? COHORT_OK : COHORT_ERROR_OUT_OF_MEMORY);
    }
    assert_true(is_made);
    cohort_scene_destroy(scene);
    assert_int_equal(co_memory_live(CO_MEMORY_SCENE), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(materials_change_and_the_mesh_stays),
        cmocka_unit_test(another_number_of_subsets_is_refused),
        cmocka_unit_test(out_of_memory_leaves_an_empty_object),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
