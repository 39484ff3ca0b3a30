// Subdivided meshes: the hits of loose triangles, bit for bit, in less memory.

#include "accel/grid_leaf.h"
#include "accel_scene.h"
#include "base/hash.h"
#include "base/memory.h"
#include "geometry/subdivision_fixture.h"

enum {
    RAYS = 3000
};

// The same triangles with indices.
static TestMesh loosen(const CoMesh *mesh)
{
    TestMesh loose = mesh_alloc(mesh->point_count, mesh->tri_count);
    memcpy(loose.points, mesh->points, 12 * (size_t)mesh->point_count);
    for (uint32_t tri = 0; tri < mesh->tri_count; tri++)
        co_mesh_triangle(mesh, tri, loose.indices + 3 * (size_t)tri);
    loose.mesh.box_min = mesh->box_min;
    loose.mesh.box_max = mesh->box_max;
    return loose;
}

// A third at random, a third at corners, a third at points of edges, from around and from inside.
static CoRayBatch rays_at(const TestMesh *mesh, size_t count, uint64_t seed)
{
    Random random = {seed};
    CoRayBatch rays = rays_alloc(count);
    for (size_t i = 0; i < count; i++) {
        const uint32_t *tri = mesh->indices + 3 * (random_bits(&random) % mesh->mesh.tri_count);
        CoVec3 a = co_vec3_load(mesh->points + 3 * (size_t)tri[0]);
        CoVec3 b = co_vec3_load(mesh->points + 3 * (size_t)tri[1]);
        CoVec3 org = random_vec3(&random, -5.0f, 5.0f);
        CoVec3 at = i % 3 == 0   ? random_vec3(&random, -4.0f, 4.0f)
                    : i % 3 == 1 ? a
                                 : co_lerp3(a, b, random_float(&random, 0.0f, 1.0f));
        ray_set(&rays, i, org, co_sub(at, org));
    }
    return rays;
}

static CoHitBatch trace(const CoMesh *mesh, const CoRayBatch *rays, CoTraverseStats *stats)
{
    TestScene s = {0};
    TestMesh m = {.mesh = *mesh};
    scene_add_mesh(&s, &m);
    // Twice, or the loose ones would be baked.
    const CoVec3 scale = co_vec3(1.0f, 1.25f, 1.0f);
    CoInstance instances[2] = {place(0, matrix(0.3, scale, co_vec3(0.1f, 0, 0))),
                               place(0, matrix(0.3, scale, co_vec3(20.0f, 0, 0)))};
    scene_add_group(&s, instances, 2);
    CoHitBatch hits = hits_alloc(rays->count);
    traverse_all(&s.scene, rays, NULL, &hits, stats);
    scene_clear(&s);
    return hits;
}

static void compare(const CoMesh *mesh, uint64_t seed)
{
    TestMesh loose = loosen(mesh);
    CoRayBatch rays = rays_at(&loose, RAYS, seed);
    CoTraverseStats a = {0}, b = {0};
    CoHitBatch want = trace(&loose.mesh, &rays, &a), got = trace(mesh, &rays, &b);
    assert_true(same_bits(want.t, got.t, RAYS));
    assert_true(same_bits(want.tri, got.tri, RAYS));
    assert_true(same_bits(want.u, got.u, RAYS));
    assert_true(same_bits(want.v, got.v, RAYS));
    size_t found = 0;
    for (size_t i = 0; i < RAYS; i++)
        found += got.tri[i] != COHORT_INVALID_ID;
    assert_true(found > RAYS / 4);
    hits_free(&want);
    hits_free(&got);
    rays_free(&rays);
    mesh_free(&loose);
}

// Quads, with other faces among them, triangles, of either scheme; uniform, and edges of all levels
// up to that.
enum {
    MESHES = 6 * 8
};

static void make_number(uint32_t k, CoMesh *mesh)
{
    static Cage cage;
    static uint8_t levels[6 * CAGE_MAX_FACES];
    uint32_t level = k / 8, cage_kind = k % 4;
    bool is_mixed = k / 4 % 2;
    make_torus(&cage, cage_kind == 1, cage_kind >= 2);
    CohortScheme scheme = cage_kind == 2 ? COHORT_SCHEME_LOOP : COHORT_SCHEME_CATMULL_CLARK;
    CohortMeshDesc desc = cage_desc(&cage, scheme, is_mixed ? 0 : level);
    for (uint32_t e = 0; e < COUNT(levels); e++)
        levels[e] = (uint8_t)(co_hash32(e + k) % (level + 1));
    desc.edge_levels = is_mixed ? levels : NULL;
    make_mesh(&desc, mesh);
    assert_non_null(mesh->patches);
}

static void hits_are_those_of_loose_triangles(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < MESHES; k++) {
        CoMesh mesh;
        make_number(k, &mesh);
        compare(&mesh, k);
        co_mesh_destroy(&mesh);
    }
}

// Leaves of moved points differ, and those of points moved back are what they were.
static void refits_write_leaves_again(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < MESHES; k++) {
        CoMesh mesh;
        make_number(k, &mesh);
        CoBvh *bvh = co_bvh_create(&mesh, NULL);
        unsigned char *before = malloc(bvh->leaf_bytes + 1);
        assert_true(bvh && before);
        if (bvh->leaf_bytes) // none at level 1
            memcpy(before, bvh->leaves, bvh->leaf_bytes);
        float *points = (float *)(uintptr_t)mesh.points;
        for (int pass = 0; pass < 2; pass++) {
            for (uint32_t p = 0; p < mesh.point_count; p++)
                points[3 * p] *= pass ? 0.5f : 2.0f;
            assert_true(co_bvh_refit(bvh, &mesh));
            bool is_same = !bvh->leaf_bytes || !memcmp(before, bvh->leaves, bvh->leaf_bytes);
            bool has_boxes = co_grid_has_tiles(mesh.patches);
            assert_true(is_same == (pass == 1 || !has_boxes));
        }
        free(before);
        co_bvh_destroy(bvh);
        co_mesh_destroy(&mesh);
    }
}

// From inside of a closed mesh with edges of all levels no ray gets out, aimed at points and edges
// where levels meet.
static void nothing_leaks_between_levels(void **state)
{
    (void)state;
    enum {
        COUNT_OF_RAYS = 20000
    };
    for (uint32_t round = 0; round < 4; round++) {
        uint8_t levels[24];
        for (uint32_t e = 0; e < 24; e++)
            levels[e] = (uint8_t)(co_hash32(e + 24 * round) % 6);
        CohortMeshDesc desc = cube_desc(COHORT_SCHEME_CATMULL_CLARK, 0);
        desc.edge_levels = levels;
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        assert_true(mesh.patches->is_mixed);
        CoRayBatch rays = rays_alloc(COUNT_OF_RAYS);
        Random random = {round};
        for (size_t i = 0; i < COUNT_OF_RAYS; i++) {
            uint32_t tri = (uint32_t)(random_bits(&random) % mesh.tri_count);
            CoVec3 a = mesh_point(&mesh, tri, 0), b = mesh_point(&mesh, tri, 1);
            CoVec3 org = random_vec3(&random, -0.1f, 0.1f);
            CoVec3 at = i % 2 ? a : co_lerp3(a, b, random_float(&random, 0.0f, 1.0f));
            ray_set(&rays, i, org, co_sub(at, org));
        }
        CoHitBatch hits = trace(&mesh, &rays, NULL);
        for (size_t i = 0; i < COUNT_OF_RAYS; i++)
            assert_true(hits.tri[i] < mesh.tri_count && !tri_collapses(&mesh, hits.tri[i]));
        hits_free(&hits);
        rays_free(&rays);
        co_mesh_destroy(&mesh);
    }
}

// A cube far away and tiny, its faces flat: boxes without thickness, coordinates without digits.
static void flat_and_far_boxes_hold(void **state)
{
    (void)state;
    const float scales[] = {1.0f, 1e-6f, 1e-40f, 1e29f}, offsets[] = {0.0f, 1e4f, 0.0f, 3e29f};
    for (int k = 0; k < 4; k++) {
        float points[24];
        for (int c = 0; c < 24; c++)
            points[c] = cube_points[c] * scales[k] + offsets[k];
        CohortMeshDesc desc = cube_desc(COHORT_SCHEME_BILINEAR, 3);
        desc.points = points;
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        CoBvh *bvh = co_bvh_create(&mesh, NULL);
        assert_non_null(bvh);
        TestMesh loose = loosen(&mesh);
        CoRayBatch rays = rays_at(&loose, 2000, (uint64_t)k);
        for (size_t i = 0; i < 2000; i++) {
            rays.org_x[i] = rays.org_x[i] * scales[k] + offsets[k];
            rays.org_y[i] = rays.org_y[i] * scales[k] + offsets[k];
            rays.org_z[i] = rays.org_z[i] * scales[k] + offsets[k];
        }
        CoHitBatch want = trace(&loose.mesh, &rays, NULL), got = trace(&mesh, &rays, NULL);
        assert_true(same_bits(want.t, got.t, 2000) && same_bits(want.tri, got.tri, 2000));
        hits_free(&want);
        hits_free(&got);
        rays_free(&rays);
        mesh_free(&loose);
        co_bvh_destroy(bvh);
        co_mesh_destroy(&mesh);
    }
}

// A bumpy plane of 100 x 100 quads, or of twice as many triangles.
static CohortMeshDesc plane_desc(bool has_triangles)
{
    static float points[3 * 101 * 101];
    static int32_t quad_counts[10000], quads[40000], triangle_counts[20000], triangles[60000];
    for (int32_t k = 0; k < 101 * 101; k++) {
        points[3 * k] = (float)(k % 101);
        points[3 * k + 1] = (float)(k / 101);
        points[3 * k + 2] = 0.3f * (float)(k % 7);
    }
    for (int32_t k = 0; k < 10000; k++) {
        int32_t a = k / 100 * 101 + k % 100;
        const int32_t quad[4] = {a, a + 1, a + 102, a + 101};
        const int32_t halves[6] = {a, a + 1, a + 102, a, a + 102, a + 101};
        quad_counts[k] = 4;
        triangle_counts[2 * k] = triangle_counts[2 * k + 1] = 3;
        memcpy(quads + 4 * k, quad, sizeof quad);
        memcpy(triangles + 6 * k, halves, sizeof halves);
    }
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_CATMULL_CLARK};
    if (has_triangles)
        SET_TOPOLOGY(desc, points, triangle_counts, triangles);
    else
        SET_TOPOLOGY(desc, points, quad_counts, quads);
    return desc;
}

// Bytes per triangle of points, normals and tree.
static double measure(const CohortMeshDesc *desc, const char *name)
{
    CoMesh mesh;
    make_mesh(desc, &mesh);
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    CoBvh *bvh = co_bvh_create(&mesh, NULL);
    size_t bytes = co_bvh_bytes(bvh);
    assert_int_equal(bytes, co_memory_live(CO_MEMORY_ACCEL) - before);
    print_message("%s, level %u: %.2f + %.2f bytes per triangle\n", name, desc->level,
                  (double)mesh.bytes / mesh.tri_count, (double)bytes / mesh.tri_count);
    double all = (double)(mesh.bytes + bytes) / mesh.tri_count;
    co_bvh_destroy(bvh);
    co_mesh_destroy(&mesh);
    return all;
}

static void faces_and_trees_are_small(void **state)
{
    (void)state;
    const double most[] = {30, 20, 14, 10, 10};
    // A crease along every row: its normals are kept by corner.
    static int32_t creases[99 * 101], lengths[99];
    static float sharpnesses[99];
    for (int32_t k = 0; k < 99 * 101; k++)
        creases[k] = 101 + k;
    for (int32_t k = 0; k < 99; k++) {
        lengths[k] = 101;
        sharpnesses[k] = 10.0f;
    }
    for (uint32_t level = 0; level < COUNT(most); level++) {
        CohortMeshDesc quads = plane_desc(false), bilinear = quads, creased = quads;
        quads.level = bilinear.level = creased.level = level;
        bilinear.scheme = COHORT_SCHEME_BILINEAR;
        creased.crease_indices = creases;
        creased.crease_index_count = COUNT(creases);
        creased.crease_lengths = lengths;
        creased.crease_count = creased.crease_sharpness_count = COUNT(lengths);
        creased.crease_sharpnesses = sharpnesses;
        assert_true(measure(&quads, "quads") <= most[level]);
        assert_true(measure(&bilinear, "bilinear") <= most[level]);
        assert_true(measure(&creased, "creased") <= most[level] + 0.1); // for the plane's border
        CohortMeshDesc loop = plane_desc(true), split = loop;
        loop.level = split.level = level;
        loop.scheme = COHORT_SCHEME_LOOP;
        assert_true(measure(&loop, "Loop") <= most[level]);
        assert_true(measure(&split, "triangles") <= most[level]);
    }
}

static void failing_allocations_are_reported(void **state)
{
    (void)state;
    static Cage cage;
    make_torus(&cage, true, false);
    for (uint32_t level = 0; level < 4; level++) {
        CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, level);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        size_t before = co_memory_live(CO_MEMORY_ACCEL);
        co_bvh_destroy(create_despite_failures(&mesh, 3));
        assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
        co_mesh_destroy(&mesh);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_those_of_loose_triangles),
        cmocka_unit_test(refits_write_leaves_again),
        cmocka_unit_test(nothing_leaks_between_levels),
        cmocka_unit_test(flat_and_far_boxes_hold),
        cmocka_unit_test(faces_and_trees_are_small),
        cmocka_unit_test(failing_allocations_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
