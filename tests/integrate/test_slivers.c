// Rays that leave thin triangles, 10^2 to 10^5 times as long as wide, authored in place: none meets
// what lies behind it, the triangle it leaves and the strips beside it least of all, none that goes
// in gets out, and the step off the surface stays small against the width.

#include "integrate/scene_data.h"
#include "support/scenes.h"
#include "vertex_support.h"

#include <math.h>

// A closed bar: sides around its axis, each of strips that lie in one plane, fans as its ends.
enum {
    SIDES = 6,
    STRIPS = 4, // of a side
    AROUND = SIDES * STRIPS,
    POINTS = 2 * AROUND + 2,
    FACES = 4 * AROUND,
    RAYS = 8192
};

typedef struct Bar {
    const char *name;
    double aspect; // length over a strip's width
    double length, turn, away;
} Bar;

typedef struct Counts {
    size_t left, behind, lost;
    double farthest; // step off the surface
} Counts;

static void set_point(const Bar *bar, double x, double y, double z, float out[3])
{
    // About two axes, by angles without a meaning, then away in a direction without one.
    const double ca = cos(bar->turn), sa = sin(bar->turn);
    const double cb = cos(1.3 * bar->turn), sb = sin(1.3 * bar->turn);
    double u = ca * x - sa * y, v = sa * x + ca * y;
    double w = cb * z - sb * u;
    u = sb * z + cb * u;
    out[0] = (float)(bar->length * (u + bar->away));
    out[1] = (float)(bar->length * (v - 0.7 * bar->away));
    out[2] = (float)(bar->length * (w + 0.4 * bar->away));
}

static void make_points(const Bar *bar, float points[POINTS][3])
{
    const double width = STRIPS / bar->aspect, radius = 0.5 * width / sin(M_PI / SIDES);
    for (int i = 0; i < AROUND; i++) {
        double a = 2 * M_PI * (i / STRIPS) / SIDES, b = a + 2 * M_PI / SIDES;
        double s = (double)(i % STRIPS) / STRIPS;
        double y = radius * ((1 - s) * cos(a) + s * cos(b));
        double z = radius * ((1 - s) * sin(a) + s * sin(b));
        set_point(bar, -0.5, y, z, points[2 * i]);
        set_point(bar, 0.5, y, z, points[2 * i + 1]);
    }
    set_point(bar, -0.5, 0, 0, points[2 * AROUND]);
    set_point(bar, 0.5, 0, 0, points[2 * AROUND + 1]);
}

static void make_indices(int32_t indices[FACES][3])
{
    for (int i = 0; i < AROUND; i++) {
        int32_t a = 2 * i, b = 2 * ((i + 1) % AROUND);
        const int32_t faces[4][3] = {
            {a, b, b + 1}, {a, b + 1, a + 1}, {2 * AROUND, b, a}, {2 * AROUND + 1, a + 1, b + 1}};
        memcpy(indices[4 * i], faces, sizeof faces);
    }
}

static CohortScene *make_scene(const Bar *bar, CohortError *err)
{
    float points[POINTS][3];
    int32_t indices[FACES][3], counts[FACES];
    make_points(bar, points);
    make_indices(indices);
    for (int i = 0; i < FACES; i++)
        counts[i] = 3;
    CohortScene *scene = test_scene(err);
    CohortMeshDesc desc = test_cage(points[0], POINTS, counts, FACES, indices[0], 3 * FACES);
    desc.material = test_matte(scene, 0.5f, 0.0f, err);
    uint32_t id = test_mesh(scene, &desc, err);
    CohortInstanceDesc place = test_place(id, 0, 0, 0, 1);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, err), err);
    test_camera(scene, 0, 0, 0, 1.0, err);
    TEST_OK(cohort_scene_commit(scene, NULL, err), err);
    return scene;
}

// Corners of a triangle in the render frame, in double.
static void world_corners(const CohortScene *scene, uint32_t tri, double out[3][3])
{
    CoPlacement placement;
    co_accel_placement(&scene->accel, 0, &placement);
    const CoMesh *mesh = scene->accel.objects[placement.object].mesh;
    uint32_t point[3];
    co_mesh_triangle(mesh, tri, point);
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++) {
            const float *p = mesh->points + 3 * (size_t)point[c], *m = placement.to_world.m[k];
            out[c][k] = (double)m[0] * (double)p[0] + (double)m[1] * (double)p[1] +
                        (double)m[2] * (double)p[2] + (double)m[3];
        }
}

// Whether the plane of a triangle lies behind the ray's origin, by doubles, and by more than 4
// units in the last place of its largest coordinate as seen from there: then it is not met.
static bool is_behind(const CohortScene *scene, uint32_t tri, CoVec3 org, CoVec3 dir)
{
    double p[3][3], n[3], height = 0.0, climb = 0.0;
    world_corners(scene, tri, p);
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        n[k] =
            (p[1][i] - p[0][i]) * (p[2][j] - p[0][j]) - (p[1][j] - p[0][j]) * (p[2][i] - p[0][i]);
    }
    const float o[3] = {org.x, org.y, org.z}, d[3] = {dir.x, dir.y, dir.z};
    double largest = 0.0, length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; k++) {
        height += n[k] * ((double)o[k] - p[0][k]);
        climb += n[k] * (double)d[k];
        for (int c = 0; c < 3; c++)
            largest = fmax(largest, fabs(p[c][k] - (double)o[k]));
    }
    return height * climb >= 0.0 && fabs(height) > 4 * 0x1p-23 * largest * length;
}

// Rays from around the bar towards points on its strips.
static void aim(const CohortScene *scene, Random *random, CoRayBatch *rays)
{
    for (size_t i = 0; i < RAYS; i++) {
        uint32_t tri = 4 * (uint32_t)(i % AROUND) + (uint32_t)(i / AROUND % 2);
        double p[3][3];
        world_corners(scene, tri, p);
        float u = random_float(random, 0, 1), v = random_float(random, 0, 1);
        if (u + v > 1.0f) {
            u = 1.0f - u;
            v = 1.0f - v;
        }
        double at[3];
        for (int k = 0; k < 3; k++)
            at[k] = p[0][k] + (double)u * (p[1][k] - p[0][k]) + (double)v * (p[2][k] - p[0][k]);
        float length = (float)sqrt(pow(p[1][0] - p[2][0], 2) + pow(p[1][1] - p[2][1], 2) +
                                   pow(p[1][2] - p[2][2], 2));
        CoVec3 to = co_vec3((float)at[0], (float)at[1], (float)at[2]);
        CoVec3 from = co_madd(to, random_direction(random), fmaxf(length, 1e-3f) * 2.0f);
        ray_set(rays, i, from, co_normalize(co_sub(to, from)));
    }
}

// Leaves each hit on the given side (1: out, -1: in).
static void leave(const CohortScene *scene, Random *random, const CoRayBatch *rays,
                  const CoHitBatch *hits, float side, Counts *counts)
{
    CoRayBatch next = rays_alloc(RAYS);
    CoHitBatch found = hits_alloc(RAYS);
    CoPlacementMemo memo = {.instance = COHORT_INVALID_ID};
    CoTraverseStats stats = {0};
    *counts = (Counts){0};
    for (size_t i = 0; i < RAYS; i++) {
        if (!(hits->t[i] < INFINITY)) {
            ray_set(&next, i, co_vec3(0, 0, 0), co_vec3(NAN, 0, 0));
            continue;
        }
        CoVertex vertex = vertex_of_hit(scene, &memo, rays, hits, i);
        // The bar is met from outside.
        CoVec3 normal = co_scale(vertex.ng, side);
        CoVec3 org = co_vertex_origin(&vertex, normal);
        CoVec3 dir = direction_above(random, normal, i % 3 == 0 ? 0.999f : 0.0f);
        counts->left++;
        counts->farthest = fmax(counts->farthest, (double)co_length(co_sub(org, vertex.p)));
        ray_set(&next, i, org, dir);
    }
    co_accel_kernels(NULL)->traverse(&scene->accel, &next, NULL, &found, 0, RAYS, true, &stats);
    for (size_t i = 0; i < RAYS; i++) {
        if (!(hits->t[i] < INFINITY))
            continue;
        bool is_hit = found.t[i] < INFINITY;
        counts->lost += !is_hit;
        if (is_hit && is_behind(scene, found.tri[i], ray_org(&next, i), ray_dir(&next, i)))
            counts->behind++;
    }
    rays_free(&next);
    hits_free(&found);
}

// 2^-24 of the coordinates, of which points are rounded to.
static double rounding(const Bar *bar)
{
    return bar->length * (1.0 + bar->away) * 0x1p-24;
}

static void leave_bar(const Bar *bar, uint64_t seed)
{
    CohortError err = {0};
    CohortScene *scene = make_scene(bar, &err);
    CoRayBatch rays = rays_alloc(RAYS);
    CoHitBatch hits = hits_alloc(RAYS);
    CoTraverseStats stats = {0};
    Random random = {seed << 32};
    Counts out, in;
    aim(scene, &random, &rays);
    co_accel_kernels(NULL)->traverse(&scene->accel, &rays, NULL, &hits, 0, RAYS, true, &stats);
    leave(scene, &random, &rays, &hits, 1.0f, &out);
    leave(scene, &random, &rays, &hits, -1.0f, &in);
    if (out.behind + in.behind + in.lost > 0)
        print_message("%g:1 %s: of %zu rays %zu out and %zu in met what lies behind, %zu got out\n",
                      bar->aspect, bar->name, out.left, out.behind, in.behind, in.lost);
    assert_true(out.left > RAYS * 9 / 10);
    assert_int_equal(out.behind, 0);
    assert_int_equal(in.behind, 0);
    assert_int_equal(in.lost, 0);
    // A third of the thinnest strip's width.
    assert_true(fmax(out.farthest, in.farthest) < 3.5e-6 * bar->length + 8 * rounding(bar));
    rays_free(&rays);
    hits_free(&hits);
    cohort_scene_destroy(scene);
}

static void rays_leave_slivers(void **state)
{
    (void)state;
    static const Bar bars[] = {{"along x", 0, 1, 0, 0},       {"turned", 0, 1, 0.6, 0},
                               {"turned more", 0, 1, 2.1, 0}, {"small", 0, 1e-4, 0.9, 0},
                               {"large", 0, 1e4, 1.7, 0},     {"moved", 0, 1, 0.4, 30},
                               {"moved far", 0, 1, 3.4, 1000}};
    for (int e = 2; e <= 5; e++) {
        for (size_t k = 0; k < sizeof bars / sizeof *bars; k++) {
            Bar bar = bars[k];
            bar.aspect = pow(10.0, e);
            // Thinner than the grid that its points lie on, it is no bar anymore.
            if (bar.length / bar.aspect > 32 * rounding(&bar))
                leave_bar(&bar, 8 * (uint64_t)e + k);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_leave_slivers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
