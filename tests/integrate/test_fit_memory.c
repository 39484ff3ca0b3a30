// A limit of memory: what gives way, in which order, and when it is too little.

#include "support/scenes.h"

#include "base/memory.h"
#include "integrate/render_data.h"

#define MB ((uint64_t)1 << 20)

static CohortScene *empty_scene(void)
{
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    test_camera(scene, 0, 0, 1, 0.5, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    return scene;
}

// What a render with a limit makes of it.
typedef struct Plan {
    uint32_t batch; // 0: refused
    uint64_t bins;  // bytes for bins in memory
} Plan;

static Plan plan_of(const CohortScene *scene, uint64_t memory, uint32_t batch, CohortError *err)
{
    CohortRenderSettings settings = {
        .width = 16, .height = 16, .memory = memory, .batch = batch, .threads = 1};
    CohortRender *render = cohort_render_create(scene, &settings, err);
    Plan plan = {0, 0};
    if (render)
        plan = (Plan){render->settings.batch, render->bin_memory};
    cohort_render_destroy(render);
    return plan;
}

static uint32_t batch_of(const CohortScene *scene, uint64_t memory, uint32_t batch,
                         CohortError *err)
{
    return plan_of(scene, memory, batch, err).batch;
}

static void without_a_limit_nothing_gives_way(void **state)
{
    (void)state;
    CohortScene *scene = empty_scene();
    CohortError err = {0};
    assert_int_equal(batch_of(scene, 0, 1 << 16, &err), 1 << 16);
    assert_int_equal(batch_of(scene, UINT64_MAX, 1 << 16, &err), 1 << 16);
    cohort_scene_destroy(scene);
}

// The message names what would be enough, and that is enough: for the least batch, and only once.
static void the_least_is_named(void **state)
{
    (void)state;
    CohortScene *scene = empty_scene();
    CohortError err = {0};
    assert_int_equal(batch_of(scene, 1, 1 << 16, &err), 0);
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
    const char *named = strstr(err.message, "at least ");
    assert_non_null(named);
    uint64_t least = strtoull(named + 9, NULL, 10);
    assert_true(least > 6 && least < 4096);
    // What the process holds may have grown by a little since.
    uint32_t batch = batch_of(scene, (least + 2) * MB, 1 << 20, &err);
    assert_true(batch >= 1024 && batch <= 1 << 15);
    cohort_scene_destroy(scene);
}

// More memory never means a smaller batch; what is given suffices for what is chosen.
static void batches_grow_with_the_limit(void **state)
{
    (void)state;
    CohortScene *scene = empty_scene();
    uint64_t held = co_memory_resident();
    uint32_t last = 0;
    for (uint64_t extra = 16; extra <= 1024; extra *= 2) {
        CohortError err = {0};
        uint32_t batch = batch_of(scene, held + extra * MB, 1 << 22, &err);
        assert_true(batch >= last && batch <= 1 << 22);
        assert_true((uint64_t)batch * 100 < extra * MB); // of about 300 bytes a ray
        last = batch;
    }
    assert_true(last >= 1 << 20);
    cohort_scene_destroy(scene);
}

// A batch that was asked for is never made larger.
static void small_batches_stay(void **state)
{
    (void)state;
    CohortScene *scene = empty_scene();
    CohortError err = {0};
    assert_int_equal(batch_of(scene, co_memory_resident() + 256 * MB, 256, &err), 256);
    cohort_scene_destroy(scene);
}

// What batches leave is for bins; without a limit, a part of what the machine has.
static void bins_get_what_is_left(void **state)
{
    (void)state;
    CohortScene *scene = empty_scene();
    CohortError err = {0};
    uint64_t held = co_memory_resident();
    Plan roomy = plan_of(scene, held + 256 * MB, 256, &err);
    assert_true(roomy.bins > 200 * MB && roomy.bins < 256 * MB);
    Plan tight = plan_of(scene, held + 64 * MB, 1 << 22, &err);
    assert_true(tight.batch < 1 << 22);
    assert_true(tight.bins < (uint64_t)tight.batch * 1000);
    Plan unlimited = plan_of(scene, 0, 256, &err);
    assert_true(unlimited.bins < co_memory_available() || !co_memory_available());
    cohort_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_a_limit_nothing_gives_way),
        cmocka_unit_test(the_least_is_named),
        cmocka_unit_test(batches_grow_with_the_limit),
        cmocka_unit_test(small_batches_stay),
        cmocka_unit_test(bins_get_what_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
