// Canonical hits: the same for any tree, any order of instances, however thin or far they are.

#include "accel_scene.h"

// The same triangles in another order make another tree; distances may not know.
static void hits_do_not_depend_on_the_tree(void **state)
{
    (void)state;
    enum {
        RAYS = 20000
    };
    TestMesh sliver = mesh_soup(400, 0.5f, 3), turned = mesh_alloc(1200, 400);
    Random random = {17};
    for (uint32_t i = 0; i < 400; i++) { // third corner within 1e-6 of the edge
        float *p = sliver.points + 9 * i, w = random_float(&random, 0.0f, 1.0f);
        for (int k = 0; k < 3; k++)
            p[6 + k] = p[k] + w * (p[3 + k] - p[k]) + random_float(&random, -1e-6f, 1e-6f);
    }
    mesh_box(&sliver);
    memcpy(turned.points, sliver.points, 3600 * sizeof(float));
    for (uint32_t i = 0; i < 1200; i++)
        turned.indices[i] = sliver.indices[3 * ((i / 3 * 171 + 5) % 400) + i % 3];
    mesh_box(&turned);
    CoRayBatch rays = rays_alloc(RAYS);
    for (size_t i = 0; i < RAYS; i++) { // aimed at points of triangles
        const float *p = sliver.points + 9 * (random_bits(&random) % 400);
        float w = random_float(&random, 0.0f, 1.0f);
        CoVec3 at = co_lerp3(co_vec3_load(p), co_vec3_load(p + 3), w);
        CoVec3 org = random_vec3(&random, -2.0f, 2.0f);
        ray_set(&rays, i, org, co_sub(at, org));
    }
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    TestMesh *meshes[2] = {&sliver, &turned};
    for (int k = 0; k < 2; k++) {
        TestScene s = {0};
        CoInstance instance =
            place(scene_add_mesh(&s, meshes[k]), matrix(0.4, co_vec3(1, 2, 1), co_vec3(0, 0, 0)));
        scene_add_group(&s, &instance, 1);
        traverse_all(&s.scene, &rays, NULL, &hits[k], NULL);
        scene_clear(&s);
    }
    assert_true(same_bits(hits[0].t, hits[1].t, RAYS));
    for (int k = 0; k < 2; k++)
        hits_free(&hits[k]);
    rays_free(&rays);
    mesh_free(&sliver);
    mesh_free(&turned);
}

// Equal distances: the smaller path wins, then the smaller triangle.
static void coincident_quads_break_ties(void **state)
{
    (void)state;
    TestScene s = {0};
    TestMesh quads = mesh_alloc(4, 20);
    const float points[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    memcpy(quads.points, points, sizeof points);
    for (uint32_t i = 0; i < 20; i++) { // ten times the same two triangles
        const uint32_t corners[2][3] = {{0, 1, 2}, {0, 2, 3}};
        memcpy(quads.indices + 3 * (size_t)i, corners[i % 2], sizeof corners[0]);
    }
    mesh_box(&quads);
    uint32_t mesh = scene_add_mesh(&s, &quads);
    CoInstance instances[7];
    for (int i = 0; i < 7; i++)
        instances[i] = place(mesh, co_mat4d_identity());
    scene_add_group(&s, instances, 7);
    CoRayBatch rays = rays_alloc(2000);
    Random random = {4};
    for (size_t i = 0; i < 2000; i++) {
        CoVec3 org = random_vec3(&random, -0.9f, 0.9f);
        ray_set(&rays, i, org, co_sub(random_vec3(&random, -0.6f, 0.6f), org));
    }
    CoHitBatch hits = hits_alloc(2000);
    size_t count = 0;
    traverse_all(&s.scene, &rays, NULL, &hits, NULL);
    for (size_t i = 0; i < 2000; i++) {
        if (isinf(hits.t[i]))
            continue;
        count++;
        assert_int_equal(hits.instance[i], 0);
        assert_true(hits.tri[i] < 2);
    }
    assert_true(count > 500);
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&s);
    mesh_free(&quads);
}

// Slanted, overlapping quads without thickness, far from the origin of their group: all of them are
// found, and the order in which they are placed does not show in the distances.
static void flat_instances_are_found_in_any_order(void **state)
{
    (void)state;
    enum {
        RAYS = 20000,
        QUADS = 50
    };
    TestMesh quad = mesh_alloc(4, 2);
    const float points[12] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1};
    const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    memcpy(quad.points, points, sizeof points);
    memcpy(quad.indices, indices, sizeof indices);
    mesh_box(&quad);
    const CoVec3 home = co_vec3(3000, -2000, 500);
    CoInstance instances[2][QUADS];
    Random random = {31};
    CoRayBatch rays = rays_alloc(RAYS);
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    for (uint32_t i = 0; i < QUADS; i++) {
        CoVec3 size = co_vec3(0.5f, 1.0f, 2.0f);
        CoVec3 offset = co_add(home, random_vec3(&random, -1.0f, 1.0f));
        CoMat4d tilt = matrix(random_float(&random, 0, 6), size, co_vec3(0, 0, 0));
        CoMat4d turn = matrix(0.0, co_vec3(1, 1, 1), offset);
        double c = cos(0.1 * i), s = sin(0.1 * i); // every fifth quad stays level
        CoMat4d roll = {{{1, 0, 0, 0}, {0, c, s, 0}, {0, -s, c, 0}, {0, 0, 0, 1}}};
        if (i % 5 != 0)
            tilt = co_mat4d_mul(&tilt, &roll);
        tilt = co_mat4d_mul(&tilt, &turn);
        instances[0][i] = place(0, tilt);
        instances[1][(i * 7 + 3) % QUADS] = instances[0][i];
    }
    for (size_t i = 0; i < RAYS; i++) {
        const CoAffine *target = &instances[0][i % QUADS].to_group;
        CoVec3 on_quad = random_vec3(&random, -0.99f, 0.99f);
        on_quad.y = 0.0f;
        CoVec3 at = co_affine_point(target, on_quad);
        CoVec3 org = co_add(at, random_vec3(&random, -40.0f, 40.0f));
        ray_set(&rays, i, org, co_normalize(co_sub(at, org)));
    }
    for (int k = 0; k < 2; k++) {
        TestScene scene = {0};
        assert_int_equal(scene_add_mesh(&scene, &quad), 0);
        scene_add_group(&scene, instances[k], QUADS);
        traverse_all(&scene.scene, &rays, NULL, &hits[k], NULL);
        scene_clear(&scene);
    }
    for (size_t i = 0; i < RAYS; i++)
        assert_true(hits[0].t[i] < 71.0f);
    assert_true(same_bits(hits[0].t, hits[1].t, RAYS));
    hits_free(&hits[0]);
    hits_free(&hits[1]);
    rays_free(&rays);
    mesh_free(&quad);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_do_not_depend_on_the_tree),
        cmocka_unit_test(coincident_quads_break_ties),
        cmocka_unit_test(flat_instances_are_found_in_any_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
