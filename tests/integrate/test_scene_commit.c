// Commits that are stopped go on where they were.

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stopped_commit_goes_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
