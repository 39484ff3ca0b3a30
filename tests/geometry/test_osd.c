// The OpenSubdiv shim alone: what it refuses, what it complains about, its coordinates. Also
// tests osd_topology.cpp.

#include "mesh_fixture.h"
#include "shims/osd.h"

static CoOsdDesc cube_osd(void)
{
    CoOsdDesc desc = {.scheme = COHORT_SCHEME_CATMULL_CLARK,
                      .vertex_count = 8,
                      .face_count = 6,
                      .face_vertex_counts = cube_counts,
                      .face_vertex_indices = cube_indices,
                      .exact_level = 2};
    return desc;
}

static CoOsdMesh *make_osd(const CoOsdDesc *desc, bool expect_warning)
{
    char warning[256];
    CohortError err = {0};
    CoOsdMesh *mesh = co_osd_create(desc, warning, &err);
    if (!mesh)
        fail_msg("%s", err.message);
    assert_int_equal(warning[0] != 0, expect_warning);
    return mesh;
}

static void edges_join_their_face_vertices(void **state)
{
    (void)state;
    CoOsdDesc desc = cube_osd();
    CoOsdMesh *mesh = make_osd(&desc, false);
    assert_int_equal(co_osd_edge_count(mesh), 12);
    int uses[12] = {0};
    for (uint32_t f = 0; f < 6; f++) {
        const int32_t *edges = co_osd_face_edges(mesh, f);
        for (uint32_t k = 0; k < 4; k++) {
            uint32_t ends[2], a = (uint32_t)cube_indices[4 * f + k];
            uint32_t b = (uint32_t)cube_indices[4 * f + (k + 1) % 4];
            co_osd_edge_vertices(mesh, (uint32_t)edges[k], ends);
            assert_true((ends[0] == a && ends[1] == b) || (ends[0] == b && ends[1] == a));
            uses[edges[k]]++;
        }
    }
    for (int e = 0; e < 12; e++)
        assert_int_equal(uses[e], 2);
    assert_false(co_osd_has_normal_seams(mesh));
    co_osd_destroy(mesh);
}

static void infinite_creases_are_seams(void **state)
{
    (void)state;
    const int32_t pair[] = {0, 1}, diagonal[] = {0, 6}, corner[] = {3};
    float sharpness = 9.5f;
    CoOsdDesc desc = cube_osd();
    desc.crease_pairs = pair;
    desc.crease_sharpnesses = &sharpness;
    desc.crease_count = 1;
    CoOsdMesh *mesh = make_osd(&desc, false);
    assert_false(co_osd_has_normal_seams(mesh));
    co_osd_destroy(mesh);
    sharpness = 10.0f;
    mesh = make_osd(&desc, false);
    assert_true(co_osd_has_normal_seams(mesh));
    co_osd_destroy(mesh);
    desc.crease_pairs = diagonal; // no edge of the cube
    mesh = make_osd(&desc, true);
    assert_false(co_osd_has_normal_seams(mesh));
    co_osd_destroy(mesh);
    desc.crease_count = 0;
    desc.corners = corner;
    desc.corner_sharpnesses = &sharpness;
    desc.corner_count = 1;
    mesh = make_osd(&desc, false);
    assert_true(co_osd_has_normal_seams(mesh));
    co_osd_destroy(mesh);
}

static void bad_topology_is_refused_with_its_reason(void **state)
{
    (void)state;
    CoOsdDesc desc = cube_osd();
    desc.scheme = COHORT_SCHEME_LOOP; // of quads
    char warning[256];
    CohortError err = {0};
    assert_null(co_osd_create(&desc, warning, &err));
    assert_int_equal(err.code, COHORT_ERROR_SCENE);
    assert_non_null(strstr(err.message, "OpenSubdiv"));
    co_osd_destroy(NULL);
    co_osd_surface_destroy(NULL);
}

// One polygon of so many sides, whose irregular center would take minutes.
static void endless_valences_are_refused(void **state)
{
    (void)state;
    enum {
        SIDES = 20000
    };
    static int32_t indices[SIDES];
    for (int32_t k = 0; k < SIDES; k++)
        indices[k] = k;
    const int32_t counts[] = {SIDES};
    CoOsdDesc desc = {.scheme = COHORT_SCHEME_CATMULL_CLARK,
                      .vertex_count = SIDES,
                      .face_count = 1,
                      .face_vertex_counts = counts,
                      .face_vertex_indices = indices};
    char warning[256];
    CohortError err = {0};
    assert_null(co_osd_create(&desc, warning, &err));
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
    assert_non_null(strstr(err.message, "20000"));
    desc.scheme = COHORT_SCHEME_BILINEAR;
    co_osd_destroy(make_osd(&desc, false));
}

// Coordinates of a hexagon's sub-faces: corner, middle of the next edge, center, middle of the
// last.
static void sub_faces_start_at_their_vertex(void **state)
{
    (void)state;
    const float p[] = {0, 0, 0, 2, 0, 0, 3, 1, 0, 2, 2, 0, 0, 2, 0, -1, 1, 0};
    const int32_t counts[] = {6}, indices[] = {0, 1, 2, 3, 4, 5};
    CoOsdDesc desc = {.scheme = COHORT_SCHEME_BILINEAR,
                      .vertex_count = 6,
                      .face_count = 1,
                      .face_vertex_counts = counts,
                      .face_vertex_indices = indices};
    CoOsdMesh *mesh = make_osd(&desc, false);
    CohortError err = {0};
    CoOsdSurface *surface = co_osd_surface_create(mesh, &err);
    bool finite = false;
    assert_true(co_osd_surface_begin(surface, 0, -1, &err));
    assert_true(co_osd_surface_values(surface, p, 3, &finite, &err));
    assert_true(finite);
    for (uint32_t k = 0; k < 6; k++) {
        const CoOsdCoord coords[] = {{k, 0, 0}, {k, 1, 0}, {k, 1, 1}, {k, 0, 1}};
        float out[12], du[12], dv[12];
        assert_true(co_osd_surface_eval(surface, coords, 4, out, du, dv, &err));
        const float *own = p + 3 * k, *next = p + 3 * ((k + 1) % 6), *last = p + 3 * ((k + 5) % 6);
        for (int c = 0; c < 2; c++) {
            assert_near((double)out[c], (double)own[c], 1e-6);
            assert_near((double)out[3 + c], (double)(own[c] + next[c]) / 2, 1e-6);
            assert_near((double)out[6 + c], 1, 1e-6);
            assert_near((double)out[9 + c], (double)(own[c] + last[c]) / 2, 1e-6);
        }
        assert_true(du[0] * dv[1] - du[1] * dv[0] > 0);
    }
    co_osd_surface_destroy(surface);
    co_osd_destroy(mesh);
}

static void broken_control_values_are_seen(void **state)
{
    (void)state;
    float points[24];
    memcpy(points, cube_points, sizeof points);
    points[4] = NAN;
    CoOsdDesc desc = cube_osd();
    CoOsdMesh *mesh = make_osd(&desc, false);
    CohortError err = {0};
    CoOsdSurface *surface = co_osd_surface_create(mesh, &err);
    bool finite = true, has = false;
    assert_true(co_osd_face_has_limit(mesh, 0, &has, &err));
    assert_true(has);
    assert_true(co_osd_surface_begin(surface, 0, -1, &err));
    assert_true(co_osd_surface_values(surface, points, 3, &finite, &err));
    assert_false(finite);
    co_osd_surface_destroy(surface);
    co_osd_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edges_join_their_face_vertices),
        cmocka_unit_test(infinite_creases_are_seams),
        cmocka_unit_test(bad_topology_is_refused_with_its_reason),
        cmocka_unit_test(endless_valences_are_refused),
        cmocka_unit_test(sub_faces_start_at_their_vertex),
        cmocka_unit_test(broken_control_values_are_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
