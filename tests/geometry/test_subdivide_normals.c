// Limit normals of creased surfaces: those of the same surface cut along its creases.

#include "geometry/displace.h"
#include "subdivision_fixture.h"

enum {
    FACES = CAGE_MAX_FACES,
    EDGES = 6 * CAGE_MAX_FACES
};

// Creases along all edges of a cage, each once, or along those between vertices of one row of 12.
static void add_creases(const Cage *cage, bool is_all, CohortMeshDesc *desc)
{
    static int32_t ends[2 * EDGES], lengths[EDGES];
    static float sharpnesses[EDGES];
    size_t count = 0, at = 0;
    for (size_t f = 0; f < cage->face_count; at += (size_t)cage->counts[f++]) {
        for (int32_t k = 0; k < cage->counts[f]; k++) {
            int32_t a = cage->indices[at + (size_t)k];
            int32_t b = cage->indices[at + (size_t)((k + 1) % cage->counts[f])];
            if (a > b || (!is_all && a / 12 != b / 12))
                continue;
            ends[2 * count] = a;
            ends[2 * count + 1] = b;
            lengths[count] = 2;
            sharpnesses[count++] = INFINITY;
        }
    }
    desc->crease_indices = ends;
    desc->crease_index_count = 2 * count;
    desc->crease_lengths = lengths;
    desc->crease_count = desc->crease_sharpness_count = count;
    desc->crease_sharpnesses = sharpnesses;
}

// The same faces with points of their own, all or by row.
static void cut(const Cage *cage, bool is_all, Cage *out)
{
    memcpy(out->counts, cage->counts, sizeof cage->counts);
    out->face_count = cage->face_count;
    out->index_count = cage->index_count;
    out->point_count = 0;
    size_t at = 0;
    for (size_t f = 0; f < cage->face_count; f++) {
        int32_t row = INT32_MAX;
        for (int32_t k = 0; k < cage->counts[f]; k++) {
            int32_t own = cage->indices[at + (size_t)k] / 12;
            row = own < row ? own : row;
        }
        // The last row goes from 7 back to 0.
        for (int32_t k = 0; k < cage->counts[f]; k++)
            row = cage->indices[at + (size_t)k] / 12 == 7 && row == 0 ? 7 : row;
        for (int32_t k = 0; k < cage->counts[f]; k++, at++) {
            int32_t v = cage->indices[at], is_upper = v / 12 != row;
            int32_t own = is_all ? (int32_t)at : 24 * row + 12 * is_upper + v % 12;
            out->indices[at] = own;
            memcpy(out->points + 3 * own, cage->points + 3 * v, 3 * sizeof(float));
            out->point_count = (size_t)own >= out->point_count ? (size_t)own + 1 : out->point_count;
        }
    }
}

static void compare(const CohortMeshDesc *creased, const CohortMeshDesc *apart)
{
    CoMesh a, b;
    make_mesh(creased, &a);
    make_mesh(apart, &b);
    assert_int_equal(a.tri_count, b.tri_count);
    const float uv[][2] = {{0, 0}, {1, 0}, {0, 1}, {0.25f, 0.5f}};
    for (uint32_t tri = 0; tri < a.tri_count; tri++) {
        for (size_t k = 0; k < COUNT(uv); k++) {
            CoSurface got, want;
            co_mesh_surface(&a, tri, uv[k][0], uv[k][1], &got);
            co_mesh_surface(&b, tri, uv[k][0], uv[k][1], &want);
            assert_true(co_length(co_sub(got.p, want.p)) < 1e-5f);
            assert_true(co_length(co_sub(got.ns, want.ns)) < 1.2e-3f);
        }
    }
    co_mesh_destroy(&b);
    co_mesh_destroy(&a);
}

static void normals_are_those_of_the_surface_cut_apart(void **state)
{
    (void)state;
    static Cage whole, apart;
    for (int kind = 0; kind < 4; kind++) {
        make_torus(&whole, kind == 1, kind >= 2);
        CohortScheme scheme = kind == 3 ? COHORT_SCHEME_LOOP : COHORT_SCHEME_CATMULL_CLARK;
        for (int is_all = 0; is_all < 2; is_all++) {
            cut(&whole, is_all, &apart);
            if (apart.point_count > CAGE_MAX_POINTS)
                continue; // triangles, each alone
            for (uint32_t level = 0; level < 5; level++) {
                CohortMeshDesc creased = cage_desc(&whole, scheme, level);
                CohortMeshDesc other = cage_desc(&apart, scheme, level);
                add_creases(&whole, is_all, &creased);
                other.interpolate_boundary =
                    is_all ? COHORT_BOUNDARY_EDGE_AND_CORNER : COHORT_BOUNDARY_EDGE_ONLY;
                compare(&creased, &other);
            }
        }
    }
}

// Faces whose edges are all creases are flat, or bilinear: nothing is kept for them.
static void flat_faces_keep_no_normals(void **state)
{
    (void)state;
    static Cage cage;
    make_torus(&cage, false, true);
    for (int k = 0; k < 2; k++) {
        CohortMeshDesc desc =
            cage_desc(&cage, k ? COHORT_SCHEME_LOOP : COHORT_SCHEME_CATMULL_CLARK, 2);
        add_creases(&cage, true, &desc);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        for (uint32_t tri = 0; tri < mesh.tri_count; tri++) {
            CoSurface s;
            co_mesh_surface(&mesh, tri, 0.2f, 0.3f, &s);
            assert_memory_equal(&s.ns, &s.ng, sizeof s.ns);
        }
        CoMeshMemory memory;
        co_mesh_memory(&mesh, &memory);
        assert_true(memory.normals < 5 * (size_t)mesh.point_count + 64 * 9);
        co_mesh_destroy(&mesh);
    }
}

// Edges of all levels: where they meet others than their face's some corners are not asked for.
static void edges_of_all_levels_keep_their_creases(void **state)
{
    (void)state;
    static Cage cage;
    static uint8_t levels[EDGES];
    for (int kind = 0; kind < 3; kind++) {
        make_torus(&cage, kind == 1, kind == 2);
        CohortMeshDesc desc =
            cage_desc(&cage, kind == 2 ? COHORT_SCHEME_LOOP : COHORT_SCHEME_CATMULL_CLARK, 0);
        add_creases(&cage, true, &desc);
        for (size_t e = 0; e < COUNT(levels); e++)
            levels[e] = (uint8_t)(1 + e * e % 7 % 4);
        desc.edge_levels = levels;
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        assert_true(mesh.patches->is_mixed);
        for (uint32_t tri = 0; tri < mesh.tri_count; tri++) {
            CoSurface s;
            co_mesh_surface(&mesh, tri, 0.2f, 0.3f, &s);
            assert_true(tri_collapses(&mesh, tri) || co_dot(s.ns, s.ng) > 0.75f);
        }
        co_mesh_destroy(&mesh);
    }
}

static bool by_nothing(void *cookie, const CoDisplacePoint *points, size_t count, float *amounts,
                       CohortError *err)
{
    (void)cookie;
    (void)points;
    (void)err;
    memset(amounts, 0, count * sizeof *amounts);
    return true;
}

// Displaced, every corner has a normal of its own.
static void creases_outlive_displacement(void **state)
{
    (void)state;
    static Cage cage;
    make_torus(&cage, false, true);
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_LOOP, 2);
    add_creases(&cage, true, &desc);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    CohortError err = {0};
    CoDisplaceCounts counts;
    assert_true(co_mesh_displace(&mesh, by_nothing, NULL, &counts, &err));
    for (uint32_t tri = 0; tri < mesh.tri_count; tri++) {
        CoSurface s;
        co_mesh_surface(&mesh, tri, 0.2f, 0.3f, &s);
        assert_true(co_dot(s.ns, s.ng) > 0.999f);
    }
    co_mesh_destroy(&mesh);
}

static void failing_allocations_are_reported(void **state)
{
    (void)state;
    static Cage cage;
    make_torus(&cage, true, false);
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 2);
    add_creases(&cage, true, &desc);
    assert_true(refuse_allocations(&desc) > 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(normals_are_those_of_the_surface_cut_apart),
        cmocka_unit_test(flat_faces_keep_no_normals),
        cmocka_unit_test(edges_of_all_levels_keep_their_creases),
        cmocka_unit_test(creases_outlive_displacement),
        cmocka_unit_test(failing_allocations_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
