// Subtrees: what is planned is what is written, each leaf is written once, where its prims were or
// apart.

#include "accel/subtree.h"
#include "build_prims.h"

enum {
    MOST = 700
};

typedef struct Written {
    uint32_t seen[MOST]; // leaves that a prim is in
    size_t leaves, largest, units; // bytes of a prim, in leaf units
} Written;

// Leaves of at most three, with the numbers of their prims.
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
        for (size_t k = 0; k < written->units; k++)
            memcpy(out + CO_LEAF_UNIT * (i * written->units + k), &prims[i].id, CO_LEAF_UNIT);
    }
    written->leaves++;
    written->largest = count > written->largest ? count : written->largest;
    *bytes = CO_LEAF_UNIT * count * written->units;
    return CO_REF_LEAF;
}

enum {
    UNITS = 20, // more than a prim takes
    EMITTED = CO_LEAVES_HELD + CO_NODE_WIDTH * UNITS * CO_LEAF_UNIT
};

typedef struct Fixture {
    CoBuildPrim prims[MOST];
    Written written;
    CoLeafRule rule;
    CoSubtree subtree;
    unsigned char emitted[EMITTED];
} Fixture;

static CoRange prepare(Fixture *f, uint32_t count, PrimKind kind, size_t units)
{
    memset(f, 0, sizeof *f);
    prims_fill(f->prims, count, kind, count);
    f->written.units = units;
    f->rule = (CoLeafRule){fits, emit, NULL, &f->written, 3, 0, CO_LEAF_UNIT * units};
    f->subtree = (CoSubtree){.prims = f->prims, .rule = &f->rule, .emitted = f->emitted};
    CoRange range = {0, count, 0, prims_box(f->prims, count)};
    double area = co_box_area(&range.box);
    f->subtree.scale = area > 0.0 ? 1.0 / area : 0.0;
    return range;
}

static void forget(Fixture *f, CoPiece *piece)
{
    co_subtree_clear(&f->subtree);
    co_piece_clear(piece);
    assert_null(piece->bytes);
}

// In the order of the leaves; each prim as often as it was written.
static void check_leaves(const Fixture *f, const CoPiece *piece, uint32_t count)
{
    uint32_t found[MOST] = {0}, id;
    assert_int_equal(piece->leaf_bytes, CO_LEAF_UNIT * count * f->written.units);
    for (size_t i = 0; i < piece->leaf_bytes; i += sizeof id) {
        memcpy(&id, piece->bytes + i, sizeof id);
        assert_true(id < count);
        found[id]++;
    }
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(f->written.seen[i], 1);
        assert_int_equal(found[i], f->written.units);
    }
    assert_true(f->written.largest <= 3);
}

// Leaves lie where their prims were as long as they and the nodes are no more.
static void every_prim_is_in_one_leaf(void **state)
{
    (void)state;
    static Fixture f;
    const uint32_t counts[] = {1, 2, 3, 4, 9, 64, MOST}, units[] = {0, 1, 5, 8, UNITS};
    for (int kind = 0; kind < PRIM_KINDS; kind++) {
        for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
            for (size_t u = 0; u < 2 * sizeof units / sizeof *units; u++) {
                bool has_node = u % 2;
                CoRange range = prepare(&f, counts[c], (PrimKind)kind, units[u / 2]);
                CoPiece piece;
                assert_true(co_subtree_build(&f.subtree, &range, has_node, &piece));
                check_leaves(&f, &piece, counts[c]);
                bool is_node = has_node || counts[c] > 3;
                assert_int_equal(piece.node_count, is_node ? co_plan_count(f.subtree.nodes, 0) : 0);
                assert_int_equal(!(piece.root & CO_REF_LEAF), is_node);
                if (piece.is_apart)
                    assert_true(units[u / 2] > 7 ||
                                co_piece_bytes(&piece) > counts[c] * sizeof(CoBuildPrim));
                else
                    assert_ptr_equal(piece.bytes, f.prims);
                assert_true(piece.is_apart || units[u / 2] <= 7);
                co_piece_leave_nodes(&piece);
                assert_int_equal(co_piece_bytes(&piece), CO_LEAF_UNIT * counts[c] * units[u / 2]);
                if (piece.leaf_bytes)
                    check_leaves(&f, &piece, counts[c]);
                forget(&f, &piece);
            }
        }
    }
}

// Returns how many leaves are below a node, and lists them from the left.
static uint32_t leaves_below(const CoBinaryNode *nodes, uint32_t from, uint32_t *out)
{
    if (!nodes[from].right) {
        *out = from;
        return 1;
    }
    uint32_t count = leaves_below(nodes, from + 1, out);
    return count + leaves_below(nodes, nodes[from].right, out + count);
}

// Children are subtrees that hold, together, what the node holds.
static void plans_cover_the_tree(void **state)
{
    (void)state;
    static Fixture f;
    static uint32_t want[MOST], got[MOST];
    CoRange range = prepare(&f, MOST, PRIMS_ANYWHERE, 1);
    CoPiece piece;
    assert_true(co_subtree_build(&f.subtree, &range, false, &piece));
    const CoBinaryNode *nodes = f.subtree.nodes;
    for (uint32_t i = 0; i < f.subtree.node_count; i++) {
        uint32_t children[CO_NODE_WIDTH], count = 0;
        if (!nodes[i].right)
            continue;
        int n = co_plan_children(nodes, i, children);
        assert_in_range(n, 2, CO_NODE_WIDTH);
        for (int k = 0; k < n; k++) {
            assert_true(children[k] > i);
            count += leaves_below(nodes, children[k], got + count);
        }
        assert_int_equal(leaves_below(nodes, i, want), count);
        assert_memory_equal(want, got, count * sizeof *want);
    }
    // 8 wide: far fewer nodes than inner nodes of the binary tree.
    assert_true(piece.node_count * 4 < f.subtree.node_count);
    forget(&f, &piece);
}

// Up to 8 are leaves of one node, or of that above it where there is room; 9 are not.
static void few_alike_are_one_node(void **state)
{
    (void)state;
    static Fixture f;
    for (uint32_t count = 2; count <= 40; count++) {
        CoRange range = prepare(&f, count, PRIMS_ANYWHERE, 1);
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
            CoWideNode node;
            memcpy(&node, piece.bytes + piece.leaf_bytes + n * sizeof node, sizeof node);
            for (int i = 0; i < CO_NODE_WIDTH; i++) {
                uint32_t ref = node.child[i];
                leaves += (ref & CO_REF_LEAF) != 0;
                nodes += !(ref & CO_REF_LEAF) && ref != CO_REF_NONE;
            }
        }
        assert_int_equal(leaves, count);
        assert_int_equal(nodes, piece.node_count);
        forget(&f, &piece);
    }
}

static void a_leaf_costs_the_same_in_any_place(void **state)
{
    (void)state;
    CoBinaryNode node = {.box = {{0, 0, 0}, {1, 2, 3}}};
    CoPlan plan;
    co_plan_node(&node, NULL, 0.5, &plan);
    assert_true(plan.cost[1] > 0.0f);
    for (int j = 2; j < CO_NODE_WIDTH; j++)
        assert_true(plan.cost[j] == plan.cost[1]);
}

// More places for children are never dearer; with one, the node is a child itself.
static void more_places_are_never_dearer(void **state)
{
    (void)state;
    Random random = {7};
    for (int i = 0; i < 1000; i++) {
        CoBinaryNode node = {.right = 5};
        CoPlan halves[2], plan;
        co_vec3_store(node.box.hi, random_vec3(&random, 0.0f, 2.0f));
        for (int k = 0; k < 2; k++) {
            halves[k].cost[1] = random_float(&random, 0.0f, 1.0f);
            for (int j = 2; j < CO_NODE_WIDTH; j++)
                halves[k].cost[j] = halves[k].cost[j - 1] * random_float(&random, 0.0f, 1.0f);
        }
        co_plan_node(&node, halves, 0.5, &plan);
        for (int j = 2; j < CO_NODE_WIDTH; j++)
            assert_true(plan.cost[j] <= plan.cost[j - 1]);
        assert_true(plan.cost[2] <= halves[0].cost[1] + halves[1].cost[1]);
    }
}

// Whichever allocation it is: of nodes, of leaves or of the piece.
static void no_memory_is_said(void **state)
{
    (void)state;
    static Fixture f;
    size_t live = co_memory_live(CO_MEMORY_ACCEL);
    for (size_t units = 1; units <= UNITS; units += UNITS - 1) {
        bool is_built = false;
        uint64_t n = 0;
        while (!is_built && n < 100) {
            CoRange range = prepare(&f, 100, PRIMS_ANYWHERE, units);
            CoPiece piece;
            co_memory_fail_after(++n);
            is_built = co_subtree_build(&f.subtree, &range, true, &piece);
            co_memory_fail_after(0);
            forget(&f, &piece);
            assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), live);
        }
        assert_true(is_built && n > (units > 1 ? 5 : 2));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_prim_is_in_one_leaf),
        cmocka_unit_test(plans_cover_the_tree),
        cmocka_unit_test(few_alike_are_one_node),
        cmocka_unit_test(a_leaf_costs_the_same_in_any_place),
        cmocka_unit_test(more_places_are_never_dearer),
        cmocka_unit_test(no_memory_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
