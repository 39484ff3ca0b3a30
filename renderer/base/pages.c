#define _GNU_SOURCE // mremap

#include "base/pages.h"

#include <stdint.h>

// Address sanitizers see only what comes from malloc.
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define IS_WATCHED
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define IS_WATCHED
#endif

#if defined(__linux__) && !defined(IS_WATCHED)

#include <sys/mman.h>
#include <unistd.h>

bool co_pages_suit(size_t size)
{
    return size >= CO_PAGES_ALIGNMENT;
}

static size_t whole_pages(size_t size)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    return (size + page - 1) / page * page;
}

// Maps a little more than asked for and cuts off what lies before the first aligned address and
// behind the end.
static void *map_aligned(size_t length, int protection)
{
    size_t mapped = length + CO_PAGES_ALIGNMENT;
    char *at = mmap(NULL, mapped, protection, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED)
        return NULL;
    size_t before = -(uintptr_t)at % CO_PAGES_ALIGNMENT;
    if (before)
        munmap(at, before);
    munmap(at + before + length, mapped - before - length);
    return at + before;
}

void *co_pages_alloc(size_t size)
{
    if (size > SIZE_MAX / 2)
        return NULL;
    size_t length = whole_pages(size);
    void *at = map_aligned(length, PROT_READ | PROT_WRITE);
    if (at)
        madvise(at, length, MADV_HUGEPAGE); // a wish: small pages do as well
    return at;
}

void co_pages_free(void *ptr, size_t size)
{
    munmap(ptr, whole_pages(size));
}

// The new place is aligned too, so that huge pages stay whole.
void *co_pages_resize(void *ptr, size_t old_size, size_t new_size)
{
    if (new_size > SIZE_MAX / 2)
        return NULL;
    size_t from = whole_pages(old_size), to = whole_pages(new_size);
    if (to <= from) {
        if (to < from)
            munmap((char *)ptr + to, from - to);
        return ptr;
    }
    void *place = map_aligned(to, PROT_NONE);
    if (!place)
        return NULL;
    if (mremap(ptr, from, to, MREMAP_MAYMOVE | MREMAP_FIXED, place) != MAP_FAILED)
        return place;
    munmap(place, to);
    return NULL;
}

#else

bool co_pages_suit(size_t size)
{
    (void)size;
    return false;
}

void *co_pages_alloc(size_t size)
{
    (void)size;
    return NULL;
}

void co_pages_free(void *ptr, size_t size)
{
    (void)ptr;
    (void)size;
}

void *co_pages_resize(void *ptr, size_t old_size, size_t new_size)
{
    (void)ptr;
    (void)old_size;
    (void)new_size;
    return NULL;
}

#endif
