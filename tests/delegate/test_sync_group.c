// Groups made of what stands in them: meshes by insertion, placements of prototypes, their colors.

#include "index_fixture.h"

#include "base/memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum {
    COUNT = 4
};
static double transforms[COUNT][4][4];
static CohortInstancesSample samples[2];

// An instancer of four placements, moved by 10, 20, 30 and 40, of one triangle.
static void open_instancer(void)
{
    for (int i = 0; i < COUNT; i++) {
        for (int k = 0; k < 4; k++)
            transforms[i][k][k] = 1.0;
        transforms[i][3][0] = 10.0 * (i + 1);
    }
    samples[0] =
        (CohortInstancesSample){.time = 0.0, .transforms = (const double(*)[4][4])transforms};
    host.x = 1.0;
    host.instancer =
        (CohortInstancerSource){.instance_count = COUNT, .samples = samples, .sample_count = 1};
    insert_prim(COHORT_PRIM_INSTANCER, "/i", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/part", "/i", 0);
}

static void sync_again(void)
{
    cohort_render_index_mark_dirty(render_index, "/i", COHORT_DIRTY_INSTANCER);
    sync_index();
}

// The instance's transform, then the instancer's; without prototype numbers all show the first.
static void test_placements(void **state)
{
    (void)state;
    open_instancer();
    sync_index();
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, COUNT);
    for (int i = 0; i < COUNT; i++) {
        assert_true(root->instances[i].transform[3][0] == 10.0 * (i + 1) + 1.0);
        assert_int_equal(root->instances[i].object, root->instances[0].object);
        assert_int_equal(root->instances[i].prim_id, -1);
        assert_null(root->instances[i].display_color);
        assert_false(root->instances[i].hidden);
    }
}

static void test_colors_and_hiding(void **state)
{
    (void)state;
    static const float colors[3 * COUNT] = {0.1f, 0, 0, 0.2f, 0, 0, 0.3f, 0, 0, 0.4f, 0, 0};
    static const uint8_t colored[COUNT] = {1, 0, 1, 1}, hidden[COUNT] = {0, 1, 0, 0};
    open_instancer();
    host.instancer.display_colors = colors;
    host.instancer.hidden = hidden;
    sync_index();
    const FakeObject *root = &fake.objects[0];
    for (int i = 0; i < COUNT; i++) {
        assert_non_null(root->instances[i].display_color);
        assert_true(root->colors[i][0] == colors[3 * i]);
        assert_int_equal(root->instances[i].hidden, i == 1);
    }
    host.instancer.colored = colored;
    sync_again();
    assert_null(root->instances[1].display_color);
    assert_non_null(root->instances[2].display_color);
}

// Numbers of prototypes that are not there place nothing; the others stay in their order.
static void test_numbers_without_prototypes(void **state)
{
    (void)state;
    static const uint32_t prototypes[COUNT] = {0, 1, COHORT_INVALID_ID, 0};
    open_instancer();
    host.instancer.prototypes = prototypes;
    sync_index();
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 2);
    assert_true(root->instances[1].transform[3][0] == 41.0);
}

// Placements without transforms are an error of the host's, which is named.
static void test_counts_without_transforms(void **state)
{
    (void)state;
    open_instancer();
    for (int i = 0; i < 2; i++) {
        host.instancer.sample_count = (size_t)i;
        samples[0].transforms = NULL;
        sync_again();
        assert_int_equal(fake.objects[0].instance_count, 0);
    }
    const CohortReportEntry *entries;
    assert_true(cohort_delegate_report(delegate, &entries) > 0);
    assert_string_equal(entries[0].name, "PointInstancer");
}

// Of several samples the one at time 0, or nearest to it.
static void test_the_nearest_sample(void **state)
{
    (void)state;
    static double far[COUNT][4][4];
    open_instancer();
    samples[0].time = -2.0;
    samples[1] = (CohortInstancesSample){.time = 5.0, .transforms = (const double(*)[4][4])far};
    host.instancer.sample_count = 2;
    sync_index();
    assert_true(fake.objects[0].instances[0].transform[3][0] == 11.0);
}

static void test_allocation_failures(void **state)
{
    (void)state;
    open_instancer();
    bool ok = false;
    int failures = 0;
    for (uint64_t n = 1; n < 200 && !ok; n++) {
        CohortError err = {0};
        co_memory_fail_after(n);
        ok = cohort_render_index_sync(render_index, &err);
        co_memory_fail_after(0);
        if (!ok)
            assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        failures += !ok;
    }
    assert_true(ok && failures > 2);
    assert_int_equal(fake.objects[0].instance_count, COUNT); // what failed was done again
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_placements, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_colors_and_hiding, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_numbers_without_prototypes, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_counts_without_transforms, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_the_nearest_sample, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_allocation_failures, setup_index, teardown_index),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
