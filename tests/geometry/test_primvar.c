// Primvars of polygon meshes: every interpolation, indexed or not, and what is dropped.

#include "mesh_fixture.h"

// A unit square of one quad beside a triangle, in the xy plane.
static const float house_points[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 2, 0.5f, 0};
static const int32_t house_counts[] = {4, 3};
static const int32_t house_indices[] = {0, 1, 2, 3, 1, 4, 2};

static CohortMeshDesc house_desc(const CohortPrimvarDesc *primvars, size_t count)
{
    CohortMeshDesc desc = {
        .scheme = COHORT_SCHEME_NONE, .primvars = primvars, .primvar_count = count};
    SET_TOPOLOGY(desc, house_points, house_counts, house_indices);
    return desc;
}

static float eval1(const CoMesh *mesh, const char *name, uint32_t tri, float u, float v)
{
    float value[4];
    co_mesh_primvar(mesh, co_mesh_primvar_find(mesh, name), tri, u, v, value);
    return value[0];
}

static void each_interpolation(void **state)
{
    (void)state;
    const float constant[] = {3}, uniform[] = {10, 20}, point[] = {0, 1, 2, 3, 4};
    const float corner[] = {0, 1, 2, 3, 10, 11, 12};
    const CohortPrimvarDesc primvars[] = {
        {"c", COHORT_INTERPOLATION_CONSTANT, 1, constant, 1, NULL, 0},
        {"u", COHORT_INTERPOLATION_UNIFORM, 1, uniform, 2, NULL, 0},
        {"va", COHORT_INTERPOLATION_VARYING, 1, point, 5, NULL, 0},
        {"ve", COHORT_INTERPOLATION_VERTEX, 1, point, 5, NULL, 0},
        {"f", COHORT_INTERPOLATION_FACE_VARYING, 1, corner, 7, NULL, 0},
    };
    CohortMeshDesc desc = house_desc(primvars, COUNT(primvars));
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 0);
    for (uint32_t t = 0; t < 3; t++)
        assert_near((double)eval1(&mesh, "c", t, 0.2f, 0.3f), 3, 0);
    assert_near((double)eval1(&mesh, "u", 1, 0.2f, 0.3f), 10, 0);
    assert_near((double)eval1(&mesh, "u", 2, 0.2f, 0.3f), 20, 0);
    // Triangle 1 is corners 0, 2, 3 of the quad; triangle 2 is points 1, 4, 2.
    assert_near((double)eval1(&mesh, "va", 1, 0.5f, 0.25f), 0.25 * 0 + 0.5 * 2 + 0.25 * 3, 1e-6);
    assert_near((double)eval1(&mesh, "ve", 2, 0.5f, 0.25f), 0.25 * 1 + 0.5 * 4 + 0.25 * 2, 1e-6);
    assert_near((double)eval1(&mesh, "f", 2, 0.5f, 0.25f), 0.25 * 10 + 0.5 * 11 + 0.25 * 12, 1e-5);
    assert_int_equal(co_mesh_primvar_find(&mesh, "none"), -1);
    co_mesh_destroy(&mesh);
}

static void indexed_values_and_missing_components(void **state)
{
    (void)state;
    const float values[] = {5, 6, 7, 8};
    const int32_t uniform[] = {1, 0}, corner[] = {0, 1, 1, 0, 1, 1, 1}, constant[] = {1};
    const CohortPrimvarDesc primvars[] = {
        {"u", COHORT_INTERPOLATION_UNIFORM, 2, values, 2, uniform, 2},
        {"f", COHORT_INTERPOLATION_FACE_VARYING, 2, values, 2, corner, 7},
        {"c", COHORT_INTERPOLATION_CONSTANT, 2, values, 2, constant, 1},
    };
    CohortMeshDesc desc = house_desc(primvars, COUNT(primvars));
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 0);
    float out[4];
    co_mesh_primvar(&mesh, 0, 0, 0.1f, 0.1f, out);
    assert_near((double)out[0], 7, 0);
    assert_near((double)out[1], 8, 0);
    assert_near((double)out[2], 0, 0);
    assert_near((double)out[3], 1, 0);
    co_mesh_primvar(&mesh, 1, 0, 0.5f, 0.0f, out);
    assert_near((double)out[0], 6, 1e-6);
    assert_near((double)eval1(&mesh, "c", 1, 0, 0), 7, 0);
    co_mesh_primvar(&mesh, -1, 0, 0.5f, 0.0f, out);
    assert_near((double)out[3], 1, 0);
    co_mesh_destroy(&mesh);
}

static void unusable_primvars_are_dropped_by_name(void **state)
{
    (void)state;
    const float values[8] = {0};
    const int32_t out_of_range[] = {0, 8}, negative[] = {0, -1};
    const CohortPrimvarDesc bad[] = {
        {"short", COHORT_INTERPOLATION_VERTEX, 1, values, 4, NULL, 0},
        {"long", COHORT_INTERPOLATION_UNIFORM, 1, values, 3, NULL, 0},
        {"range", COHORT_INTERPOLATION_UNIFORM, 1, values, 8, out_of_range, 2},
        {"negative", COHORT_INTERPOLATION_UNIFORM, 1, values, 8, negative, 2},
        {"few", COHORT_INTERPOLATION_FACE_VARYING, 1, values, 8, out_of_range, 2},
        {"wide", COHORT_INTERPOLATION_CONSTANT, 5, values, 1, NULL, 0},
        {"empty", COHORT_INTERPOLATION_CONSTANT, 1, NULL, 0, NULL, 0},
        {"null", COHORT_INTERPOLATION_UNIFORM, 1, NULL, 2, NULL, 0},
        {"kind", (CohortInterpolation)9, 1, values, 1, NULL, 0},
    };
    for (size_t k = 0; k < COUNT(bad); k++) {
        CohortMeshDesc desc = house_desc(&bad[k], 1);
        CoMesh mesh;
        Warnings warnings = {0};
        assert_true(co_mesh_create(&desc, &mesh, count_warning, &warnings, NULL));
        assert_int_equal(warnings.count, 1);
        assert_non_null(strstr(warnings.last, bad[k].name));
        assert_int_equal(co_mesh_primvar_find(&mesh, bad[k].name), -1);
        co_mesh_destroy(&mesh);
    }
}

static void broken_values_become_zero(void **state)
{
    (void)state;
    const float values[] = {NAN, INFINITY, 2, 3, 4};
    const CohortPrimvarDesc primvar = {"x", COHORT_INTERPOLATION_VERTEX, 1, values, 5, NULL, 0};
    CohortMeshDesc desc = house_desc(&primvar, 1);
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 1);
    assert_near((double)eval1(&mesh, "x", 0, 0.0f, 0.5f), 1, 1e-6);
    co_mesh_destroy(&mesh);
}

static void texture_coordinates_have_derivatives(void **state)
{
    (void)state;
    // s = 2x + y, t = 3y + 1
    float st[10];
    for (size_t k = 0; k < 5; k++) {
        st[2 * k] = 2 * house_points[3 * k] + house_points[3 * k + 1];
        st[2 * k + 1] = 3 * house_points[3 * k + 1] + 1;
    }
    const float flat[] = {0.5f, 0.5f};
    const CohortPrimvarDesc primvars[] = {
        {"st", COHORT_INTERPOLATION_VERTEX, 2, st, 5, NULL, 0},
        {"flat", COHORT_INTERPOLATION_CONSTANT, 2, flat, 1, NULL, 0},
    };
    CohortMeshDesc desc = house_desc(primvars, 2);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    for (uint32_t t = 0; t < 3; t++) {
        CoTexCoord tc;
        CoSurface s;
        co_mesh_texcoord(&mesh, 0, t, 0.3f, 0.4f, &tc);
        co_mesh_surface(&mesh, t, 0.3f, 0.4f, &s);
        assert_near((double)tc.s, (double)(2 * s.p.x + s.p.y), 1e-5);
        assert_near((double)tc.t, (double)(3 * s.p.y + 1), 1e-5);
        assert_vec_near(tc.dpds, 0.5, 0, 0, 1e-5);
        assert_vec_near(tc.dpdt, -1.0 / 6, 1.0 / 3, 0, 1e-5);
        co_mesh_texcoord(&mesh, 1, t, 0.3f, 0.4f, &tc);
        assert_near((double)tc.s, 0.5, 0);
        assert_vec_near(tc.dpds, 0, 0, 0, 0);
        co_mesh_texcoord(&mesh, -1, t, 0.3f, 0.4f, &tc);
        assert_vec_near(tc.dpdt, 0, 0, 0, 0);
    }
    co_mesh_destroy(&mesh);
}

static void collapsed_texture_coordinates_have_none(void **state)
{
    (void)state;
    const float st[10] = {0, 0, 1, 1, 2, 2, 3, 3, 4, 4};
    const CohortPrimvarDesc primvar = {"st", COHORT_INTERPOLATION_VERTEX, 2, st, 5, NULL, 0};
    CohortMeshDesc desc = house_desc(&primvar, 1);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    CoTexCoord tc;
    co_mesh_texcoord(&mesh, 0, 0, 0.3f, 0.4f, &tc);
    assert_vec_near(tc.dpds, 0, 0, 0, 0);
    assert_vec_near(tc.dpdt, 0, 0, 0, 0);
    co_mesh_destroy(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_interpolation),
        cmocka_unit_test(indexed_values_and_missing_components),
        cmocka_unit_test(unusable_primvars_are_dropped_by_name),
        cmocka_unit_test(broken_values_become_zero),
        cmocka_unit_test(texture_coordinates_have_derivatives),
        cmocka_unit_test(collapsed_texture_coordinates_have_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
