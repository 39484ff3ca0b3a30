// Operations that run out of memory: done again and again, the first of their allocations refused
// and all that come after it, then the second and all after it, and so on until none is; then each
// alone. What fails says so, nothing stays behind, and what is done next is done.
//
//     TestFaults faults = {0};
//     while (test_faults_next(&faults)) {
//         CohortError err = {0};
//         test_faults_begin(&faults);
//         bool ok = ...;
//         test_faults_end(&faults, ok, &err);
//         ... // and all is undone
//     }
//     assert_true(faults.count > ...);

#ifndef TEST_SUPPORT_FAULTS_H
#define TEST_SUPPORT_FAULTS_H

#include "base/arena.h"
#include "base/memory.h"
#include "cohort/base.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

typedef struct TestFaults {
    uint64_t n;     // which allocation is refused, from 1
    uint64_t count; // of the operation's allocations when none is; 0 until that is known
    size_t live;    // bytes before
} TestFaults;

static inline size_t test_live_bytes(void)
{
    size_t bytes = 0;
    for (int tag = 0; tag < CO_MEMORY_TAG_COUNT; tag++)
        bytes += co_memory_live((CoMemoryTag)tag);
    return bytes;
}

// Whether there is an allocation left to refuse. Begins with zeros; from the second call on, memory
// must be as it was at the first.
static inline bool test_faults_next(TestFaults *faults)
{
    const uint64_t most = 100000;
    if (faults->n == 0 && faults->count == 0)
        faults->live = test_live_bytes();
    assert_int_equal(test_live_bytes(), faults->live);
    assert_true(faults->n < most);
    return faults->n++ < faults->count || faults->count == 0;
}

static inline void test_faults_begin(const TestFaults *faults)
{
    if (faults->count)
        co_memory_fail_once(faults->n);
    else
        co_memory_fail_after(faults->n);
}

// From here on memory is to be had. An operation that did without what was refused has no error,
// one that was refused nothing is done.
static inline void test_faults_end(TestFaults *faults, bool is_done, const CohortError *err)
{
    // One more than the operation asked for is given, if it came to its end before its turn.
    void *probe = co_alloc(CO_MEMORY_BASE, 1);
    bool is_whole = faults->count == 0 && probe;
    co_memory_fail_after(0);
    co_free(CO_MEMORY_BASE, probe, 1);
    if (err->code != (is_done ? COHORT_OK : COHORT_ERROR_OUT_OF_MEMORY))
        fail_msg("allocation %u%s: %s, error %d: %s", (unsigned)faults->n,
                 faults->count ? " alone" : "", is_done ? "done" : "not done", (int)err->code,
                 err->message);
    if (!is_done)
        assert_true(err->message[0]);
    if (!is_whole)
        return;
    assert_true(is_done && faults->n > 2);
    faults->count = faults->n - 2;
    faults->n = 0;
}

// Leaves an arena `room` bytes, and no more once they are taken; what is in it stays. Under
// AddressSanitizer, which asks for gaps, it may be a little less.
static inline void test_arena_leave(CoArena *arena, size_t room)
{
    assert_non_null(co_arena_bytes(arena, 1, 1));
    arena->limit = arena->total;
    CoArenaMark before = co_arena_mark(arena);
    const size_t piece = 512, gap = 32;
    for (size_t size = piece; size > 0; size = size > 1 ? 1 : 0)
        while (co_arena_bytes(arena, size, 1))
            ;
    size_t end = co_arena_mark(arena).used;
    co_arena_rewind(arena, before);
    while (co_arena_mark(arena).used + room + piece + gap < end)
        assert_non_null(co_arena_bytes(arena, piece, 1));
    while (co_arena_mark(arena).used + room < end && co_arena_bytes(arena, 1, 1))
        ;
}

#endif
