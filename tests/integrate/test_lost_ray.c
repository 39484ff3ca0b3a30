// A ray that gets lost on its way into the bins fails the render. The loss is made by the linker:
// this program's calls of co_ray_bins_push come through here (CMakeLists.txt, --wrap).

#include "support/scenes.h"

#include "rays/ray_bin.h"

static uint64_t pushes, dropped_push; // which push is lost, counted from 1; 0 = none

bool __real_co_ray_bins_push(CoRayBins *bins, uint32_t worker, const uint32_t *words, uint32_t bin);
bool __wrap_co_ray_bins_push(CoRayBins *bins, uint32_t worker, const uint32_t *words, uint32_t bin);

bool __wrap_co_ray_bins_push(CoRayBins *bins, uint32_t worker, const uint32_t *words, uint32_t bin)
{
    if (++pushes == dropped_push)
        return true;
    return __real_co_ray_bins_push(bins, worker, words, bin);
}

static bool render_with_loss(uint64_t which, CohortError *err)
{
    CohortScene *scene = test_scene(err);
    uint32_t matte = test_matte(scene, 0.5f, 0.5f, err);
    uint32_t box = test_quads(scene, test_box_points, 8, test_box_indices, 6, NULL, matte, err);
    CohortInstanceDesc place = test_place(box, 0, 0, 0, 3.0);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, err), err);
    test_camera(scene, 0, 0, 2.9, 1.0, err);
    TEST_OK(cohort_scene_commit(scene, NULL, err), err);
    CohortRenderSettings settings = {
        .width = 16, .height = 16, .spp = 1, .max_depth = 4, .threads = 1, .batch = 1u << 8};
    CohortRender *render = cohort_render_create(scene, &settings, err);
    assert_non_null(render);
    pushes = 0;
    dropped_push = which;
    bool ok = cohort_render_round(render, err);
    cohort_render_destroy(render);
    cohort_scene_destroy(scene);
    return ok;
}

static void all_rays_arrive(void **state)
{
    (void)state;
    CohortError err = {0};
    assert_true(render_with_loss(0, &err));
    assert_true(pushes >= 16 * 16 * 2);
}

static void one_lost_ray_fails_the_render(void **state)
{
    (void)state;
    static const uint64_t lost[] = {1, 200, 400}; // of the camera, and of a bounce
    for (int i = 0; i < 3; i++) {
        CohortError err = {0};
        assert_false(render_with_loss(lost[i], &err));
        assert_int_equal(err.code, COHORT_ERROR_INTERNAL);
        assert_non_null(strstr(err.message, "rays were lost"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_rays_arrive),
        cmocka_unit_test(one_lost_ray_fails_the_render),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
