// Blocks that trees of small meshes share: trees stay what they are, and no block outlives them.

#include "accel/build.h"
#include "accel_scene.h"
#include "base/memory.h"
#include "base/pages.h"

enum {
    MANY = 60
};

typedef struct Copy {
    CoWideNode *nodes;
    unsigned char *leaves;
} Copy;

static Copy copy_of(const CoBvh *bvh)
{
    Copy copy = {malloc(bvh->tree.node_count * sizeof *copy.nodes), malloc(bvh->leaf_bytes + 1)};
    memcpy(copy.nodes, bvh->tree.nodes, bvh->tree.node_count * sizeof *copy.nodes);
    memcpy(copy.leaves, bvh->leaves, bvh->leaf_bytes);
    return copy;
}

static void check_copy(const CoBvh *bvh, Copy copy)
{
    static const unsigned char zero[CO_LEAF_TAIL];
    assert_memory_equal(bvh->tree.nodes, copy.nodes, bvh->tree.node_count * sizeof *copy.nodes);
    assert_memory_equal(bvh->leaves, copy.leaves, bvh->leaf_bytes);
    assert_memory_equal(bvh->leaves + bvh->leaf_bytes, zero, sizeof zero);
    assert_ptr_equal(bvh->leaf_at, bvh->leaves);
    assert_int_equal((uintptr_t)bvh->tree.nodes % 64, 0);
    free(copy.nodes);
    free(copy.leaves);
}

// More than two blocks' worth, of which the first stays apart; destroyed in another order than that
// of building.
static void trees_move_unchanged(void **state)
{
    (void)state;
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    TestMesh sphere = mesh_sphere(50, 1.0f, co_vec3(0, 0, 0));
    CoBvhBlocks blocks = {0};
    CoBvh *bvhs[MANY];
    const CoBvhBlock *first = NULL;
    for (int i = 0; i < MANY; i++) {
        bvhs[i] = co_bvh_create(&sphere.mesh, NULL);
        Copy copy = copy_of(bvhs[i]);
        co_bvh_pack(bvhs[i], &blocks);
        if (bvhs[i]->block)
            co_bvh_pack(bvhs[i], &blocks); // it is already
        check_copy(bvhs[i], copy);
        assert_int_equal(bvhs[i]->block != NULL, blocks.seen > CO_PAGES_ALIGNMENT);
        assert_true(co_bvh_bytes(bvhs[i]) <= 21 * (size_t)sphere.mesh.tri_count);
        first = first ? first : bvhs[i]->block;
    }
    assert_ptr_not_equal(bvhs[MANY - 1]->block, first);
    co_bvh_blocks_close(&blocks);
    assert_null(blocks.open);
    for (int i = 0; i < MANY; i++)
        co_bvh_destroy(bvhs[i * 7 % MANY]);
    assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
    mesh_free(&sphere);
}

static void large_and_empty_ones_stay_alone(void **state)
{
    (void)state;
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    TestMesh meshes[2] = {mesh_sphere(160, 1.0f, co_vec3(0, 0, 0)), mesh_alloc(0, 0)};
    CoBvhBlocks blocks = {0};
    for (int i = 0; i < 2; i++) {
        CoBvh *bvh = co_bvh_create(&meshes[i].mesh, NULL);
        co_bvh_pack(bvh, &blocks);
        assert_null(bvh->block);
        assert_null(blocks.open);
        co_bvh_destroy(bvh);
        mesh_free(&meshes[i]);
    }
    co_bvh_blocks_close(&blocks);
    assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
}

// Refits happen in place; a tree without memory to move to stays where it is.
static void trees_in_blocks_refit_or_stay(void **state)
{
    (void)state;
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    TestMesh sphere = mesh_sphere(20, 1.0f, co_vec3(0, 0, 0));
    CoBvhBlocks blocks = {.seen = CO_PAGES_ALIGNMENT}; // enough for a block
    CoBvh *bvh = co_bvh_create(&sphere.mesh, NULL);
    co_memory_fail_after(1);
    co_bvh_pack(bvh, &blocks);
    co_memory_fail_after(0);
    assert_null(bvh->block);
    co_bvh_pack(bvh, &blocks);
    assert_non_null(bvh->block);
    co_bvh_blocks_close(&blocks);
    const CoWideNode *nodes = bvh->tree.nodes;
    float *points = (float *)(uintptr_t)sphere.mesh.points;
    for (uint32_t i = 0; i < sphere.mesh.point_count; i++)
        points[3 * (size_t)i] += 2.0f;
    assert_true(co_bvh_refit(bvh, &sphere.mesh));
    assert_ptr_equal(bvh->tree.nodes, nodes);
    assert_true(bvh->tree.box.lo[0] > 0.9f && bvh->tree.box.hi[0] < 3.1f);
    co_bvh_destroy(bvh);
    assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
    mesh_free(&sphere);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_move_unchanged),
        cmocka_unit_test(large_and_empty_ones_stay_alone),
        cmocka_unit_test(trees_in_blocks_refit_or_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
