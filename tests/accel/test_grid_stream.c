// Leaves of subdivided meshes under groups of rays that stay together, which enter blocks at once:
// the hits of loose triangles, bit for bit. Rays that go apart are in test_grid_leaf. Both also
// test grid_plan.c.

#include "grid_scenes.h"

enum {
    GROUP = 64,
    GROUPS = 40,
    RAYS = GROUP * GROUPS
};

// Each group from about one place to about one point of the mesh; the wider, the fewer of them meet
// a leaf together. Every third ray is aimed at a point exactly.
static CoRayBatch bundles(const TestMesh *mesh, float width, uint64_t seed)
{
    Random random = {seed};
    CoRayBatch rays = rays_alloc(RAYS);
    CoVec3 from = co_vec3_splat(0.0f), at = from;
    for (size_t i = 0; i < RAYS; i++) {
        const uint32_t *tri = mesh->indices + 3 * (random_bits(&random) % mesh->mesh.tri_count);
        if (i % GROUP == 0) {
            from = random_vec3(&random, -6.0f, 6.0f);
            at = co_vec3_load(mesh->points + 3 * (size_t)tri[0]);
        }
        CoVec3 org = co_add(from, random_vec3(&random, -width, width));
        CoVec3 to = i % 3 ? co_add(at, random_vec3(&random, -width, width)) : at;
        ray_set(&rays, i, org, co_sub(to, org));
    }
    return rays;
}

static void groups_find_what_single_rays_find(void **state)
{
    (void)state;
    const float widths[] = {1e-4f, 0.02f, 0.2f};
    for (uint32_t k = 0; k < MESHES; k++) {
        CoMesh mesh;
        make_number(k, &mesh);
        TestMesh loose = loosen(&mesh);
        for (uint32_t w = 0; w < 3; w++) {
            CoRayBatch rays = bundles(&loose, widths[w], 3 * k + w);
            assert_true(compare_with_loose(&mesh, &loose, &rays) > RAYS / 4);
            rays_free(&rays);
        }
        mesh_free(&loose);
        co_mesh_destroy(&mesh);
    }
}

// Squashed until its triangles are slivers: who meets them is decided by doubles, for some of a
// group.
static void slivers_are_decided_alike(void **state)
{
    (void)state;
    const float thin[] = {1e-3f, 1e-6f};
    for (uint32_t k = 0; k < MESHES; k++) {
        CoMesh mesh;
        make_number(k, &mesh);
        float *points = (float *)(uintptr_t)mesh.points;
        for (uint32_t p = 0; p < mesh.point_count; p++)
            points[3 * (size_t)p + 2] *= thin[k % 2];
        mesh.box_min.z *= thin[k % 2];
        mesh.box_max.z *= thin[k % 2];
        TestMesh loose = loosen(&mesh);
        CoRayBatch rays = bundles(&loose, 1e-3f, k);
        for (size_t i = 0; i < RAYS; i++) // almost in the plane
            rays.org_z[i] *= 2.0f * thin[k % 2];
        for (size_t i = 0; i < RAYS; i++)
            rays.dir_z[i] = -rays.org_z[i];
        compare_with_loose(&mesh, &loose, &rays);
        rays_free(&rays);
        mesh_free(&loose);
        co_mesh_destroy(&mesh);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(groups_find_what_single_rays_find),
        cmocka_unit_test(slivers_are_decided_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
