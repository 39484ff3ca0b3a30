// Arenas: alignment, mark and rewind, limits, accounting, and failure on purpose.

#include "base/arena.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void blocks_are_aligned_zeroed_and_apart(void **state)
{
    (void)state;
    CoArena arena = {.tag = CO_MEMORY_BASE};
    unsigned char *previous = NULL;
    for (size_t size = 0; size < 300; size++) {
        unsigned char *block = co_arena_alloc(&arena, size);
        assert_non_null(block);
        assert_int_equal((uintptr_t)block % 16, 0);
        for (size_t i = 0; i < size; i++) {
            assert_int_equal(block[i], 0);
            block[i] = 0xff;
        }
        assert_true(size <= 1 || block != previous);
        previous = block;
    }
    co_arena_clear(&arena);
    assert_int_equal(co_memory_live(CO_MEMORY_BASE), 0);
}

static void rewind_gives_chunks_back(void **state)
{
    (void)state;
    CoArena arena = {.tag = CO_MEMORY_BASE};
    assert_non_null(co_arena_alloc(&arena, 100));
    size_t live = co_memory_live(CO_MEMORY_BASE);
    CoArenaMark mark = co_arena_mark(&arena);
    char *first = co_arena_alloc(&arena, 16);
    for (int i = 0; i < 10; i++)
        assert_non_null(co_arena_alloc(&arena, 1 << 20));
    co_arena_rewind(&arena, mark);
    assert_int_equal(co_memory_live(CO_MEMORY_BASE), live);
    assert_ptr_equal(co_arena_alloc(&arena, 16), first);
    co_arena_clear(&arena);
}

static void what_is_adopted_lives_on(void **state)
{
    (void)state;
    for (int filled = 0; filled < 4; filled++) {
        CoArena arena = {.tag = CO_MEMORY_BASE}, from = {.tag = CO_MEMORY_BASE};
        int *own = NULL, *other = NULL;
        for (int i = 0; i < 3 && (filled & 1); i++)
            *(own = co_arena_alloc(&arena, 100 << 10)) = 1;
        for (int i = 0; i < 3 && (filled & 2); i++)
            *(other = co_arena_alloc(&from, 100 << 10)) = 2;
        size_t total = arena.total + from.total;
        co_arena_adopt(&arena, &from);
        assert_null(from.chunk);
        assert_int_equal(from.total, 0);
        assert_int_equal(arena.total, total);
        assert_non_null(co_arena_alloc(&from, 8));
        co_arena_clear(&from);
        assert_true((!own || *own == 1) && (!other || *other == 2));
        co_arena_clear(&arena);
        assert_int_equal(co_memory_live(CO_MEMORY_BASE), 0);
    }
}

static void limits_and_impossible_sizes_fail(void **state)
{
    (void)state;
    CoArena arena = {.tag = CO_MEMORY_BASE, .limit = 1 << 20};
    assert_null(co_arena_alloc(&arena, 2 << 20));
    assert_null(co_arena_alloc(&arena, SIZE_MAX));
    assert_null(co_arena_array(&arena, SIZE_MAX / 2, 3));
    assert_non_null(co_arena_string(&arena, "abc", 3));
    co_arena_clear(&arena);
}

static void allocation_failure_is_reported(void **state)
{
    (void)state;
    CoArena arena = {.tag = CO_MEMORY_BASE};
    co_memory_fail_after(1);
    assert_null(co_arena_alloc(&arena, 8));
    co_memory_fail_after(0);
    assert_non_null(co_arena_alloc(&arena, 8));
    co_arena_clear(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_aligned_zeroed_and_apart),
        cmocka_unit_test(rewind_gives_chunks_back),
        cmocka_unit_test(what_is_adopted_lives_on),
        cmocka_unit_test(limits_and_impossible_sizes_fail),
        cmocka_unit_test(allocation_failure_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
