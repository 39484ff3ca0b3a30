// The hit sort: order, stability, keys that fit beside the index and keys that do not.

#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "sort/hit_sort.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define HITS 70001u

static uint32_t mesh[HITS], tri[HITS], order[HITS], first_order[HITS];

// Every third hit is missing from the list, as misses are.
static size_t fill(uint32_t meshes, uint32_t tris, uint32_t step)
{
    size_t count = 0;
    for (uint32_t i = 0; i < HITS; i++) {
        mesh[i] = co_hash32(i) % meshes * step;
        tri[i] = co_hash32(i + 77) % tris * step;
        if (i % 3)
            order[count++] = i;
    }
    return count;
}

static void check_sorted(size_t count)
{
    static uint8_t seen[HITS];
    memset(seen, 0, sizeof seen);
    for (size_t k = 0; k < count; k++) {
        uint32_t b = order[k];
        assert_true(b < HITS && b % 3 && !seen[b]);
        seen[b] = 1;
        if (k == 0)
            continue;
        uint32_t a = order[k - 1];
        assert_true(mesh[a] <= mesh[b]);
        if (mesh[a] == mesh[b])
            assert_true(tri[a] < tri[b] || (tri[a] == tri[b] && a < b));
    }
}

static void hits_come_in_mesh_and_face_order(void **state)
{
    (void)state;
    CoSortScratch scratch = {NULL, 0};
    const struct {
        uint32_t meshes, tris, step;
    } cases[] = {{1, 1, 1},     {1, 1000, 1},        {5000, 3, 1},
                 {40, 4000, 1}, {3, 3, 0x55555555u}, {70000, 60000, 61356}};
    for (int c = 0; c < 6; c++)
        for (uint32_t threads = 1; threads <= 4; threads++) {
            size_t count = fill(cases[c].meshes, cases[c].tris, cases[c].step);
            co_worker_count_set(threads);
            assert_true(co_sort_hits(mesh, tri, order, count, &scratch, NULL));
            check_sorted(count);
            if (threads == 1)
                memcpy(first_order, order, count * sizeof *order);
            assert_memory_equal(first_order, order, count * sizeof *order);
        }
    co_worker_count_set(0);
    co_sort_scratch_clear(&scratch);
}

static void short_lists_and_failures_leave_the_order(void **state)
{
    (void)state;
    CoSortScratch scratch = {NULL, 0};
    CohortError err = {0};
    fill(10, 10, 1);
    assert_true(co_sort_hits(mesh, tri, order, 0, &scratch, &err));
    assert_true(co_sort_hits(mesh, tri, order, 1, &scratch, &err));
    assert_int_equal(order[0], 1);
    co_memory_fail_after(1);
    assert_false(co_sort_hits(mesh, tri, order, 100, &scratch, &err));
    co_memory_fail_after(0);
    assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
    for (uint32_t i = 1; i < 100; i++)
        assert_true(order[i] > order[i - 1]);
    assert_int_equal(co_memory_live(CO_MEMORY_RAYS), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_come_in_mesh_and_face_order),
        cmocka_unit_test(short_lists_and_failures_leave_the_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
