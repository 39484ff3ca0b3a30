// Subtrees: what is planned is what is written, each leaf is written once, its records where its
// prims were or apart.

#include "accel/subtree.h"
#include "build_prims.h"

enum {
    MOST = 700,
    UNITS = 3,     // of leaves, most
    BASE_NODE = 2, // before those of the piece
    BASE_UNIT = 5
};

typedef struct Written {
    uint32_t seen[MOST];           // leaves that a prim is in
    size_t leaves, largest, units; // bytes of a prim, in leaf units
} Written;

// Leaves of at most three, with the numbers of their prims.
static bool fits(const void *context, const CoBuildPrim *prims, size_t count, CoLeafShape *out)
{
    const Written *written = context;
    for (size_t i = 0; i < count && i < 3; i++)
        out->ids[i] = prims[i].id;
    out->count = (uint32_t)count;
    out->bytes = (uint32_t)(CO_LEAF_UNIT * count * written->units);
    out->ref = CO_REF_LEAF | (written->units ? 0 : prims[0].id);
    return count <= 3;
}

static size_t emit(const void *context, const uint32_t *ids, size_t count, unsigned char *out)
{
    Written *written = (Written *)(uintptr_t)context;
    for (size_t i = 0; i < count; i++) {
        written->seen[ids[i]]++;
        for (size_t k = 0; k < written->units; k++)
            memcpy(out + CO_LEAF_UNIT * (i * written->units + k), &ids[i], CO_LEAF_UNIT);
    }
    written->leaves++;
    written->largest = count > written->largest ? count : written->largest;
    return CO_LEAF_UNIT * count * written->units;
}

typedef struct Fixture {
    CoBuildPrim prims[MOST];
    Written written;
    CoLeafRule rule;
    CoSubtrees in;
    CoWideNode nodes[BASE_NODE + MOST];
    unsigned char leaves[CO_LEAF_UNIT * (BASE_UNIT + MOST * UNITS)];
} Fixture;

static CoRange prepare(Fixture *f, uint32_t count, PrimKind kind, size_t units)
{
    memset(f, 0, sizeof *f);
    prims_fill(f->prims, count, kind, count);
    f->written.units = units;
    f->rule = (CoLeafRule){.fits = fits, .emit = emit, .context = &f->written, .most = 3};
    CoRange range = {0, count, 0, prims_box(f->prims, count)};
    double area = co_box_area(&range.box);
    f->in = (CoSubtrees){f->prims, &f->rule, area > 0.0 ? 1.0 / area : 0.0};
    return range;
}

// All of a piece, behind some of others.
static void write_piece(Fixture *f, CoPiece *piece)
{
    piece->node_base = BASE_NODE;
    piece->leaf_base = BASE_UNIT * CO_LEAF_UNIT;
    assert_in_range(piece->node_count, 0, MOST);
    co_piece_write_nodes(piece, f->nodes);
    co_piece_write_leaves(piece, &f->rule, f->leaves);
}

// Returns how many leaves are below a reference; those that lie in memory follow each other.
static uint32_t check_ref(const Fixture *f, const CoPiece *piece, uint32_t ref, uint32_t *next_node)
{
    if (ref & CO_REF_LEAF)
        return 1;
    assert_int_equal(ref, (*next_node)++);
    assert_in_range(ref, BASE_NODE, BASE_NODE + piece->node_count - 1);
    uint32_t leaves = 0;
    for (int i = 0; i < CO_NODE_WIDTH; i++)
        if (f->nodes[ref].child[i] != CO_REF_NONE)
            leaves += check_ref(f, piece, f->nodes[ref].child[i], next_node);
    return leaves;
}

// Each prim is in one leaf; nothing is written around them.
static void check_leaves(const Fixture *f, const CoPiece *piece, uint32_t count)
{
    uint32_t found[MOST] = {0}, id;
    size_t units = f->written.units;
    assert_int_equal(piece->leaf_bytes, CO_LEAF_UNIT * count * units);
    for (size_t i = 0; i < sizeof f->leaves; i += sizeof id) {
        memcpy(&id, f->leaves + i, sizeof id);
        bool is_leaf = i >= piece->leaf_base && i < piece->leaf_base + piece->leaf_bytes;
        assert_true(is_leaf ? id < count : id == 0);
        found[id] += is_leaf;
    }
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(f->written.seen[i], units > 0);
        assert_int_equal(found[i], units);
    }
    assert_true(f->written.largest <= 3);
    assert_int_equal(piece->byte_count, units ? sizeof id * count : 0);
    for (size_t n = 0; n < BASE_NODE; n++)
        assert_int_equal(f->nodes[n].child[0], 0);
    assert_int_equal(f->nodes[BASE_NODE + piece->node_count].child[0], 0);
}

static void every_prim_is_in_one_leaf(void **state)
{
    (void)state;
    static Fixture f;
    const uint32_t counts[] = {1, 2, 3, 4, 9, 64, MOST};
    for (int kind = 0; kind < PRIM_KINDS; kind++) {
        for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
            for (size_t u = 0; u < 2 * (UNITS + 1); u++) {
                bool has_node = u % 2;
                CoRange range = prepare(&f, counts[c], (PrimKind)kind, u / 2);
                CoPiece piece;
                uint32_t next = BASE_NODE;
                assert_true(co_subtree_build(&f.in, &range, has_node, &piece));
                assert_int_equal(piece.is_node, has_node || counts[c] > 3);
                assert_true(piece.is_node == (piece.node_count > 0));
                if (!piece.capacity)
                    assert_ptr_equal(piece.bytes, f.prims);
                assert_true(piece.byte_count <= counts[c] * sizeof(CoBuildPrim) || piece.capacity);
                write_piece(&f, &piece);
                check_leaves(&f, &piece, counts[c]);
                uint32_t leaves = check_ref(&f, &piece, piece.root, &next);
                assert_int_equal(next, BASE_NODE + piece.node_count);
                assert_true(f.written.leaves == leaves || u < 2);
                co_piece_clear(&piece);
                assert_null(piece.bytes);
            }
        }
    }
}

// Leaves of three take less as records than their prims did, single ones more.
static void records_are_where_prims_were(void **state)
{
    (void)state;
    static Fixture f;
    for (uint32_t most = 1; most <= 3; most += 2) {
        CoRange range = prepare(&f, MOST / 3 * 3, PRIMS_IN_ONE_PLACE, 1);
        CoPiece piece;
        f.rule.most = most;
        assert_true(co_subtree_build(&f.in, &range, true, &piece));
        assert_true((piece.capacity > 0) == (most == 1));
        co_piece_clear(&piece);
    }
}

// Returns how many leaves are below a record, and lists them from the left.
static uint32_t leaves_below(const void *records, uint32_t from, uint32_t *out)
{
    const CoBinaryNode *node = co_binary_at(records, from);
    if (co_binary_is_leaf(node)) {
        *out = from;
        return 1;
    }
    assert_true(node->left < from);
    uint32_t count = leaves_below(records, node->left, out);
    return count + leaves_below(records, from - CO_BINARY_UNITS, out + count);
}

// Children are subtrees that hold, together, what the node holds. Returns how many wide nodes.
static uint32_t check_plan(const void *records, uint32_t from)
{
    uint32_t want[MOST], got[MOST], children[CO_NODE_WIDTH], count = 0, wide = 1;
    int n = co_plan_children(records, from, children);
    assert_in_range(n, 2, CO_NODE_WIDTH);
    for (int k = 0; k < n; k++) {
        assert_true(children[k] < from && (k == 0 || children[k] > children[k - 1]));
        count += leaves_below(records, children[k], got + count);
        if (!co_binary_is_leaf(co_binary_at(records, children[k])))
            wide += check_plan(records, children[k]);
    }
    assert_int_equal(leaves_below(records, from, want), count);
    assert_memory_equal(want, got, count * sizeof *want);
    return wide;
}

static void plans_cover_the_tree(void **state)
{
    (void)state;
    static Fixture f;
    static uint32_t all[MOST];
    CoRange range = prepare(&f, MOST, PRIMS_ANYWHERE, 1);
    CoPiece piece;
    assert_true(co_subtree_build(&f.in, &range, false, &piece));
    assert_int_equal(check_plan(piece.bytes, piece.root), piece.node_count);
    // 8 wide: far fewer nodes than inner nodes of the binary tree.
    assert_true(piece.node_count * 4 < 2 * leaves_below(piece.bytes, piece.root, all));
    co_piece_clear(&piece);
}

// Up to 8 are leaves of one node, or of that above it where there is room; 9 are not.
static void few_alike_are_one_node(void **state)
{
    (void)state;
    static Fixture f;
    for (uint32_t count = 2; count <= 80; count++) {
        CoRange range = prepare(&f, count % 40 + 2, PRIMS_ANYWHERE, count / 40);
        CoPiece piece;
        uint32_t next = BASE_NODE;
        f.rule.most = 1;
        f.rule.flat = CO_NODE_WIDTH;
        assert_true(co_subtree_build(&f.in, &range, false, &piece));
        assert_true((piece.node_count == 1) == (range.count <= CO_NODE_WIDTH));
        write_piece(&f, &piece);
        check_leaves(&f, &piece, range.count);
        assert_int_equal(check_ref(&f, &piece, piece.root, &next), range.count);
        assert_int_equal(next, BASE_NODE + piece.node_count);
        co_piece_clear(&piece);
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
        CoBinaryNode node = {.left = 5};
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

// Records that lie apart grow a few times.
static void no_memory_is_said(void **state)
{
    (void)state;
    static Fixture f;
    size_t live = co_memory_live(CO_MEMORY_ACCEL);
    bool is_built = false;
    uint64_t n = 0;
    while (!is_built && n < 100) {
        CoRange range = prepare(&f, MOST, PRIMS_ANYWHERE, 1);
        CoPiece piece;
        f.rule.most = 1;
        co_memory_fail_after(++n);
        is_built = co_subtree_build(&f.in, &range, true, &piece);
        if (is_built)
            write_piece(&f, &piece);
        co_memory_fail_after(0);
        if (is_built)
            check_leaves(&f, &piece, MOST);
        co_piece_clear(&piece);
        assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), live);
    }
    assert_true(is_built && n > 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_prim_is_in_one_leaf),
        cmocka_unit_test(records_are_where_prims_were),
        cmocka_unit_test(plans_cover_the_tree),
        cmocka_unit_test(few_alike_are_one_node),
        cmocka_unit_test(a_leaf_costs_the_same_in_any_place),
        cmocka_unit_test(more_places_are_never_dearer),
        cmocka_unit_test(no_memory_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
