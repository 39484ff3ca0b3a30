// Commits that are stopped go on where they were; what cannot be placed is left out by name.

#include "support/scenes.h"

static const float points[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, white[] = {1, 1, 1};
static const int32_t indices[] = {0, 1, 2, 3};

static void a_stopped_commit_goes_on(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t glow = test_matte(scene, 0.0f, 0.5f, &err);
    CohortInstanceDesc places[2];
    for (int i = 0; i < 2; i++) {
        uint32_t object = test_quads(scene, points, 4, indices, 1, white, glow, &err);
        places[i] = test_place(object, i, 0, 0, 1);
    }
    TEST_OK(cohort_scene_set_group(scene, 0, places, 2, &err), &err);
    CohortCameraDesc camera = {.window = {-1, 1, -1, 1}, .clip_near = 0.1, .clip_far = 10};
    test_identity(camera.transform);
    camera.transform[3][2] = 5.0;
    TEST_OK(cohort_scene_set_camera(scene, &camera, &err), &err);
    volatile int stop = 1;
    const CohortSceneOptions options = {.stop = &stop};
    for (int i = 0; i < 2; i++) {
        CohortError stopped = {0};
        assert_false(cohort_scene_commit(scene, &options, &stopped));
        assert_int_equal(stopped.code, COHORT_ERROR_CANCELLED);
    }
    CohortSceneCounts counts;
    double box[6];
    assert_false(cohort_scene_bounds(scene, box));
    stop = 0;
    TEST_OK(cohort_scene_commit(scene, &options, &err), &err);
    cohort_scene_counts(scene, &counts);
    assert_int_equal(counts.mesh_count, 2);
    assert_int_equal(counts.group_builds, 1);
    assert_true(cohort_scene_bounds(scene, box));
    cohort_scene_destroy(scene);
}

// A placement that no ray can be taken into is named and left out, whichever way it is too much.
static void placements_out_of_reach_are_left_out(void **state)
{
    (void)state;
    static const struct {
        double x, y, z;
        bool is_shown;
    } scales[] = {{1e17, 1e17, 1e17, true},    {1e-17, 1e-17, 1e-17, true},
                  {1e20, 1e20, 1e20, false},   {1e-20, 1e-20, 1e-20, false},
                  {1, 1e-20, 1, false},        {1, 0, 1, false},
                  {1e200, 1e200, 1e200, false}};
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
        CohortError err = {0};
        CohortScene *scene = test_scene(&err);
        uint32_t glow = test_matte(scene, 0.0f, 0.5f, &err);
        uint32_t object = test_quads(scene, points, 4, indices, 1, white, glow, &err);
        CohortInstanceDesc place = test_place(object, 0, 0, 0, 1);
        place.transform[0][0] = scales[i].x;
        place.transform[1][1] = scales[i].y;
        place.transform[2][2] = scales[i].z;
        TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, &err), &err);
        CohortCameraDesc camera = {.window = {-1, 1, -1, 1}, .clip_near = 0.1, .clip_far = 10};
        test_identity(camera.transform);
        TEST_OK(cohort_scene_set_camera(scene, &camera, &err), &err);
        TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
        CohortSceneCounts counts;
        cohort_scene_counts(scene, &counts);
        assert_int_equal(counts.instance_count, scales[i].is_shown);
        const CohortDiagnostic *warnings;
        assert_int_equal(cohort_scene_warnings(scene, &warnings), !scales[i].is_shown);
        cohort_scene_destroy(scene);
    }
}

// A scene too wide for rays, and a camera that has no place, are named.
static void scenes_out_of_reach_are_named(void **state)
{
    (void)state;
    static const double far[] = {1e30, 3e37, 1.7e38};
    for (size_t i = 0; i < 3; i++) {
        CohortError err = {0};
        CohortScene *scene = test_scene(&err);
        uint32_t glow = test_matte(scene, 0.0f, 0.5f, &err);
        uint32_t object = test_quads(scene, points, 4, indices, 1, white, glow, &err);
        const CohortInstanceDesc places[2] = {test_place(object, 0, 0, 0, 1),
                                              test_place(object, 2 * far[i], 0, 0, 1)};
        TEST_OK(cohort_scene_set_group(scene, 0, places, 2, &err), &err);
        test_camera(scene, far[i], 0, 5, 1, &err);
        TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
        const CohortDiagnostic *warnings;
        assert_int_equal(cohort_scene_warnings(scene, &warnings), i >= 2);
        test_camera(scene, 0, 0, 1e39, 1, &err);
        assert_false(cohort_scene_commit(scene, NULL, &err));
        assert_int_equal(err.code, COHORT_ERROR_SCENE);
        cohort_scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stopped_commit_goes_on),
        cmocka_unit_test(placements_out_of_reach_are_left_out),
        cmocka_unit_test(scenes_out_of_reach_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
