// UsdGeom's implicit shapes: closed, of the right size and place, smooth, textured.

#include "geometry/implicit.h"
#include "mesh_fixture.h"

static CoArena arena = {.tag = CO_MEMORY_SCENE};

static void make_implicit(const CoImplicitDesc *implicit, CoMesh *mesh)
{
    CohortMeshDesc desc;
    CohortError err = {0};
    if (!co_implicit_mesh(implicit, "/shape", &arena, &desc, &err))
        fail_msg("%s", err.message);
    assert_int_equal(make_mesh(&desc, mesh), 0);
}

static void done(CoMesh *mesh)
{
    co_mesh_destroy(mesh);
    co_arena_clear(&arena);
}

#define PI 3.14159265358979

// A closed mesh of that area and volume, smooth where `smooth` of its area is, for every axis.
static void check_solid(CoImplicitDesc implicit, double area, double volume)
{
    for (implicit.axis = 0; implicit.axis < 3; implicit.axis++) {
        CoMesh mesh;
        make_implicit(&implicit, &mesh);
        assert_int_equal(open_edges(&mesh), 0);
        assert_near(mesh_area(&mesh), area, 2e-3 * area);
        assert_near(mesh_volume6(&mesh) / 6, volume, 2e-3 * volume);
        int st = co_mesh_primvar_find(&mesh, "st");
        assert_true(st >= 0);
        for (uint32_t t = 0; t < mesh.tri_count; t++) {
            CoSurface s;
            CoTexCoord tc;
            co_mesh_surface(&mesh, t, 0.3f, 0.3f, &s);
            assert_near((double)co_length(s.ns), 1, 1e-6);
            assert_true(co_dot(s.ns, s.ng) > 0.998f);
            co_mesh_texcoord(&mesh, st, t, 0.3f, 0.3f, &tc);
            assert_true(tc.s >= 0 && tc.s <= 1 && tc.t >= 0 && tc.t <= 1);
            assert_true(co_length(tc.dpds) > 0 && co_length(tc.dpdt) > 0);
        }
        done(&mesh);
    }
}

static void solids_have_their_size(void **state)
{
    (void)state;
    check_solid((CoImplicitDesc){.kind = CO_IMPLICIT_SPHERE, .radius_bottom = 2}, 16 * PI,
                32 * PI / 3);
    check_solid((CoImplicitDesc){.kind = CO_IMPLICIT_CUBE, .size = 3}, 54, 27);
    check_solid((CoImplicitDesc){.kind = CO_IMPLICIT_CONE, .radius_bottom = 3, .height = 4},
                (9 + 15) * PI, 12 * PI);
    check_solid(
        (CoImplicitDesc){
            .kind = CO_IMPLICIT_CYLINDER, .radius_bottom = 1, .radius_top = 1, .height = 5},
        12 * PI, 5 * PI);
    check_solid(
        (CoImplicitDesc){
            .kind = CO_IMPLICIT_CYLINDER, .radius_bottom = 4, .radius_top = 1, .height = 4},
        (16 + 1 + 25) * PI, 28 * PI);
    check_solid(
        (CoImplicitDesc){
            .kind = CO_IMPLICIT_CYLINDER, .radius_bottom = 0, .radius_top = 3, .height = 4},
        (9 + 15) * PI, 12 * PI);
    check_solid(
        (CoImplicitDesc){
            .kind = CO_IMPLICIT_CAPSULE, .radius_bottom = 1, .radius_top = 1, .height = 2},
        (4 + 4) * PI, (4.0 / 3 + 2) * PI);
    check_solid(
        (CoImplicitDesc){
            .kind = CO_IMPLICIT_CAPSULE, .radius_bottom = 1, .radius_top = 1, .height = 0},
        4 * PI, 4 * PI / 3);
    check_solid(
        (CoImplicitDesc){
            .kind = CO_IMPLICIT_CAPSULE, .radius_bottom = 4, .radius_top = 1, .height = 4},
        (32 + 2 + 25) * PI, (128 + 2) * PI / 3 + 28 * PI);
}

static void ends_lie_along_the_axis(void **state)
{
    (void)state;
    CoImplicitDesc cone = {.kind = CO_IMPLICIT_CONE, .radius_bottom = 1, .height = 6, .axis = 0};
    CoMesh mesh;
    make_implicit(&cone, &mesh);
    assert_vec_near(mesh.box_min, -3, -1, -1, 1e-6);
    assert_vec_near(mesh.box_max, 3, 1, 1, 1e-6);
    float widest_at = 0, widest = 0;
    for (uint32_t k = 0; k < mesh.point_count; k++) {
        const float *p = mesh.points + 3 * k;
        if (p[1] * p[1] + p[2] * p[2] > widest) {
            widest = p[1] * p[1] + p[2] * p[2];
            widest_at = p[0];
        }
    }
    assert_near((double)widest_at, -3, 0);
    done(&mesh);
    CoImplicitDesc capsule = {
        .kind = CO_IMPLICIT_CAPSULE, .radius_bottom = 2, .radius_top = 1, .height = 4, .axis = 1};
    make_implicit(&capsule, &mesh);
    assert_vec_near(mesh.box_min, -2, -4, -2, 1e-6);
    assert_vec_near(mesh.box_max, 2, 3, 2, 1e-6);
    done(&mesh);
}

static void planes_face_their_axis(void **state)
{
    (void)state;
    // Width and length along: z and y, x and z, x and y.
    const double box[3][3] = {{0, 3, 1}, {1, 0, 3}, {1, 3, 0}};
    for (int axis = 0; axis < 3; axis++) {
        CoImplicitDesc plane = {.kind = CO_IMPLICIT_PLANE, .axis = axis, .width = 2, .length = 6};
        CoMesh mesh;
        make_implicit(&plane, &mesh);
        assert_int_equal(mesh.tri_count, 2);
        assert_vec_near(mesh.box_max, box[axis][0], box[axis][1], box[axis][2], 0);
        assert_vec_near(mesh.box_min, -box[axis][0], -box[axis][1], -box[axis][2], 0);
        CoSurface s;
        CoTexCoord tc;
        co_mesh_surface(&mesh, 0, 0.25f, 0.25f, &s);
        assert_vec_near(s.ng, axis == 0, axis == 1, axis == 2, 0);
        co_mesh_texcoord(&mesh, 0, 0, 0.25f, 0.25f, &tc);
        assert_near((double)co_length(tc.dpds), 2, 1e-6);
        assert_near((double)co_length(tc.dpdt), 6, 1e-6);
        done(&mesh);
    }
}

static void sphere_normals_are_radial(void **state)
{
    (void)state;
    CoImplicitDesc sphere = {.kind = CO_IMPLICIT_SPHERE, .radius_bottom = 5};
    CoMesh mesh;
    make_implicit(&sphere, &mesh);
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        CoSurface s;
        co_mesh_surface(&mesh, t, 0.5f, 0.25f, &s);
        assert_true(co_dot(s.ns, co_normalize(s.p)) > 0.99999f);
    }
    done(&mesh);
}

static void nothing_of_no_size(void **state)
{
    (void)state;
    CoImplicitDesc sphere = {.kind = CO_IMPLICIT_SPHERE};
    CoMesh mesh;
    make_implicit(&sphere, &mesh);
    assert_int_equal(mesh.tri_count, 0);
    done(&mesh);
}

static void bad_sizes_are_refused_by_name(void **state)
{
    (void)state;
    const double bad[] = {-1, (double)NAN, (double)INFINITY, -(double)INFINITY, 1e300};
    for (int kind = 0; kind <= CO_IMPLICIT_PLANE; kind++) {
        for (size_t k = 0; k < COUNT(bad); k++) {
            CoImplicitDesc implicit = {.kind = (CoImplicit)kind,
                                       .radius_bottom = bad[k],
                                       .height = 1,
                                       .size = bad[k],
                                       .width = 1,
                                       .length = bad[k]};
            CohortMeshDesc desc = {.level = 9};
            CohortError err = {0};
            assert_false(co_implicit_mesh(&implicit, "/shape", &arena, &desc, &err));
            assert_int_equal(err.code, COHORT_ERROR_SCENE);
            assert_non_null(strstr(err.message, "/shape"));
            assert_string_equal(err.prim_path, "/shape");
            assert_int_equal(desc.level, 9);
        }
    }
    CoImplicitDesc implicit = {.kind = CO_IMPLICIT_PLANE, .axis = 3};
    CohortMeshDesc desc;
    assert_false(co_implicit_mesh(&implicit, "/shape", &arena, &desc, NULL));
    implicit = (CoImplicitDesc){.kind = (CoImplicit)17};
    assert_false(co_implicit_mesh(&implicit, "/shape", &arena, &desc, NULL));
}

// The name is that of the attribute: one radius for both ends, or two.
static void bad_radii_are_named_apart(void **state)
{
    (void)state;
    const struct {
        double bottom, top;
        const char *said;
    } cases[] = {{-1, -1, "radius is"},
                 {-1, 1, "radiusBottom is"},
                 {1, -1, "radiusTop is"},
                 {(double)NAN, (double)NAN, "radius is"}};
    for (size_t i = 0; i < COUNT(cases); i++) {
        CoImplicitDesc implicit = {.kind = CO_IMPLICIT_CYLINDER,
                                   .height = 1,
                                   .radius_bottom = cases[i].bottom,
                                   .radius_top = cases[i].top};
        CohortMeshDesc desc;
        CohortError err = {0};
        assert_false(co_implicit_mesh(&implicit, "/shape", &arena, &desc, &err));
        assert_non_null(strstr(err.message, cases[i].said));
    }
}

static void memory_that_runs_out(void **state)
{
    (void)state;
    for (int kind = 0; kind <= CO_IMPLICIT_PLANE; kind++) {
        CoImplicitDesc implicit = {.kind = (CoImplicit)kind,
                                   .radius_bottom = 1,
                                   .radius_top = 1,
                                   .height = 1,
                                   .size = 1,
                                   .width = 1,
                                   .length = 1};
        CohortMeshDesc desc;
        CohortError err = {0};
        co_memory_fail_after(1);
        assert_false(co_implicit_mesh(&implicit, "/shape", &arena, &desc, &err));
        co_memory_fail_after(0);
        assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        co_arena_clear(&arena);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solids_have_their_size),
        cmocka_unit_test(ends_lie_along_the_axis),
        cmocka_unit_test(planes_face_their_axis),
        cmocka_unit_test(sphere_normals_are_radial),
        cmocka_unit_test(nothing_of_no_size),
        cmocka_unit_test(bad_sizes_are_refused_by_name),
        cmocka_unit_test(bad_radii_are_named_apart),
        cmocka_unit_test(memory_that_runs_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
