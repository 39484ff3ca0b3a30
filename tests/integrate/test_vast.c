// Grounds a thousand to a thousand million times as large as what stands on them
// (geometry/surface.c, accel/kernels/triangle.h): rays find them where they are, and what leaves
// them starts no farther off than from a small one, meets nothing behind it and all that stands
// there.

#include "integrate/scene_data.h"
#include "support/scenes.h"
#include "vertex_support.h"

#include <math.h>

enum {
    RAYS = 8192
};

typedef struct Ground {
    const char *name;
    double half;    // of its side, in units of what is looked at
    double tilt[2]; // slopes along x and y
    double unit;    // what is looked at, scene units
    double scale;   // of the instance: points are smaller by that
    double away[3]; // of the instance, units of `unit`
} Ground;

static double height_at(const Ground *ground, double x, double y)
{
    return ground->tilt[0] * x + ground->tilt[1] * y;
}

// A square about z = 0, in two triangles whose common edge passes through the middle.
static CohortScene *make_scene(const Ground *ground, CohortError *err)
{
    const double h = ground->half * ground->unit / ground->scale;
    float points[4][3];
    const int32_t indices[4] = {0, 1, 2, 3};
    const float white[3] = {0.8f, 0.8f, 0.8f};
    for (int i = 0; i < 4; i++) {
        double x = i == 1 || i == 2 ? h : -h, y = i > 1 ? h : -h;
        points[i][0] = (float)x;
        points[i][1] = (float)y;
        points[i][2] = (float)height_at(ground, x, y);
    }
    CohortScene *scene = test_scene(err);
    uint32_t id = test_quads(scene, points[0], 4, indices, 1, white, COHORT_INVALID_ID, err);
    CohortInstanceDesc place =
        test_place(id, ground->away[0] * ground->unit, ground->away[1] * ground->unit,
                   ground->away[2] * ground->unit, ground->scale);
    // Something to look at, up and away.
    CohortInstanceDesc places[2] = {
        place, test_place(id, 0, 0, 50.0 * ground->unit, 0.5 * ground->scale / ground->half)};
    TEST_OK(cohort_scene_set_group(scene, 0, places, 2, err), err);
    test_camera(scene, 0, 0, 0, 1.0, err);
    TEST_OK(cohort_scene_commit(scene, NULL, err), err);
    return scene;
}

// The plane of the ground as it was committed, in double: height = n (x - at), n of length 1.
typedef struct Plane {
    double n[3], at[3];
} Plane;

static Plane plane_of(const CohortScene *scene)
{
    CoPlacement placement;
    co_accel_placement(&scene->accel, 0, &placement);
    const CoMesh *mesh = scene->accel.objects[placement.object].mesh;
    uint32_t point[3];
    double p[3][3], length = 0.0;
    co_mesh_triangle(mesh, 0, point);
    for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++) {
            const float *at = mesh->points + 3 * (size_t)point[c], *m = placement.to_world.m[r];
            p[c][r] = (double)m[0] * (double)at[0] + (double)m[1] * (double)at[1] +
                      (double)m[2] * (double)at[2] + (double)m[3];
        }
    Plane plane;
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        plane.n[k] =
            (p[1][i] - p[0][i]) * (p[2][j] - p[0][j]) - (p[1][j] - p[0][j]) * (p[2][i] - p[0][i]);
        plane.at[k] = p[0][k];
        length += plane.n[k] * plane.n[k];
    }
    for (int k = 0; k < 3; k++)
        plane.n[k] /= sqrt(length);
    return plane;
}

static double height_of(const Plane *plane, CoVec3 x)
{
    return plane->n[0] * ((double)x.x - plane->at[0]) + plane->n[1] * ((double)x.y - plane->at[1]) +
           plane->n[2] * ((double)x.z - plane->at[2]);
}

static double climb_of(const Plane *plane, CoVec3 dir)
{
    return plane->n[0] * (double)dir.x + plane->n[1] * (double)dir.y + plane->n[2] * (double)dir.z;
}

// From all around the middle of the ground, both sides, to points near it.
static void aim(const Ground *ground, const Plane *plane, CoRayBatch *rays)
{
    Random random = {5};
    for (size_t i = 0; i < RAYS; i++) {
        double to[3], lift = 0.0;
        for (int k = 0; k < 3; k++) {
            to[k] = ground->unit *
                    (ground->away[k] + (double)(k < 2 ? random_float(&random, -1.0f, 1.0f) : 0));
            lift += plane->n[k] * (to[k] - plane->at[k]);
        }
        for (int k = 0; k < 3; k++)
            to[k] -= lift * plane->n[k];
        CoVec3 at = co_vec3((float)to[0], (float)to[1], (float)to[2]);
        CoVec3 from = co_madd(at, random_direction(&random),
                              (float)ground->unit * random_float(&random, 0.01f, 4.0f));
        ray_set(rays, i, from, co_normalize(co_sub(at, from)));
    }
}

// The largest distances of hits from where they should be, of their points from the plane, and of
// where rays start from there: parts of the largest coordinate of what is looked at. In floats
// alone those of a ground 10^6 times as large are 0.05, 2e-7 and 0.7.
typedef struct Errors {
    double t, height, step;
    size_t missed, again; // rays that met nothing; that left and met something
} Errors;

// With every kernel of this machine, alone and in groups: the same hits.
static void trace(const CohortScene *scene, const CoRayBatch *rays, CoHitBatch *hits)
{
    static const char *const isas[] = {"scalar", "sse42", "avx2", "avx512"};
    CoHitBatch other = hits_alloc(RAYS);
    CoTraverseStats stats = {0};
    co_accel_kernels("scalar")->traverse(&scene->accel, rays, NULL, hits, 0, RAYS, false, &stats);
    for (int k = 1; k < 8; k++) {
        const CoAccelKernels *kernels = co_accel_kernels(isas[k / 2]);
        if (!kernels)
            continue;
        kernels->traverse(&scene->accel, rays, NULL, &other, 0, RAYS, k % 2, &stats);
        assert_memory_equal(hits->t, other.t, RAYS * sizeof *other.t);
        assert_memory_equal(hits->u, other.u, RAYS * sizeof *other.u);
        assert_memory_equal(hits->v, other.v, RAYS * sizeof *other.v);
        assert_memory_equal(hits->tri, other.tri, RAYS * sizeof *other.tri);
    }
    hits_free(&other);
}

static Errors leave(const Ground *ground, const CohortScene *scene)
{
    CoRayBatch rays = rays_alloc(RAYS), next = rays_alloc(RAYS);
    CoHitBatch hits = hits_alloc(RAYS), found = hits_alloc(RAYS);
    CoPlacementMemo memo = {.instance = COHORT_INVALID_ID};
    Errors errors = {0};
    Random random = {6};
    const Plane plane = plane_of(scene);
    const double size = ground->unit * (4.0 + fabs(ground->away[0]) + fabs(ground->away[1]) +
                                        fabs(ground->away[2]));
    aim(ground, &plane, &rays);
    trace(scene, &rays, &hits);
    for (size_t i = 0; i < RAYS; i++) {
        ray_set(&next, i, co_vec3(0, 0, 0), co_vec3(NAN, 0, 0));
        errors.missed += !(hits.t[i] < INFINITY);
        if (!(hits.t[i] < INFINITY))
            continue;
        CoVec3 org = ray_org(&rays, i), dir = ray_dir(&rays, i);
        CoVertex vertex = vertex_of_hit(scene, &memo, &rays, &hits, i);
        CoVec3 normal = i % 2 ? vertex.ng : co_neg(vertex.ng);
        CoVec3 start = co_vertex_origin(&vertex, normal);
        // Along the normal: at grazing rays t itself is uncertain by as much as their origin.
        double off = (double)hits.t[i] * climb_of(&plane, dir) + height_of(&plane, org);
        errors.t = fmax(errors.t, fabs(off) / size);
        errors.height = fmax(errors.height, fabs(height_of(&plane, vertex.p)) / size);
        errors.step = fmax(errors.step, (double)co_length(co_sub(start, vertex.p)) / size);
        CoVec3 away = direction_above(&random, normal, i % 3 ? 0.0f : 0.999f);
        // The normal is a float: along the ground it may lead back to it, far away.
        if (height_of(&plane, start) * climb_of(&plane, away) > 0.0)
            ray_set(&next, i, start, away);
    }
    trace(scene, &next, &found);
    // Far from here floats know of a height what they do of the distance.
    for (size_t i = 0; i < RAYS; i++)
        errors.again +=
            found.instance[i] == 0 && (double)found.t[i] < 0.01 * ground->half * ground->unit;
    rays_free(&rays);
    rays_free(&next);
    hits_free(&hits);
    hits_free(&found);
    return errors;
}

static void vast_grounds_are_where_they_are(void **state)
{
    (void)state;
    static const Ground grounds[] = {{"flat", 0, {0, 0}, 1, 1, {0, 0, 0}},
                                     {"tilted", 0, {0.3, 0.02}, 1, 1, {0, 0, 0}},
                                     {"steep", 0, {-3.0, 0.7}, 1, 1, {0, 0, 0}},
                                     {"hardly tilted", 0, {1e-5, -3e-6}, 1, 1, {0, 0, 0}},
                                     {"small", 0, {0.3, 0.02}, 0.01, 1, {0, 0, 0}},
                                     {"scaled", 0, {0.1, 0.2}, 1, 3e4, {0, 0, 0}},
                                     {"moved", 0, {0.1, 0.2}, 1, 1, {7.3, -5.1, 3.7}},
                                     {"scaled and moved", 0, {0.3, 0}, 1, 3e5, {70.7, 40.3, -5.9}}};
    for (int e = 1; e <= 9; e++) {
        for (size_t k = 0; k < sizeof grounds / sizeof *grounds; k++) {
            Ground ground = grounds[k];
            ground.half = pow(10.0, e);
            CohortError err = {0};
            CohortScene *scene = make_scene(&ground, &err);
            Errors errors = leave(&ground, scene);
            bool is_good = errors.t < 5e-7 && errors.height < 2e-7 && errors.step < 4e-5 &&
                           errors.missed + errors.again == 0;
            if (!is_good)
                print_error("1e%d %s: t %.2g, height %.2g, step %.2g, missed %zu, again %zu\n", e,
                            ground.name, errors.t, errors.height, errors.step, errors.missed,
                            errors.again);
            assert_true(is_good);
            cohort_scene_destroy(scene);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(vast_grounds_are_where_they_are)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
