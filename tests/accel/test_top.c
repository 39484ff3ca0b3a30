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
    assert_true(n > 5);
    assert_int_equal(co_top_bytes(top), co_memory_live(CO_MEMORY_ACCEL) - before);
    co_top_destroy(top);
    co_top_destroy(NULL);
    scene_clear(&s);
    mesh_free(&sphere);
}

// Rays between points of a lattice, many of them along axes, with zeros of both signs.
static CoRayBatch lattice_rays(size_t count)
{
    Random random = {12};
    CoRayBatch rays = rays_alloc(count);
    for (size_t i = 0; i < count; i++) {
        float at[6];
        for (int k = 0; k < 6; k++) {
            at[k] = (float)(random_bits(&random) % 9) * 0.25f - 1.0f;
            if (at[k] == 0.0f && random_bits(&random) % 2)
                at[k] = -0.0f;
        }
        if (at[3] == 0.0f && at[4] == 0.0f && at[5] == 0.0f)
            at[5] = 1.0f;
        ray_set(&rays, i, co_vec3(3.0f * at[0], 3.0f * at[1], 3.0f * at[2]),
                co_vec3(at[3], at[4], at[5]));
    }
    return rays;
}

// The same hits twice, more than `least` of them and some misses. Frees them.
static void check_same_hits(CoHitBatch hits[2], size_t count, size_t least)
{
    size_t hit = 0;
    for (size_t i = 0; i < count; i++)
        hit += hits[0].t[i] < INFINITY;
    assert_true(hit > least && hit < count);
    assert_true(same_bits(hits[0].t, hits[1].t, count));
    assert_true(same_bits(hits[0].tri, hits[1].tri, count));
    assert_true(same_bits(hits[0].instance, hits[1].instance, count));
    hits_free(&hits[0]);
    hits_free(&hits[1]);
}

// Else every ray meets most of the fine mesh: nodes in place are padded for the whole group.
static void fine_meshes_of_wide_groups_are_not_in_place(void **state)
{
    (void)state;
    TestMesh fine = mesh_sphere(20, 1.0f, co_vec3(0, 0, 0));
    TestMesh wide = mesh_sphere(6, 1e6f, co_vec3(0, 0, 0));
    TestScene s = {0};
    CoInstance instances[2] = {place(scene_add_mesh(&s, &fine), co_mat4d_identity()),
                               place(scene_add_mesh(&s, &wide), co_mat4d_identity())};
    const CoTop *top = s.tops[scene_add_group(&s, instances, 2)];
    assert_false(top->placed[0].is_in_place);
    assert_true(top->placed[1].is_in_place);
    assert_false(top->is_in_place);
    scene_clear(&s);
    mesh_free(&fine);
    mesh_free(&wide);
}

// A mesh that stands in its group as it is is walked with the group: hits are those of a walk in a
// space of its own.
static void meshes_in_place_are_hit_as_others(void **state)
{
    (void)state;
    enum {
        RAYS = 20000
    };
    TestMesh ball = mesh_sphere(6, 1.0f, co_vec3(0, 0, 0)), soup = mesh_soup(200, 1.0f, 5);
    CoRayBatch rays = lattice_rays(RAYS);
    uint8_t *flags = malloc(RAYS);
    for (size_t i = 0; i < RAYS; i++)
        flags[i] = (uint8_t)(i % 3 == 0 ? CO_TRAVERSE_OCCLUSION : i % 3 == 1 ? 2 : 0);
    for (int moved = 0; moved < 2; moved++) {
        TestScene s = {0};
        uint32_t a = scene_add_mesh(&s, &ball), b = scene_add_mesh(&s, &soup);
        CoInstance instances[3] = {place(a, co_mat4d_identity()), place(b, co_mat4d_identity()),
                                   place(a, co_mat4d_identity())};
        instances[0].hidden_from = 2;
        if (moved)
            instances[2] = place(a, matrix(0.3, co_vec3_splat(1.5f), co_vec3(0.5f, 0.25f, 0)));
        CoTop *top = s.tops[scene_add_group(&s, instances, 3)];
        CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
        assert_int_equal(top->is_in_place, !moved);
        assert_int_equal(top->placed[0].root, 0);
        for (int i = 0; i < 3; i++)
            assert_int_equal(top->placed[i].is_in_place, !(moved && i == 2));
        traverse_all(&s.scene, &rays, flags, &hits[0], NULL);
        top->is_in_place = false;
        for (int i = 0; i < 3; i++)
            top->placed[i].is_in_place = false;
        traverse_all(&s.scene, &rays, flags, &hits[1], NULL);
        check_same_hits(hits, RAYS, RAYS / 10);
        scene_clear(&s);
    }
    free(flags);
    rays_free(&rays);
    mesh_free(&ball);
    mesh_free(&soup);
}

// A mesh a million radii from its group's origin in two of three axes, and rays along the third
// with zeros of both signs.
static void far_meshes_in_place_are_hit_as_others(void **state)
{
    (void)state;
    enum {
        RAYS = 4000
    };
    const float far[3] = {0.0f, 1e6f, -3e5f};
    TestMesh ball = mesh_sphere(6, 1.0f, co_vec3_load(far));
    CoRayBatch rays = lattice_rays(RAYS);
    float *const org[3] = {rays.org_x, rays.org_y, rays.org_z};
    for (size_t i = 0; i < RAYS; i++) {
        for (int k = 1; k < 3; k++)
            org[k][i] = far[k] + 0.25f * org[k][i];
        if (i % 4 == 0)
            ray_set(&rays, i, co_vec3(i % 8 ? 0.0f : -0.0f, org[1][i], org[2][i]),
                    co_vec3(-0.0f, i % 3 ? -1.0f : 1.0f, i % 5 ? -0.0f : 0.0f));
    }
    TestScene s = {0};
    uint32_t mesh = scene_add_mesh(&s, &ball);
    CoInstance instances[2] = {place(mesh, co_mat4d_identity()), place(mesh, co_mat4d_identity())};
    CoTop *top = s.tops[scene_add_group(&s, instances, 2)];
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    assert_true(top->is_in_place && top->placed[0].is_in_place && top->placed[1].is_in_place);
    traverse_all(&s.scene, &rays, NULL, &hits[0], NULL);
    top->is_in_place = top->placed[0].is_in_place = top->placed[1].is_in_place = false;
    traverse_all(&s.scene, &rays, NULL, &hits[1], NULL);
    check_same_hits(hits, RAYS, RAYS / 10);
    scene_clear(&s);
    rays_free(&rays);
    mesh_free(&ball);
}

// A mesh of one leaf is that leaf, wherever it stands: hits are those of a walk from its root.
static void meshes_of_one_leaf_are_hit_as_others(void **state)
{
    (void)state;
    enum {
        RAYS = 20000
    };
    TestMesh few = mesh_soup(5, 1.5f, 7);
    CoRayBatch rays = lattice_rays(RAYS);
    uint8_t *flags = calloc(RAYS, 1);
    for (size_t i = 0; i < RAYS; i += 3)
        flags[i] = CO_TRAVERSE_OCCLUSION;
    TestScene s = {0};
    uint32_t mesh = scene_add_mesh(&s, &few);
    CoInstance instances[4] = {
        place(mesh, co_mat4d_identity()),
        place(mesh, matrix(0.0, co_vec3_splat(1.0f), co_vec3(0.25f, -1.0f, 0.5f))),
        place(mesh, matrix(0.7, co_vec3_splat(0.3f), co_vec3(-1.0f, 0, 0))),
        place(mesh, matrix(0.0, co_vec3(1e-30f, 1e30f, 1.0f), co_vec3(0, 0, 0)))};
    CoTop *top = s.tops[scene_add_group(&s, instances, 4)];
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    for (int i = 0; i < 4; i++)
        assert_true(top->placed[i].root & CO_REF_LEAF);
    traverse_all(&s.scene, &rays, flags, &hits[0], NULL);
    for (int i = 0; i < 4; i++)
        top->placed[i].root = 0;
    traverse_all(&s.scene, &rays, flags, &hits[1], NULL);
    check_same_hits(hits, RAYS, RAYS / 20);
    scene_clear(&s);
    free(flags);
    rays_free(&rays);
    mesh_free(&few);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(prototypes_are_one_object),
        cmocka_unit_test(depth_is_limited),
        cmocka_unit_test(what_cannot_be_placed_is_never_hit),
        cmocka_unit_test(failing_allocations_are_reported),
        cmocka_unit_test(meshes_in_place_are_hit_as_others),
        cmocka_unit_test(far_meshes_in_place_are_hit_as_others),
        cmocka_unit_test(fine_meshes_of_wide_groups_are_not_in_place),
        cmocka_unit_test(meshes_of_one_leaf_are_hit_as_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
