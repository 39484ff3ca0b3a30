// How large things are seen: pixels by distance, what lies in the picture, where a cage is, and
// failing allocations.

#include "index_fixture.h"
#include "prims/dicing.h"
#include "support/faults.h"

#include <math.h>

// At the origin, looking along -Z with a right angle; 1000 pixels to a unit at distance 1.
static CoDicing view(bool is_orthographic)
{
    return (CoDicing){.clip_near = 0.5,
                      .axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                      .window = {-1, 1, -1, 1},
                      .pixels = 1000.0,
                      .is_orthographic = is_orthographic};
}

static void pixels_fall_with_distance(void **state)
{
    (void)state;
    CoDicing near = view(false), parallel = view(true);
    assert_true(co_dicing_pixels_at(&near, 2.0) == 500.0);
    // Nothing is nearer than the near plane, not even what is around the eye.
    assert_true(co_dicing_pixels_at(&near, 0.1) == 2000.0);
    assert_true(co_dicing_pixels_at(&near, -3.0) == 2000.0);
    assert_true(co_dicing_pixels_at(&near, HUGE_VAL) == 0.0);
    assert_true(co_dicing_pixels_at(&parallel, 1e9) == 1000.0);
}

// Spheres that touch the picture count whole, others less: beside it, behind the eye.
static void what_is_outside_counts_less(void **state)
{
    (void)state;
    static const struct {
        double center[3], radius;
        bool is_seen[2]; // perspective, parallel
    } cases[] = {{{0, 0, -10}, 1, {true, true}},     {{9, 0, -10}, 0.1, {true, false}},
                 {{12, 0, -10}, 1, {false, false}},  {{12, 0, -10}, 1.5, {true, false}},
                 {{0, -12, -10}, 1, {false, false}}, {{0, 0, 5}, 1, {false, true}},
                 {{0, 0, 5}, 6, {true, true}},       {{1.5, 0, -1e6}, 0.6, {true, true}},
                 {{0, 1.5, 3}, 0.6, {false, true}}};
    for (int is_parallel = 0; is_parallel < 2; is_parallel++) {
        CoDicing d = view(is_parallel);
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
            assert_true(co_dicing_share(&d, cases[i].center, cases[i].radius) ==
                        (cases[i].is_seen[is_parallel] ? 1.0 : 0.25));
    }
}

static void rows_are_vectors(void **state)
{
    (void)state;
    const double m[4][4] = {{0, 2, 0, 0}, {3, 0, 0, 0}, {0, 0, 1, 0}, {10, 20, 30, 1}};
    const double p[3] = {1, 1, 1};
    double out[3];
    co_dicing_to_world(m, p, out);
    assert_true(out[0] == 13.0 && out[1] == 22.0 && out[2] == 31.0);
}

// A ball around all points that are finite; of none a point at the origin.
static void cages_are_measured(void **state)
{
    (void)state;
    const float points[] = {0, 0, 0, 2, 0, 0, NAN, 4, INFINITY, 0, 4, 4};
    CoPrim prim = {.cage_radius = -1.0};
    CohortMeshDesc desc = {.points = points, .point_count = 4};
    co_dicing_measure(&prim, &desc);
    assert_true(prim.cage_center[0] == 1.0 && prim.cage_center[1] == 2.0);
    assert_true(prim.cage_center[2] == 2.0 && prim.cage_radius == 3.0);
    const CohortMeshDesc none[] = {{.point_count = 0}, {.points = points + 6, .point_count = 0}};
    for (int i = 0; i < 2; i++) {
        co_dicing_measure(&prim, &none[i]);
        assert_true(prim.cage_radius == 0.0 && prim.cage_center[1] == 0.0);
    }
}

static void what_is_seen_needs_memory(void **state)
{
    assert_int_equal(setup_index(state), 0);
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    assert_true(cohort_delegate_set_double(delegate, "cohort:edgeLength", 1.0, NULL));
    sync_index();
    render_index->camera_set = (CohortCameraDesc){.window = {-1, 1, -1, 1}, .clip_near = 0.1f};
    render_index->has_camera_set = true;
    const CoPrim *mesh = co_index_find(render_index, "/mesh");
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CohortError err = {0};
        test_faults_begin(&faults);
        bool ok = co_dicing_update(render_index, 100, &err);
        test_faults_end(&faults, ok, &err);
        assert_int_equal(render_index->dicing.view_count, ok ? mesh->id + 1 : 0);
        assert_true(co_dicing_update(render_index, 100, NULL));
        assert_true(mesh->view != 0 && (mesh->dirty & COHORT_DIRTY_DISPLAY_STYLE));
        co_dicing_clear(&render_index->dicing);
    }
    assert_int_equal(faults.count, 1);
    assert_int_equal(teardown_index(state), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_fall_with_distance), cmocka_unit_test(what_is_outside_counts_less),
        cmocka_unit_test(rows_are_vectors),          cmocka_unit_test(cages_are_measured),
        cmocka_unit_test(what_is_seen_needs_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
