// What the cage may hold: creases, corners, holes, boundaries, and topology no surface has.

#include "subdivision_fixture.h"

static const int32_t cube_crease_indices[] = {0, 3, 2, 1, 0, 4, 5, 6, 7, 4, 0, 4, 3, 7, 2, 6, 1, 5};
static const int32_t cube_crease_lengths[] = {5, 5, 2, 2, 2, 2};

static CohortMeshDesc creased_cube(const float *sharpnesses, size_t count, uint32_t level)
{
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_CATMULL_CLARK, level);
    desc.crease_indices = cube_crease_indices;
    desc.crease_index_count = COUNT(cube_crease_indices);
    desc.crease_lengths = cube_crease_lengths;
    desc.crease_count = COUNT(cube_crease_lengths);
    desc.crease_sharpnesses = sharpnesses;
    desc.crease_sharpness_count = count;
    return desc;
}

static void infinite_creases_keep_the_cube(void **state)
{
    (void)state;
    const float per_crease[] = {10, 10, 10, 10, 10, 10};
    const float per_edge[] = {10, 11, 10, INFINITY, 10, 10, 10, 10, 10, 10, 10, 10};
    for (int k = 0; k < 2; k++) {
        CohortMeshDesc desc = creased_cube(k ? per_edge : per_crease, k ? 12 : 6, 2);
        CoMesh mesh;
        assert_int_equal(make_mesh(&desc, &mesh), 0);
        assert_int_equal(open_edges(&mesh), 0);
        assert_near(mesh_area(&mesh), 24.0, 1e-4);
        assert_near(mesh_volume6(&mesh), 48.0, 1e-3);
        for (uint32_t t = 0; t < mesh.tri_count; t++) {
            CoSurface s; // normals do not leak over the crease
            co_mesh_surface(&mesh, t, 0.1f, 0.1f, &s);
            assert_true(co_dot(s.ns, s.ng) > 0.9999f);
        }
        co_mesh_destroy(&mesh);
    }
}

static void sharpness_widens_the_surface(void **state)
{
    (void)state;
    double previous = 0.0;
    for (int k = 0; k <= 4; k++) {
        const float s = (float)k;
        const float sharpnesses[] = {s, s, s, s, s, s};
        CohortMeshDesc desc = creased_cube(sharpnesses, 6, 3);
        CoMesh mesh;
        assert_int_equal(make_mesh(&desc, &mesh), 0);
        assert_int_equal(open_edges(&mesh), 0);
        assert_true(mesh_volume6(&mesh) > previous * 1.01);
        previous = mesh_volume6(&mesh);
        co_mesh_destroy(&mesh);
    }
    assert_true(previous < 48.0);
}

static void corners_stay_where_they_are(void **state)
{
    (void)state;
    const int32_t corners[] = {6, 0};
    const float sharpnesses[] = {10, 10};
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_CATMULL_CLARK, 1);
    desc.corner_indices = corners;
    desc.corner_sharpnesses = sharpnesses;
    desc.corner_count = 2;
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 0);
    assert_memory_equal(mesh.points + 18, cube_points + 18, 12);
    assert_memory_equal(mesh.points, cube_points, 12);
    assert_near((double)mesh.points[3], 0.5, 0.3);
    assert_int_equal(open_edges(&mesh), 0);
    co_mesh_destroy(&mesh);
}

static void sharpness_that_is_no_number_is_said(void **state)
{
    (void)state;
    const float odd[] = {NAN, NAN, NAN, NAN, NAN, NAN};
    const int32_t corners[] = {6, 0};
    CohortMeshDesc smooth = cube_desc(COHORT_SCHEME_CATMULL_CLARK, 1);
    CohortMeshDesc creased = creased_cube(odd, 6, 1), cornered = smooth;
    cornered.corner_indices = corners;
    cornered.corner_sharpnesses = odd;
    cornered.corner_count = 2;
    CoMesh want, mesh;
    assert_int_equal(make_mesh(&smooth, &want), 0);
    assert_int_equal(make_mesh(&creased, &mesh), 1);
    assert_same_mesh(&want, &mesh);
    co_mesh_destroy(&mesh);
    assert_int_equal(make_mesh(&cornered, &mesh), 1);
    assert_same_mesh(&want, &mesh);
    co_mesh_destroy(&mesh);
    co_mesh_destroy(&want);
}

static void wrong_creases_are_ignored_loudly(void **state)
{
    (void)state;
    const float sharpnesses[] = {5, 5, 5, 5, 5, 5, 5};
    const int32_t bad_lengths[] = {5, 5, 2, 2, 2, 1}, bad_indices[18] = {0, 99};
    CohortMeshDesc good = creased_cube(sharpnesses, 6, 1), smooth = cube_desc(0, 1);
    CohortMeshDesc bad[4] = {good, good, good, good};
    bad[0].crease_sharpness_count = 7;
    bad[1].crease_lengths = bad_lengths;
    bad[2].crease_indices = bad_indices;
    bad[3].crease_index_count = 17;
    CoMesh want, mesh;
    make_mesh(&smooth, &want);
    for (size_t k = 0; k < COUNT(bad); k++) {
        assert_int_equal(make_mesh(&bad[k], &mesh), 1);
        assert_same_mesh(&want, &mesh);
        co_mesh_destroy(&mesh);
    }
    const int32_t no_edge[] = {0, 6}, two[] = {2}, corner[] = {8};
    bad[0] = smooth;
    bad[0].crease_indices = no_edge;
    bad[0].crease_index_count = 2;
    bad[0].crease_lengths = two;
    bad[0].crease_count = bad[0].crease_sharpness_count = 1;
    bad[0].crease_sharpnesses = sharpnesses;
    assert_int_equal(make_mesh(&bad[0], &mesh), 1);
    co_mesh_destroy(&mesh);
    bad[1] = smooth;
    bad[1].corner_indices = corner;
    bad[1].corner_sharpnesses = sharpnesses;
    bad[1].corner_count = 1;
    assert_int_equal(make_mesh(&bad[1], &mesh), 1);
    co_mesh_destroy(&mesh);
    co_mesh_destroy(&want);
}

static void holes_change_no_neighbor(void **state)
{
    (void)state;
    const int32_t holes[] = {0, 4};
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_CATMULL_CLARK, 2);
    CoMesh whole, mesh;
    make_mesh(&desc, &whole);
    desc.hole_indices = holes;
    desc.hole_count = 2;
    assert_int_equal(make_mesh(&desc, &mesh), 0);
    assert_int_equal(mesh.tri_count, 4 * 32);
    const uint32_t face[] = {1, 2, 3, 5};
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        CoSurface a, b;
        co_mesh_surface(&mesh, t, 0.3f, 0.3f, &a);
        co_mesh_surface(&whole, face[t / 32] * 32 + t % 32, 0.3f, 0.3f, &b);
        assert_int_equal(a.face, face[t / 32]);
        assert_int_equal(a.ptex_face, b.ptex_face);
        assert_vec_near(a.p, (double)b.p.x, (double)b.p.y, (double)b.p.z, 1e-6);
        assert_vec_near(a.ns, (double)b.ns.x, (double)b.ns.y, (double)b.ns.z, 5e-5);
    }
    co_mesh_destroy(&whole);
    co_mesh_destroy(&mesh);
}

static double grid_area(CohortInterpolateBoundary boundary)
{
    static Cage cage;
    make_grid(&cage, 4, false);
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 4);
    desc.interpolate_boundary = boundary;
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    double area = mesh_area(&mesh);
    co_mesh_destroy(&mesh);
    return area;
}

static void boundaries_follow_their_rule(void **state)
{
    (void)state;
    assert_near(grid_area(COHORT_BOUNDARY_EDGE_AND_CORNER), 16.0, 1e-4);
    // The rounded corners of a cubic B-spline are cut off.
    assert_true(grid_area(COHORT_BOUNDARY_EDGE_ONLY) < 15.99);
    assert_true(grid_area(COHORT_BOUNDARY_EDGE_ONLY) > 15.0);
    // Only the four inner faces have all their neighbors.
    assert_near(grid_area(COHORT_BOUNDARY_NONE), 4.0, 1e-4);
}

// Volume of a torus of triangles under Catmull-Clark, which the triangle rule changes.
static double triangle_torus_volume(bool smooth)
{
    static Cage cage;
    make_torus(&cage, false, true);
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 2);
    desc.triangle_rule_smooth = smooth;
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 0);
    assert_int_equal(open_edges(&mesh), 0);
    double volume = mesh_volume6(&mesh) / 6;
    co_mesh_destroy(&mesh);
    return volume;
}

static void triangle_rule_matters(void **state)
{
    (void)state;
    double plain = triangle_torus_volume(false), smooth = triangle_torus_volume(true);
    assert_true(fabs(plain - smooth) > 1e-4 * plain);
    assert_near(plain, smooth, 0.05 * plain);
}

static void loop_takes_triangles_only(void **state)
{
    (void)state;
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_LOOP, 1);
    CoMesh mesh;
    CohortError err = {0};
    assert_false(co_mesh_create(&desc, &mesh, NULL, NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_SCENE);
    assert_non_null(strstr(err.message, "triangles"));
    assert_string_equal(err.prim_path, "/test/mesh");
}

// Builds with every scheme and level that may take it: a mesh or an error, and nothing leaks.
static void survive(const float *points, size_t point_count, const int32_t *counts, size_t faces,
                    const int32_t *indices, size_t index_count)
{
    for (int k = 0; k < 4 * 3; k++) {
        CohortMeshDesc desc = {.path = "/test/mesh",
                               .scheme = (CohortScheme)(k % 4),
                               .level = (uint32_t)k / 4,
                               .points = points,
                               .point_count = point_count,
                               .face_vertex_counts = counts,
                               .face_count = faces,
                               .face_vertex_indices = indices,
                               .face_vertex_index_count = index_count};
        CoMesh mesh;
        CohortError err = {0};
        if (co_mesh_create(&desc, &mesh, NULL, NULL, &err)) {
            for (uint32_t t = 0; t < mesh.tri_count; t++) {
                CoSurface s;
                co_mesh_surface(&mesh, t, 0.3f, 0.3f, &s);
                assert_true(co_is_finite3(s.p) && co_is_finite3(s.ng) && co_is_finite3(s.ns));
                assert_true(s.face < faces);
            }
            co_mesh_destroy(&mesh);
        } else {
            assert_non_null(strstr(err.message, "/test/mesh"));
        }
        assert_int_equal(co_memory_live(CO_MEMORY_GEOMETRY), 0);
    }
}

static void topology_no_surface_has(void **state)
{
    (void)state;
    const int32_t quads[] = {4, 4, 4}, triangles[] = {3, 3, 3, 3}, mixed[] = {4, 3, 5};
    const int32_t fan[] = {0, 1, 5, 4, 0, 1, 2, 3, 1, 0, 7, 6};       // three faces at one edge
    const int32_t bow_tie[] = {0, 1, 2, 0, 3, 4, 0, 5, 6, 7, 6, 5};   // faces meet at one vertex
    const int32_t twice[] = {0, 1, 2, 3, 0, 1, 2, 3, 3, 2, 1, 0};     // the same face again
    const int32_t collapsed[] = {0, 0, 1, 2, 1, 1, 1, 3, 4, 5, 3, 6}; // repeated vertices
    const int32_t flipped[] = {0, 1, 2, 1, 2, 3, 2, 3, 4, 3, 4, 5};   // windings disagree
    survive(cube_points, 8, quads, 3, fan, 12);
    survive(cube_points, 8, triangles, 4, bow_tie, 12);
    survive(cube_points, 8, quads, 3, twice, 12);
    survive(cube_points, 8, mixed, 3, collapsed, 12);
    survive(cube_points, 8, triangles, 4, flipped, 12);
    uint32_t random = 12345;
    for (int round = 0; round < 300; round++) {
        int32_t indices[12];
        for (int k = 0; k < 12; k++) {
            random = random * 1664525u + 1013904223u;
            indices[k] = (int32_t)(random >> 16) % 8;
        }
        survive(cube_points, 8, round % 2 ? quads : mixed, 3, indices, 12);
        survive(cube_points, 8, triangles, 4, indices, 12);
    }
}

static void untakable_faces_keep_numbers(void **state)
{
    (void)state;
    // Faces of two vertices and of one between the sides of a cube.
    const int32_t counts[] = {4, 2, 4, 4, 1, 4, 4, 4};
    const int32_t indices[] = {0, 3, 2, 1, 5, 6, 4, 5, 6, 7, 0, 1, 5, 4,
                               3, 2, 3, 7, 6, 0, 4, 7, 3, 1, 2, 6, 5};
    float corner[27];
    for (int k = 0; k < 27; k++)
        corner[k] = (float)k;
    const CohortPrimvarDesc primvar = {"f", COHORT_INTERPOLATION_FACE_VARYING, 1, corner, 27, NULL,
                                       0};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_CATMULL_CLARK,
                           .level = 1,
                           .primvars = &primvar,
                           .primvar_count = 1};
    SET_TOPOLOGY(desc, cube_points, counts, indices);
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 1);
    assert_int_equal(open_edges(&mesh), 0);
    assert_int_equal(mesh.tri_count, 48);
    assert_int_equal(mesh.ptex_face_count, 9);
    CoSurface s;
    float value[4];
    const uint32_t face[] = {0, 2, 3, 5, 6, 7}, ptex[] = {0, 3, 4, 6, 7, 8};
    const float first[] = {0, 6, 10, 15, 19, 23};
    for (uint32_t t = 0; t < 48; t += 8) {
        co_mesh_surface(&mesh, t, 0, 0, &s);
        assert_int_equal(s.face, face[t / 8]);
        assert_int_equal(s.ptex_face, ptex[t / 8]);
        co_mesh_primvar(&mesh, 0, t, 0, 0, value);
        assert_near((double)value[0], (double)first[t / 8], 1e-4);
    }
    co_mesh_destroy(&mesh);
}

// A quad with a collapsed edge is a triangle in disguise: it keeps its place among its neighbors.
static void collapsed_edges_leave_no_gap(void **state)
{
    (void)state;
    const float points[] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0};
    const int32_t counts[] = {4, 4, 3}, indices[] = {0, 1, 4, 3, 1, 2, 4, 4, 2, 5, 4};
    for (uint32_t level = 0; level <= 2; level++) {
        CohortMeshDesc desc = {.scheme = COHORT_SCHEME_BILINEAR, .level = level};
        SET_TOPOLOGY(desc, points, counts, indices);
        CoMesh mesh;
        assert_int_equal(make_mesh(&desc, &mesh), 0);
        assert_near(mesh_area(&mesh), 2.0, 1e-5);
        co_mesh_destroy(&mesh);
    }
}

static void broken_points_spread_no_further_than_they_must(void **state)
{
    (void)state;
    static Cage cage;
    make_grid(&cage, 8, false);
    cage.points[0] = NAN;
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 1);
    CoMesh mesh;
    assert_true(make_mesh(&desc, &mesh) > 0);
    assert_int_equal(mesh.tri_count, (64 - 4) * 8);
    for (uint32_t k = 0; k < 3 * mesh.tri_count; k++)
        assert_true(co_is_finite3(mesh_point(&mesh, k / 3, k % 3)));
    co_mesh_destroy(&mesh);

    make_grid(&cage, 8, false);
    for (int k = 0; k < 9; k++)
        cage.points[3 * (9 * k + 8)] = 3.4e38f * (k % 2 ? 1.0f : -1.0f);
    desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 3);
    make_mesh(&desc, &mesh);
    assert_true(mesh.tri_count >= 48 * 128);
    for (uint32_t k = 0; k < 3 * mesh.point_count; k++)
        assert_true(isfinite(mesh.points[k]));
    co_mesh_destroy(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(infinite_creases_keep_the_cube),
        cmocka_unit_test(sharpness_widens_the_surface),
        cmocka_unit_test(corners_stay_where_they_are),
        cmocka_unit_test(sharpness_that_is_no_number_is_said),
        cmocka_unit_test(wrong_creases_are_ignored_loudly),
        cmocka_unit_test(holes_change_no_neighbor),
        cmocka_unit_test(boundaries_follow_their_rule),
        cmocka_unit_test(triangle_rule_matters),
        cmocka_unit_test(loop_takes_triangles_only),
        cmocka_unit_test(topology_no_surface_has),
        cmocka_unit_test(untakable_faces_keep_numbers),
        cmocka_unit_test(collapsed_edges_leave_no_gap),
        cmocka_unit_test(broken_points_spread_no_further_than_they_must),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
