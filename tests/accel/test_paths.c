// Path ids: dense, in the order of the paths, resolved back to chains and products of transforms.

#include "accel/paths.h"
#include "accel_scene.h"

static void ids_are_dense_and_ordered(void **state)
{
    (void)state;
    TestScene s = {0};
    TestMesh soup = mesh_soup(3, 0.5f, 1), none = mesh_alloc(0, 0);
    mesh_box(&none);
    uint32_t mesh = scene_add_mesh(&s, &soup), empty_mesh = scene_add_mesh(&s, &none);
    uint32_t empty_group = scene_add_group(&s, NULL, 0);
    CoVec3 one = co_vec3_splat(1.0f);
    CoInstance inner[3] = {place(empty_group, co_mat4d_identity()),
                           place(mesh, matrix(0.5, one, co_vec3(1, 2, 3))),
                           place(mesh, matrix(0.6, one, co_vec3(-1, 2, 3)))};
    uint32_t pair = scene_add_group(&s, inner, 3);
    CoInstance outer[6] = {
        place(pair, matrix(0.2, one, co_vec3(5, 0, 0))), place(empty_group, co_mat4d_identity()),
        place(mesh, matrix(0.3, one, co_vec3(0, 7, 0))), place(empty_mesh, co_mat4d_identity()),
        place(pair, matrix(0.4, one, co_vec3(0, 0, 9))), place(empty_group, co_mat4d_identity())};
    scene_add_group(&s, outer, 6);
    uint64_t count;
    assert_true(co_accel_path_count(&s.scene, &count));
    assert_int_equal(count, 6);
    const uint32_t chains[6][2] = {{0, 1}, {0, 2}, {2, 0}, {3, 0}, {4, 1}, {4, 2}};
    const uint32_t lengths[6] = {2, 2, 1, 1, 2, 2};
    for (uint32_t id = 0; id < 6; id++) {
        CoPlacement at;
        co_accel_placement(&s.scene, id, &at);
        assert_int_equal(at.chain_length, lengths[id]);
        assert_memory_equal(at.chain, chains[id], lengths[id] * sizeof(uint32_t));
        assert_int_equal(at.object, id == 3 ? empty_mesh : mesh);
        assert_int_equal(co_accel_path_object(&s.scene, id), at.object);
        CoVec3 p = co_vec3(0.3f, -0.2f, 0.9f), world = p;
        if (lengths[id] == 2)
            world = co_affine_point(&inner[chains[id][1]].to_group, world);
        world = co_affine_point(&outer[chains[id][0]].to_group, world);
        CoVec3 d = co_sub(co_affine_point(&at.to_world, p), world);
        assert_true(co_length(d) < 1e-5f);
        assert_true(co_length(co_sub(co_affine_point(&at.to_object, world), p)) < 1e-5f);
    }
    scene_clear(&s);
    mesh_free(&soup);
    mesh_free(&none);
}

// 2^34 paths in three levels: refused by the count, harmless otherwise.
static void too_many_paths_are_noticed(void **state)
{
    (void)state;
    enum {
        FAN = 2600
    };
    TestScene s = {0};
    TestMesh soup = mesh_soup(1, 0.5f, 1);
    uint32_t object = scene_add_mesh(&s, &soup);
    CoInstance *levels[3];
    uint64_t count;
    for (int k = 0; k < 3; k++) {
        levels[k] = malloc(FAN * sizeof *levels[k]);
        for (int i = 0; i < FAN; i++)
            levels[k][i] = place(object, matrix(0, co_vec3_splat(1), co_vec3((float)i, 0, 0)));
        object = scene_add_group(&s, levels[k], FAN);
        assert_true(co_accel_path_count(&s.scene, &count) == (k < 2));
    }
    assert_true(count == (uint64_t)FAN * FAN * FAN);
    scene_clear(&s);
    mesh_free(&soup);
    for (int k = 0; k < 3; k++)
        free(levels[k]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ids_are_dense_and_ordered),
        cmocka_unit_test(too_many_paths_are_noticed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
