// Layers (accel/layers.c): things on a ground of any size are met as they are without it, by as
// many steps and to the last bit; layers within layers; what stays where it is.

#include "accel/layers.h"
#include "accel/node.h"
#include "accel_scene.h"

enum {
    THINGS = 60,
    RAYS = 6400
};

// A flat square of two triangles around the origin.
static TestMesh mesh_ground(float half, float y)
{
    TestMesh m = mesh_alloc(4, 2);
    const uint32_t quad[6] = {0, 1, 2, 0, 2, 3};
    for (uint32_t i = 0; i < 4; i++)
        co_vec3_store(m.points + 3 * (size_t)i,
                      co_vec3(i == 1 || i == 2 ? half : -half, y, i > 1 ? half : -half));
    memcpy(m.indices, quad, sizeof quad);
    mesh_box(&m);
    return m;
}

// Spheres within 3 units of `middle`, half of them moved, half where they are; turned when they are
// not alike: one in five has its own scales.
static void place_things(CoInstance *out, const uint32_t objects[2], CoVec3 middle)
{
    Random random = {11};
    for (int i = 0; i < THINGS; i++) {
        CoVec3 at = co_add(middle, random_vec3(&random, -3.0f, 3.0f));
        CoVec3 scale = i % 5 ? co_vec3_splat(1.0f) : co_vec3(0.5f, 1.5f, 1.0f);
        out[i] = i < 2 ? place(objects[i], co_mat4d_identity())
                       : place(objects[i % 2], matrix(0.1 * i, scale, at));
    }
}

// Among the things, some exactly along axes, with zeros of both signs.
static CoRayBatch rays_among(CoVec3 middle)
{
    Random random = {12};
    CoRayBatch rays = rays_alloc(RAYS);
    for (size_t i = 0; i < RAYS; i++) {
        CoVec3 dir = random_direction(&random);
        if (i % 5 == 0)
            dir = co_vec3(i % 2 ? 0.0f : -0.0f, i % 3 ? 1.0f : -0.0f, i % 3 ? -0.0f : -1.0f);
        ray_set(&rays, i, co_add(middle, random_vec3(&random, -3.0f, 3.0f)), dir);
        rays.tfar[i] = 20.0f; // the ground is lower
    }
    return rays;
}

static void check_same(const CoHitBatch *a, const CoHitBatch *b)
{
    size_t hit = 0;
    for (size_t i = 0; i < RAYS; i++)
        hit += a->t[i] < INFINITY;
    assert_true(hit > RAYS / 20 && hit < RAYS);
    assert_true(same_bits(a->t, b->t, RAYS) && same_bits(a->u, b->u, RAYS));
    assert_true(same_bits(a->v, b->v, RAYS) && same_bits(a->tri, b->tri, RAYS));
    assert_true(same_bits(a->instance, b->instance, RAYS));
}

static uint64_t steps(const CoTraverseStats *stats)
{
    return stats->top_nodes_single + stats->bottom_nodes + stats->triangles;
}

// Before there were layers, rays took 79 steps on the larger of these, where it is 14 now.
static void a_vast_ground_changes_nothing(void **state)
{
    (void)state;
    TestMesh balls[2] = {mesh_sphere(20, 0.3f, co_vec3(0, 0, 0)),
                         mesh_sphere(6, 0.4f, co_vec3(1, 0, 0))};
    CoRayBatch rays = rays_among(co_vec3(0, 0, 0));
    uint8_t *flags = calloc(RAYS, 1);
    for (size_t i = 0; i < RAYS; i += 3)
        flags[i] = CO_TRAVERSE_OCCLUSION;
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    CoTraverseStats alone, stats;
    for (int g = 0; g <= 4; g++) {
        const float half = 10.0f * powf(100.0f, (float)g); // up to 1e9
        TestMesh ground = mesh_ground(half, -30.0f);
        TestScene s = {0};
        CoInstance instances[THINGS + 1];
        const uint32_t objects[2] = {scene_add_mesh(&s, &balls[0]), scene_add_mesh(&s, &balls[1])};
        place_things(instances, objects, co_vec3(0, 0, 0));
        instances[THINGS] = place(scene_add_mesh(&s, &ground), co_mat4d_identity());
        const CoTop *top = s.tops[scene_add_group(&s, instances, g ? THINGS + 1 : THINGS)];
        assert_int_equal(top->layer_count, g > 1);
        for (uint32_t i = 0; i < THINGS; i++)
            assert_int_equal(top->placed[i].layer, g > 1 ? 0 : CO_LAYER_NONE);
        assert_true(top->placed[0].is_in_place && top->placed[1].is_in_place);
        traverse_all(&s.scene, &rays, flags, &hits[g > 0], g ? &stats : &alone);
        if (g) {
            check_same(&hits[0], &hits[1]);
            // The group's own tree has a node, which comes before all, and the ground.
            print_message("%g: %g steps a ray in place of %g\n", (double)half,
                          (double)steps(&stats) / RAYS, (double)steps(&alone) / RAYS);
            assert_true(steps(&stats) < steps(&alone) + (g > 1 ? 5 : 1) * (uint64_t)RAYS);
        }
        scene_clear(&s);
        mesh_free(&ground);
    }
    hits_free(&hits[0]);
    hits_free(&hits[1]);
    rays_free(&rays);
    free(flags);
    mesh_free(&balls[0]);
    mesh_free(&balls[1]);
}

// A heap of things on a ground, both on a ground that is larger still; another heap far away.
static void layers_nest(void **state)
{
    (void)state;
    TestMesh ball = mesh_sphere(20, 0.3f, co_vec3(0, 0, 0));
    TestMesh near = mesh_ground(1e6f, -30.0f), vast = mesh_ground(1e12f, -40.0f);
    TestMesh tower = mesh_ground(3e4f, 1e5f);
    CoRayBatch rays = rays_among(co_vec3(0, 0, 0));
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    for (int pass = 0; pass < 2; pass++) {
        TestScene s = {0};
        CoInstance instances[2 * THINGS + 3];
        const uint32_t id = scene_add_mesh(&s, &ball), objects[2] = {id, id};
        place_things(instances, objects, co_vec3(0, 0, 0));
        place_things(instances + THINGS, objects, co_vec3(4e5f, 0, 0));
        for (int i = 0; i < 2; i++) // but what stands where it is
            instances[THINGS + i] = instances[THINGS + 2];
        instances[2 * THINGS] = place(scene_add_mesh(&s, &near), co_mat4d_identity());
        instances[2 * THINGS + 1] = place(scene_add_mesh(&s, &vast), co_mat4d_identity());
        instances[2 * THINGS + 2] = place(scene_add_mesh(&s, &tower), co_mat4d_identity());
        const CoTop *top = s.tops[scene_add_group(&s, instances, pass ? 2 * THINGS + 3 : THINGS)];
        traverse_all(&s.scene, &rays, NULL, &hits[pass], NULL);
        if (pass) {
            assert_int_equal(top->layer_count, 3);
            assert_int_equal(top->layers[0].parent, CO_LAYER_NONE);
            assert_int_equal(top->layers[1].parent, 0);
            assert_int_equal(top->layers[2].parent, 0);
            assert_int_equal(top->placed[2 * THINGS + 1].layer, CO_LAYER_NONE);
            assert_int_equal(top->placed[2 * THINGS].layer, 0);
            assert_int_equal(top->placed[0].layer + top->placed[2 * THINGS - 1].layer, 3);
        }
        scene_clear(&s);
    }
    check_same(&hits[0], &hits[1]);
    hits_free(&hits[0]);
    hits_free(&hits[1]);
    rays_free(&rays);
    mesh_free(&ball);
    mesh_free(&near);
    mesh_free(&vast);
    mesh_free(&tower);
}

// Where all is fit for the whole, where a layer would be one thing alone, and for empty things,
// there is none.
static void most_groups_have_none(void **state)
{
    (void)state;
    TestMesh ball = mesh_sphere(6, 0.3f, co_vec3(0, 0, 0)), ground = mesh_ground(1e9f, -30.0f);
    TestMesh wall = mesh_ground(30.0f, -2.0f), none = mesh_alloc(0, 0);
    mesh_box(&none);
    TestScene s = {0};
    CoInstance instances[THINGS];
    const uint32_t id = scene_add_mesh(&s, &ball), objects[2] = {id, id};
    place_things(instances, objects, co_vec3(0, 0, 0));
    instances[5] = place(scene_add_mesh(&s, &wall), co_mat4d_identity());
    instances[6] = place(scene_add_mesh(&s, &none), co_mat4d_identity());
    assert_int_equal(s.tops[scene_add_group(&s, instances, THINGS)]->layer_count, 0);
    instances[1] = place(scene_add_mesh(&s, &ground), co_mat4d_identity());
    assert_int_equal(s.tops[scene_add_group(&s, instances, 2)]->layer_count, 0);
    assert_int_equal(s.tops[scene_add_group(&s, instances + 5, 2)]->layer_count, 0);
    scene_clear(&s);
    mesh_free(&ball);
    mesh_free(&ground);
    mesh_free(&wall);
    mesh_free(&none);
}

// A ground grown vast under things that stay, or moved away from under them, asks for a new top.
static void layers_are_not_refit(void **state)
{
    (void)state;
    TestMesh ball = mesh_sphere(20, 0.3f, co_vec3(0, 0, 0)), ground = mesh_ground(10.0f, -30.0f);
    TestScene s = {0};
    CoInstance instances[THINGS + 1];
    const uint32_t id = scene_add_mesh(&s, &ball), objects[2] = {id, id};
    place_things(instances, objects, co_vec3(0, 0, 0));
    const uint32_t under = scene_add_mesh(&s, &ground);
    CohortError err = {0};
    for (int first = 0; first < 2; first++) {
        instances[THINGS] =
            place(under, matrix(0, co_vec3_splat(first ? 1e8f : 1.0f), co_vec3(0, 0, 0)));
        CoTop *top = co_top_create(instances, THINGS + 1, s.objects, &err);
        assert_int_equal(top->layer_count, first);
        instances[3].to_group.m[0][3] += 0.01f;
        instances[3].to_object.m[0][3] -= 0.01f;
        assert_int_equal(co_top_refit(top, instances, THINGS + 1, s.objects), !first);
        instances[THINGS] =
            place(under, matrix(0, co_vec3_splat(first ? 1.0f : 1e8f), co_vec3(0, 0, 0)));
        assert_false(co_top_refit(top, instances, THINGS + 1, s.objects));
        co_top_destroy(top);
    }
    scene_clear(&s);
    mesh_free(&ball);
    mesh_free(&ground);
}

static void failing_allocations_are_reported(void **state)
{
    (void)state;
    TestMesh ball = mesh_sphere(20, 0.3f, co_vec3(0, 0, 0)), ground = mesh_ground(1e8f, -30.0f);
    TestScene s = {0};
    CoInstance instances[THINGS + 1];
    const uint32_t id = scene_add_mesh(&s, &ball), objects[2] = {id, id};
    place_things(instances, objects, co_vec3(0, 0, 0));
    instances[THINGS] = place(scene_add_mesh(&s, &ground), co_mat4d_identity());
    const size_t before = co_memory_live(CO_MEMORY_ACCEL);
    CoTop *top = NULL;
    uint64_t n;
    for (n = 1; n < 100 && !top; n++) {
        CohortError err = {0};
        co_memory_fail_after(n);
        top = co_top_create(instances, THINGS + 1, s.objects, &err);
        co_memory_fail_after(0);
        if (!top) {
            assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
            assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
        }
    }
    assert_non_null(top);
    assert_true(n > 12);
    for (uint64_t k = 1; k < n - 1; k++) { // each alone
        CohortError err = {0};
        co_memory_fail_once(k);
        CoTop *other = co_top_create(instances, THINGS + 1, s.objects, &err);
        co_memory_fail_once(0);
        assert_true(other || err.code == COHORT_ERROR_OUT_OF_MEMORY);
        co_top_destroy(other);
    }
    assert_int_equal(top->layer_count, 1);
    assert_int_equal(co_top_bytes(top), co_memory_live(CO_MEMORY_ACCEL) - before);
    co_top_destroy(top);
    scene_clear(&s);
    mesh_free(&ball);
    mesh_free(&ground);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_vast_ground_changes_nothing),
        cmocka_unit_test(layers_nest),
        cmocka_unit_test(most_groups_have_none),
        cmocka_unit_test(layers_are_not_refit),
        cmocka_unit_test(failing_allocations_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
