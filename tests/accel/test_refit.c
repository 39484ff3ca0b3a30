// Refits: the hits of a tree that was refitted are those of one built anew, bit for bit.

#include "accel_scene.h"
#include "base/memory.h"
#include "geometry/mesh.h"

enum {
    RAYS = 2000
};

static CoRayBatch random_rays(uint64_t seed)
{
    Random random = {seed};
    CoRayBatch rays = rays_alloc(RAYS);
    for (size_t i = 0; i < RAYS; i++)
        ray_set(&rays, i, random_vec3(&random, -4.0f, 4.0f), random_vec3(&random, -1.0f, 1.0f));
    return rays;
}

// Returns how many rays hit.
static size_t compare_scenes(const CoAccelScene *a, const CoAccelScene *b)
{
    CoRayBatch rays = random_rays(77);
    CoHitBatch x = hits_alloc(RAYS), y = hits_alloc(RAYS);
    traverse_all(a, &rays, NULL, &x, NULL);
    traverse_all(b, &rays, NULL, &y, NULL);
    assert_true(same_bits(x.t, y.t, RAYS) && same_bits(x.u, y.u, RAYS) &&
                same_bits(x.v, y.v, RAYS) && same_bits(x.tri, y.tri, RAYS) &&
                same_bits(x.instance, y.instance, RAYS));
    size_t found = 0;
    for (size_t i = 0; i < RAYS; i++)
        found += x.t[i] < INFINITY;
    hits_free(&x);
    hits_free(&y);
    rays_free(&rays);
    return found;
}

static void set_object(TestScene *scene, uint32_t id, const CoMesh *mesh)
{
    scene->objects[id].mesh = mesh;
    scene->objects[id].box_min = mesh->box_min;
    scene->objects[id].box_max = mesh->box_max;
}

// Sets up one placement of `mesh`, refitted to it where `bvh` is given.
static void place_one(TestScene *scene, const TestMesh *mesh, CoBvh *bvh, CoInstance *instance)
{
    memset(scene, 0, sizeof *scene);
    uint32_t id = scene_add_mesh(scene, mesh);
    if (bvh) {
        co_bvh_destroy(scene->bvhs[id]);
        scene->bvhs[id] = bvh;
        scene->objects[id].bvh = bvh;
    }
    *instance = place(id, matrix(0.0, co_vec3_splat(1.0f), co_vec3_splat(0.0f)));
    scene_add_group(scene, instance, 1);
}

static void wave(TestMesh *mesh, float amount)
{
    for (uint32_t i = 0; i < mesh->mesh.point_count; i++) {
        float *p = mesh->points + 3 * (size_t)i, y = p[1];
        p[0] += amount * sinf(3.0f * y);
        p[2] += amount * cosf(2.0f * y);
    }
    mesh_box(mesh);
}

static void deformed_meshes_are_followed(void **state)
{
    (void)state;
    const uint32_t sizes[] = {3, 8, 60};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        TestMesh mesh = mesh_sphere(sizes[s], 3.0f, co_vec3(0, 0, 0));
        CoBvh *bvh = co_bvh_create(&mesh.mesh, NULL);
        size_t bytes = co_bvh_bytes(bvh);
        for (int step = 0; step < 3; step++) {
            wave(&mesh, 0.15f);
            assert_true(co_bvh_refit(bvh, &mesh.mesh));
        }
        assert_int_equal(co_bvh_bytes(bvh), bytes);
        CoInstance instances[2];
        TestScene refitted, anew;
        place_one(&refitted, &mesh, bvh, &instances[0]);
        place_one(&anew, &mesh, NULL, &instances[1]);
        assert_in_range(compare_scenes(&refitted.scene, &anew.scene), 50, RAYS);
        scene_clear(&refitted);
        scene_clear(&anew);
        mesh_free(&mesh);
    }
}

// Points thrown about at random leave a tree whose boxes all overlap.
static void ruined_trees_are_refused(void **state)
{
    (void)state;
    Random random = {5};
    TestMesh mesh = mesh_sphere(40, 1.0f, co_vec3(0, 0, 0));
    CoBvh *bvh = co_bvh_create(&mesh.mesh, NULL);
    assert_true(co_bvh_refit(bvh, &mesh.mesh));
    for (uint32_t i = 0; i < mesh.mesh.point_count; i++)
        co_vec3_store(mesh.points + 3 * (size_t)i, random_vec3(&random, -1.0f, 1.0f));
    assert_false(co_bvh_refit(bvh, &mesh.mesh));
    co_bvh_destroy(bvh);
    TestMesh none = mesh_alloc(0, 0);
    bvh = co_bvh_create(&none.mesh, NULL);
    assert_true(co_bvh_refit(bvh, &none.mesh));
    co_bvh_destroy(bvh);
    mesh_free(&none);
    mesh_free(&mesh);
}

enum {
    PLACED = 200
};

static void place_all(CoInstance instances[PLACED], uint32_t object, float spread, uint64_t seed)
{
    Random random = {seed};
    for (int i = 0; i < PLACED; i++) {
        CoVec3 at =
            co_vec3((float)(i % 6) - 3.0f, (float)(i / 6 % 6) - 3.0f, (float)(i / 36) - 3.0f);
        instances[i] =
            place(object, matrix((double)random_float(&random, 0.0f, 6.0f), co_vec3_splat(0.4f),
                                 co_add(at, random_vec3(&random, -spread, spread))));
    }
}

static void moved_instances_are_followed(void **state)
{
    (void)state;
    TestMesh mesh = mesh_sphere(6, 1.0f, co_vec3(0, 0, 0));
    TestScene scenes[2];
    memset(scenes, 0, sizeof scenes);
    CoInstance instances[PLACED];
    uint32_t id = scene_add_mesh(&scenes[0], &mesh);
    scene_add_mesh(&scenes[1], &mesh);
    place_all(instances, id, 0.0f, 1);
    uint32_t group = scene_add_group(&scenes[0], instances, PLACED);
    CoTop *top = scenes[0].tops[group];
    size_t bytes = co_top_bytes(top);
    place_all(instances, id, 0.3f, 2);
    assert_true(co_top_refit(top, instances, PLACED, scenes[0].objects));
    assert_int_equal(co_top_bytes(top), bytes);
    group_box(&scenes[0], &scenes[0].objects[group]);
    scene_add_group(&scenes[1], instances, PLACED);
    assert_true(compare_scenes(&scenes[0].scene, &scenes[1].scene) > 100);
    // All the way across, a tree over what was near is no use; nor one over another number.
    Random random = {9};
    for (int i = 0; i < PLACED; i++)
        instances[i] =
            place(id, matrix(0.0, co_vec3_splat(0.1f), random_vec3(&random, -9.0f, 9.0f)));
    assert_false(co_top_refit(top, instances, PLACED, scenes[0].objects));
    assert_false(co_top_refit(top, instances, PLACED - 1, scenes[0].objects));
    scene_clear(&scenes[0]);
    scene_clear(&scenes[1]);
    mesh_free(&mesh);
}

// An object that gets or loses its box is not in the tree, or is still.
static void boxes_that_come_and_go_are_noticed(void **state)
{
    (void)state;
    TestMesh mesh = mesh_sphere(6, 1.0f, co_vec3(0, 0, 0)), none = mesh_alloc(0, 0);
    mesh_box(&none);
    TestScene scene;
    memset(&scene, 0, sizeof scene);
    uint32_t full = scene_add_mesh(&scene, &mesh), empty = scene_add_mesh(&scene, &none);
    CoInstance instances[3];
    for (int i = 0; i < 3; i++)
        instances[i] = place(i == 1 ? empty : full, matrix(0.0, co_vec3_splat(1.0f),
                                                           co_vec3((float)i * 2.0f - 2.0f, 0, 0)));
    uint32_t group = scene_add_group(&scene, instances, 3);
    assert_true(co_top_refit(scene.tops[group], instances, 3, scene.objects));
    set_object(&scene, empty, &mesh.mesh);
    assert_false(co_top_refit(scene.tops[group], instances, 3, scene.objects));
    set_object(&scene, empty, &none.mesh);
    instances[2].to_group.m[0][0] = NAN;
    assert_false(co_top_refit(scene.tops[group], instances, 3, scene.objects));
    scene_clear(&scene);
    mesh_free(&mesh);
    mesh_free(&none);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(deformed_meshes_are_followed),
        cmocka_unit_test(ruined_trees_are_refused),
        cmocka_unit_test(moved_instances_are_followed),
        cmocka_unit_test(boxes_that_come_and_go_are_noticed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
