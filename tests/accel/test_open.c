// Openings: ranges that cover everything once, a binary tree above them, for any number of threads.

#include "accel/open.h"
#include "base/parallel.h"
#include "build_prims.h"

// Walks the tree in order: ranges must come one after the other. Returns how many prims there are.
static uint32_t check_node(const CoOpening *o, uint32_t at, uint32_t *range)
{
    const CoBinaryNode *node = co_binary_at(o->binary, at);
    if (co_binary_is_leaf(node)) {
        assert_int_equal(node->leaf, *range);
        return o->ranges[(*range)++].count;
    }
    assert_true(node->left < at - CO_BINARY_UNITS);
    uint32_t count = check_node(o, node->left, range);
    return count + check_node(o, at - CO_BINARY_UNITS, range);
}

static void check_opening(const CoOpening *o, const CoBuildPrim *prims, size_t count)
{
    uint32_t range = 0, first = 0;
    assert_int_equal(check_node(o, co_opening_root(o), &range), count);
    assert_int_equal(range, o->range_count);
    assert_int_equal(o->binary_count, 2 * o->range_count - 1);
    for (size_t i = 0; i < o->range_count; i++) {
        const CoRange *at = &o->ranges[i];
        assert_int_equal(at->first, first);
        assert_in_range(at->count, 1, o->largest);
        CoBox box = prims_box(prims + at->first, at->count);
        assert_same_box(&box, &at->box);
        first += at->count;
    }
    CoBox all = prims_box(prims, count);
    assert_same_box(&all, &o->box);
    assert_all_there(prims, count);
}

static void ranges_cover_everything_once(void **state)
{
    (void)state;
    const size_t counts[] = {1, 2, 4096, 4097, 20000, 150000};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        for (int kind = 0; kind < PRIM_KINDS; kind++) {
            CoBuildPrim *mine = malloc(counts[c] * sizeof *mine);
            CoPrimArray prims = {mine, counts[c], counts[c]};
            prims_fill(mine, counts[c], (PrimKind)kind, c);
            CoOpening o;
            assert_true(co_opening_make(&prims, 1, 2, &o));
            check_opening(&o, mine, counts[c]);
            assert_true(counts[c] > 4096 ? o.range_count > 1 : o.range_count == 1);
            assert_true(o.scale >= 0.0 && isfinite(o.scale));
            co_opening_clear(&o);
            assert_null(o.ranges);
            free(mine);
        }
    }
}

static void check_threads(size_t count)
{
    CoBuildPrim *mine[2] = {malloc(count * sizeof **mine), malloc(count * sizeof **mine)};
    CoOpening o[2];
    for (uint32_t i = 0; i < 2; i++) {
        CoPrimArray prims = {mine[i], count, count};
        co_worker_count_set(1 + 4 * i);
        prims_fill(mine[i], count, PRIMS_ANYWHERE, 5);
        assert_true(co_opening_make(&prims, 1, co_worker_count(), &o[i]));
    }
    co_worker_count_set(0);
    assert_memory_equal(mine[0], mine[1], count * sizeof **mine);
    assert_int_equal(o[0].range_count, o[1].range_count);
    assert_int_equal(o[0].binary_count, o[1].binary_count);
    for (size_t i = 0; i < o[0].binary_count; i++) {
        const CoBinaryNode *a = &o[0].binary[i], *b = &o[1].binary[i];
        assert_true(a->left == b->left && a->plan == b->plan);
    }
    for (int i = 0; i < 2; i++) {
        co_opening_clear(&o[i]);
        free(mine[i]);
    }
}

// Few things are shared out otherwise than many.
static void threads_do_not_show(void **state)
{
    (void)state;
    const size_t counts[] = {5000, 13000, 32000, 33000, 100000};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        check_threads(counts[i]);
}

// Opens so many prims for two threads, with less memory and then a little more, until it is enough.
// Returns how many allocations it takes.
static uint64_t open_without_memory(size_t count)
{
    CoBuildPrim *mine = malloc(count * sizeof *mine);
    CoPrimArray prims = {mine, count, count};
    size_t live = co_memory_live(CO_MEMORY_ACCEL);
    uint64_t n = 0;
    bool is_made = false;
    co_worker_count_set(1);
    while (!is_made && n < 1000) {
        CoOpening o;
        prims_fill(mine, count, PRIMS_ANYWHERE, 5);
        co_memory_fail_after(++n);
        is_made = co_opening_make(&prims, 1, 2, &o);
        co_memory_fail_after(0);
        co_opening_clear(&o);
        assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), live);
    }
    co_worker_count_set(0);
    free(mine);
    return n - 1;
}

static void no_memory_leaves_nothing_behind(void **state)
{
    (void)state;
    assert_in_range(open_without_memory(30000), 10, 998);
    // The halves of so few are split at once, without the five arrays by which blocks of large
    // ranges are.
    assert_in_range(open_without_memory(12000), 10, 40);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ranges_cover_everything_once),
        cmocka_unit_test(threads_do_not_show),
        cmocka_unit_test(no_memory_leaves_nothing_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
