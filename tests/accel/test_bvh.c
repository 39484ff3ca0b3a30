// Bottom levels: what leaves hold, memory per triangle, and failing allocations.

#include "accel/build.h"
#include "accel_scene.h"
#include "base/memory.h"

// Every triangle in one leaf, with its own corner points in its own order.
static void check_leaves(const CoBvh *bvh, const CoMesh *mesh)
{
    uint8_t *seen = calloc(mesh->tri_count + 1u, 1);
    for (size_t n = 0; n < bvh->tree.node_count; n++) {
        for (int i = 0; i < CO_NODE_WIDTH; i++) {
            uint32_t ref = bvh->tree.nodes[n].child[i];
            if (!(ref & CO_REF_LEAF))
                continue;
            const CoTriLeaf leaf =
                co_leaf_open(bvh->leaves + CO_LEAF_UNIT * (size_t)(ref & CO_REF_LEAF_PLACE));
            for (uint32_t j = 0; j < leaf.count; j++) {
                uint32_t tri = co_leaf_tri(&leaf, j);
                assert_in_range(tri, 0, mesh->tri_count - 1);
                seen[tri]++;
                for (uint32_t c = 0; c < 3; c++) {
                    size_t point = mesh->indices[3 * (size_t)tri + c];
                    for (size_t k = 0; k < 3; k++)
                        assert_true(leaf.points[k][co_leaf_corner(&leaf, c, j)] ==
                                    mesh->points[3 * point + k]);
                }
            }
        }
    }
    for (uint32_t i = 0; i < mesh->tri_count; i++)
        assert_int_equal(seen[i], 1);
    free(seen);
}

static void leaves_hold_each_triangle(void **state)
{
    (void)state;
    TestMesh meshes[3] = {mesh_soup(500, 0.2f, 1), mesh_sphere(20, 1.0f, co_vec3(0, 0, 0)),
                          mesh_soup(1, 1.0f, 2)};
    for (int i = 0; i < 3; i++) {
        CoBvh *bvh = co_bvh_create(&meshes[i].mesh, NULL);
        assert_non_null(bvh);
        check_leaves(bvh, &meshes[i].mesh);
        co_bvh_destroy(bvh);
        mesh_free(&meshes[i]);
    }
}

static void memory_is_modest_and_counted(void **state)
{
    (void)state;
    TestMesh sphere = mesh_sphere(80, 1.0f, co_vec3(0, 0, 0));
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    CoBvh *bvh = co_bvh_create(&sphere.mesh, NULL);
    assert_int_equal(co_bvh_bytes(bvh), co_memory_live(CO_MEMORY_ACCEL) - before);
    assert_true(co_bvh_bytes(bvh) <= 21 * (size_t)sphere.mesh.tri_count);
    co_bvh_destroy(bvh);
    assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
    co_bvh_destroy(NULL);
    mesh_free(&sphere);
}

static void empty_meshes_are_fine(void **state)
{
    (void)state;
    TestMesh none = mesh_alloc(0, 0);
    CoBvh *bvh = co_bvh_create(&none.mesh, NULL);
    assert_non_null(bvh);
    assert_int_equal(bvh->tree.node_count, 0);
    co_bvh_destroy(bvh);
    mesh_free(&none);
}

static void failing_allocations_are_reported(void **state)
{
    (void)state;
    TestMesh sphere = mesh_sphere(10, 1.0f, co_vec3(0, 0, 0));
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    CoBvh *bvh = create_despite_failures(&sphere.mesh, 5);
    check_leaves(bvh, &sphere.mesh);
    co_bvh_destroy(bvh);
    assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
    mesh_free(&sphere);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(leaves_hold_each_triangle),
        cmocka_unit_test(memory_is_modest_and_counted),
        cmocka_unit_test(empty_meshes_are_fine),
        cmocka_unit_test(failing_allocations_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
