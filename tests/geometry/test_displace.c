// Displacement: where points go, that faces stay together, and which normals come of it.

#include "displace_check.h"
#include "limit_shapes.h"

// ---- How far -----------------------------------------------------------------------------------

static bool by_constant(void *cookie, const CoDisplacePoint *points, size_t count, float *amounts,
                        CohortError *err)
{
    (void)points;
    (void)err;
    for (size_t k = 0; k < count; k++)
        amounts[k] = *(const float *)cookie;
    return true;
}

// z = 0.1 x y on a flat grid.
static bool by_saddle(void *cookie, const CoDisplacePoint *points, size_t count, float *amounts,
                      CohortError *err)
{
    (void)err;
    for (size_t k = 0; k < count; k++) {
        CoSurface s;
        co_mesh_surface(cookie, points[k].tri, points[k].u, points[k].v, &s);
        amounts[k] = 0.1f * s.p.x * s.p.y;
    }
    return true;
}

static bool by_nonsense(void *cookie, const CoDisplacePoint *points, size_t count, float *amounts,
                        CohortError *err)
{
    (void)cookie;
    (void)points;
    (void)err;
    for (size_t k = 0; k < count; k++)
        amounts[k] = k % 3 == 0 ? NAN : k % 3 == 1 ? INFINITY : 1e38f;
    return true;
}

static bool by_failing(void *cookie, const CoDisplacePoint *points, size_t count, float *amounts,
                       CohortError *err)
{
    (void)cookie;
    (void)points;
    (void)count;
    (void)amounts;
    err->code = COHORT_ERROR_SCENE;
    return false;
}

static CoDisplaceCounts displace(CoMesh *mesh, CoDisplaceFn *fn, void *cookie)
{
    CoDisplaceCounts counts;
    CohortError err = {0};
    if (!co_mesh_displace(mesh, fn, cookie, &counts, &err))
        fail_msg("%s", err.message);
    return counts;
}

// ---- Points ------------------------------------------------------------------------------------

static void check_box(const CoMesh *mesh)
{
    CoVec3 lo = co_vec3_splat(INFINITY), hi = co_vec3_splat(-INFINITY);
    for (uint32_t t = 0; t < mesh->tri_count; t++)
        for (size_t c = 0; c < 3; c++) {
            CoVec3 p = mesh_point(mesh, t, c);
            lo = co_vec3(fminf(lo.x, p.x), fminf(lo.y, p.y), fminf(lo.z, p.z));
            hi = co_vec3(fmaxf(hi.x, p.x), fmaxf(hi.y, p.y), fmaxf(hi.z, p.z));
        }
    assert_memory_equal(&lo, &mesh->box_min, sizeof lo);
    assert_memory_equal(&hi, &mesh->box_max, sizeof hi);
}

static void points_move_along_the_limit_normal(void **state)
{
    (void)state;
    for (int left = 0; left < 2; left++) {
        CohortMeshDesc desc = cube_desc(COHORT_SCHEME_CATMULL_CLARK, 3);
        desc.left_handed = left;
        CoMesh rest, mesh;
        make_mesh(&desc, &rest);
        make_mesh(&desc, &mesh);
        float amount = 0.25f;
        CoDisplaceCounts counts = displace(&mesh, by_constant, &amount);
        assert_int_equal(counts.moved, mesh.point_count);
        assert_int_equal(counts.broken, 0);
        for (uint32_t t = 0; t < mesh.tri_count; t++)
            for (size_t c = 0; c < 3; c++) {
                CoSurface s;
                co_mesh_surface(&rest, t, c == 1 ? 1 : 0, c == 2 ? 1 : 0, &s);
                CoVec3 want = co_madd(s.p, s.ns, amount), got = mesh_point(&mesh, t, c);
                assert_vec_near(got, (double)want.x, (double)want.y, (double)want.z, 1e-6);
            }
        assert_int_equal(open_edges(&mesh), 0);
        assert_true((mesh_volume6(&mesh) > mesh_volume6(&rest)) == !left);
        check_box(&mesh);
        co_mesh_destroy(&mesh);
        co_mesh_destroy(&rest);
    }
}

// Whatever faces disagree about, a point moves once: by its own amount, no further.
static void shapes_stay_together(void **state)
{
    (void)state;
    static Shape shape;
    for (int number = 0; number < SHAPE_COUNT; number++) {
        for (uint32_t level = 0; level <= 3; level++) {
            make_shape(&shape, number);
            shape.desc.level = level;
            CoMesh rest, mesh;
            make_mesh(&shape.desc, &rest);
            make_mesh(&shape.desc, &mesh);
            float most = 0.3f;
            CoDisplaceCounts counts = displace(&mesh, at_random, &most);
            assert_int_equal(counts.broken, 0);
            check_moved_once(&rest, &mesh, most);
            check_box(&mesh);
            check_shading_normals(&mesh);
            co_mesh_destroy(&mesh);
            co_mesh_destroy(&rest);
        }
    }
}

// ---- Normals -----------------------------------------------------------------------------------

static void normals_are_of_the_displaced_surface(void **state)
{
    (void)state;
    static Cage cage;
    make_grid(&cage, 4, false);
    CohortMeshDesc desc = cage_desc(&cage, COHORT_SCHEME_CATMULL_CLARK, 4);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    displace(&mesh, by_saddle, &mesh);
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        CoSurface s;
        co_mesh_surface(&mesh, t, 0.3f, 0.3f, &s);
        CoVec3 want = co_normalize(co_vec3(-0.1f * s.p.y, -0.1f * s.p.x, 1.0f));
        assert_true(co_dot(s.ns, want) > 0.99999f); // one-sided at the border: 0.25 degrees
        assert_near((double)s.p.z, 0.1 * (double)s.p.x * (double)s.p.y, 1e-3);
    }
    co_mesh_destroy(&mesh);
}

// A cube of six planes, whatever makes its edges sharp: they stay sharp, and its planes flat.
static void check_sharp_cube(const CohortMeshDesc *desc, double farthest)
{
    CoMesh mesh;
    make_mesh(desc, &mesh);
    float amount = 0.5f;
    displace(&mesh, by_constant, &amount);
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        CoSurface s;
        co_mesh_surface(&mesh, t, 0.2f, 0.2f, &s);
        assert_true(co_dot(s.ns, s.ng) > 0.8f);
    }
    assert_vec_near(mesh.box_max, farthest, farthest, farthest, 1e-4);
    co_mesh_destroy(&mesh);
}

static void edges_stay_sharp(void **state)
{
    (void)state;
    CohortMeshDesc facets = cube_desc(COHORT_SCHEME_NONE, 0);
    // Corners move along the average of three normals, planes along their own.
    check_sharp_cube(&facets, 1.0 + 0.5 / sqrt(3.0));
    CohortMeshDesc bilinear = cube_desc(COHORT_SCHEME_BILINEAR, 3);
    check_sharp_cube(&bilinear, 1.5);
    static Shape shape;
    make_shape(&shape, 1); // two faces with infinitely sharp edges
    shape.desc.level = 3;
    CoMesh mesh;
    make_mesh(&shape.desc, &mesh);
    float amount = 0.05f, least = 1.0f;
    displace(&mesh, by_constant, &amount);
    for (uint32_t a = 0; a < mesh.tri_count; a++) {
        CoSurface s;
        co_mesh_surface(&mesh, a, 0.0f, 0.0f, &s);
        uint32_t point[3];
        co_mesh_triangle(&mesh, a, point);
        if (point[0] >= 8) // vertices of the cage only
            continue;
        for (uint32_t b = 0; b < a; b++) {
            uint32_t other[3];
            CoSurface o;
            co_mesh_triangle(&mesh, b, other);
            if (other[0] != point[0])
                continue;
            co_mesh_surface(&mesh, b, 0.0f, 0.0f, &o);
            least = fminf(least, co_dot(s.ns, o.ns));
        }
    }
    assert_true(least < 0.7f);
    co_mesh_destroy(&mesh);
}

static void authored_normals_do_not_outlive_their_surface(void **state)
{
    (void)state;
    const float points[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, up[] = {0, 0, 1};
    const int32_t counts[] = {4}, indices[] = {0, 1, 2, 3}, same[] = {0, 0, 0, 0};
    CohortPrimvarDesc normals = {"normals", COHORT_INTERPOLATION_VERTEX, 3, up, 1, same, 4};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE};
    SET_TOPOLOGY(desc, points, counts, indices);
    desc.primvars = &normals;
    desc.primvar_count = 1;
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    displace(&mesh, by_saddle, &mesh);
    CoSurface s;
    co_mesh_surface(&mesh, 0, 0.4f, 0.2f, &s);
    assert_true(fabsf(s.ns.x) + fabsf(s.ns.y) > 0.02f);
    assert_near((double)mesh.points[8], 0.1, 1e-7);
    co_mesh_destroy(&mesh);
}

// ---- Ends --------------------------------------------------------------------------------------

static void nonsense_moves_nothing(void **state)
{
    (void)state;
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_CATMULL_CLARK, 2);
    CoMesh rest, mesh;
    make_mesh(&desc, &rest);
    make_mesh(&desc, &mesh);
    CoDisplaceCounts counts = displace(&mesh, by_nonsense, NULL);
    assert_int_equal(counts.broken, 2 * (mesh.point_count / 3) + (mesh.point_count % 3 != 0) +
                                        (mesh.point_count % 3 == 2));
    for (size_t p = 0; p < 3 * (size_t)mesh.point_count; p++)
        assert_true(isfinite(mesh.points[p]));
    co_mesh_destroy(&mesh);
    CohortError err = {0};
    assert_false(co_mesh_displace(&rest, by_failing, NULL, &counts, &err));
    assert_int_equal(err.code, COHORT_ERROR_SCENE);
    co_mesh_destroy(&rest);
    assert_int_equal(co_memory_live(CO_MEMORY_GEOMETRY), 0);
}

static void check_without_memory(const CohortMeshDesc *desc)
{
    CoMesh rest, mesh;
    make_mesh(desc, &rest);
    make_mesh(desc, &mesh);
    float amount = 0.3f;
    bool ok = false;
    for (uint64_t allowed = 1; !ok; allowed++) {
        CoDisplaceCounts counts;
        CohortError err = {0};
        co_memory_fail_after(allowed);
        ok = co_mesh_displace(&mesh, by_constant, &amount, &counts, &err);
        co_memory_fail_after(0);
        if (ok)
            break;
        assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        assert_memory_equal(rest.points, mesh.points, 12 * (size_t)mesh.point_count);
        for (uint32_t tri = 0; tri < mesh.tri_count; tri++) {
            CoSurface a, b;
            co_mesh_surface(&rest, tri, 0.2f, 0.2f, &a);
            co_mesh_surface(&mesh, tri, 0.2f, 0.2f, &b);
            assert_memory_equal(&a.ns, &b.ns, sizeof a.ns);
        }
        assert_true(allowed < 100);
    }
    co_mesh_destroy(&mesh);
    co_mesh_destroy(&rest);
}

// Of a bilinear mesh, and of faces that meet at a crease, beside others that do not: both need new
// normals.
static void without_memory_nothing_changes(void **state)
{
    (void)state;
    static Shape shape;
    make_shape(&shape, 23);
    shape.desc.level = 1;
    check_without_memory(&shape.desc);
    static const float points[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 1, 1, 1, 1,
                                   2, 0, 0, 3, 0, 0, 3, 1, 0, 2, 1, 0, 3, 0, 1, 3, 1, 1};
    static const int32_t counts[] = {4, 4, 4, 4};
    static const int32_t indices[] = {0, 1, 2, 3, 1, 4, 5, 2, 6, 7, 8, 9, 7, 10, 11, 8};
    static const int32_t crease[] = {1, 2}, length = 2;
    static const float sharpness = 10.0f;
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_CATMULL_CLARK, .level = 2};
    SET_TOPOLOGY(desc, points, counts, indices);
    desc.crease_indices = crease;
    desc.crease_index_count = 2;
    desc.crease_lengths = &length;
    desc.crease_count = 1;
    desc.crease_sharpnesses = &sharpness;
    desc.crease_sharpness_count = 1;
    check_without_memory(&desc);
}

static void thread_count_changes_nothing(void **state)
{
    (void)state;
    static Shape shape;
    const int numbers[] = {1, 15, 23, 29};
    for (size_t k = 0; k < COUNT(numbers); k++) {
        make_shape(&shape, numbers[k]);
        shape.desc.level = 3;
        CoMesh one, many;
        float most = 0.2f;
        co_worker_count_set(1);
        make_mesh(&shape.desc, &one);
        displace(&one, at_random, &most);
        co_worker_count_set(5);
        make_mesh(&shape.desc, &many);
        displace(&many, at_random, &most);
        co_worker_count_set(0);
        assert_same_mesh(&one, &many);
        co_mesh_destroy(&one);
        co_mesh_destroy(&many);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_move_along_the_limit_normal),
        cmocka_unit_test(shapes_stay_together),
        cmocka_unit_test(normals_are_of_the_displaced_surface),
        cmocka_unit_test(edges_stay_sharp),
        cmocka_unit_test(authored_normals_do_not_outlive_their_surface),
        cmocka_unit_test(nonsense_moves_nothing),
        cmocka_unit_test(without_memory_nothing_changes),
        cmocka_unit_test(thread_count_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
