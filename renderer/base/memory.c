#include "base/memory.h"

#include "base/pages.h"

#include <malloc.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    PART = 1 << 18 // bytes
};

static struct {
    atomic_size_t live, peak;
} tally[CO_MEMORY_TAG_COUNT];

static atomic_uint_fast64_t fail_countdown; // 0: off; 1: fail now and from now on
static atomic_bool fails_once;              // then 1: fail now, and be off

static bool must_fail(void)
{
    uint_fast64_t n = atomic_load_explicit(&fail_countdown, memory_order_relaxed);
    while (n > 1 && !atomic_compare_exchange_weak(&fail_countdown, &n, n - 1))
        ; // two that take the same 2 would leave 0, which turns it off
    if (n == 1 && atomic_load(&fails_once))
        return atomic_compare_exchange_strong(&fail_countdown, &n, 0);
    return n == 1;
}

static void count(CoMemoryTag tag, size_t size)
{
    size_t live = atomic_fetch_add_explicit(&tally[tag].live, size, memory_order_relaxed) + size;
    size_t peak = atomic_load_explicit(&tally[tag].peak, memory_order_relaxed);
    while (live > peak && !atomic_compare_exchange_weak(&tally[tag].peak, &peak, live))
        ;
}

static size_t whole_lines(size_t size)
{
    return (size + 63) & ~(size_t)63;
}

// Trees are what is walked at random and what grows by pieces; rays are met in any order and their
// memory is used over and over. What is only written once is not worth the search for large pages,
// which on a machine long in use takes as long as the writing.
static bool is_paged(CoMemoryTag tag, size_t size)
{
    return (tag == CO_MEMORY_ACCEL || tag == CO_MEMORY_RAYS) && co_pages_suit(size);
}

void *co_alloc(CoMemoryTag tag, size_t size)
{
    if (size == 0 || size > SIZE_MAX / 2 || must_fail())
        return NULL;
    void *ptr = is_paged(tag, size) ? co_pages_alloc(size) : aligned_alloc(64, whole_lines(size));
    if (ptr)
        count(tag, size);
    return ptr;
}

void *co_alloc_zero(CoMemoryTag tag, size_t size)
{
    void *ptr = co_alloc(tag, size);
    if (ptr)
        memset(ptr, 0, size);
    return ptr;
}

void co_free(CoMemoryTag tag, void *ptr, size_t size)
{
    if (!ptr)
        return;
    atomic_fetch_sub_explicit(&tally[tag].live, size, memory_order_relaxed);
    if (is_paged(tag, size))
        co_pages_free(ptr, size);
    else
        free(ptr);
}

static void *resize_pages(CoMemoryTag tag, void *ptr, size_t old_size, size_t new_size)
{
    void *moved = must_fail() ? NULL : co_pages_resize(ptr, old_size, new_size);
    if (!moved)
        return NULL;
    if (new_size > old_size)
        count(tag, new_size - old_size);
    else
        atomic_fetch_sub_explicit(&tally[tag].live, old_size - new_size, memory_order_relaxed);
    return moved;
}

// Most heaps leave a block that shrinks where it is, so that there are never two of it. One that
// does not may align it less; should there be no room then to move it once more, it stays so.
static void *shrink(CoMemoryTag tag, void *ptr, size_t old_size, size_t new_size)
{
    void *moved = must_fail() ? NULL : realloc(ptr, whole_lines(new_size));
    if (!moved)
        return NULL;
    atomic_fetch_sub_explicit(&tally[tag].live, old_size - new_size, memory_order_relaxed);
    if ((uintptr_t)moved % 64 == 0)
        return moved;
    void *aligned = aligned_alloc(64, whole_lines(new_size));
    if (!aligned)
        return moved;
    memcpy(aligned, moved, new_size);
    free(moved);
    return aligned;
}

// From the end, each part given back once it is copied, so that there are never two of it all.
static void *leave_pages(CoMemoryTag tag, char *ptr, size_t old_size, size_t new_size)
{
    char *moved = must_fail() ? NULL : aligned_alloc(64, whole_lines(new_size));
    if (!moved)
        return NULL;
    for (size_t left = old_size, next = new_size; left > 0; next -= next < PART ? next : PART) {
        size_t part = next < new_size ? left - next : 0;
        count(tag, part);
        memcpy(moved + next, ptr + next, part);
        if (next > 0)
            co_pages_resize(ptr, left, next);
        else
            co_pages_free(ptr, left);
        atomic_fetch_sub_explicit(&tally[tag].live, left - next, memory_order_relaxed);
        left = next;
    }
    return moved;
}

void *co_realloc(CoMemoryTag tag, void *ptr, size_t old_size, size_t new_size)
{
    bool was_paged = is_paged(tag, old_size), shrinks = new_size > 0 && new_size <= old_size;
    if (ptr && was_paged && is_paged(tag, new_size))
        return resize_pages(tag, ptr, old_size, new_size);
    if (ptr && shrinks)
        return was_paged ? leave_pages(tag, ptr, old_size, new_size)
                         : shrink(tag, ptr, old_size, new_size);
    void *moved = co_alloc(tag, new_size);
    if (!moved)
        return NULL;
    if (ptr) {
        memcpy(moved, ptr, old_size < new_size ? old_size : new_size);
        co_free(tag, ptr, old_size);
    }
    return moved;
}

bool co_grow(CoMemoryTag tag, void **array, size_t count, size_t *capacity, size_t size)
{
    if (count < *capacity)
        return true;
    size_t wanted, bytes;
    if (!co_size_mul(*capacity, 2, &wanted) || !co_size_mul(wanted ? wanted : 16, size, &bytes))
        return false;
    void *bigger = co_realloc(tag, *array, *capacity * size, bytes);
    if (!bigger)
        return false;
    *array = bigger;
    *capacity = wanted ? wanted : 16;
    return true;
}

size_t co_memory_live(CoMemoryTag tag)
{
    return atomic_load(&tally[tag].live);
}

size_t co_memory_peak(CoMemoryTag tag)
{
    return atomic_load(&tally[tag].peak);
}

size_t co_memory_resident(void)
{
    malloc_trim(0);
    FILE *f = fopen("/proc/self/statm", "r");
    size_t total = 0, resident = 0;
    if (f && fscanf(f, "%zu %zu", &total, &resident) != 2)
        resident = 0;
    if (f)
        fclose(f);
    long page = sysconf(_SC_PAGESIZE);
    return page > 0 ? resident * (size_t)page : 0;
}

void co_memory_fail_after(uint64_t n)
{
    atomic_store(&fails_once, false);
    atomic_store(&fail_countdown, n);
}

void co_memory_fail_once(uint64_t n)
{
    atomic_store(&fails_once, true);
    atomic_store(&fail_countdown, n);
}
