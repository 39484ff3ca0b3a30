// Primvars and normals of subdivision surfaces.

#include "subdivision_fixture.h"

static CoVec3 primvar3(const CoMesh *mesh, const char *name, uint32_t tri, float u, float v)
{
    float value[4];
    int primvar = co_mesh_primvar_find(mesh, name);
    assert_true(primvar >= 0);
    co_mesh_primvar(mesh, primvar, tri, u, v, value);
    return co_vec3_load(value);
}

// Positions as primvars of every kind tell what each kind does.
static void position_primvars(CohortScheme scheme, const Cage *cage, uint32_t level,
                              CohortFvarLinear rule, float linear_distance)
{
    int32_t in_order[CAGE_MAX_POINTS];
    for (int32_t k = 0; k < CAGE_MAX_POINTS; k++)
        in_order[k] = k;
    const CohortPrimvarDesc primvars[] = {
        {"vertex", COHORT_INTERPOLATION_VERTEX, 3, cage->points, cage->point_count, NULL, 0},
        {"indexed", COHORT_INTERPOLATION_VERTEX, 3, cage->points, cage->point_count, in_order,
         cage->point_count},
        {"varying", COHORT_INTERPOLATION_VARYING, 3, cage->points, cage->point_count, NULL, 0},
        {"corner", COHORT_INTERPOLATION_FACE_VARYING, 3, cage->points, cage->point_count,
         cage->indices, cage->index_count},
    };
    CohortMeshDesc desc = cage_desc(cage, scheme, level);
    desc.primvars = primvars;
    desc.primvar_count = COUNT(primvars);
    desc.fvar_linear = rule;
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 0);
    float most = 0.0f;
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        CoSurface s;
        co_mesh_surface(&mesh, t, 0.25f, 0.5f, &s);
        CoVec3 first = mesh_point(&mesh, t, 0);
        CoVec3 vertex = primvar3(&mesh, "vertex", t, 0.0f, 0.0f);
        CoVec3 indexed = primvar3(&mesh, "indexed", t, 0.0f, 0.0f);
        CoVec3 varying = primvar3(&mesh, "varying", t, 0.25f, 0.5f);
        CoVec3 corner = primvar3(&mesh, "corner", t, 0.25f, 0.5f);
        assert_memory_equal(&vertex, &first, sizeof vertex);
        assert_memory_equal(&indexed, &first, sizeof vertex);
        // The same topology and values: smooth as the surface, or linear if the rule says so.
        CoVec3 want = rule == COHORT_FVAR_ALL ? varying : s.p;
        assert_vec_near(corner, (double)want.x, (double)want.y, (double)want.z, 3e-6);
        most = fmaxf(most, co_length(co_sub(varying, s.p)));
    }
    assert_true(most <= linear_distance && most >= 0.1f * linear_distance);
    co_mesh_destroy(&mesh);
}

static void primvars_follow_their_kind(void **state)
{
    (void)state;
    static Cage mixed, triangles;
    make_torus(&mixed, true, false);
    make_torus(&triangles, false, true);
    for (uint32_t level = 0; level <= 3; level++) {
        position_primvars(COHORT_SCHEME_CATMULL_CLARK, &mixed, level, COHORT_FVAR_NONE, 0.7f);
        position_primvars(COHORT_SCHEME_CATMULL_CLARK, &mixed, level, COHORT_FVAR_ALL, 0.7f);
        position_primvars(COHORT_SCHEME_LOOP, &triangles, level, COHORT_FVAR_CORNERS_PLUS1, 0.7f);
        position_primvars(COHORT_SCHEME_LOOP, &triangles, level, COHORT_FVAR_ALL, 0.7f);
    }
}

static void bilinear_primvars_agree(void **state)
{
    (void)state;
    static Cage cage;
    make_torus(&cage, true, false);
    CohortPrimvarDesc primvars[] = {
        {"varying", COHORT_INTERPOLATION_VARYING, 3, cage.points, cage.point_count, NULL, 0},
        {"corner", COHORT_INTERPOLATION_FACE_VARYING, 3, cage.points, cage.point_count,
         cage.indices, cage.index_count},
    };
    for (uint32_t level = 0; level <= 2; level++) {
        CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_BILINEAR, level);
        desc.primvars = primvars;
        desc.primvar_count = 2;
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        for (uint32_t t = 0; t < mesh.tri_count; t++) {
            CoSurface s;
            co_mesh_surface(&mesh, t, 0.25f, 0.5f, &s);
            CoVec3 varying = primvar3(&mesh, "varying", t, 0.25f, 0.5f);
            CoVec3 corner = primvar3(&mesh, "corner", t, 0.25f, 0.5f);
            assert_vec_near(varying, (double)s.p.x, (double)s.p.y, (double)s.p.z, 2e-6);
            assert_vec_near(corner, (double)s.p.x, (double)s.p.y, (double)s.p.z, 2e-6);
        }
        co_mesh_destroy(&mesh);
    }
}

// Two faces whose texture coordinates do not meet keep their seam, and stay in their islands.
static void face_varying_seams_stay(void **state)
{
    (void)state;
    static Cage cage;
    make_grid(&cage, 2, false);
    float st[32];
    for (int k = 0; k < 16; k++) {
        const float quad[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        st[2 * k] = (float)(k / 4) * 10 + quad[k % 4][0];
        st[2 * k + 1] = quad[k % 4][1];
    }
    const CohortPrimvarDesc primvar = {"st", COHORT_INTERPOLATION_FACE_VARYING, 2, st, 16, NULL, 0};
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 2);
    desc.primvars = &primvar;
    desc.primvar_count = 1;
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        CoSurface s;
        CoTexCoord tc;
        co_mesh_surface(&mesh, t, 0.2f, 0.3f, &s);
        co_mesh_texcoord(&mesh, 0, t, 0.2f, 0.3f, &tc);
        assert_near((double)tc.s, (double)s.face * 10 + (double)s.ptex_u, 1e-4);
        assert_near((double)tc.t, (double)s.ptex_v, 1e-5);
        assert_vec_near(tc.dpds, (double)s.ptex_dpdu.x, (double)s.ptex_dpdu.y, 0, 1e-3);
    }
    co_mesh_destroy(&mesh);
}

// Largest s on a flat grid whose face-varying data are its positions, joined everywhere: only the
// rule for the data's own boundary decides how far its corners are rounded.
static float farthest_corner(CohortFvarLinear rule)
{
    static Cage cage;
    make_grid(&cage, 3, false);
    const CohortPrimvarDesc primvar = {"st",
                                       COHORT_INTERPOLATION_FACE_VARYING,
                                       3,
                                       cage.points,
                                       cage.point_count,
                                       cage.indices,
                                       cage.index_count};
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 2);
    desc.primvars = &primvar;
    desc.primvar_count = 1;
    desc.fvar_linear = rule;
    desc.interpolate_boundary = COHORT_BOUNDARY_EDGE_ONLY; // the surface itself is round there
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    float most = 0.0f;
    for (uint32_t t = 0; t < mesh.tri_count; t++)
        for (int c = 0; c < 3; c++) {
            CoVec3 st = primvar3(&mesh, "st", t, c == 1 ? 1.0f : 0.0f, c == 2 ? 1.0f : 0.0f);
            most = fmaxf(most, st.x + st.y);
        }
    co_mesh_destroy(&mesh);
    return most;
}

static void face_varying_rules_differ_at_corners(void **state)
{
    (void)state;
    assert_true(farthest_corner(COHORT_FVAR_NONE) < 5.9f);
    assert_near((double)farthest_corner(COHORT_FVAR_CORNERS_ONLY), 6, 1e-5);
    assert_near((double)farthest_corner(COHORT_FVAR_CORNERS_PLUS1), 6, 1e-5);
    assert_near((double)farthest_corner(COHORT_FVAR_CORNERS_PLUS2), 6, 1e-5);
    assert_near((double)farthest_corner(COHORT_FVAR_BOUNDARIES), 6, 1e-5);
    assert_near((double)farthest_corner(COHORT_FVAR_ALL), 6, 1e-5);
}

static void uniform_and_constant_pass_through(void **state)
{
    (void)state;
    static Cage cage;
    make_torus(&cage, true, false);
    float number[CAGE_MAX_FACES];
    for (int k = 0; k < CAGE_MAX_FACES; k++)
        number[k] = (float)k;
    const CohortPrimvarDesc primvars[] = {
        {"normals", COHORT_INTERPOLATION_VERTEX, 3, cage.points, cage.point_count, NULL, 0},
        {"face", COHORT_INTERPOLATION_UNIFORM, 1, number, cage.face_count, NULL, 0},
        {"c", COHORT_INTERPOLATION_CONSTANT, 1, number + 5, 1, NULL, 0},
    };
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 2);
    desc.primvars = primvars;
    desc.primvar_count = 3;
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    assert_int_equal(co_mesh_primvar_find(&mesh, "normals"), -1);
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        CoSurface s;
        co_mesh_surface(&mesh, t, 0.2f, 0.3f, &s);
        assert_near((double)primvar3(&mesh, "face", t, 0.2f, 0.3f).x, s.face, 0);
        assert_near((double)primvar3(&mesh, "c", t, 0.2f, 0.3f).x, 5, 0);
    }
    co_mesh_destroy(&mesh);
}

static void normals_are_those_of_the_limit(void **state)
{
    (void)state;
    // A torus of many quads is nearly round.
    static Cage cage;
    memset(&cage, 0, sizeof cage);
    enum {
        NU = 20,
        NV = 16
    };
    torus_points(&cage, NU, NV);
    for (int32_t f = 0; f < NU * NV; f++) {
        int32_t i = f % NU, j = f / NU, next = (i + 1) % NU, up = (j + 1) % NV;
        const int32_t v[] = {j * NU + i, j * NU + next, up * NU + next, up * NU + i};
        cage_face(&cage, 4, v);
    }
    for (int left = 0; left < 2; left++) {
        CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 3);
        desc.left_handed = left;
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        float least = 1.0f;
        for (uint32_t t = 0; t < mesh.tri_count; t++) {
            CoSurface s;
            co_mesh_surface(&mesh, t, 0.3f, 0.3f, &s);
            CoVec3 axis = co_normalize(co_vec3(s.p.x, s.p.y, 0));
            CoVec3 outward = co_normalize(co_sub(s.p, co_scale(axis, 3 * 0.97f)));
            if (left)
                outward = co_neg(outward);
            least = fminf(least, fminf(co_dot(s.ns, outward), co_dot(s.ng, outward)));
            assert_near((double)co_length(s.ns), 1, 1e-6);
        }
        assert_true(least > 0.98f);
        co_mesh_destroy(&mesh);
    }
}

static void left_handed_data_stays_in_place(void **state)
{
    (void)state;
    static Cage cage;
    make_torus(&cage, true, false);
    const CohortPrimvarDesc primvar = {"p",
                                       COHORT_INTERPOLATION_FACE_VARYING,
                                       3,
                                       cage.points,
                                       cage.point_count,
                                       cage.indices,
                                       cage.index_count};
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 1);
    desc.primvars = &primvar;
    desc.primvar_count = 1;
    CoMesh right, left;
    make_mesh(&desc, &right);
    desc.left_handed = true;
    make_mesh(&desc, &left);
    for (uint32_t t = 0; t < right.tri_count; t++) {
        CoSurface a, b;
        co_mesh_surface(&right, t, 0.3f, 0.3f, &a);
        co_mesh_surface(&left, t, 0.3f, 0.3f, &b);
        assert_memory_equal(&a.p, &b.p, sizeof a.p);
        assert_true(co_dot(a.ng, b.ng) < -0.999f);
        assert_true(co_dot(a.ns, b.ns) < -0.999f);
        CoVec3 p = primvar3(&left, "p", t, 0.3f, 0.3f), q = primvar3(&right, "p", t, 0.3f, 0.3f);
        assert_memory_equal(&p, &q, sizeof p);
    }
    co_mesh_destroy(&left);
    co_mesh_destroy(&right);
}

static void bilinear_normals_are_of_the_patch(void **state)
{
    (void)state;
    // z = x y over the unit square: normal (-y, -x, 1).
    const float points[] = {0, 0, 0, 1, 0, 0, 1, 1, 1, 0, 1, 0};
    const int32_t counts[] = {4}, indices[] = {0, 1, 2, 3};
    for (uint32_t level = 0; level <= 3; level++) {
        CohortMeshDesc desc = {.scheme = COHORT_SCHEME_BILINEAR, .level = level};
        SET_TOPOLOGY(desc, points, counts, indices);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        for (uint32_t t = 0; t < mesh.tri_count; t++) {
            CoSurface s;
            co_mesh_surface(&mesh, t, 0.3f, 0.4f, &s);
            CoVec3 want = co_normalize(co_vec3(-s.p.y, -s.p.x, 1));
            assert_vec_near(s.ns, (double)want.x, (double)want.y, (double)want.z, 1e-5);
        }
        co_mesh_destroy(&mesh);
    }
}

static void broken_values_become_zero(void **state)
{
    (void)state;
    float values[8] = {1, 1, 1, NAN, 1, 1, 1, 1};
    const CohortPrimvarDesc primvar = {"x", COHORT_INTERPOLATION_VERTEX, 1, values, 8, NULL, 0};
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_CATMULL_CLARK, 1);
    desc.primvars = &primvar;
    desc.primvar_count = 1;
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 1);
    for (uint32_t t = 0; t < mesh.tri_count; t++)
        assert_true(isfinite(primvar3(&mesh, "x", t, 0.3f, 0.3f).x));
    co_mesh_destroy(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(primvars_follow_their_kind),
        cmocka_unit_test(bilinear_primvars_agree),
        cmocka_unit_test(face_varying_seams_stay),
        cmocka_unit_test(face_varying_rules_differ_at_corners),
        cmocka_unit_test(uniform_and_constant_pass_through),
        cmocka_unit_test(normals_are_those_of_the_limit),
        cmocka_unit_test(left_handed_data_stays_in_place),
        cmocka_unit_test(bilinear_normals_are_of_the_patch),
        cmocka_unit_test(broken_values_become_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
