// Levels by size on screen: no side is longer than asked for, edges agree, what is not seen is
// coarse.

#include "geometry/subdivision_fixture.h"

#include "prims/dicing.h"

#define EDGE_PIXELS 4.0

typedef struct Look {
    CohortRenderIndex index;
    CoDicingView view;
    CoPrim prim;
    CohortPull pull;
} Look;

// A camera 1000 pixels wide at (7.5, -1, 1), which looks along y, or back.
static void set_up(Look *look, bool looks_back)
{
    double sign = looks_back ? -1.0 : 1.0;
    memset(look, 0, sizeof *look);
    look->view.placements = 1;
    for (int k = 0; k < 4; k++)
        look->view.to_world[0][k][k] = 1.0;
    look->prim.view = 1;
    CoDicing *d = &look->index.dicing;
    *d = (CoDicing){.eye = {7.5, -1.0, 1.0},
                    .clip_near = 0.1,
                    .axes = {{sign, 0, 0}, {0, 0, 1}, {0, -sign, 0}},
                    .window = {-0.5, 0.5, -0.5, 0.5},
                    .pixels = 1000.0,
                    .edge_length = EDGE_PIXELS,
                    .views = &look->view,
                    .view_count = 1};
}

static void set_levels(Look *look, CohortMeshDesc *desc)
{
    assert_true(co_dicing_set_levels(&look->index, &look->prim, &look->pull, desc));
}

// Pixels of a segment where it is nearest, in the grid's plane.
static double pixels_of(const Look *look, CoVec3 a, CoVec3 b)
{
    double nearest = HUGE_VAL;
    const double *e = look->index.dicing.eye;
    for (int k = 0; k <= 8; k++) {
        CoVec3 p = co_lerp3(a, b, (float)k / 8.0f);
        double x = (double)p.x - e[0], y = (double)p.y - e[1], z = (double)p.z - e[2];
        nearest = fmin(nearest, sqrt(x * x + y * y + z * z));
    }
    return (double)co_length(co_sub(b, a)) * 1000.0 / nearest;
}

static void sides_are_as_short_as_asked_for(void **state)
{
    (void)state;
    static Cage cage;
    Look look;
    set_up(&look, false);
    make_grid(&cage, 15, false);
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_BILINEAR, 0);
    set_levels(&look, &desc);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    assert_true(mesh.patches->is_mixed);
    double longest = 0.0;
    for (uint32_t k = 0; k < 3 * mesh.tri_count; k++) {
        CoVec3 a = mesh_point(&mesh, k / 3, k % 3), b = mesh_point(&mesh, k / 3, (k + 1) % 3);
        bool is_seen = fabs((double)a.x - 7.5) < 0.5 * ((double)a.y + 1.0);
        double pixels = is_seen ? pixels_of(&look, a, b) : 0.0;
        bool is_straight = a.x == b.x || a.y == b.y;
        longest = fmax(longest, is_straight ? pixels : 0.0);
        // Across squares, and along edges that are coarser by one.
        assert_true(pixels < 2.3 * EDGE_PIXELS);
    }
    assert_true(longest <= EDGE_PIXELS * 1.001 && longest > 0.5 * EDGE_PIXELS);
    // Uniformly as fine it had 15 x 15 x 2 x 4^8.
    assert_int_equal(mesh.patches->level, 8);
    assert_true(mesh.tri_count < (225u << 17) / 16);
    co_mesh_destroy(&mesh);
    co_arena_clear(&look.pull.arena);
}

// What both faces say about an edge is the same.
static void faces_agree(void **state)
{
    (void)state;
    static Cage cage;
    static uint8_t of_edge[CAGE_MAX_POINTS][CAGE_MAX_POINTS];
    Look look;
    set_up(&look, false);
    make_torus(&cage, true, false);
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 0);
    set_levels(&look, &desc);
    size_t first = 0, met = 0;
    for (size_t f = 0; f < cage.face_count; first += (size_t)cage.counts[f++])
        for (int32_t k = 0; k < cage.counts[f]; k++) {
            int32_t a = cage.indices[first + (size_t)k];
            int32_t b = cage.indices[first + (size_t)((k + 1) % cage.counts[f])];
            uint8_t *own = &of_edge[a < b ? a : b][a < b ? b : a];
            uint8_t level = desc.edge_levels[first + (size_t)k];
            assert_true(*own == 0 || *own == level + 1);
            met += *own != 0;
            *own = (uint8_t)(level + 1);
            assert_true(desc.face_levels[f] >= level);
        }
    assert_int_equal(met, cage.index_count / 2);
    co_arena_clear(&look.pull.arena);
}

static uint32_t sum_of_levels(const Look *look, CohortMeshDesc *desc)
{
    Look own = *look;
    set_levels(&own, desc);
    uint32_t sum = 0;
    for (size_t k = 0; k < desc->face_vertex_index_count; k++)
        sum += desc->edge_levels[k];
    co_arena_clear(&own.pull.arena);
    return sum;
}

static void what_is_not_seen_is_coarser(void **state)
{
    (void)state;
    static Cage cage;
    Look look;
    make_torus(&cage, false, false);
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 0);
    set_up(&look, false);
    look.index.dicing.eye[0] = 0.0;
    look.index.dicing.eye[1] = -20.0;
    uint32_t seen = sum_of_levels(&look, &desc);
    set_up(&look, true);
    look.index.dicing.eye[0] = 0.0;
    look.index.dicing.eye[1] = -20.0;
    assert_int_equal(sum_of_levels(&look, &desc), seen - 2 * (uint32_t)cage.index_count);
    // Through a parallel projection all is near.
    set_up(&look, false);
    look.index.dicing.is_orthographic = true;
    look.index.dicing.eye[0] = 0.0;
    memcpy(look.index.dicing.window, (double[4]){-9, 9, -9, 9}, 4 * sizeof(double));
    look.index.dicing.pixels = 1000.0 / 18.0;
    seen = sum_of_levels(&look, &desc);
    look.index.dicing.eye[1] = -1e6;
    assert_int_equal(sum_of_levels(&look, &desc), seen);
    look.index.dicing.eye[0] = 1e6;
    assert_true(sum_of_levels(&look, &desc) < seen);
}

// The middle of a large face may be nearer than its edges.
static void faces_are_fine_inside(void **state)
{
    (void)state;
    const float points[] = {-93, -101, 0, 107, -101, 0, 107, 99, 0, -93, 99, 0};
    const int32_t counts[] = {4}, indices[] = {0, 1, 2, 3};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_BILINEAR};
    SET_TOPOLOGY(desc, points, counts, indices);
    Look look;
    set_up(&look, false);
    look.index.dicing.edge_length = 800.0;
    set_levels(&look, &desc);
    assert_int_equal(desc.face_levels[0], 8); // 200 units at a distance of 1
    for (int k = 0; k < 4; k++)
        assert_in_range(desc.edge_levels[k], 0, 2); // at 100
    co_arena_clear(&look.pull.arena);
}

// Of several placements the largest counts, edge by edge; of many some as a density, whatever their
// places.
static void the_largest_placement_counts(void **state)
{
    (void)state;
    static Cage cage;
    static uint8_t alone[2][6 * CAGE_MAX_FACES];
    Look look;
    make_grid(&cage, 4, false);
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 0);
    for (int k = 0; k < 3; k++) {
        set_up(&look, false);
        look.view.placements = k == 2 ? 2 : 1;
        memcpy(look.view.to_world[1], look.view.to_world[0], sizeof look.view.to_world[0]);
        // To the left and near, and far ahead and larger.
        look.view.to_world[0][3][0] = 4.0;
        for (int c = 0; c < 3; c++)
            look.view.to_world[1][c][c] = 20.0;
        look.view.to_world[1][3][1] = 10.0;
        if (k == 1)
            memcpy(look.view.to_world[0], look.view.to_world[1], sizeof look.view.to_world[0]);
        set_levels(&look, &desc);
        size_t is_first = 0, is_second = 0;
        for (size_t e = 0; e < cage.index_count; e++) {
            uint8_t level = desc.edge_levels[e];
            if (k < 2) {
                alone[k][e] = level;
                continue;
            }
            is_first += level == alone[0][e] && level > alone[1][e];
            is_second += level == alone[1][e] && level > alone[0][e];
            assert_true(level == alone[0][e] || level == alone[1][e]);
            assert_true(level >= alone[0][e] && level >= alone[1][e]);
        }
        assert_true(k < 2 || (is_first > 0 && is_second > 0));
        co_arena_clear(&look.pull.arena);
    }
    set_up(&look, false);
    look.view.placements = 1000;
    look.view.density = 8.0 * EDGE_PIXELS;
    memset(look.view.to_world, 0, sizeof look.view.to_world); // of no size
    set_levels(&look, &desc);
    for (size_t k = 0; k < cage.index_count; k++)
        assert_int_equal(desc.edge_levels[k], 3);
    for (size_t f = 0; f < cage.face_count; f++)
        assert_int_equal(desc.face_levels[f], 3);
    co_arena_clear(&look.pull.arena);
}

static void broken_cages_have_no_levels(void **state)
{
    (void)state;
    Look look;
    set_up(&look, false);
    const float points[] = {0, 0, 0, 1, 0, 0, NAN, 1, 0};
    const int32_t counts[] = {0, 3, 2}, indices[] = {0, 1, 2, 0, 1};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_CATMULL_CLARK};
    SET_TOPOLOGY(desc, points, counts, indices);
    set_levels(&look, &desc);
    assert_int_equal(desc.edge_levels[1], 0); // not finite
    assert_int_equal(desc.face_levels[0], 0);
    const int32_t bad_counts[][3] = {{0, 3, 3}, {0, -3, 2}, {0, 2, 2}};
    const int32_t bad_indices[] = {0, 1, 3, 0, 1};
    for (int k = 0; k < 4; k++) {
        SET_TOPOLOGY(desc, points, counts, indices);
        desc.edge_levels = desc.face_levels = NULL;
        desc.face_vertex_counts = k < 3 ? bad_counts[k] : counts;
        desc.face_vertex_indices = k < 3 ? indices : bad_indices;
        set_levels(&look, &desc);
        assert_null(desc.edge_levels);
    }
    co_arena_clear(&look.pull.arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sides_are_as_short_as_asked_for),
        cmocka_unit_test(faces_agree),
        cmocka_unit_test(what_is_not_seen_is_coarser),
        cmocka_unit_test(faces_are_fine_inside),
        cmocka_unit_test(the_largest_placement_counts),
        cmocka_unit_test(broken_cages_have_no_levels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
