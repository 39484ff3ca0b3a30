// Small meshes that a group moves: what is baked, and to which bits.

#include "accel/bake.h"
#include "accel_scene.h"
#include "base/memory.h"

enum {
    RAYS = 8192
};

static CoMat4d turned(void)
{
    return matrix(0.7, co_vec3(0.8f, 1.3f, 1.0f), co_vec3(0.3f, -0.25f, 2.0f));
}

// A mesh whose points are where an instance has them.
static TestMesh mesh_moved(const TestMesh *from, const CoAffine *to_group)
{
    TestMesh m = mesh_alloc(from->mesh.point_count, from->mesh.tri_count);
    memcpy(m.indices, from->indices, 12 * (size_t)from->mesh.tri_count);
    for (size_t i = 0; i < from->mesh.point_count; i++)
        for (size_t r = 0; r < 3; r++) {
            double terms[3];
            for (size_t k = 0; k < 3; k++)
                terms[k] = (double)to_group->m[r][k] * (double)from->points[3 * i + k];
            m.points[3 * i + r] =
                (float)(terms[0] + terms[1] + terms[2] + (double)to_group->m[r][3]);
        }
    mesh_box(&m);
    return m;
}

static CoRayBatch random_rays(uint64_t seed)
{
    Random random = {seed};
    CoRayBatch rays = rays_alloc(RAYS);
    for (size_t i = 0; i < RAYS; i++) {
        CoVec3 org = random_vec3(&random, -4.0f, 4.0f), at = random_vec3(&random, -1.0f, 1.0f);
        at.z += 2.0f * (float)(i % 2);
        ray_set(&rays, i, org, co_sub(at, org));
        if (i % 5 == 0) // along an axis, with zeros of both signs
            ray_set(&rays, i, co_vec3(at.x, at.y, -4.0f),
                    co_vec3(i % 2 ? 0.0f : -0.0f, i % 3 ? 0.0f : -0.0f, 1.0f));
    }
    return rays;
}

static size_t count_hits(const CoHitBatch *hits)
{
    size_t count = 0;
    for (size_t i = 0; i < RAYS; i++)
        count += hits->t[i] < INFINITY;
    return count;
}

static void assert_same_hits(const CoHitBatch *a, const CoHitBatch *b)
{
    assert_true(same_bits(a->t, b->t, RAYS) && same_bits(a->u, b->u, RAYS) &&
                same_bits(a->v, b->v, RAYS));
    assert_memory_equal(a->tri, b->tri, RAYS * sizeof(uint32_t));
    assert_memory_equal(a->instance, b->instance, RAYS * sizeof(uint32_t));
}

// The same bits as of a mesh that was authored there, beside a large one that stays where it is.
static void hits_are_those_of_points_put_there(void **state)
{
    (void)state;
    TestMesh few = mesh_soup(40, 0.7f, 5), wall = mesh_soup(2, 3.0f, 9);
    CoInstance moved = place(0, turned());
    TestMesh there[2] = {mesh_moved(&few, &moved.to_group), mesh_moved(&wall, &moved.to_group)};
    CoRayBatch rays = random_rays(3);
    for (size_t i = 0; i < RAYS; i++) // the transform that is none takes their sign from zeros
        if (i % 5 == 0)
            rays.dir_x[i] = rays.dir_y[i] = 0.0f;
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    for (int k = 0; k < 2; k++) {
        TestScene s = {0};
        CoInstance instances[2];
        for (int i = 0; i < 2; i++) {
            const TestMesh *own = i ? &wall : &few;
            instances[i] =
                place(scene_add_mesh(&s, k ? &there[i] : own), k ? co_mat4d_identity() : turned());
        }
        const CoTop *top = s.tops[scene_add_group(&s, instances, 2)];
        assert_true(top->is_in_place);
        assert_int_equal(top->baked_count, k ? 0 : 2);
        traverse_all(&s.scene, &rays, NULL, &hits[k], NULL);
        scene_clear(&s);
    }
    assert_true(count_hits(&hits[0]) > RAYS / 4 && count_hits(&hits[0]) < RAYS);
    assert_same_hits(&hits[0], &hits[1]);
    for (int k = 0; k < 2; k++) {
        hits_free(&hits[k]);
        mesh_free(&there[k]);
    }
    rays_free(&rays);
    mesh_free(&few);
    mesh_free(&wall);
}

// With zeros of both signs, hidden ones, and shadow rays; walked with the group or for themselves.
static void hits_do_not_depend_on_the_walk(void **state)
{
    (void)state;
    TestMesh few = mesh_soup(12, 1.0f, 6), more = mesh_soup(200, 0.3f, 7);
    CoRayBatch rays = random_rays(4);
    uint8_t *flags = malloc(RAYS);
    for (size_t i = 0; i < RAYS; i++)
        flags[i] = (uint8_t)(i % 3 == 0 ? CO_TRAVERSE_OCCLUSION : i % 3 == 1 ? 2 : 0);
    TestScene s = {0};
    CoInstance instances[2] = {place(scene_add_mesh(&s, &few), turned()),
                               place(scene_add_mesh(&s, &more), turned())};
    instances[0].hidden_from = 2;
    uint32_t inner = scene_add_group(&s, instances, 2);
    CoInstance outer = place(inner, matrix(-0.3, co_vec3_splat(1.2f), co_vec3(0, 0, -1.5f)));
    scene_add_group(&s, &outer, 1);
    CoTop *top = s.tops[inner];
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    assert_true(top->placed[0].is_baked && top->placed[1].is_baked && top->is_in_place);
    for (int k = 0; k < 2; k++) {
        traverse_all(&s.scene, &rays, flags, &hits[k], NULL);
        top->is_in_place = top->placed[0].is_in_place = top->placed[1].is_in_place = false;
    }
    assert_true(count_hits(&hits[0]) > RAYS / 8 && count_hits(&hits[0]) < RAYS);
    assert_same_hits(&hits[0], &hits[1]);
    for (int k = 0; k < 2; k++)
        hits_free(&hits[k]);
    scene_clear(&s);
    free(flags);
    rays_free(&rays);
    mesh_free(&few);
    mesh_free(&more);
}

static void others_stay_as_they_are(void **state)
{
    (void)state;
    TestMesh few = mesh_soup(8, 1.0f, 6), many = mesh_soup(257, 0.3f, 7);
    TestScene s = {0};
    uint32_t twice = scene_add_mesh(&s, &few), large = scene_add_mesh(&s, &many);
    uint32_t stays = scene_add_mesh(&s, &few), far = scene_add_mesh(&s, &few);
    uint32_t broken = scene_add_mesh(&s, &few), near = scene_add_mesh(&s, &few);
    uint32_t thin = scene_add_mesh(&s, &few);
    CoInstance instances[8] = {
        place(twice, turned()),
        place(twice, co_mat4d_identity()),
        place(large, turned()),
        place(stays, co_mat4d_identity()),
        place(far, matrix(0.0, co_vec3_splat(1.0f), co_vec3(1e6f, 0, 0))), // too coarse there
        place(broken, turned()),
        place(near, turned()),
        place(thin, matrix(0.7, co_vec3(1.0f, 0.4f, 1.0f), co_vec3(0, 0, 0)))};
    instances[5].to_group.m[0][3] = INFINITY;
    const CoTop *top = s.tops[scene_add_group(&s, instances, 8)];
    for (int i = 0; i < 8; i++)
        assert_int_equal(top->placed[i].is_baked, i == 6);
    assert_int_equal(top->baked_count, 1);
    assert_ptr_equal(top->placed[6].bvh, top->baked[0]);
    scene_clear(&s);
    mesh_free(&few);
    mesh_free(&many);
}

// A top brought to other places, and to points that have moved, is one made anew.
static void refits_bake_again(void **state)
{
    (void)state;
    TestMesh few = mesh_soup(12, 1.0f, 6);
    CoRayBatch rays = random_rays(5);
    TestScene s = {0};
    uint32_t mesh = scene_add_mesh(&s, &few);
    CoInstance instance = place(mesh, matrix(0, co_vec3_splat(1.0f), co_vec3(0.5f, 0, 0)));
    uint32_t group = scene_add_group(&s, &instance, 1);
    instance = place(mesh, turned());
    for (uint32_t i = 0; i < 3 * few.mesh.point_count; i++)
        few.points[i] *= 0.9f;
    mesh_box(&few);
    s.objects[mesh].box_min = few.mesh.box_min;
    s.objects[mesh].box_max = few.mesh.box_max;
    assert_true(co_bvh_refit(s.bvhs[mesh], &few.mesh));
    assert_true(co_top_refit(s.tops[group], &instance, 1, s.objects));
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    traverse_all(&s.scene, &rays, NULL, &hits[0], NULL);
    size_t bytes = co_top_bytes(s.tops[group]);
    scene_clear(&s);
    instance = place(scene_add_mesh(&s, &few), turned());
    group = scene_add_group(&s, &instance, 1);
    traverse_all(&s.scene, &rays, NULL, &hits[1], NULL);
    assert_int_equal(co_top_bytes(s.tops[group]), bytes);
    assert_true(count_hits(&hits[0]) > RAYS / 8);
    assert_same_hits(&hits[0], &hits[1]);
    for (int k = 0; k < 2; k++)
        hits_free(&hits[k]);
    scene_clear(&s);
    rays_free(&rays);
    mesh_free(&few);
}

static void failing_allocations_are_reported(void **state)
{
    (void)state;
    enum {
        PIECES = 10 // more than the list of trees has room for at first
    };
    TestScene s = {0};
    TestMesh few = mesh_soup(3, 1.0f, 6);
    CoInstance instances[PIECES];
    for (int i = 0; i < PIECES; i++)
        instances[i] = place(scene_add_mesh(&s, &few), turned());
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    CoTop *top = NULL;
    uint64_t n;
    for (n = 1; n < 500 && !top; n++) {
        CohortError err = {0};
        co_memory_fail_after(n);
        top = co_top_create(instances, PIECES, s.objects, &err);
        co_memory_fail_after(0);
        if (!top) {
            assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
            assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
        }
    }
    assert_non_null(top);
    assert_true(n > 3 * PIECES);
    assert_int_equal(top->baked_count, PIECES);
    assert_int_equal(co_top_bytes(top), co_memory_live(CO_MEMORY_ACCEL) - before);
    co_memory_fail_after(1);
    assert_false(co_top_refit(top, instances, PIECES, s.objects));
    co_memory_fail_after(0);
    co_top_destroy(top);
    scene_clear(&s);
    mesh_free(&few);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_those_of_points_put_there),
        cmocka_unit_test(hits_do_not_depend_on_the_walk),
        cmocka_unit_test(others_stay_as_they_are),
        cmocka_unit_test(refits_bake_again),
        cmocka_unit_test(failing_allocations_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
