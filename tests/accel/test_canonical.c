// Canonical hits: the same for any tree, any order of instances, however thin or far they are.

#include "accel_scene.h"

// Points strewn among the triangles as triangles without area are never hit, but move every split:
// distances may not know.
static void hits_do_not_depend_on_the_tree(void **state)
{
    (void)state;
    enum {
        RAYS = 50000,
        STREWN = 900
    };
    TestMesh slivers = mesh_slivers(3), strewn = mesh_alloc(3 * SLIVERS, SLIVERS + STREWN);
    Random random = {23};
    memcpy(strewn.points, slivers.points, 9 * SLIVERS * sizeof(float));
    for (uint32_t i = 0; i < 3 * SLIVERS; i++)
        strewn.indices[i] = i;
    for (uint32_t i = SLIVERS; i < SLIVERS + STREWN; i++) {
        uint32_t point = random_bits(&random) % SLIVERS; // a corner of one of the first slivers
        for (uint32_t c = 0; c < 3; c++)
            strewn.indices[3 * (size_t)i + c] = point;
    }
    mesh_box(&strewn);
    CoRayBatch rays = rays_along_slivers(&slivers, SLIVERS, RAYS, 17);
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    TestMesh *meshes[2] = {&slivers, &strewn};
    size_t count = 0;
    for (int k = 0; k < 2; k++) {
        TestScene s = {0};
        CoInstance instance = place(scene_add_mesh(&s, meshes[k]), co_mat4d_identity());
        scene_add_group(&s, &instance, 1);
        traverse_all(&s.scene, &rays, NULL, &hits[k], NULL);
        scene_clear(&s);
    }
    for (size_t i = 0; i < RAYS; i++)
        count += hits[0].t[i] < INFINITY;
    assert_true(count > RAYS / 100);
    assert_true(same_bits(hits[0].t, hits[1].t, RAYS));
    for (int k = 0; k < 2; k++)
        hits_free(&hits[k]);
    rays_free(&rays);
    mesh_free(&slivers);
    mesh_free(&strewn);
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

// Rotation about x.
static CoMat4d roll(double angle)
{
    double c = cos(angle), s = sin(angle);
    CoMat4d m = {{{1, 0, 0, 0}, {0, c, s, 0}, {0, -s, c, 0}, {0, 0, 0, 1}}};
    return m;
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
    // The second quad is slanted by what its instances turn it back: level up to rounding.
    TestMesh quads[2] = {mesh_alloc(4, 2), mesh_alloc(4, 2)};
    const float points[12] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1};
    const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    const CoMat4d slant = roll(0.7), level = roll(-0.7);
    const CoAffine slanted = co_affine_from_mat4d(&slant);
    for (int k = 0; k < 2; k++) {
        memcpy(quads[k].points, points, sizeof points);
        memcpy(quads[k].indices, indices, sizeof indices);
        for (int i = 0; i < 4 && k == 1; i++)
            co_vec3_store(quads[k].points + 3 * i,
                          co_affine_point(&slanted, co_vec3_load(points + 3 * i)));
        mesh_box(&quads[k]);
    }
    const CoVec3 home = co_vec3(3000, -2000, 500);
    CoInstance instances[2][QUADS];
    Random random = {31};
    CoRayBatch rays = rays_alloc(RAYS);
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    for (uint32_t i = 0; i < QUADS; i++) {
        CoVec3 size = co_vec3(0.5f, 1.0f, 2.0f);
        CoVec3 offset = co_add(home, random_vec3(&random, -1.0f, 1.0f));
        CoMat4d tilt = matrix((double)random_float(&random, 0, 6), size, co_vec3(0, 0, 0));
        CoMat4d turn = matrix(0.0, co_vec3(1, 1, 1), offset);
        CoMat4d tilted = roll(0.1 * i);
        if (i % 5 != 0) // every fifth quad stays level
            tilt = co_mat4d_mul(&tilt, &tilted);
        tilt = co_mat4d_mul(&tilt, &turn);
        if (i % 2)
            tilt = co_mat4d_mul(&level, &tilt);
        instances[0][i] = place(i % 2, tilt);
        instances[1][(i * 7 + 3) % QUADS] = instances[0][i];
    }
    for (size_t i = 0; i < RAYS; i++) {
        const CoAffine *target = &instances[0][i % QUADS].to_group;
        CoVec3 on_quad = random_vec3(&random, -0.99f, 0.99f);
        on_quad.y = 0.0f;
        if (i % QUADS % 2)
            on_quad = co_affine_point(&slanted, on_quad);
        CoVec3 at = co_affine_point(target, on_quad);
        CoVec3 org = co_add(at, random_vec3(&random, -40.0f, 40.0f));
        ray_set(&rays, i, org, co_normalize(co_sub(at, org)));
    }
    for (int k = 0; k < 2; k++) {
        TestScene scene = {0};
        assert_int_equal(scene_add_mesh(&scene, &quads[0]), 0);
        assert_int_equal(scene_add_mesh(&scene, &quads[1]), 1);
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
    mesh_free(&quads[0]);
    mesh_free(&quads[1]);
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
