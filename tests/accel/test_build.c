// The tree builder: every thing in one leaf, boxes inside boxes, the same tree for any thread
// count.

#include "accel/build.h"
#include "accel_scene.h"
#include "base/memory.h"
#include "base/parallel.h"

// Leaves of up to four ids, their count first.
static bool four_fit(const void *context, const CoBuildPrim *prims, size_t count, CoLeafShape *out)
{
    (void)context;
    *out = (CoLeafShape){.count = (uint32_t)count, .bytes = 32, .ref = CO_REF_LEAF};
    for (size_t i = 0; i < count && i < 4; i++)
        out->ids[i] = prims[i].id;
    return count <= 4;
}

static size_t list_leaf(const void *context, const uint32_t *ids, size_t count, unsigned char *out)
{
    uint32_t words[8] = {(uint32_t)count};
    (void)context;
    memcpy(words + 1, ids, count * sizeof *ids);
    memcpy(out, words, sizeof words);
    return sizeof words;
}

static const CoLeafRule four_rule = {.fits = four_fit, .emit = list_leaf, .most = 4};

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

static CoPrimArray array_of(const CoBuildPrim *prims, size_t count)
{
    CoPrimArray array = {.count = count, .capacity = count};
    array.prims = co_alloc(CO_MEMORY_ACCEL, count * sizeof *prims);
    assert_true(array.prims || count == 0);
    if (count)
        memcpy(array.prims, prims, count * sizeof *prims);
    return array;
}

typedef struct Check {
    const CoTreeParts *parts;
    const CoBuildPrim *by_id;
    uint8_t *seen; // how often, by id
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
    const CoWideNode *node = &check->parts->tree.nodes[index];
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
            uint32_t words[8];
            memcpy(words, check->parts->leaves + CO_LEAF_UNIT * (size_t)(ref & CO_REF_LEAF_PLACE),
                   32);
            assert_in_range(words[0], 1, 4);
            for (uint32_t j = 1; j <= words[0]; j++) {
                const CoBuildPrim *prim = &check->by_id[words[j]];
                assert_true(is_inside(prim->lo, prim->hi, &child));
                check->seen[words[j]]++;
            }
        } else {
            depth = check_node(check, ref, &child);
        }
        deepest = depth > deepest ? depth : deepest;
    }
    return deepest + 1;
}

static void build_and_check(const CoBuildPrim *prims, uint32_t count)
{
    CoPrimArray array = array_of(prims, count);
    CoTreeParts parts;
    assert_true(co_tree_build(&array, &four_rule, &parts, NULL));
    assert_null(array.prims);
    Check check = {&parts, prims, calloc(count + 1u, 1)};
    if (count)
        assert_true(check_node(&check, 0, &parts.tree.box) <= CO_TREE_DEPTH_MAX);
    else
        assert_int_equal(parts.tree.node_count, 0);
    for (size_t i = 0; i < count; i++)
        assert_int_equal(check.seen[i], 1);
    co_tree_parts_clear(&parts);
    free(check.seen);
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

// So many that threads are not spared on a busy machine.
static void threads_do_not_show(void **state)
{
    (void)state;
    enum {
        COUNT = 270000
    };
    CoTreeParts parts[2];
    for (uint32_t k = 0; k < 2; k++) {
        co_worker_count_set(k ? 3 : 1);
        CoBuildPrim *prims = random_prims(COUNT, 0.02f, 6);
        CoPrimArray array = array_of(prims, COUNT);
        assert_true(co_tree_build(&array, &four_rule, &parts[k], NULL));
        free(prims);
    }
    co_worker_count_set(0);
    assert_int_equal(parts[0].tree.node_count, parts[1].tree.node_count);
    assert_memory_equal(parts[0].tree.nodes, parts[1].tree.nodes,
                        parts[0].tree.node_count * sizeof *parts[0].tree.nodes);
    assert_int_equal(parts[0].leaf_bytes, parts[1].leaf_bytes);
    assert_memory_equal(parts[0].leaves, parts[1].leaves, parts[0].leaf_bytes);
    for (int k = 0; k < 2; k++)
        co_tree_parts_clear(&parts[k]);
}

typedef struct MeshKind {
    bool is_soup;
    float stretch;
    bool is_shuffled;
} MeshKind;

// Rows of a height field, or triangles that share nothing.
static TestMesh mesh_of(const MeshKind *kind, uint32_t side)
{
    Random random = {side};
    uint32_t tris = 2 * side * side;
    TestMesh m = mesh_alloc(kind->is_soup ? 3 * tris : (side + 1) * (side + 1), tris);
    float size = 1.0f / cbrtf((float)tris);
    for (uint32_t i = 0; i < m.mesh.point_count; i++) {
        float *p = m.points + 3 * (size_t)i;
        CoVec3 at = {(float)(i % (side + 1)) / (float)side, (float)(i / (side + 1)) / (float)side,
                     0.0f};
        if (kind->is_soup)
            at = i % 3 ? co_vec3(p[-3], p[-2], p[-1]) : random_vec3(&random, -1.0f, 1.0f);
        CoVec3 by = random_vec3(&random, 0.0f, kind->is_soup ? size : 0.2f / (float)side);
        by.x *= kind->stretch;
        co_vec3_store(p, co_add(at, by));
    }
    for (uint32_t t = 0; t < tris; t++) {
        uint32_t quad = t / 2, at = quad / side * (side + 1) + quad % side;
        const uint32_t corners[2][3] = {{at, at + 1, at + side + 2},
                                        {at, at + side + 2, at + side + 1}};
        for (uint32_t c = 0; c < 3; c++)
            m.indices[3 * (size_t)t + c] = kind->is_soup ? 3 * t + c : corners[t % 2][c];
    }
    for (uint32_t t = tris - 1; kind->is_shuffled && t > 0; t--) {
        uint32_t other = (uint32_t)random_float(&random, 0.0f, (float)t), moved[3];
        memcpy(moved, m.indices + 3 * (size_t)t, sizeof moved);
        memcpy(m.indices + 3 * (size_t)t, m.indices + 3 * (size_t)other, sizeof moved);
        memcpy(m.indices + 3 * (size_t)other, moved, sizeof moved);
    }
    return m;
}

// A tree takes the place of its prims, leaves are written once all else is gone: what there is at
// most is little more than the boxes of all triangles, or than the result. At every size, whatever
// the triangles are like. Run before what needs more, and from small ones to large ones.
static void peak_is_near_the_result(void **state)
{
    (void)state;
    const MeshKind kinds[] = {
        {false, 1.0f, false}, {false, 1.0f, true}, {true, 1.0f, false}, {true, 30.0f, false}};
    const uint32_t sides[] = {23, 40, 71, 142, 260};
    co_worker_count_set(2);
    for (size_t k = 0; k < 4 * sizeof sides / sizeof *sides; k++) {
        TestMesh m = mesh_of(&kinds[k % 4], sides[k / 4]);
        size_t before = co_memory_live(CO_MEMORY_ACCEL);
        CoBvh *bvh = co_bvh_create(&m.mesh, NULL);
        size_t result = co_memory_live(CO_MEMORY_ACCEL) - before;
        size_t peak = co_memory_peak(CO_MEMORY_ACCEL) - before;
        assert_int_equal(result, co_bvh_bytes(bvh));
        assert_true((double)peak <= (k % 4 < 2 ? 1.6 : 1.2) * (double)result);
        co_bvh_destroy(bvh);
        mesh_free(&m);
    }
    co_worker_count_set(0);
}

static void failing_allocations_are_reported(void **state)
{
    (void)state;
    enum {
        COUNT = 20000
    };
    CoBuildPrim *prims = random_prims(COUNT, 0.02f, 8);
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    bool is_built = false;
    uint64_t n;
    for (n = 1; n < 200 && !is_built; n++) {
        CohortError err = {0};
        CoPrimArray array = array_of(prims, COUNT);
        CoTreeParts parts;
        co_memory_fail_after(n);
        is_built = co_tree_build(&array, &four_rule, &parts, &err);
        co_memory_fail_after(0);
        assert_true(is_built || err.code == COHORT_ERROR_OUT_OF_MEMORY);
        co_tree_parts_clear(&parts);
        assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
    }
    assert_true(is_built && n > 10);
    free(prims);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(peak_is_near_the_result),
        cmocka_unit_test(trees_hold_everything_once),
        cmocka_unit_test(odd_distributions_end),
        cmocka_unit_test(threads_do_not_show),
        cmocka_unit_test(failing_allocations_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
