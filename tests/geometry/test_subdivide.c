// Tessellation of subdivision surfaces: closed by index, known limit points, the numbering of
// triangles and its inverse, Ptex coordinates.

#include "subdivision_fixture.h"

static void assert_closed(const Cage *cage, CohortScheme scheme, uint32_t level, uint32_t quads)
{
    CohortMeshDesc desc = cage_desc(cage, scheme, level);
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 0);
    if (quads)
        assert_int_equal(mesh.tri_count, quads << (2 * level));
    assert_int_equal(open_edges(&mesh), 0);
    for (uint32_t k = 0; k < 3 * mesh.point_count; k++)
        assert_true(isfinite(mesh.points[k]));
    // Outward winding encloses a positive volume: 2 pi^2 R r^2 is 59, coarse cages have less.
    assert_true(mesh_volume6(&mesh) > 6 * 25.0);
    co_mesh_destroy(&mesh);
}

static void tori_are_closed_by_index(void **state)
{
    (void)state;
    static Cage quads, mixed, triangles;
    make_torus(&quads, false, false);
    make_torus(&mixed, true, false);
    make_torus(&triangles, false, true);
    for (uint32_t level = 0; level <= 4; level++) {
        assert_closed(&quads, COHORT_SCHEME_CATMULL_CLARK, level, 2 * 96);
        assert_closed(&quads, COHORT_SCHEME_BILINEAR, level, 2 * 96);
        assert_closed(&mixed, COHORT_SCHEME_CATMULL_CLARK, level, 0);
        assert_closed(&mixed, COHORT_SCHEME_BILINEAR, level, 0);
        assert_closed(&triangles, COHORT_SCHEME_LOOP, level, 192);
        assert_closed(&triangles, COHORT_SCHEME_CATMULL_CLARK, level, 0);
    }
}

// No two points of a tessellation lie at the same place: each was made once.
static void points_are_not_repeated(void **state)
{
    (void)state;
    static Cage cage;
    make_torus(&cage, true, false);
    for (uint32_t level = 0; level <= 2; level++) {
        CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, level);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        for (uint32_t a = 0; a < mesh.point_count; a++)
            for (uint32_t b = a + 1; b < mesh.point_count; b++)
                assert_true(memcmp(mesh.points + 3 * a, mesh.points + 3 * b, 12) != 0);
        co_mesh_destroy(&mesh);
    }
}

static void cube_corner_goes_to_its_limit(void **state)
{
    (void)state;
    // (n^2 v + 4 sum of edge neighbors + sum of face neighbors) / (n (n + 5)) with n = 3: half.
    for (uint32_t level = 0; level <= 3; level++) {
        CohortMeshDesc desc = cube_desc(COHORT_SCHEME_CATMULL_CLARK, level);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        assert_int_equal(mesh.tri_count, 12u << (2 * level));
        for (int k = 0; k < 24; k++)
            assert_near((double)mesh.points[k], 0.5 * (double)cube_points[k], 1e-6);
        co_mesh_destroy(&mesh);
    }
}

// One step of Catmull-Clark on the cube by hand: 8 vertex, 12 edge and 6 face points.
static void make_refined_cube(Cage *cage)
{
    memset(cage, 0, sizeof *cage);
    cage->point_count = 8;
    for (int k = 0; k < 24; k++)
        cage->points[k] = cube_points[k] * 5.0f / 9.0f;
    int32_t edge_point[8][8] = {{0}};
    for (int32_t f = 0; f < 6; f++) {
        const int32_t *v = cube_indices + 4 * f;
        int32_t center = (int32_t)cage->point_count++;
        for (int c = 0; c < 3; c++) {
            float sum = 0;
            for (int k = 0; k < 4; k++)
                sum += cube_points[3 * v[k] + c];
            cage->points[3 * center + c] = sum / 4;
        }
        for (int k = 0; k < 4; k++) {
            int32_t a = v[k], b = v[(k + 1) % 4], lo = a < b ? a : b, hi = a < b ? b : a;
            if (!edge_point[lo][hi]) {
                edge_point[lo][hi] = (int32_t)cage->point_count++;
                for (int c = 0; c < 3; c++)
                    cage->points[3 * edge_point[lo][hi] + c] =
                        0.375f * (cube_points[3 * lo + c] + cube_points[3 * hi + c]);
            }
        }
        for (int k = 0; k < 4; k++) {
            int32_t p = v[(k + 3) % 4], a = v[k], b = v[(k + 1) % 4];
            const int32_t quad[] = {a, edge_point[a < b ? a : b][a < b ? b : a], center,
                                    edge_point[a < p ? a : p][a < p ? p : a]};
            cage_face(cage, 4, quad);
        }
    }
}

// The limit surface of a cage and of its refinement are one: level 3 of the cube has the same
// points as level 2 of the refined cube.
static void refinement_keeps_the_limit(void **state)
{
    (void)state;
    static Cage cage;
    make_refined_cube(&cage);
    CohortMeshDesc coarse_desc = cube_desc(COHORT_SCHEME_CATMULL_CLARK, 3);
    CohortMeshDesc fine_desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 2);
    CoMesh coarse, fine;
    make_mesh(&coarse_desc, &coarse);
    make_mesh(&fine_desc, &fine);
    assert_int_equal(coarse.point_count, fine.point_count);
    for (uint32_t a = 0; a < coarse.point_count; a++) {
        CoVec3 p = co_vec3_load(coarse.points + 3 * a);
        float nearest = INFINITY;
        for (uint32_t b = 0; b < fine.point_count; b++)
            nearest = fminf(nearest, co_length(co_sub(co_vec3_load(fine.points + 3 * b), p)));
        assert_true(nearest < 2e-6f);
    }
    co_mesh_destroy(&coarse);
    co_mesh_destroy(&fine);
}

// On a regular flat grid the limit map is linear where no boundary is near: Ptex coordinates can be
// read off the position.
static void ptex_coordinates_on_a_flat_grid(void **state)
{
    (void)state;
    static Cage cage;
    make_grid(&cage, 5, false);
    for (uint32_t level = 0; level <= 4; level++) {
        CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, level);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        for (uint32_t t = 0; t < mesh.tri_count; t++) {
            CoSurface s;
            co_mesh_surface(&mesh, t, 0.3f, 0.6f, &s);
            assert_int_equal(s.ptex_face, t / (2u << (2 * level)));
            assert_true(s.p.z == 0.0f);
            assert_vec_near(s.ng, 0, 0, 1, 0);
            assert_vec_near(s.ns, 0, 0, 1, 1e-6);
            uint32_t i = s.face % 5, j = s.face / 5;
            if (i < 1 || i > 3 || j < 1 || j > 3)
                continue;
            assert_near((double)s.ptex_u, (double)s.p.x - i, 2e-6);
            assert_near((double)s.ptex_v, (double)s.p.y - j, 2e-6);
            assert_vec_near(s.ptex_dpdu, 1, 0, 0, 2e-5);
            assert_vec_near(s.ptex_dpdv, 0, 1, 0, 2e-5);
        }
        co_mesh_destroy(&mesh);
    }
}

static void loop_coordinates_on_a_flat_grid(void **state)
{
    (void)state;
    static Cage cage;
    make_grid(&cage, 5, true);
    for (uint32_t level = 0; level <= 4; level++) {
        CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_LOOP, level);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        assert_int_equal(mesh.ptex_face_count, 50);
        for (uint32_t t = 0; t < mesh.tri_count; t++) {
            CoSurface s;
            co_mesh_surface(&mesh, t, 0.3f, 0.6f, &s);
            assert_int_equal(s.ptex_face, t >> (2 * level));
            assert_vec_near(s.ng, 0, 0, 1, 0);
            uint32_t i = s.face / 2 % 5, j = s.face / 10;
            if (i < 1 || i > 3 || j < 1 || j > 3)
                continue;
            double x = (double)s.p.x - i, y = (double)s.p.y - j;
            // Second triangles: (1,0) (1,1) (0,1).
            assert_near((double)s.ptex_u, s.face % 2 ? x + y - 1 : x, 3e-6);
            assert_near((double)s.ptex_v, s.face % 2 ? 1 - x : y, 3e-6);
        }
        co_mesh_destroy(&mesh);
    }
}

// Bilinear n-gons: each tessellated point lies where its Ptex coordinates say.
static void ptex_coordinates_of_ngons(void **state)
{
    (void)state;
    const float p[] = {0, 0, 0, 2, -1, 0, 3, 1, 0, 1, 3, 0, -1, 1, 0, 4, -1, 0};
    const int32_t counts[] = {5, 3}, indices[] = {0, 1, 2, 3, 4, 1, 5, 2};
    for (uint32_t level = 0; level <= 3; level++) {
        CohortMeshDesc desc = {.scheme = COHORT_SCHEME_BILINEAR, .level = level};
        SET_TOPOLOGY(desc, p, counts, indices);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        assert_int_equal(mesh.ptex_face_count, 8);
        for (uint32_t k = 0; k < 3 * mesh.tri_count; k++) {
            CoSurface s;
            co_mesh_surface(&mesh, k / 3, k % 3 == 1 ? 1.0f : 0.0f, k % 3 == 2 ? 1.0f : 0.0f, &s);
            uint32_t n = s.face ? 3 : 5, sub = s.ptex_face - (s.face ? 5 : 0);
            const int32_t *face = indices + (s.face ? 5 : 0);
            assert_true(sub < n);
            CoVec3 c = {0, 0, 0}, q[4];
            for (uint32_t m = 0; m < n; m++)
                c = co_add(c, co_scale(co_vec3_load(p + 3 * face[m]), 1.0f / (float)n));
            q[0] = co_vec3_load(p + 3 * face[sub]);
            q[1] = co_lerp3(q[0], co_vec3_load(p + 3 * face[(sub + 1) % n]), 0.5f);
            q[2] = c;
            q[3] = co_lerp3(q[0], co_vec3_load(p + 3 * face[(sub + n - 1) % n]), 0.5f);
            CoVec3 want =
                co_lerp3(co_lerp3(q[0], q[1], s.ptex_u), co_lerp3(q[3], q[2], s.ptex_u), s.ptex_v);
            assert_vec_near(s.p, (double)want.x, (double)want.y, (double)want.z, 1e-5);
        }
        co_mesh_destroy(&mesh);
    }
}

static void thread_count_changes_nothing(void **state)
{
    (void)state;
    static Cage cage;
    make_torus(&cage, true, false);
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 3);
    CoMesh one, many;
    co_worker_count_set(1);
    make_mesh(&desc, &one);
    co_worker_count_set(5);
    make_mesh(&desc, &many);
    co_worker_count_set(0);
    assert_same_mesh(&one, &many);
    co_mesh_destroy(&one);
    co_mesh_destroy(&many);
}

// What a mesh was made from is gone when it is made, and what it keeps is what it counts.
static void only_the_mesh_is_kept(void **state)
{
    (void)state;
    static Cage cage;
    make_torus(&cage, true, false);
    for (uint32_t level = 0; level <= 3; level++) {
        CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, level);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        assert_int_equal(co_memory_live(CO_MEMORY_GEOMETRY), mesh.bytes);
        co_mesh_destroy(&mesh);
        assert_int_equal(co_memory_live(CO_MEMORY_GEOMETRY), 0);
    }
}

static void too_many_triangles_are_refused(void **state)
{
    (void)state;
    enum {
        FACES = 2000
    };
    static int32_t counts[FACES], indices[4 * FACES];
    for (int k = 0; k < FACES; k++) {
        counts[k] = 4;
        for (int c = 0; c < 4; c++)
            indices[4 * k + c] = cube_indices[4 * (k % 6) + c];
    }
    static float points[12 * FACES];
    for (int k = 0; k < 4 * FACES; k++) {
        indices[k] = k;
        points[3 * k] = (float)k;
    }
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_CATMULL_CLARK, .level = 10};
    SET_TOPOLOGY(desc, points, counts, indices);
    CoMesh mesh;
    CohortError err = {0};
    assert_false(co_mesh_create(&desc, &mesh, NULL, NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
    assert_int_equal(co_memory_live(CO_MEMORY_GEOMETRY), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tori_are_closed_by_index),
        cmocka_unit_test(points_are_not_repeated),
        cmocka_unit_test(cube_corner_goes_to_its_limit),
        cmocka_unit_test(refinement_keeps_the_limit),
        cmocka_unit_test(ptex_coordinates_on_a_flat_grid),
        cmocka_unit_test(loop_coordinates_on_a_flat_grid),
        cmocka_unit_test(ptex_coordinates_of_ngons),
        cmocka_unit_test(thread_count_changes_nothing),
        cmocka_unit_test(only_the_mesh_is_kept),
        cmocka_unit_test(too_many_triangles_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
