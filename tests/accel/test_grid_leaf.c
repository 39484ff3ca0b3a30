// Subdivided meshes: the hits of loose triangles, bit for bit, in less memory (also grid_tile.c).

#include "accel/grid_leaf.h"
#include "base/memory.h"
#include "grid_scenes.h"

enum {
    RAYS = 3000
};

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

// At least so many of the rays hit.
static void compare(const CoMesh *mesh, uint64_t seed, size_t least)
{
    TestMesh loose = loosen(mesh);
    CoRayBatch rays = rays_at(&loose, RAYS, seed);
    assert_true(compare_with_loose(mesh, &loose, &rays) > least);
    rays_free(&rays);
    mesh_free(&loose);
}

static void hits_are_those_of_loose_triangles(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < MESHES; k++) {
        CoMesh mesh;
        make_number(k, &mesh);
        compare(&mesh, k, RAYS / 4);
        co_mesh_destroy(&mesh);
    }
}

// Makes every other patch, or face of a folded table, one whose points are too far apart.
static CoPatchTable make_far(const CoPatchTable *table)
{
    CoPatchTable out = *table;
    const uint32_t count = table->count / (table->fold ? 3 : 1);
    CoPatchNear *nears = malloc(count * sizeof *nears);
    uint32_t *fars = malloc(count * CO_PATCH_NEAR_POINTS * sizeof *fars);
    assert_true(table->nears && nears && fars);
    memcpy(nears, table->nears, count * sizeof *nears);
    for (uint32_t k = 0; k < count; k++) {
        co_patch_near_points(table, k, fars + CO_PATCH_NEAR_POINTS * k);
        if (k % 2)
            nears[k] = (CoPatchNear){k, 0, {CO_PATCH_FAR, 0}, {0, 0}};
    }
    out.nears = nears;
    out.fars = fars;
    return out;
}

static void hits_of_patches_that_are_far_apart(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < 2; k++) {
        static Cage cage;
        make_torus(&cage, false, true);
        CohortScheme scheme = k ? COHORT_SCHEME_LOOP : COHORT_SCHEME_CATMULL_CLARK;
        CohortMeshDesc desc = cage_desc(&cage, scheme, 1);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        CoMesh far = mesh;
        CoPatchTable table = make_far(mesh.patches);
        far.patches = &table;
        assert_true(co_mesh_same_topology(&mesh, &far));
        compare(&far, k, RAYS / 4);
        free((void *)(uintptr_t)table.nears);
        free((void *)(uintptr_t)table.fars);
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
            assert_true(is_same == (pass == 1 || bvh->grid != CO_GRID_TILE)); // which has boxes
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
        CoHitBatch hits = trace_placed(&mesh, &rays, NULL);
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
        CoHitBatch want = trace_placed(&loose.mesh, &rays, NULL),
                   got = trace_placed(&mesh, &rays, NULL);
        assert_true(same_bits(want.t, got.t, 2000) && same_bits(want.tri, got.tri, 2000));
        hits_free(&want);
        hits_free(&got);
        rays_free(&rays);
        mesh_free(&loose);
        co_bvh_destroy(bvh);
        co_mesh_destroy(&mesh);
    }
}

// At level 3 two triangles of a Loop mesh are a leaf if they lie side by side.
static void patches_pair_where_they_are_close(void **state)
{
    (void)state;
    const int32_t counts[2] = {3, 3}, indices[6] = {0, 1, 2, 0, 2, 3},
                  apart[6] = {0, 1, 2, 4, 5, 6};
    const float points[21] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 9, 0, 0, 10, 0, 0, 10, 1, 1};
    for (uint32_t k = 0; k < 2; k++) {
        const CohortMeshDesc desc = {.scheme = COHORT_SCHEME_LOOP,
                                     .level = 3,
                                     .points = points,
                                     .point_count = 7,
                                     .face_vertex_counts = counts,
                                     .face_count = 2,
                                     .face_vertex_indices = k ? apart : indices,
                                     .face_vertex_index_count = 6};
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        CoBvh *bvh = co_bvh_create(&mesh, NULL);
        assert_non_null(bvh);
        const size_t single = sizeof(CoGridLeaf) + 6 * CO_PAIR_BLOCKS;
        assert_int_equal(bvh->leaf_bytes, k ? 2 * single : single + 4 + 6 * CO_PAIR_BLOCKS);
        co_bvh_destroy(bvh);
        compare(&mesh, k, RAYS / 16);
        co_mesh_destroy(&mesh);
    }
}

enum {
    SIDE_MOST = 100
};

// A bumpy torus of side x side quads, or of twice as many triangles.
static CohortMeshDesc closed_desc(int32_t side, bool has_triangles)
{
    static float points[3 * SIDE_MOST * SIDE_MOST];
    static int32_t counts[2 * SIDE_MOST * SIDE_MOST], quads[4 * SIDE_MOST * SIDE_MOST];
    static int32_t triangles[6 * SIDE_MOST * SIDE_MOST];
    const int32_t faces = side * side;
    for (int32_t k = 0; k < faces; k++) {
        const int32_t i = k % side, j = k / side, next = (i + 1) % side, up = (j + 1) % side;
        const double x = 6.283185307179586 * i / side, y = 6.283185307179586 * j / side;
        const double r = 1.0 + 0.1 * sin(9.0 * x) * cos(7.0 * y);
        points[3 * k] = (float)((3.0 + r * cos(y)) * cos(x));
        points[3 * k + 1] = (float)((3.0 + r * cos(y)) * sin(x));
        points[3 * k + 2] = (float)(r * sin(y));
        const int32_t a = k, b = j * side + next, c = up * side + next, d = up * side + i;
        const int32_t quad[4] = {a, b, c, d}, halves[6] = {a, b, c, a, c, d};
        memcpy(quads + 4 * k, quad, sizeof quad);
        memcpy(triangles + 6 * k, halves, sizeof halves);
        counts[2 * k] = counts[2 * k + 1] = 3;
    }
    for (int32_t k = 0; k < faces && !has_triangles; k++)
        counts[k] = 4;
    const size_t count = (size_t)faces;
    return (CohortMeshDesc){.scheme = COHORT_SCHEME_CATMULL_CLARK,
                            .points = points,
                            .point_count = count,
                            .face_vertex_counts = counts,
                            .face_count = has_triangles ? 2 * count : count,
                            .face_vertex_indices = has_triangles ? triangles : quads,
                            .face_vertex_index_count = (has_triangles ? 6 : 4) * count};
}

// Bytes per triangle of points, normals and tree.
static double measure(const CohortMeshDesc *desc, const char *name, int creases)
{
    CoMesh mesh;
    make_mesh(desc, &mesh);
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    CoBvh *bvh = co_bvh_create(&mesh, NULL);
    size_t bytes = co_bvh_bytes(bvh);
    assert_int_equal(bytes, co_memory_live(CO_MEMORY_ACCEL) - before);
    const char *const creased[] = {"", ", creased along rows", ", creased", ", half creased"};
    print_message("%s%s, level %u: %.2f + %.2f bytes per triangle\n", name, creased[creases],
                  desc->level, (double)mesh.bytes / mesh.tri_count, (double)bytes / mesh.tri_count);
    double all = (double)(mesh.bytes + bytes) / mesh.tri_count;
    co_bvh_destroy(bvh);
    co_mesh_destroy(&mesh);
    return all;
}

// Infinitely sharp: no edges, those along one axis, all, or half.
typedef enum Creases {
    NO_EDGES,
    ROWS,
    ALL_EDGES,
    HALF,
    CREASES
} Creases;

static bool is_creased(Creases creases, uint32_t edge)
{
    return creases == ALL_EDGES || (creases == ROWS && edge % 3 == 0) ||
           (creases == HALF && co_hash32(edge) % 2);
}

static void add_creases(CohortMeshDesc *desc, int32_t side, Creases creases)
{
    static int32_t ends[6 * SIDE_MOST * SIDE_MOST], lengths[3 * SIDE_MOST * SIDE_MOST];
    static float sharpnesses[3 * SIDE_MOST * SIDE_MOST];
    const int32_t kinds = desc->face_vertex_counts[0] == 3 ? 3 : 2;
    size_t count = 0;
    for (int32_t edge = 0; edge < 3 * side * side; edge++) {
        if (edge % 3 >= kinds || !is_creased(creases, (uint32_t)edge))
            continue;
        const int32_t i = edge / 3 % side, j = edge / 3 / side;
        const int32_t next = edge % 3 == 1 ? i : (i + 1) % side, up = (j + 1) % side;
        ends[2 * count] = j * side + i;
        ends[2 * count + 1] = (edge % 3 == 0 ? j : up) * side + next;
        lengths[count] = 2;
        sharpnesses[count++] = 10.0f;
    }
    desc->crease_indices = ends;
    desc->crease_index_count = 2 * count;
    desc->crease_lengths = lengths;
    desc->crease_count = desc->crease_sharpness_count = count;
    desc->crease_sharpnesses = sharpnesses;
}

static void faces_and_trees_are_small(void **state)
{
    (void)state;
    const double asked[] = {30, 20, 14, 10, 10}; // by level
    for (uint32_t level = 0; level < COUNT(asked); level++) {
        const int32_t sides[] = {SIDE_MOST, 60, 32, 24, 16}, side = sides[level];
        CohortMeshDesc bilinear = closed_desc(side, false);
        bilinear.level = level;
        bilinear.scheme = COHORT_SCHEME_BILINEAR;
        assert_true(measure(&bilinear, "bilinear", NO_EDGES) <= asked[level]);
        for (Creases creases = NO_EDGES; creases < CREASES; creases++) {
            CohortMeshDesc quads = closed_desc(side, false);
            quads.level = level;
            add_creases(&quads, side, creases);
            assert_true(measure(&quads, "quads", (int)creases) <= asked[level]);
            // Surfaces where creases end take long.
            const int32_t fewer = creases == HALF && side > 40 ? 40 : side;
            CohortMeshDesc triangles = closed_desc(fewer, true);
            triangles.level = level;
            add_creases(&triangles, fewer, creases);
            assert_true(measure(&triangles, "triangles", (int)creases) <= asked[level]);
            triangles.scheme = COHORT_SCHEME_LOOP;
            assert_true(measure(&triangles, "Loop", (int)creases) <= asked[level]);
        }
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
        cmocka_unit_test(hits_of_patches_that_are_far_apart),
        cmocka_unit_test(refits_write_leaves_again),
        cmocka_unit_test(nothing_leaks_between_levels),
        cmocka_unit_test(flat_and_far_boxes_hold),
        cmocka_unit_test(patches_pair_where_they_are_close),
        cmocka_unit_test(faces_and_trees_are_small),
        cmocka_unit_test(failing_allocations_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
