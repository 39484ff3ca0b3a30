// The heap: what is counted, what sizes are refused, growing, and failure on purpose.

#include "base/memory.h"

#include "base/parallel.h"

#include <string.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void blocks_are_counted_by_tag(void **state)
{
    (void)state;
    size_t light = co_memory_live(CO_MEMORY_LIGHT), film = co_memory_live(CO_MEMORY_FILM);
    unsigned char *block = co_alloc_zero(CO_MEMORY_LIGHT, 1000);
    assert_int_equal((uintptr_t)block % 64, 0);
    assert_int_equal(block[0] | block[999], 0);
    assert_int_equal(co_memory_live(CO_MEMORY_LIGHT), light + 1000);
    assert_int_equal(co_memory_live(CO_MEMORY_FILM), film);
    co_free(CO_MEMORY_LIGHT, block, 1000);
    assert_int_equal(co_memory_live(CO_MEMORY_LIGHT), light);
    assert_true(co_memory_peak(CO_MEMORY_LIGHT) >= light + 1000);
    co_free(CO_MEMORY_LIGHT, NULL, 1000);
    assert_int_equal(co_memory_live(CO_MEMORY_LIGHT), light);
}

static void sizes_that_cannot_be_are_refused(void **state)
{
    (void)state;
    const size_t sizes[] = {0, SIZE_MAX, SIZE_MAX / 2 + 1};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        assert_null(co_alloc(CO_MEMORY_BASE, sizes[i]));
        assert_null(co_alloc_zero(CO_MEMORY_BASE, sizes[i]));
    }
    size_t out = 7;
    assert_false(co_size_mul(SIZE_MAX / 2, 3, &out));
    assert_true(co_size_mul(SIZE_MAX, 0, &out));
    assert_int_equal(out, 0);
}

static void moved_blocks_keep_what_fits(void **state)
{
    (void)state;
    size_t live = co_memory_live(CO_MEMORY_BASE);
    char *text = co_realloc(CO_MEMORY_BASE, NULL, 0, 8);
    assert_non_null(text);
    memcpy(text, "1234567", 8);
    text = co_realloc(CO_MEMORY_BASE, text, 8, 100000);
    assert_string_equal(text, "1234567");
    assert_null(co_realloc(CO_MEMORY_BASE, text, 100000, SIZE_MAX));
    assert_string_equal(text, "1234567"); // what could not be moved is where it was
    text = co_realloc(CO_MEMORY_BASE, text, 100000, 4);
    assert_memory_equal(text, "1234", 4);
    assert_int_equal(co_memory_live(CO_MEMORY_BASE), live + 4);
    co_free(CO_MEMORY_BASE, text, 4);
    assert_int_equal(co_memory_live(CO_MEMORY_BASE), live);
}

// Within the heap, within large pages and from those to the heap: aligned, nothing lost, and none
// of the latter twice.
static void blocks_that_shrink_keep_what_is_left(void **state)
{
    (void)state;
    const size_t sizes[] = {9000000, 3000000, 1500000, 300, 100, 100, 1};
    size_t live = co_memory_live(CO_MEMORY_ACCEL), size = sizes[0];
    unsigned char *block = co_alloc(CO_MEMORY_ACCEL, size);
    assert_non_null(block);
    for (size_t i = 0; i < size; i++)
        block[i] = (unsigned char)(i % 251);
    for (size_t k = 1; k < sizeof sizes / sizeof *sizes; k++) {
        co_memory_fail_after(1);
        assert_null(co_realloc(CO_MEMORY_ACCEL, block, size, sizes[k]));
        co_memory_fail_after(0);
        assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), live + size);
        block = co_realloc(CO_MEMORY_ACCEL, block, size, sizes[k]);
        size = sizes[k];
        assert_int_equal((uintptr_t)block % 64, 0);
        assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), live + size);
        for (size_t i = 0; i < size; i++)
            assert_true(block[i] == i % 251);
    }
    co_free(CO_MEMORY_ACCEL, block, size);
    assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), live);
    assert_true(co_memory_peak(CO_MEMORY_ACCEL) < live + 10000000);
}

static void arrays_grow_one_at_a_time(void **state)
{
    (void)state;
    uint32_t *numbers = NULL;
    size_t capacity = 0;
    for (uint32_t i = 0; i < 1000; i++) {
        assert_true(co_grow(CO_MEMORY_BASE, (void **)&numbers, i, &capacity, sizeof *numbers));
        assert_true(capacity > i && capacity < 2 * i + 17);
        numbers[i] = i;
    }
    for (uint32_t i = 0; i < 1000; i++)
        assert_int_equal(numbers[i], i);
    uint32_t *before = numbers;
    size_t same = capacity;
    co_memory_fail_after(1);
    assert_true(co_grow(CO_MEMORY_BASE, (void **)&numbers, 5, &capacity, sizeof *numbers));
    assert_false(co_grow(CO_MEMORY_BASE, (void **)&numbers, same, &capacity, sizeof *numbers));
    co_memory_fail_after(0);
    assert_ptr_equal(numbers, before);
    assert_int_equal(capacity, same);
    co_free(CO_MEMORY_BASE, numbers, capacity * sizeof *numbers);

    void *nothing = NULL;
    size_t none = 0;
    assert_false(co_grow(CO_MEMORY_BASE, &nothing, 0, &none, SIZE_MAX / 8));
    assert_null(nothing);
    assert_int_equal(none, 0);
}

static void the_nth_allocation_fails_and_all_after_it(void **state)
{
    (void)state;
    co_memory_fail_after(2);
    void *first = co_alloc(CO_MEMORY_BASE, 1);
    assert_non_null(first);
    assert_null(co_alloc(CO_MEMORY_BASE, 1));
    assert_null(co_realloc(CO_MEMORY_BASE, first, 1, 2));
    co_memory_fail_after(0);
    void *next = co_alloc(CO_MEMORY_BASE, 1);
    assert_non_null(next);
    co_free(CO_MEMORY_BASE, next, 1);
    co_free(CO_MEMORY_BASE, first, 1);
}

static void the_nth_allocation_fails_alone(void **state)
{
    (void)state;
    co_memory_fail_once(2);
    void *first = co_alloc(CO_MEMORY_BASE, 1);
    assert_non_null(first);
    assert_null(co_alloc(CO_MEMORY_BASE, 1));
    void *third = co_alloc(CO_MEMORY_BASE, 1);
    assert_non_null(third);
    co_free(CO_MEMORY_BASE, third, 1);
    co_free(CO_MEMORY_BASE, first, 1);
}

static void take_one_each(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    void **blocks = context;
    for (size_t i = begin; i < end; i++)
        blocks[i] = co_alloc(CO_MEMORY_BASE, 1);
}

// Threads that ask at once for what is left share it, and none finds more once one has found none.
static void no_thread_slips_past_the_nth(void **state)
{
    (void)state;
    enum {
        ROUNDS = 200,
        COUNT = 4000, // so many that all threads are awake when it ends
        LEFT = 3000
    };
    static void *blocks[COUNT];
    co_worker_count_set(4);
    for (int round = 0; round < ROUNDS; round++) {
        co_memory_fail_after(LEFT + 1);
        co_parallel_for(COUNT, 16, take_one_each, blocks);
        assert_null(co_alloc(CO_MEMORY_BASE, 1));
        co_memory_fail_after(0);
        int given = 0;
        for (int i = 0; i < COUNT; i++) {
            given += blocks[i] != NULL;
            co_free(CO_MEMORY_BASE, blocks[i], 1);
        }
        assert_int_equal(given, LEFT);
    }
    co_worker_count_set(0);
}

static void what_is_resident_is_told(void **state)
{
    (void)state;
    assert_true(co_memory_resident() > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_counted_by_tag),
        cmocka_unit_test(sizes_that_cannot_be_are_refused),
        cmocka_unit_test(moved_blocks_keep_what_fits),
        cmocka_unit_test(blocks_that_shrink_keep_what_is_left),
        cmocka_unit_test(arrays_grow_one_at_a_time),
        cmocka_unit_test(the_nth_allocation_fails_and_all_after_it),
        cmocka_unit_test(the_nth_allocation_fails_alone),
        cmocka_unit_test(no_thread_slips_past_the_nth),
        cmocka_unit_test(what_is_resident_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
