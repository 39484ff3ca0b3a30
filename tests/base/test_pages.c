// Large blocks: aligned, zeroed, kept over growing and shrinking, counted like small ones.

#include "base/memory.h"
#include "base/pages.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

enum {
    MEGABYTE = 1 << 20
};

static void fill(unsigned char *bytes, size_t begin, size_t end)
{
    for (size_t i = begin; i < end; i += 1000)
        bytes[i] = (unsigned char)(i / 1000 * 7);
}

static void check(const unsigned char *bytes, size_t end)
{
    for (size_t i = 0; i < end; i += 1000)
        assert_int_equal(bytes[i], (unsigned char)(i / 1000 * 7));
}

static void blocks_are_aligned_and_zero(void **state)
{
    (void)state;
    const size_t sizes[] = {CO_PAGES_ALIGNMENT, CO_PAGES_ALIGNMENT + 1, 9 * MEGABYTE + 12345};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        if (!co_pages_suit(sizes[i]))
            skip();
        unsigned char *block = co_pages_alloc(sizes[i]);
        assert_non_null(block);
        assert_int_equal((uintptr_t)block % CO_PAGES_ALIGNMENT, 0);
        assert_int_equal(block[0] | block[sizes[i] / 2] | block[sizes[i] - 1], 0);
        memset(block, 1, sizes[i]);
        co_pages_free(block, sizes[i]);
    }
    assert_false(co_pages_suit(0));
    assert_false(co_pages_suit(4096));
}

static void absurd_sizes_are_refused(void **state)
{
    (void)state;
    if (!co_pages_suit(SIZE_MAX))
        skip();
    assert_null(co_pages_alloc(SIZE_MAX));
    assert_null(co_pages_alloc(SIZE_MAX / 4));
    unsigned char *block = co_pages_alloc(4 * MEGABYTE);
    fill(block, 0, 4 * MEGABYTE);
    assert_null(co_pages_resize(block, 4 * MEGABYTE, SIZE_MAX));
    check(block, 4 * MEGABYTE);
    co_pages_free(block, 4 * MEGABYTE);
}

// Small to large, large to larger, back to large and to small again.
static void contents_survive_resizing(void **state)
{
    (void)state;
    const size_t sizes[] = {100000,       3 * MEGABYTE, 3 * MEGABYTE + 1, 20 * MEGABYTE,
                            5 * MEGABYTE, MEGABYTE,     3 * MEGABYTE};
    const size_t before = co_memory_live(CO_MEMORY_ACCEL);
    size_t size = 5000;
    unsigned char *block = co_alloc(CO_MEMORY_ACCEL, size);
    fill(block, 0, size);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        block = co_realloc(CO_MEMORY_ACCEL, block, size, sizes[i]);
        assert_non_null(block);
        assert_int_equal((uintptr_t)block % 64, 0);
        check(block, size < sizes[i] ? size : sizes[i]);
        size = sizes[i];
        fill(block, 0, size);
        assert_int_equal(co_memory_live(CO_MEMORY_ACCEL) - before, size);
    }
    co_free(CO_MEMORY_ACCEL, block, size);
    assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
}

static void failures_leave_the_block(void **state)
{
    (void)state;
    const size_t before = co_memory_live(CO_MEMORY_ACCEL), size = 4 * MEGABYTE;
    unsigned char *block = co_alloc(CO_MEMORY_ACCEL, size);
    fill(block, 0, size);
    co_memory_fail_after(1);
    assert_null(co_realloc(CO_MEMORY_ACCEL, block, size, 2 * size));
    assert_null(co_realloc(CO_MEMORY_ACCEL, block, size, size / 2));
    co_memory_fail_after(0);
    check(block, size);
    assert_int_equal(co_memory_live(CO_MEMORY_ACCEL) - before, size);
    co_free(CO_MEMORY_ACCEL, block, size);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_aligned_and_zero),
        cmocka_unit_test(absurd_sizes_are_refused),
        cmocka_unit_test(contents_survive_resizing),
        cmocka_unit_test(failures_leave_the_block),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
