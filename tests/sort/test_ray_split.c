// The exact ray sort: medians as the paper has them. What both sorts keep is in test_ray_sort.

#include "ray_sort_support.h"

// On the longest axis of all origins, the first half ends where the second begins, at a multiple
// of 64.
static void exact_splits_at_the_median(void **state)
{
    (void)state;
    CoSortScratch scratch = {NULL, 0};
    CoRayBatch batch = {.count = 0};
    size_t count = 10000, middle = (157 + 1) / 2 * 64;
    fill_scene(&batch, count, 1);
    assert_true(sort_batch(&batch, COHORT_SORTER_EXACT, &scratch, NULL));
    float high = -INFINITY, low = INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (i < middle)
            high = fmaxf(high, batch.org_x[i]);
        else
            low = fminf(low, batch.org_x[i]);
    }
    assert_true(high <= low);
    // At most 4096 rays: by direction only; y is the longest axis of this bin's directions or z is.
    fill_scene(&batch, 4096, 1);
    for (size_t i = 0; i < 4096; i++) {
        CoVec3 d = co_vec3(0.1f * batch.dir_x[i], 0.1f * batch.dir_y[i], batch.dir_z[i]);
        uint32_t code[2];
        d = co_ray_snap_direction(co_normalize(d), code);
        batch.dir_x[i] = d.x;
        batch.dir_y[i] = d.y;
        batch.dir_z[i] = d.z;
    }
    assert_true(sort_batch(&batch, COHORT_SORTER_EXACT, &scratch, NULL));
    high = -INFINITY;
    low = INFINITY;
    for (size_t i = 0; i < 4096; i++) {
        if (i < 2048)
            high = fmaxf(high, batch.dir_z[i]);
        else
            low = fminf(low, batch.dir_z[i]);
    }
    assert_true(high <= low);
    co_ray_batch_clear(&batch);
    co_sort_scratch_clear(&scratch);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact_splits_at_the_median),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
