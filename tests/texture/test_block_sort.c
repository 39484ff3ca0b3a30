// The sort by blocks: in order, complete, for any thread count.

#include "texture/block_sort.h"

#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#define MOST 200000

static void check(size_t count, uint64_t mask)
{
    static CoBlockEntry entries[MOST], spare[MOST];
    static CoRequest request;
    for (size_t i = 0; i < count; i++)
        entries[i] = (CoBlockEntry){co_hash64(i) & mask, &request};
    uint64_t sum = 0, sorted_sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += entries[i].key;
    CoBlockEntry *sorted = co_block_sort(entries, spare, count);
    assert_non_null(sorted);
    for (size_t i = 0; i < count; i++) {
        sorted_sum += sorted[i].key;
        assert_true(i == 0 || sorted[i - 1].key <= sorted[i].key);
        assert_ptr_equal(sorted[i].request, &request);
    }
    assert_true(sum == sorted_sum);
}

static void keys_come_out_in_order(void **state)
{
    (void)state;
    static const size_t counts[] = {0, 1, 2, 100, 65535, 65536, 65537, MOST};
    for (uint32_t threads = 1; threads <= 3; threads++) {
        co_worker_count_set(threads);
        for (int i = 0; i < 8; i++) {
            check(counts[i], UINT64_MAX);
            check(counts[i], 0xff00000fff);
            check(counts[i], 7);
            check(counts[i], 0);
        }
    }
    co_worker_count_set(0);
}

static void failure_to_allocate_is_told(void **state)
{
    (void)state;
    CoBlockEntry entries[4] = {{3, NULL}, {2, NULL}, {1, NULL}, {0, NULL}}, spare[4];
    co_memory_fail_after(1);
    assert_null(co_block_sort(entries, spare, 4));
    co_memory_fail_after(0);
    assert_non_null(co_block_sort(entries, spare, 4));
    assert_int_equal(co_memory_live(CO_MEMORY_TEXTURE), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_come_out_in_order),
        cmocka_unit_test(failure_to_allocate_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
