// The tree builder: every thing in one leaf, boxes inside boxes, the same tree for any thread
// count.

#include "accel/build.h"
#include "accel_scene.h"
#include "base/parallel.h"

typedef struct Leaves {
    uint32_t *ids;
    size_t count;
} Leaves;

static bool four_fit(const void *context, const CoBuildPrim *prims, size_t count)
{
    (void)context;
    (void)prims;
    return count <= 4;
}

// A reference holds where its ids start and how many there are.
static bool list_leaf(void *context, const CoBuildPrim *prims, size_t count, uint32_t *ref,
                      CohortError *err)
{
    Leaves *leaves = context;
    (void)err;
    *ref = CO_REF_LEAF | (uint32_t)(count - 1) << CO_REF_COUNT_SHIFT | (uint32_t)leaves->count;
    for (size_t i = 0; i < count; i++)
        leaves->ids[leaves->count++] = prims[i].id;
    return true;
}

static CoBuildPrim *random_prims(size_t count, float size, uint64_t seed)
{
    Random random = {seed};
    CoBuildPrim *prims = calloc(count + 1, sizeof *prims);
    for (size_t i = 0; i < count; i++) {
        CoVec3 lo = random_vec3(&random, -1.0f, 1.0f), d = random_vec3(&random, 0.0f, size);
        co_vec3_store(prims[i].lo, lo);
        co_vec3_store(prims[i].hi, co_add(lo, d));
        prims[i].id = (uint32_t)i;
    }
    return prims;
}

typedef struct Check {
    const CoTree *tree;
    const Leaves *leaves;
    const CoBuildPrim *by_id;
    size_t seen;
} Check;

static bool is_inside(const float lo[3], const float hi[3], const CoBox *box)
{
    bool inside = true;
    for (int k = 0; k < 3; k++)
        inside = inside && box->lo[k] <= lo[k] && hi[k] <= box->hi[k];
    return inside;
}

// Returns the depth below a node, whose box the parent says is `box`.
static int check_node(Check *check, uint32_t index, const CoBox *box)
{
    const CoWideNode *node = &check->tree->nodes[index];
    int deepest = 0;
    for (int i = 0; i < CO_NODE_WIDTH; i++) {
        uint32_t ref = node->child[i];
        CoBox child;
        for (int k = 0; k < 3; k++) {
            child.lo[k] = node->planes[2 * k][i];
            child.hi[k] = node->planes[2 * k + 1][i];
        }
        if (ref == CO_REF_NONE) {
            assert_true(child.lo[0] == INFINITY && child.hi[0] == -INFINITY);
            continue;
        }
        assert_true(is_inside(child.lo, child.hi, box));
        int depth = 0;
        if (ref & CO_REF_LEAF) {
            uint32_t count = (ref >> CO_REF_COUNT_SHIFT & 7u) + 1;
            for (uint32_t j = 0; j < count; j++) {
                uint32_t id = check->leaves->ids[(ref & CO_REF_LEAF_PLACE) + j];
                assert_true(is_inside(check->by_id[id].lo, check->by_id[id].hi, &child));
                check->seen++;
            }
        } else {
            depth = check_node(check, ref, &child);
        }
        deepest = depth > deepest ? depth : deepest;
    }
    return deepest + 1;
}

static void build_and_check(CoBuildPrim *prims, uint32_t count)
{
    CoBuildPrim *by_id = malloc((count + 1) * sizeof *by_id);
    memcpy(by_id, prims, count * sizeof *by_id);
    Leaves leaves = {malloc((count + 1) * sizeof(uint32_t)), 0};
    CoLeafRule rule = {four_fit, list_leaf, &leaves, 4};
    CoTree tree;
    assert_true(co_tree_build(prims, count, &rule, &tree, NULL));
    assert_int_equal(leaves.count, count);
    if (count) {
        Check check = {&tree, &leaves, by_id, 0};
        assert_true(check_node(&check, 0, &tree.box) <= CO_TREE_DEPTH_MAX);
        assert_int_equal(check.seen, count);
        uint8_t *once = calloc(count, 1);
        for (size_t i = 0; i < count; i++)
            once[leaves.ids[i]]++;
        for (size_t i = 0; i < count; i++)
            assert_int_equal(once[i], 1);
        free(once);
    } else {
        assert_int_equal(tree.node_count, 0);
    }
    co_tree_clear(&tree);
    free(leaves.ids);
    free(by_id);
}

static void trees_hold_everything_once(void **state)
{
    (void)state;
    const uint32_t counts[] = {0, 1, 2, 4, 5, 9, 100, 3000, 70000};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        CoBuildPrim *prims = random_prims(counts[k], 0.1f, k);
        build_and_check(prims, counts[k]);
        free(prims);
    }
}

// All in one place; on a line with gaps that double; at the ends of the float range; sizes of
// nothing.
static void odd_distributions_end(void **state)
{
    (void)state;
    enum {
        COUNT = 5000
    };
    for (int kind = 0; kind < 4; kind++) {
        CoBuildPrim *prims = random_prims(COUNT, 0.0f, 3);
        for (int i = 0; i < COUNT; i++) {
            const float values[4] = {1.0f, ldexpf(1.0f, i % 250 - 125), i % 2 ? 3e38f : -3e38f,
                                     ldexpf((float)i, -149)};
            for (int k = 0; k < 3; k++)
                prims[i].lo[k] = prims[i].hi[k] = values[kind];
        }
        build_and_check(prims, COUNT);
        free(prims);
    }
}

static void threads_do_not_show(void **state)
{
    (void)state;
    enum {
        COUNT = 150000
    };
    CoTree trees[2];
    Leaves leaves[2];
    for (uint32_t k = 0; k < 2; k++) {
        co_worker_count_set(k ? 3 : 1);
        CoBuildPrim *prims = random_prims(COUNT, 0.02f, 6);
        leaves[k] = (Leaves){malloc(COUNT * sizeof(uint32_t)), 0};
        CoLeafRule rule = {four_fit, list_leaf, &leaves[k], 4};
        assert_true(co_tree_build(prims, COUNT, &rule, &trees[k], NULL));
        free(prims);
    }
    co_worker_count_set(0);
    assert_int_equal(trees[0].node_count, trees[1].node_count);
    assert_memory_equal(trees[0].nodes, trees[1].nodes,
                        trees[0].node_count * sizeof *trees[0].nodes);
    assert_memory_equal(leaves[0].ids, leaves[1].ids, COUNT * sizeof(uint32_t));
    for (int k = 0; k < 2; k++) {
        co_tree_clear(&trees[k]);
        free(leaves[k].ids);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_hold_everything_once),
        cmocka_unit_test(odd_distributions_end),
        cmocka_unit_test(threads_do_not_show),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
