// Subtrees: what is planned is what is written, no plan is dearer than a binary tree, each leaf is
// written once.

#include "accel/subtree.h"
#include "build_prims.h"

enum {
    MOST = 700
};

typedef struct Written {
    uint32_t seen[MOST]; // leaves that a prim is in
    size_t leaves, largest;
} Written;

// Leaves of at most three, of a unit for each prim.
static bool fits(const void *context, const CoBuildPrim *prims, size_t count)
{
    (void)context;
    (void)prims;
    return count <= 3;
}

static uint32_t emit(const void *context, const CoBuildPrim *prims, size_t count,
                     unsigned char *out, size_t *bytes)
{
    Written *written = (Written *)(uintptr_t)context;
    for (size_t i = 0; i < count; i++) {
        written->seen[prims[i].id]++;
        memset(out + CO_LEAF_UNIT * i, (int)(prims[i].id & 0xff), CO_LEAF_UNIT);
    }
    written->leaves++;
    written->largest = count > written->largest ? count : written->largest;
    *bytes = CO_LEAF_UNIT * count;
    return CO_REF_LEAF;
}

typedef struct Fixture {
    CoBuildPrim prims[MOST], moved[MOST];
    Written written;
    CoLeafRule rule;
    CoSubtree subtree;
} Fixture;

static CoRange prepare(Fixture *f, uint32_t count, PrimKind kind)
{
    memset(f, 0, sizeof *f);
    prims_fill(f->prims, count, kind, count);
    f->rule = (CoLeafRule){fits, emit, NULL, &f->written, 3, 0, CO_LEAF_UNIT};
    f->subtree = (CoSubtree){.moved = f->moved, .prims = f->prims, .rule = &f->rule};
    CoRange range = {0, count, 0, prims_box(f->prims, count)};
    double area = co_box_area(&range.box);
    f->subtree.scale = area > 0.0 ? 1.0 / area : 0.0;
    return range;
}

static void forget(Fixture *f)
{
    CoSubtree *s = &f->subtree;
    co_free(CO_MEMORY_ACCEL, s->nodes, s->node_capacity * sizeof *s->nodes);
    co_free(CO_MEMORY_ACCEL, s->leaves, s->leaf_capacity);
}

static void every_prim_is_in_one_leaf(void **state)
{
    (void)state;
    static Fixture f;
    const uint32_t counts[] = {1, 2, 3, 4, 9, 64, MOST};
    for (int kind = 0; kind < PRIM_KINDS; kind++) {
        for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
            for (int has_node = 0; has_node < 2; has_node++) {
                CoRange range = prepare(&f, counts[c], (PrimKind)kind);
                CoPiece piece;
                assert_true(co_subtree_build(&f.subtree, &range, has_node, &piece));
                for (uint32_t i = 0; i < counts[c]; i++)
                    assert_int_equal(f.written.seen[i], 1);
                assert_true(f.written.largest <= 3);
                assert_int_equal(piece.leaf_bytes, CO_LEAF_UNIT * counts[c]);
                assert_memory_equal((char *)(piece.nodes + piece.node_count), f.subtree.leaves,
                                    piece.leaf_bytes);
                bool is_node = has_node || counts[c] > 3;
                assert_int_equal(piece.node_count, is_node ? co_plan_count(f.subtree.nodes, 0) : 0);
                assert_int_equal(!(piece.root & CO_REF_LEAF), is_node);
                co_piece_clear(&piece);
                assert_null(piece.nodes);
                forget(&f);
            }
        }
    }
}

// Children are subtrees that hold, together, what the node holds.
static void plans_cover_the_tree(void **state)
{
    (void)state;
    static Fixture f;
    CoRange range = prepare(&f, MOST, PRIMS_ANYWHERE);
    CoPiece piece;
    assert_true(co_subtree_build(&f.subtree, &range, false, &piece));
    const CoBinaryNode *nodes = f.subtree.nodes;
    for (size_t i = 0; i < f.subtree.node_count; i++) {
        uint32_t children[CO_NODE_WIDTH], count = 0;
        if (!nodes[i].right)
            continue;
        int n = co_plan_children(nodes, i, children);
        assert_in_range(n, 2, CO_NODE_WIDTH);
        for (int k = 0; k < n; k++) {
            assert_true(children[k] > i);
            assert_int_equal(nodes[children[k]].first, nodes[i].first + count);
            count += nodes[children[k]].count;
        }
        assert_int_equal(count, nodes[i].count);
        // More places for children are never dearer.
        for (int j = 2; j < CO_NODE_WIDTH; j++)
            assert_true(nodes[i].cost[j] <= nodes[i].cost[j - 1]);
    }
    // 8 wide: far fewer nodes than inner nodes of the binary tree.
    assert_true(piece.node_count * 4 < f.subtree.node_count);
    co_piece_clear(&piece);
    forget(&f);
}

// Up to 8 are leaves of one node, or of that above it where there is room; 9 are not.
static void few_alike_are_one_node(void **state)
{
    (void)state;
    static Fixture f;
    for (uint32_t count = 2; count <= 40; count++) {
        CoRange range = prepare(&f, count, PRIMS_ANYWHERE);
        CoPiece piece;
        f.rule.most = 1;
        f.rule.flat = CO_NODE_WIDTH;
        assert_true(co_subtree_build(&f.subtree, &range, false, &piece));
        assert_int_equal(f.written.leaves, count);
        assert_int_equal(f.written.largest, 1);
        assert_int_equal(piece.node_count, co_plan_count(f.subtree.nodes, 0));
        assert_true((piece.node_count == 1) == (count <= CO_NODE_WIDTH));
        size_t leaves = 0, nodes = 1;
        for (size_t n = 0; n < piece.node_count; n++) {
            for (int i = 0; i < CO_NODE_WIDTH; i++) {
                uint32_t ref = piece.nodes[n].child[i];
                leaves += (ref & CO_REF_LEAF) != 0;
                nodes += !(ref & CO_REF_LEAF) && ref != CO_REF_NONE;
            }
        }
        assert_int_equal(leaves, count);
        assert_int_equal(nodes, piece.node_count);
        co_piece_clear(&piece);
        forget(&f);
    }
}

static void a_leaf_costs_the_same_in_any_place(void **state)
{
    (void)state;
    CoBinaryNode node = {.box = {{0, 0, 0}, {1, 2, 3}}};
    co_plan_node(&node, NULL, NULL, 0.5);
    assert_true(node.cost[1] > 0.0f);
    for (int j = 2; j < CO_NODE_WIDTH; j++)
        assert_true(node.cost[j] == node.cost[1]);
}

// Whichever allocation it is: of nodes, of leaves or of the piece.
static void no_memory_is_said(void **state)
{
    (void)state;
    static Fixture f;
    size_t live = co_memory_live(CO_MEMORY_ACCEL);
    bool is_built = false;
    uint64_t n;
    for (n = 1; n < 100 && !is_built; n++) {
        CoRange range = prepare(&f, 100, PRIMS_ANYWHERE);
        CoPiece piece;
        co_memory_fail_after(n);
        is_built = co_subtree_build(&f.subtree, &range, true, &piece);
        co_memory_fail_after(0);
        assert_true(is_built == (piece.nodes != NULL));
        co_piece_clear(&piece);
        forget(&f);
        assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), live);
    }
    assert_true(is_built && n > 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_prim_is_in_one_leaf),
        cmocka_unit_test(plans_cover_the_tree),
        cmocka_unit_test(few_alike_are_one_node),
        cmocka_unit_test(a_leaf_costs_the_same_in_any_place),
        cmocka_unit_test(no_memory_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
