// The sorted, deferred machinery is real: full batches wait on a stack, rays go to disk and come
// back, groups share node fetches, and no ray is lost.

#include "base/hash.h"
#include "support/cgroup.h"
#include "support/scenes.h"

// A closed room with a box in it; every surface shines.
static CohortScene *room(CohortError *err)
{
    CohortScene *scene = test_scene(err);
    uint32_t matte = test_matte(scene, 0.5f, 0.5f, err);
    uint32_t box = test_quads(scene, test_box_points, 8, test_box_indices, 6, NULL, matte, err);
    CohortInstanceDesc places[2] = {test_place(box, 0, 0, 0, 3.0),
                                    test_place(box, 0.5, -1, 0, 0.6)};
    TEST_OK(cohort_scene_set_group(scene, 0, places, 2, err), err);
    test_camera(scene, 0, 0, 2.9, 1.0, err);
    TEST_OK(cohort_scene_commit(scene, NULL, err), err);
    return scene;
}

static void full_batches_wait_on_a_stack(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = room(&err);
    CohortRenderSettings settings = {.width = 64,
                                     .height = 64,
                                     .spp = 4,
                                     .max_depth = 8,
                                     .first_hit_samples = 8,
                                     .batch = 1u << 11};
    CohortRenderStats stats;
    free(test_render(scene, &settings, &stats, &err));
    for (int i = 0; i < 6; i++)
        assert_true(stats.batches[i] > 0);
    assert_true(stats.ready_depth_peak >= 3);
    assert_true(stats.bins_in_memory + stats.bins_on_disk >= 6 + 3);
    assert_int_equal(stats.rays_made, stats.rays_traced);
    assert_int_equal(stats.rays_made, stats.rays_camera + stats.rays_bsdf + stats.rays_light);
    assert_int_equal(stats.rays_made,
                     stats.ends_hit + stats.ends_miss + stats.ends_blocked + stats.ends_invalid);
    cohort_scene_destroy(scene);
}

// Eisenacher et al. 2013, 3.1: a group fetches a node once for all of its rays.
static void groups_share_node_fetches(void **state)
{
    (void)state;
    enum {
        SIDE = 24
    };
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t matte = test_matte(scene, 0.8f, 0.1f, &err);
    uint32_t box = test_quads(scene, test_box_points, 8, test_box_indices, 6, NULL, matte, &err);
    static CohortInstanceDesc places[SIDE * SIDE * SIDE];
    uint32_t n = 0;
    for (int z = 0; z < SIDE; z++)
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++)
                places[n++] = test_place(box, x - SIDE / 2, y - SIDE / 2, -z, 0.3);
    TEST_OK(cohort_scene_set_group(scene, 0, places, n, &err), &err);
    test_camera(scene, 0, 0, 6, 1.0, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = {.width = 128,
                                     .height = 128,
                                     .spp = 8,
                                     .max_depth = 3,
                                     .sort = COHORT_SORT_BOTH,
                                     .batch = 1u << 18};
    CohortRenderStats stats;
    free(test_render(scene, &settings, &stats, &err));
    if (stats.top_nodes_grouped * 4 > stats.top_nodes_single)
        fail_msg("%llu node fetches by groups, %llu by single rays",
                 (unsigned long long)stats.top_nodes_grouped,
                 (unsigned long long)stats.top_nodes_single);
    assert_true(stats.top_nodes_grouped > stats.groups);
    cohort_scene_destroy(scene);
}

typedef struct Outcome {
    uint64_t hash, bytes_read;
} Outcome;

enum {
    LIMIT_BYTES = 28 << 20
};

// 8192 camera rays, and 140 more from where each of them hits: 41 MB of rays in flight.
static void render_much(const void *context, void *out)
{
    (void)context;
    CohortError err = {0};
    CohortScene *scene = room(&err);
    CohortRenderSettings settings = {.width = 128,
                                     .height = 64,
                                     .spp = 1,
                                     .max_depth = 2,
                                     .first_hit_samples = 140,
                                     .batch = 1u << 13,
                                     .threads = 2};
    CohortRenderStats stats;
    float *pixels = test_render(scene, &settings, &stats, &err);
    *(Outcome *)out =
        (Outcome){co_hash_bytes(pixels, 128 * 64 * 4 * sizeof *pixels, 0), stats.bytes_read};
    free(pixels);
    cohort_scene_destroy(scene);
}

static void rays_that_do_not_fit_go_to_disk_and_back(void **state)
{
    (void)state;
    char folder[600];
    if (!test_cgroup_make(folder, sizeof folder, LIMIT_BYTES))
        skip();
    Outcome free_run = {0}, tight = {0};
    bool is_done = test_in_child(NULL, render_much, NULL, &free_run, sizeof free_run, NULL) &&
                   test_in_child(folder, render_much, NULL, &tight, sizeof tight, NULL);
    test_cgroup_remove(folder);
    assert_true(is_done);
    assert_true(tight.bytes_read > 0);
    assert_int_equal(tight.hash, free_run.hash);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_that_do_not_fit_go_to_disk_and_back),
        cmocka_unit_test(full_batches_wait_on_a_stack),
        cmocka_unit_test(groups_share_node_fetches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
