// Edges of different rates: neighbors share the points between them, whatever each asks for, and
// every point is the one that the same surface has when all of it is as fine.

#include "displace_check.h"
#include "limit_check.h"

#include "base/hash.h"

enum {
    ROUNDS = 3,
    LEVELS = 5 // 0 to 4
};

typedef struct Rated {
    Shape shape;
    uint8_t levels[6 * CAGE_MAX_FACES], inside[CAGE_MAX_FACES];
    float st[2 * 6 * CAGE_MAX_FACES], weight[CAGE_MAX_POINTS];
    CohortPrimvarDesc primvars[3];
} Rated;

// What an edge of the cage asks for: most are near each other, some far off. Round 0: one edge of
// all is fine.
static uint8_t random_level(uint32_t a, uint32_t b, uint32_t round)
{
    uint32_t low = a < b ? a : b, high = a < b ? b : a;
    uint32_t bits = co_hash32(low + 1000 * high + 1000000 * round);
    if (round == 0)
        return low == 0 ? LEVELS - 1 : 0;
    return (uint8_t)(round % 2 ? bits % LEVELS : bits % 7 == 0 ? 0 : 2 + bits / 7 % 2);
}

// A shape with primvars of all kinds and levels that differ from edge to edge.
static void make_rated(Rated *r, int number, uint32_t round)
{
    make_shape(&r->shape, number);
    Cage *cage = &r->shape.cage;
    size_t k = 0;
    for (size_t f = 0; f < cage->face_count; f++) {
        const int32_t *v = cage->indices + k;
        for (int32_t c = 0; c < cage->counts[f]; c++, k++)
            r->levels[k] =
                random_level((uint32_t)v[c], (uint32_t)v[(c + 1) % cage->counts[f]], round);
    }
    for (size_t i = 0; i < COUNT(r->st); i++)
        r->st[i] = (float)(i % 97); // a seam at every edge
    for (size_t i = 0; i < COUNT(r->weight); i++)
        r->weight[i] = (float)(i % 13);
    r->primvars[0] = (CohortPrimvarDesc){
        "st", COHORT_INTERPOLATION_FACE_VARYING, 2, r->st, cage->index_count, NULL, 0};
    r->primvars[1] = (CohortPrimvarDesc){
        "vertex", COHORT_INTERPOLATION_VERTEX, 1, r->weight, cage->point_count, NULL, 0};
    r->primvars[2] = (CohortPrimvarDesc){
        "varying", COHORT_INTERPOLATION_VARYING, 1, r->weight, cage->point_count, NULL, 0};
    r->shape.desc.primvars = r->primvars;
    r->shape.desc.primvar_count = COUNT(r->primvars);
    r->shape.desc.edge_levels = r->levels;
    for (uint32_t f = 0; f < CAGE_MAX_FACES; f++)
        r->inside[f] = co_hash32(f + round) % 5 == 0 ? LEVELS - 1 : 0;
    r->shape.desc.face_levels = round % 2 ? r->inside : NULL;
}

// ---- Shared edges ------------------------------------------------------------------------------

// Edges of the cage by the number of live faces there, each as often as it has segments.
static void segments_wanted(const Rated *r, const CoMesh *mesh, size_t out[8])
{
    static bool is_live[CAGE_MAX_FACES];
    memset(is_live, 0, sizeof is_live);
    for (uint32_t t = 0; t < mesh->tri_count; t++)
        is_live[co_mesh_tri_face(mesh, t)] = true;
    const Cage *cage = &r->shape.cage;
    bool has_split = r->shape.desc.scheme != COHORT_SCHEME_LOOP;
    EdgeTable live = edge_table(cage->index_count), split = edge_table(cage->index_count);
    const int32_t *v = cage->indices;
    for (size_t f = 0; f < cage->face_count; v += cage->counts[f++])
        for (int32_t k = 0; k < cage->counts[f]; k++) {
            uint32_t a = (uint32_t)v[k], b = (uint32_t)v[(k + 1) % cage->counts[f]];
            if (has_split && cage->counts[f] != 4)
                edge_add(&split, a, b);
            if (is_live[f])
                edge_add(&live, a, b);
        }
    memset(out, 0, 8 * sizeof *out);
    const uint8_t *level = r->levels;
    v = cage->indices;
    for (size_t f = 0; f < cage->face_count; v += cage->counts[f++])
        for (int32_t k = 0; k < cage->counts[f]; k++, level++) {
            uint32_t a = (uint32_t)v[k], b = (uint32_t)v[(k + 1) % cage->counts[f]];
            uint32_t *uses = edge_uses(&live, a, b);
            uint32_t least = *edge_uses(&split, a, b) ? 1 : 0;
            if (*uses != 2 && *uses != 0)
                out[*uses] += (size_t)1 << (*level > least ? *level : least);
            *uses = 0; // once for every edge
        }
    edge_table_free(&live);
    edge_table_free(&split);
}

static void neighbors_share_every_edge(void **state)
{
    (void)state;
    static Rated r;
    for (int number = 0; number < SHAPE_COUNT; number++) {
        for (uint32_t round = 0; round < ROUNDS; round++) {
            CoMesh mesh;
            make_rated(&r, number, round);
            make_mesh(&r.shape.desc, &mesh);
            assert_true(mesh.patches->is_mixed);
            size_t got[8], want[8];
            EdgeTable table = edge_table(3 * (size_t)mesh.tri_count);
            for (uint32_t t = 0; t < mesh.tri_count; t++) {
                uint32_t p[3];
                co_mesh_triangle(&mesh, t, p);
                for (int c = 0; !tri_collapses(&mesh, t) && c < 3; c++)
                    edge_add(&table, p[c], p[(c + 1) % 3]);
            }
            edge_histogram(&table, got);
            segments_wanted(&r, &mesh, want);
            for (int k = 0; k < 8; k++)
                if (got[k] != want[k])
                    fail_msg("%s, round %u: %zu edges of %d triangles, not %zu", r.shape.name,
                             round, got[k], k, want[k]);
            co_mesh_destroy(&mesh);
        }
    }
}

// Tori: each edge once in each direction, and what is enclosed is enclosed.
static void closed_cages_stay_closed(void **state)
{
    (void)state;
    static Rated r;
    const int tori[] = {15, 16, 17, 23, 25, 29};
    for (size_t k = 0; k < COUNT(tori); k++) {
        for (uint32_t round = 0; round < 2 * ROUNDS; round++) {
            CoMesh mesh;
            make_rated(&r, tori[k], round);
            make_mesh(&r.shape.desc, &mesh);
            assert_int_equal(open_edges(&mesh), 0);
            assert_true(mesh_volume6(&mesh) > 6 * 25.0);
            co_mesh_destroy(&mesh);
        }
    }
}

// ---- Points ------------------------------------------------------------------------------------

// What a corner of a triangle has, by its place on the cage.
typedef struct Corner {
    bool is_set;
    float p[3], primvars[3][4];
} Corner;

enum {
    SIDE = 1 << (LEVELS - 1),
    PLACES = (SIDE + 1) * (SIDE + 1)
};

static Corner load_corner(const CoMesh *mesh, uint32_t tri, int c)
{
    Corner out = {.is_set = true};
    CoVec3 p = mesh_point(mesh, tri, (size_t)c);
    memcpy(out.p, &p, sizeof out.p);
    const char *names[] = {"st", "vertex", "varying"};
    for (int k = 0; k < 3; k++)
        co_mesh_primvar(mesh, co_mesh_primvar_find(mesh, names[k]), tri, c == 1 ? 1.0f : 0.0f,
                        c == 2 ? 1.0f : 0.0f, out.primvars[k]);
    return out;
}

static Corner *corner_at(Corner *all, const Rated *r, const CoMesh *mesh, uint32_t tri, int c)
{
    static uint32_t first[CAGE_MAX_FACES];
    uint32_t face, sub, next = 0;
    double uv[2];
    for (size_t f = 0; f < r->shape.cage.face_count; f++) {
        first[f] = next;
        next += (uint32_t)r->shape.cage.counts[f];
    }
    corner_place(mesh, tri, c, &face, &sub, uv);
    return all + (size_t)(first[face] + sub) * PLACES + (size_t)(uv[1] * SIDE) * (SIDE + 1) +
           (size_t)(uv[0] * SIDE);
}

// Every corner is bit for bit what the uniformly fine mesh has there; no triangle but the collapsed
// ones is without area.
static void points_are_those_of_the_finest(void **state)
{
    (void)state;
    static Rated r;
    size_t bytes = 6 * CAGE_MAX_FACES * (size_t)PLACES * sizeof(Corner);
    Corner *all = co_alloc(CO_MEMORY_BASE, bytes);
    assert_non_null(all);
    for (int number = 0; number < SHAPE_COUNT; number++) {
        CoMesh mesh, fine;
        make_rated(&r, number, (uint32_t)number);
        make_mesh(&r.shape.desc, &mesh);
        r.shape.desc.edge_levels = r.shape.desc.face_levels = NULL;
        r.shape.desc.level = mesh.patches->level;
        make_mesh(&r.shape.desc, &fine);
        memset(all, 0, bytes);
        for (uint32_t t = 0; t < fine.tri_count; t++)
            for (int c = 0; c < 3; c++)
                *corner_at(all, &r, &fine, t, c) = load_corner(&fine, t, c);
        for (uint32_t t = 0; t < mesh.tri_count; t++) {
            if (tri_collapses(&mesh, t))
                continue;
            if (!(tri_area(&mesh, t) > 1e-7))
                fail_msg("%s: triangle %u has area %g", r.shape.name, t, tri_area(&mesh, t));
            for (int c = 0; c < 3; c++) {
                Corner got = load_corner(&mesh, t, c);
                const Corner *want = corner_at(all, &r, &mesh, t, c);
                assert_true(want->is_set);
                assert_memory_equal(got.p, want->p, sizeof got.p);
                assert_memory_equal(got.primvars, want->primvars, sizeof got.primvars);
            }
        }
        co_mesh_destroy(&fine);
        co_mesh_destroy(&mesh);
    }
    co_free(CO_MEMORY_BASE, all, bytes);
}

static void limit_points_are_those_of_opensubdiv(void **state)
{
    (void)state;
    static Rated r;
    uint64_t seed = 7;
    for (int number = 0; number < SHAPE_COUNT; number++) {
        make_rated(&r, number, 1);
        FarReference *reference = far_reference_create(&r.shape.desc);
        assert_non_null(reference);
        CoMesh mesh;
        make_mesh(&r.shape.desc, &mesh);
        double worst = worst_distance(&mesh, reference, 2000, &seed) / box_size(&mesh);
        if (!(worst <= 1e-6))
            fail_msg("%s: %g of the box away", r.shape.name, worst);
        co_mesh_destroy(&mesh);
        far_reference_destroy(reference);
    }
}

// ---- Displaced ---------------------------------------------------------------------------------

// Each point moves once, whatever its faces disagree about, and shading stays sound.
static void displaced_faces_stay_together(void **state)
{
    (void)state;
    static Rated r;
    for (int number = 0; number < SHAPE_COUNT; number++) {
        CoMesh rest, mesh;
        make_rated(&r, number, 2);
        make_mesh(&r.shape.desc, &rest);
        make_mesh(&r.shape.desc, &mesh);
        float most = 0.3f;
        CoDisplaceCounts counts;
        CohortError err = {0};
        assert_true(co_mesh_displace(&mesh, at_random, &most, &counts, &err));
        assert_int_equal(counts.broken, 0);
        check_moved_once(&rest, &mesh, most);
        check_shading_normals(&mesh);
        co_mesh_destroy(&mesh);
        co_mesh_destroy(&rest);
    }
}

// ---- What is asked for -------------------------------------------------------------------------

// Edges that agree make the mesh of that level; of faces that disagree the finer counts.
static void levels_are_as_asked(void **state)
{
    (void)state;
    uint8_t levels[24];
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_CATMULL_CLARK, 3), rated = desc;
    CoMesh want, got;
    make_mesh(&desc, &want);
    for (int k = 0; k < 24; k++)
        levels[k] = 3;
    rated.edge_levels = levels;
    rated.level = 1;
    make_mesh(&rated, &got);
    assert_false(got.patches->is_mixed);
    assert_same_mesh(&want, &got);
    co_mesh_destroy(&got);
    memset(levels, 0, 4);
    make_mesh(&rated, &got); // the other faces of these edges still ask for 3
    assert_same_mesh(&want, &got);
    co_mesh_destroy(&got);
    memset(levels, 0, sizeof levels);
    rated.level = 3; // is the least
    make_mesh(&rated, &got);
    assert_same_mesh(&want, &got);
    co_mesh_destroy(&got);
    co_mesh_destroy(&want);
    levels[7] = 11;
    CohortError err = {0};
    assert_false(co_mesh_create(&rated, &got, NULL, NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    rated.scheme = COHORT_SCHEME_NONE;
    make_mesh(&rated, &got);
    co_mesh_destroy(&got);
}

// One fine edge among a thousand coarse faces costs what it must.
static void coarse_faces_stay_small(void **state)
{
    (void)state;
    static Cage cage;
    static uint8_t levels[4 * 225];
    make_grid(&cage, 15, false);
    levels[0] = 8;
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 0);
    desc.edge_levels = levels;
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    assert_int_equal(mesh.tri_count, 2 * 65536 + 2 * 224);
    assert_true(mesh.bytes < 9 * (size_t)mesh.tri_count);
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        uint32_t patch = co_patch_of(mesh.patches, t);
        assert_int_equal(co_mesh_tri_face(&mesh, t), patch);
        assert_true(co_patch_first_tri(mesh.patches, patch) <= t);
    }
    co_mesh_destroy(&mesh);
}

static void threads_and_failures_change_nothing(void **state)
{
    (void)state;
    static Rated r;
    CoMesh one, many;
    make_rated(&r, 15, 1);
    co_worker_count_set(1);
    make_mesh(&r.shape.desc, &one);
    co_worker_count_set(5);
    make_mesh(&r.shape.desc, &many);
    co_worker_count_set(0);
    assert_same_mesh(&one, &many);
    co_mesh_destroy(&many);
    co_mesh_destroy(&one);
    assert_true(refuse_allocations(&r.shape.desc) > 9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(neighbors_share_every_edge),
        cmocka_unit_test(closed_cages_stay_closed),
        cmocka_unit_test(points_are_those_of_the_finest),
        cmocka_unit_test(limit_points_are_those_of_opensubdiv),
        cmocka_unit_test(displaced_faces_stay_together),
        cmocka_unit_test(levels_are_as_asked),
        cmocka_unit_test(coarse_faces_stay_small),
        cmocka_unit_test(threads_and_failures_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
