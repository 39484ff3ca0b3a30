// Top levels: many placements of many parts, depth, what cannot be placed, failing allocations.

#include "accel/node.h"
#include "accel_scene.h"
#include "base/memory.h"

// 700 placements of a group of 16000 parts are 16700 boxes, not eleven million.
static void prototypes_are_one_object(void **state)
{
    (void)state;
    enum {
        PARTS = 16000,
        PLACEMENTS = 700
    };
    TestScene s = {0};
    TestMesh part = mesh_soup(4, 0.5f, 1);
    uint32_t mesh = scene_add_mesh(&s, &part);
    CoInstance *parts = malloc(PARTS * sizeof *parts),
               *placed = malloc(PLACEMENTS * sizeof *placed);
    Random random = {3};
    for (size_t i = 0; i < PARTS; i++)
        parts[i] =
            place(mesh, matrix((double)i, co_vec3_splat(0.02f), random_vec3(&random, -1.0f, 1.0f)));
    uint32_t prototype = scene_add_group(&s, parts, PARTS);
    for (size_t i = 0; i < PLACEMENTS; i++)
        placed[i] = place(
            prototype, matrix((double)i, co_vec3_splat(1.0f), random_vec3(&random, -30.0f, 30.0f)));
    uint32_t root = scene_add_group(&s, placed, PLACEMENTS);
    uint64_t paths;
    assert_true(co_accel_path_count(&s.scene, &paths));
    assert_int_equal(paths, (uint64_t)PARTS * PLACEMENTS);
    size_t bytes = co_top_bytes(s.tops[prototype]) + co_top_bytes(s.tops[root]);
    assert_true(bytes < (PARTS + PLACEMENTS) * 128u);

    CoRayBatch rays = rays_alloc(512);
    CoHitBatch hits = hits_alloc(512);
    for (size_t i = 0; i < 512; i++) {
        CoVec3 dir = co_vec3(1e-3f * (float)(i % 8), 1e-3f * (float)(i / 8 % 8), 1);
        ray_set(&rays, i, co_vec3(0.4f * (float)(i / 64), 0, -60), dir);
    }
    CoTraverseStats stats;
    traverse_all(&s.scene, &rays, NULL, &hits, &stats);
    size_t count = 0;
    for (size_t i = 0; i < 512; i++) {
        if (!(hits.t[i] < INFINITY))
            continue;
        CoPlacement at;
        co_accel_placement(&s.scene, hits.instance[i], &at);
        CoVec3 p = co_vec3(rays.org_x[i] + hits.t[i] * rays.dir_x[i],
                           rays.org_y[i] + hits.t[i] * rays.dir_y[i],
                           rays.org_z[i] + hits.t[i] * rays.dir_z[i]);
        CoVec3 local = co_affine_point(&at.to_object, p);
        assert_true(fabsf(local.x) < 1.6f && fabsf(local.y) < 1.6f && fabsf(local.z) < 1.6f);
        assert_int_equal(at.object, mesh);
        assert_int_equal(at.chain_length, 2);
        assert_int_equal(at.chain[0] * (uint32_t)PARTS + at.chain[1], hits.instance[i]);
        count++;
    }
    assert_true(count > 20);
    // Nodes are shared by a group of coherent rays.
    assert_true(4 * stats.top_nodes_grouped < stats.top_nodes_single);
    assert_int_equal(stats.groups, 8);
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&s);
    mesh_free(&part);
    free(parts);
    free(placed);
}

static void depth_is_limited(void **state)
{
    (void)state;
    TestScene s = {0};
    TestMesh part = mesh_soup(4, 0.5f, 1);
    CoInstance chain[9];
    chain[0] = place(scene_add_mesh(&s, &part), co_mat4d_identity());
    for (int i = 0; i < 8; i++) {
        uint32_t group = scene_add_group(&s, &chain[i], 1);
        chain[i + 1] = place(group, matrix(0.1, co_vec3_splat(1.0f), co_vec3(0.1f, 0, 0)));
    }
    CoRayBatch rays = rays_alloc(64);
    CoHitBatch hits = hits_alloc(64);
    Random random = {3};
    for (size_t i = 0; i < 64; i++)
        ray_set(&rays, i, random_vec3(&random, -1.0f, 1.0f), random_vec3(&random, -1.0f, 1.0f));
    traverse_all(&s.scene, &rays, NULL, &hits, NULL);
    CohortError err = {0};
    assert_null(co_top_create(&chain[8], 1, s.objects, &err));
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&s);
    mesh_free(&part);
}

static void what_cannot_be_placed_is_never_hit(void **state)
{
    (void)state;
    TestScene s = {0};
    TestMesh sphere = mesh_sphere(6, 1.0f, co_vec3(0, 0, 0));
    uint32_t mesh = scene_add_mesh(&s, &sphere);
    CoInstance instances[3];
    for (int i = 0; i < 3; i++)
        instances[i] = place(mesh, co_mat4d_identity());
    instances[0].to_group.m[0][0] = NAN;
    instances[1].to_group.m[2][3] = INFINITY;
    scene_add_group(&s, instances, 3);
    CoRayBatch rays = rays_alloc(1);
    CoHitBatch hits = hits_alloc(1);
    ray_set(&rays, 0, co_vec3(0.1f, 0.1f, -4), co_vec3(0, 0, 1));
    traverse_all(&s.scene, &rays, NULL, &hits, NULL);
    assert_int_equal(hits.instance[0], 2);
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&s);
    mesh_free(&sphere);
}

static void failing_allocations_are_reported(void **state)
{
    (void)state;
    TestScene s = {0};
    TestMesh sphere = mesh_sphere(6, 1.0f, co_vec3(0, 0, 0));
    uint32_t mesh = scene_add_mesh(&s, &sphere);
    CoInstance instances[40];
    for (int i = 0; i < 40; i++)
        instances[i] = place(mesh, matrix(0, co_vec3_splat(1), co_vec3((float)i, 0, 0)));
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    CoTop *top = NULL;
    uint64_t n;
    for (n = 1; n < 100 && !top; n++) {
        CohortError err = {0};
        co_memory_fail_after(n);
        top = co_top_create(instances, 40, s.objects, &err);
        co_memory_fail_after(0);
        if (!top) {
            assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
            assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
        }
    }
    assert_non_null(top);
    assert_true(n > 6);
    assert_int_equal(co_top_bytes(top), co_memory_live(CO_MEMORY_ACCEL) - before);
    co_top_destroy(top);
    co_top_destroy(NULL);
    scene_clear(&s);
    mesh_free(&sphere);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(prototypes_are_one_object),
        cmocka_unit_test(depth_is_limited),
        cmocka_unit_test(what_cannot_be_placed_is_never_hit),
        cmocka_unit_test(failing_allocations_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
