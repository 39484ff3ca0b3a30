// Triangulation of polygon meshes.

#include "mesh_fixture.h"

static void cube_is_closed_and_outward(void **state)
{
    (void)state;
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_NONE, 3);
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 0);
    assert_int_equal(mesh.tri_count, 12);
    assert_int_equal(mesh.point_count, 8);
    assert_int_equal(mesh.face_count, 6);
    assert_int_equal(open_edges(&mesh), 0);
    assert_near(mesh_area(&mesh), 24.0, 1e-5);
    assert_near(mesh_volume6(&mesh), 48.0, 1e-5);
    assert_vec_near(mesh.box_min, -1, -1, -1, 0);
    assert_vec_near(mesh.box_max, 1, 1, 1, 0);
    CoSurface s;
    co_mesh_surface(&mesh, 2, 0.25f, 0.5f, &s);
    assert_vec_near(s.ng, 0, 0, 1, 0);
    assert_int_equal(s.face, 1);
    co_mesh_destroy(&mesh);
    assert_int_equal(co_memory_live(CO_MEMORY_GEOMETRY), 0);
}

// Area of one polygon's triangles, each of which must turn the same way.
static double polygon_area(const float *points, const int32_t *counts, const int32_t *indices)
{
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE,
                           .path = "/polygon",
                           .points = points,
                           .point_count = (size_t)counts[0],
                           .face_vertex_counts = counts,
                           .face_count = 1,
                           .face_vertex_indices = indices,
                           .face_vertex_index_count = (size_t)counts[0]};
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 0);
    assert_int_equal(mesh.tri_count, counts[0] - 2);
    CoSurface first, s;
    co_mesh_surface(&mesh, 0, 0.3f, 0.3f, &first);
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        co_mesh_surface(&mesh, t, 0.3f, 0.3f, &s);
        if (tri_area(&mesh, t) > 0.0)
            assert_true(co_dot(first.ng, s.ng) > 0.0f);
    }
    double area = mesh_area(&mesh);
    co_mesh_destroy(&mesh);
    return area;
}

static const int32_t in_order[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};

static void concave_quads_split_inside(void **state)
{
    (void)state;
    // An arrow head with its notch at each corner in turn: area 1 wherever the cage starts.
    const float arrow[4][2] = {{0, 0}, {2, -1}, {1, 0}, {2, 1}};
    for (size_t start = 0; start < 4; start++) {
        float points[12];
        for (size_t k = 0; k < 4; k++) {
            points[3 * k] = arrow[(start + k) % 4][0];
            points[3 * k + 1] = arrow[(start + k) % 4][1];
            points[3 * k + 2] = 5.0f;
        }
        const int32_t counts[] = {4};
        assert_near(polygon_area(points, counts, in_order), 1.0, 1e-6);
    }
}

static void convex_quad_splits_along_0_2(void **state)
{
    (void)state;
    const float points[] = {0, 0, 0, 1, 0, 0, 1, 1, 0.5f, 0, 1, 0};
    const int32_t counts[] = {4}, indices[] = {0, 1, 2, 3};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE};
    SET_TOPOLOGY(desc, points, counts, indices);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    const uint32_t want[] = {0, 1, 2, 0, 2, 3};
    assert_memory_equal(mesh.indices, want, sizeof want);
    co_mesh_destroy(&mesh);
}

static void concave_polygons_keep_their_area(void **state)
{
    (void)state;
    // A comb in the yz plane, 12 vertices: a 5 x 1 base with three 1 x 2 teeth.
    const float yz[12][2] = {{0, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1}, {3, 1},
                             {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
    for (size_t start = 0; start < 12; start++) {
        float points[36];
        for (size_t k = 0; k < 12; k++) {
            points[3 * k] = -2.0f;
            points[3 * k + 1] = yz[(start + k) % 12][0];
            points[3 * k + 2] = yz[(start + k) % 12][1];
        }
        const int32_t counts[] = {12};
        assert_near(polygon_area(points, counts, in_order), 5.0 + 3 * 2.0, 1e-5);
    }
}

static void hopeless_polygons_still_end(void **state)
{
    (void)state;
    const float line[] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0};
    const float star[] = {0, 1, 0, 0.6f, -0.8f, 0, -1, 0.3f, 0, 1, 0.3f, 0, -0.6f, -0.8f, 0};
    const float one_point[15] = {0};
    const float bow[] = {0, 0, 0, 1, 1, 0, 1, 0, 0, 0, 1, 0};
    const int32_t five[] = {5}, four[] = {4};
    assert_near(polygon_area(line, five, in_order), 0.0, 0.0);
    assert_near(polygon_area(one_point, five, in_order), 0.0, 0.0);
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE,
                           .points = star,
                           .point_count = 5,
                           .face_vertex_counts = five,
                           .face_count = 1,
                           .face_vertex_indices = in_order,
                           .face_vertex_index_count = 5};
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    assert_int_equal(mesh.tri_count, 3);
    co_mesh_destroy(&mesh);
    desc.points = bow;
    desc.point_count = 4;
    desc.face_vertex_counts = four;
    desc.face_vertex_index_count = 4;
    make_mesh(&desc, &mesh);
    assert_int_equal(mesh.tri_count, 2);
    co_mesh_destroy(&mesh);
}

static void huge_polygon_is_a_fan(void **state)
{
    (void)state;
    enum {
        N = 5000
    };
    static float points[3 * N];
    static int32_t indices[N];
    for (int k = 0; k < N; k++) {
        double angle = 6.283185307179586 * k / N;
        points[3 * k] = (float)cos(angle);
        points[3 * k + 1] = (float)sin(angle);
        indices[k] = k;
    }
    const int32_t counts[] = {N};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE};
    SET_TOPOLOGY(desc, points, counts, indices);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    assert_int_equal(mesh.tri_count, N - 2);
    assert_near(mesh_area(&mesh), 3.14159265, 1e-4);
    CoSurface s;
    co_mesh_surface(&mesh, N / 2, 0.3f, 0.3f, &s);
    assert_int_equal(s.face, 0);
    assert_true(s.ptex_face < N);
    co_mesh_destroy(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cube_is_closed_and_outward),
        cmocka_unit_test(concave_quads_split_inside),
        cmocka_unit_test(convex_quad_splits_along_0_2),
        cmocka_unit_test(concave_polygons_keep_their_area),
        cmocka_unit_test(hopeless_polygons_still_end),
        cmocka_unit_test(huge_polygon_is_a_fan),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
