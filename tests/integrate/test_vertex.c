// Where rays leave a surface: whatever the transforms, a ray that leaves a convex body never meets
// it again, one that goes in always does, and the step off the surface stays small.

#include "integrate/scene_data.h"
#include "support/scenes.h"
#include "vertex_support.h"

#include <math.h>

enum {
    RAYS = 4096
};

// Rotation by Euler angles, scale per axis, then a move; row vectors.
static void turn(double m[4][4], double a, double b, const double scale[3], const double move[3])
{
    const double ca = cos(a), sa = sin(a), cb = cos(b), sb = sin(b);
    const double r[3][3] = {{ca, sa * cb, sa * sb}, {-sa, ca * cb, ca * sb}, {0, -sb, cb}};
    test_identity(m);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++)
            m[i][k] = scale[i] * r[i][k];
        m[3][i] = move[i];
    }
}

typedef struct Body {
    const char *name;
    double scale[3], move[3]; // of the body in its group
    double outer, outer_move; // of the group in the world, along (1, -1, 0.5)
    float most;               // step off the surface, in units of the body's smallest half side
} Body;

static const Body bodies[] = {
    {"as it is", {1, 1, 1}, {0, 0, 0}, 1, 0, 2e-5f},
    {"thin", {1, 0.01, 30}, {0, 0, 0}, 1, 0, 5e-2f},
    {"small", {1e-5, 1e-5, 1e-5}, {0, 0, 0}, 1, 0, 2e-5f},
    {"large", {1e5, 1e5, 1e5}, {0, 0, 0}, 1, 0, 2e-5f},
    {"far in its group, and back", {1, 1, 1}, {3000, -500, 80}, 1, 0, 5e-2f},
    {"far in the world", {1, 1, 1}, {0, 0, 0}, 1, 1e5, 2e-5f},
    {"scaled back", {100, 100, 100}, {5, 5, 5}, 0.01, 3, 1e-3f},
};

static CohortScene *make_scene(const Body *body, CohortError *err)
{
    CohortScene *scene = test_scene(err);
    uint32_t matte = test_matte(scene, 0.5f, 0.0f, err);
    uint32_t box = test_quads(scene, test_box_points, 8, test_box_indices, 6, NULL, matte, err);
    CohortInstanceDesc inner = test_place(box, 0, 0, 0, 1), outer;
    turn(inner.transform, 0.7, -1.1, body->scale, body->move);
    uint32_t group = cohort_scene_new_object(scene, err);
    TEST_OK(cohort_scene_set_group(scene, group, &inner, 1, err), err);
    outer = test_place(group, 0, 0, 0, 1);
    const double scale[3] = {body->outer, body->outer, body->outer};
    const double move[3] = {body->outer_move, -body->outer_move, 0.5 * body->outer_move};
    turn(outer.transform, 2.1, 0.4, scale, move);
    TEST_OK(cohort_scene_set_group(scene, 0, &outer, 1, err), err);
    test_camera(scene, move[0], move[1], move[2], 1.0, err);
    TEST_OK(cohort_scene_commit(scene, NULL, err), err);
    return scene;
}

// Rays from around the body towards points on it.
static void aim(const CohortScene *scene, Random *random, CoRayBatch *rays)
{
    CoPlacement placement;
    co_accel_placement(&scene->accel, 0, &placement);
    for (size_t i = 0; i < RAYS; i++) {
        CoVec3 near = random_vec3(random, -1, 1);
        float at[3] = {near.x, near.y, near.z};
        at[i % 3] = i % 2 ? 1.0f : -1.0f;
        CoVec3 from = co_scale(random_direction(random), 4.0f);
        CoVec3 to = co_affine_point(&placement.to_world, co_vec3_load(at));
        CoVec3 org = co_affine_point(&placement.to_world, from);
        ray_set(rays, i, org, co_normalize(co_sub(to, org)));
    }
}

// Leaves each hit on the given side (1: out, -1: in); returns how many rays meet something.
static size_t leave(const CohortScene *scene, Random *random, const CoRayBatch *rays,
                    const CoHitBatch *hits, float side, float *farthest)
{
    CoRayBatch next = rays_alloc(RAYS);
    CoHitBatch found = hits_alloc(RAYS);
    CoPlacementMemo memo = {.instance = COHORT_INVALID_ID};
    CoTraverseStats stats = {0};
    for (size_t i = 0; i < RAYS; i++) {
        if (!(hits->t[i] < INFINITY)) { // aimed past an edge, by rounding
            ray_set(&next, i, co_vec3(0, 0, 0), co_vec3(NAN, 0, 0));
            continue;
        }
        CoVertex vertex = vertex_of_hit(scene, &memo, rays, hits, i);
        // The side that the ray came from is outside.
        CoVec3 out = co_dot(vertex.ng, vertex.wo) > 0.0f ? vertex.ng : co_neg(vertex.ng);
        CoVec3 normal = co_scale(out, side);
        CoVec3 org = co_vertex_origin(&vertex, normal);
        CoVec3 dir = direction_above(random, normal, i % 3 == 0 ? 0.99999f : 0.0f);
        *farthest = fmaxf(*farthest, co_length(co_sub(org, vertex.p)));
        ray_set(&next, i, org, dir);
    }
    co_accel_kernels(NULL)->traverse(&scene->accel, &next, NULL, &found, 0, RAYS, true, &stats);
    size_t count = 0;
    for (size_t i = 0; i < RAYS; i++)
        count += found.t[i] < INFINITY;
    rays_free(&next);
    hits_free(&found);
    return count;
}

static void rays_leave_what_they_hit(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof bodies / sizeof *bodies; k++) {
        const Body *body = &bodies[k];
        CohortError err = {0};
        CohortScene *scene = make_scene(body, &err);
        CoRayBatch rays = rays_alloc(RAYS);
        CoHitBatch hits = hits_alloc(RAYS);
        CoTraverseStats stats = {0};
        Random random = {k << 32};
        float farthest = 0.0f;
        aim(scene, &random, &rays);
        co_accel_kernels(NULL)->traverse(&scene->accel, &rays, NULL, &hits, 0, RAYS, true, &stats);
        size_t again = leave(scene, &random, &rays, &hits, 1.0f, &farthest);
        size_t inside = leave(scene, &random, &rays, &hits, -1.0f, &farthest);
        float size =
            (float)(fmin(fmin(body->scale[0], body->scale[1]), body->scale[2]) * body->outer);
        print_message("%s: %zu met again, %zu of %d inside, steps up to %g\n", body->name, again,
                      inside, (int)RAYS, (double)(farthest / size));
        assert_int_equal(again, 0);
        // Near an edge a step inward may be a step out through the other side.
        assert_true(inside >= RAYS - RAYS / 50);
        assert_true(farthest <= body->most * size);
        rays_free(&rays);
        hits_free(&hits);
        cohort_scene_destroy(scene);
    }
}

static void the_innermost_number_counts(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t matte = test_matte(scene, 0.5f, 0.0f, &err);
    uint32_t box = test_quads(scene, test_box_points, 8, test_box_indices, 6, NULL, matte, &err);
    CohortInstanceDesc parts[2] = {test_place(box, 0, 0, 0, 1), test_place(box, 3, 0, 0, 1)};
    parts[0].prim_id = -1;
    parts[1].prim_id = 7;
    uint32_t group = cohort_scene_new_object(scene, &err);
    TEST_OK(cohort_scene_set_group(scene, group, parts, 2, &err), &err);
    CohortInstanceDesc wholes[2] = {test_place(group, 0, 0, 0, 1), test_place(group, 0, 5, 0, 1)};
    wholes[0].prim_id = 4;
    wholes[1].prim_id = -1;
    TEST_OK(cohort_scene_set_group(scene, 0, wholes, 2, &err), &err);
    test_camera(scene, 0, 0, 9, 1.0, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    const int32_t want[4] = {4, 7, -1, 7};
    for (uint32_t path = 0; path < 4; path++) {
        CoPlacement placement;
        co_accel_placement(&scene->accel, path, &placement);
        assert_int_equal(co_placement_prim_id(scene, &placement), want[path]);
    }
    cohort_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_leave_what_they_hit),
        cmocka_unit_test(the_innermost_number_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
