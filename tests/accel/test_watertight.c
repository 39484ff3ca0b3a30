// No ray passes between triangles that share an edge or a point, at any scale, offset or direction.

#include "accel_scene.h"

enum {
    RAYS = 100000 // per placement of the sphere
};

// A sphere seen from inside: every ray must hit.
static size_t count_leaks(const TestMesh *sphere, const CoMat4d *to_group, const CoRayBatch *rays,
                          const char *isa)
{
    TestScene s = {0};
    CoInstance instance = place(scene_add_mesh(&s, sphere), *to_group);
    scene_add_group(&s, &instance, 1);
    CoHitBatch hits = hits_alloc(rays->count);
    CoTraverseStats stats = {0};
    const CoAccelKernels *kernels = co_accel_kernels(isa);
    size_t leaks = 0;
    kernels->traverse(&s.scene, rays, NULL, &hits, 0, rays->count, true, &stats);
    for (size_t i = 0; i < rays->count; i++)
        leaks += !(hits.t[i] < INFINITY);
    hits_free(&hits);
    scene_clear(&s);
    return leaks;
}

// Rays from near the center to points and edges of the mesh, as it stands in the group's space.
static void aim_at_edges(CoRayBatch *rays, const TestMesh *sphere, const CoAffine *to_group,
                         CoVec3 center, float spread, uint64_t seed)
{
    Random random = {seed};
    for (size_t i = 0; i < rays->count; i++) {
        const uint32_t *tri = sphere->indices + 3 * (random_bits(&random) % sphere->mesh.tri_count);
        CoVec3 a = co_affine_point(to_group, co_vec3_load(sphere->points + 3 * (size_t)tri[0]));
        CoVec3 b = co_affine_point(to_group, co_vec3_load(sphere->points + 3 * (size_t)tri[1]));
        float w = i % 4 == 0 ? 0.0f : random_float(&random, 0.0f, 1.0f);
        CoVec3 org = center;
        if (i % 3 != 0)
            org = co_madd(center, random_vec3(&random, -1.0f, 1.0f), spread);
        CoVec3 dir = co_sub(co_lerp3(a, b, w), org);
        ray_set(rays, i, org, i % 2 ? co_normalize(dir) : dir);
    }
}

static void shared_edges_do_not_leak(void **state)
{
    (void)state;
    const struct {
        float scale;
        CoVec3 offset;
    } cases[] = {
        {1.0f, {0, 0, 0}},          {1e-6f, {0, 0, 0}},          {1e6f, {0, 0, 0}},
        {1.0f, {1000, -2000, 500}}, {1.0f, {1e5f, 1e5f, -1e5f}}, {1e-18f, {0, 0, 0}},
        {1e17f, {0, 0, 0}},         {1e-30f, {0, 0, 0}},         {1e30f, {0, 0, 0}},
    };
    CoRayBatch rays = rays_alloc(RAYS);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        TestMesh sphere = mesh_sphere(24, cases[k].scale, cases[k].offset);
        CoMat4d still = co_mat4d_identity();
        CoAffine identity = affine_identity();
        aim_at_edges(&rays, &sphere, &identity, cases[k].offset, 0.3f * cases[k].scale, k);
        for (int i = 0; i < TEST_ISA_COUNT; i++)
            if (co_accel_kernels(test_isas[i]) && (i >= 2 || k < 2))
                assert_int_equal(count_leaks(&sphere, &still, &rays, test_isas[i]), 0);
        mesh_free(&sphere);
    }
    rays_free(&rays);
}

static void instances_do_not_leak(void **state)
{
    (void)state;
    const CoMat4d placements[] = {
        matrix(0.3, co_vec3(1, 1, 1), co_vec3(100, -20, 7)),
        matrix(1.3, co_vec3(1e-6f, 1e-6f, 1e-6f), co_vec3(0, 0, 0)),
        matrix(2.3, co_vec3(1e6f, 1e6f, 1e6f), co_vec3(1e6f, 0, 0)),
        matrix(0.9, co_vec3(30, 0.2f, 1), co_vec3(3, 4, 5)),
        matrix(0.9, co_vec3(-1, 1, 1), co_vec3(3e4f, 4e4f, 5e4f)),
    };
    CoRayBatch rays = rays_alloc(RAYS);
    TestMesh sphere = mesh_sphere(24, 1.0f, co_vec3(0, 0, 0));
    for (size_t k = 0; k < sizeof placements / sizeof *placements; k++) {
        CoAffine affine = co_affine_from_mat4d(&placements[k]);
        CoVec3 center = co_affine_point(&affine, co_vec3(0, 0, 0));
        float size = fminf(fminf(co_length(co_affine_vector(&affine, co_vec3(1, 0, 0))),
                                 co_length(co_affine_vector(&affine, co_vec3(0, 1, 0)))),
                           co_length(co_affine_vector(&affine, co_vec3(0, 0, 1))));
        aim_at_edges(&rays, &sphere, &affine, center, 0.3f * size, 70 + k);
        assert_int_equal(count_leaks(&sphere, &placements[k], &rays, NULL), 0);
    }
    rays_free(&rays);
    mesh_free(&sphere);
}

// Instances within each other that scale one way each, by more together than any of them.
static void scales_add_up(void **state)
{
    (void)state;
    static const float scales[] = {1e10f, 1e14f, 1e-10f, 1e-17f};
    CoRayBatch rays = rays_alloc(RAYS / 10);
    CoHitBatch hits = hits_alloc(RAYS / 10);
    for (size_t k = 0; k < sizeof scales / sizeof *scales; k++) {
        const float scale = scales[k];
        TestMesh sphere = mesh_sphere(12, 1.0f / scale / scale, co_vec3(0, 0, 0));
        const CoMat4d placement = matrix(0.4, co_vec3(scale, scale, scale), co_vec3(0, 0, 0));
        TestScene s = {0};
        CoInstance inner = place(scene_add_mesh(&s, &sphere), placement);
        CoInstance outer = place(scene_add_group(&s, &inner, 1), placement);
        scene_add_group(&s, &outer, 1);
        Random random = {k};
        for (size_t i = 0; i < rays.count; i++)
            ray_set(&rays, i, random_vec3(&random, -0.3f, 0.3f), random_direction(&random));
        traverse_all(&s.scene, &rays, NULL, &hits, NULL);
        for (size_t i = 0; i < rays.count; i++)
            assert_true(hits.t[i] > 0.4f && hits.t[i] < 2.0f);
        scene_clear(&s);
        mesh_free(&sphere);
    }
    rays_free(&rays);
    hits_free(&hits);
}

// A box of n x n quads per side whose points all lie on the planes -1 and 1, seen along the axes.
static void axis_parallel_rays_do_not_leak(void **state)
{
    (void)state;
    enum {
        N = 8,
        SIDE = (N + 1) * (N + 1)
    };
    TestMesh box = mesh_alloc(6 * SIDE, 6 * N * N * 2);
    uint32_t tri = 0;
    for (uint32_t side = 0; side < 6; side++) {
        uint32_t axis = side / 2;
        for (uint32_t i = 0; i < SIDE; i++) {
            float *p = box.points + 3 * (size_t)(side * SIDE + i);
            p[axis] = side % 2 ? 1.0f : -1.0f;
            p[(axis + 1) % 3] = -1.0f + 2.0f * (float)(i % (N + 1)) / N;
            p[(axis + 2) % 3] = -1.0f + 2.0f * (float)(i / (N + 1)) / N;
        }
        for (uint32_t q = 0; q < N * N; q++) {
            uint32_t a = side * SIDE + q / N * (N + 1) + q % N;
            uint32_t quad[2][3] = {{a, a + 1, a + N + 2}, {a, a + N + 2, a + N + 1}};
            memcpy(box.indices + 3 * (size_t)tri, quad, sizeof quad);
            tri += 2;
        }
    }
    mesh_box(&box);
    CoRayBatch rays = rays_alloc(6000);
    Random random = {8};
    for (size_t i = 0; i < 6000; i++) {
        // On the lattice of the points: rays run in the planes of boxes and through shared points.
        CoVec3 org = co_vec3((float)(random_bits(&random) % 9) / 4.0f - 1.0f,
                             (float)(random_bits(&random) % 9) / 4.0f - 1.0f,
                             (float)(random_bits(&random) % 9) / 4.0f - 1.0f);
        float dir[3] = {0.0f, i % 2 ? 0.0f : -0.0f, 0.0f}, at[3] = {org.x, org.y, org.z};
        dir[i % 3] = i % 4 < 2 ? 1.0f : -1.0f;
        at[i % 3] = -0.5f * dir[i % 3];
        ray_set(&rays, i, co_vec3_load(at), co_vec3_load(dir));
    }
    CoMat4d still = co_mat4d_identity();
    for (int i = 0; i < TEST_ISA_COUNT; i++)
        if (co_accel_kernels(test_isas[i]))
            assert_int_equal(count_leaks(&box, &still, &rays, test_isas[i]), 0);
    rays_free(&rays);
    mesh_free(&box);
}

// Triangles without area, points of denormal size: nothing breaks, and what stands behind is found.
static void degenerate_triangles_are_harmless(void **state)
{
    (void)state;
    TestScene s = {0};
    TestMesh odd = mesh_soup(300, 0.5f, 11), wall = mesh_soup(1, 0.0f, 1);
    for (uint32_t i = 0; i < 300; i++) {
        float *p = odd.points + 9 * i;
        if (i % 3 == 0)
            memcpy(p + 3, p, 3 * sizeof(float)); // two corners in one place
        else if (i % 3 == 1)
            memcpy(p + 6, p, 3 * sizeof(float));
        else
            for (int k = 0; k < 9; k++)
                p[k] = ldexpf(p[k], -140); // denormal
    }
    const float corners[9] = {-50, -50, -2, 50, -50, -2, 0, 80, -2};
    memcpy(wall.points, corners, sizeof corners);
    mesh_box(&odd);
    mesh_box(&wall);
    CoInstance instances[2] = {place(scene_add_mesh(&s, &odd), co_mat4d_identity()),
                               place(scene_add_mesh(&s, &wall), co_mat4d_identity())};
    scene_add_group(&s, instances, 2);
    CoRayBatch rays = rays_alloc(3000);
    CoHitBatch hits = hits_alloc(3000);
    Random random = {2};
    for (size_t i = 0; i < 3000; i++) {
        CoVec3 org = random_vec3(&random, -1.0f, 1.0f);
        org.z = 2.0f;
        const float *p = odd.points + 9 * (random_bits(&random) % 300);
        ray_set(&rays, i, org, co_sub(co_vec3_load(p), org));
    }
    traverse_all(&s.scene, &rays, NULL, &hits, NULL);
    for (size_t i = 0; i < 3000; i++)
        assert_true(hits.t[i] < INFINITY);
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&s);
    mesh_free(&odd);
    mesh_free(&wall);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shared_edges_do_not_leak),
        cmocka_unit_test(instances_do_not_leak),
        cmocka_unit_test(scales_add_up),
        cmocka_unit_test(axis_parallel_rays_do_not_leak),
        cmocka_unit_test(degenerate_triangles_are_harmless),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
