// The exact sort: recursive median partition (Eisenacher et al. 2013, 3.1).
#include "sort/ray_entry.h"

#include "base/hash.h"
#include "base/parallel.h"

#include <stdbool.h>

#define RUN_MOST 4096   // rays; from here down by direction
#define LEVELS_SHARED 6 // levels of the tree whose subsets are handed to workers one by one
#define SELECT_SMALL 24
#define SAMPLE_FROM 4096 // smaller subsets take the middle of three
#define SAMPLE_MAX 63

// Equal coordinates are common (axis-aligned walls, one pinhole), so the other coordinates decide
// then: the order is total up to rays that are the same, and so are the groups.
static bool is_less_tied(const CoRayEntry *a, const CoRayEntry *b)
{
    for (int i = 0; i < 6; i++)
        if (a->v[i] != b->v[i])
            return a->v[i] < b->v[i];
    return false;
}

static inline bool is_less(const CoRayEntry *a, const CoRayEntry *b, int axis)
{
    if (a->v[axis] != b->v[axis])
        return a->v[axis] < b->v[axis];
    return is_less_tied(a, b);
}

static inline void swap(CoRayEntry *a, CoRayEntry *b)
{
    CoRayEntry t = *a;
    *a = *b;
    *b = t;
}

static void insertion_sort(CoRayEntry *e, size_t count, int axis)
{
    for (size_t i = 1; i < count; i++) {
        CoRayEntry item = e[i];
        size_t at = i;
        for (; at > 0 && is_less(&item, &e[at - 1], axis); at--)
            e[at] = e[at - 1];
        e[at] = item;
    }
}

// A pivot from a sample at places that no pattern in the input lines up with. Its rank is a little
// beyond k's, on the longer side, so that what remains after a partition is mostly the short side
// (Floyd, Rivest 1975).
static CoRayEntry pick_pivot(const CoRayEntry *e, size_t count, size_t k, int axis)
{
    CoRayEntry sample[SAMPLE_MAX];
    size_t n = count < SAMPLE_FROM ? 3 : SAMPLE_MAX;
    uint64_t hash = co_hash64(count);
    for (size_t i = 0; i < n; i++) {
        sample[i] = e[hash % count];
        hash = co_hash64(hash);
    }
    insertion_sort(sample, n, axis);
    size_t rank = (size_t)((double)k / (double)count * (double)n);
    size_t margin = n / 12;
    if (k > count / 2)
        rank = rank > margin ? rank - margin : 0;
    else if (k < count / 2)
        rank = rank + margin;
    return sample[n == 3 ? 1 : rank < n ? rank : n - 1];
}

// Hoare's select: afterwards no entry of [0, k) is above one of [k, count).
static void select_median(CoRayEntry *e, size_t count, size_t k, int axis)
{
    while (k > 0 && count > SELECT_SMALL) {
        CoRayEntry pivot = pick_pivot(e, count, k, axis);
        size_t i = 0, j = count - 1;
        for (;;) {
            while (is_less(&e[i], &pivot, axis))
                i++;
            while (is_less(&pivot, &e[j], axis))
                j--;
            if (i >= j)
                break;
            swap(&e[i++], &e[j--]);
        }
        // [0, i) <= pivot <= [i, count); i is 0 only if the pivot is the least and stands first.
        size_t below = i > 0 ? i : 1;
        if (k < below) {
            count = below;
        } else {
            e += below;
            k -= below;
            count -= below;
        }
    }
    if (k > 0)
        insertion_sort(e, count, axis);
}

// Longest axis of the bounds of v[first .. first + 2]; *extent gets its length.
static int longest_axis(const CoRayEntry *e, size_t count, int first, float *extent)
{
    float low[3], high[3];
    for (int a = 0; a < 3; a++)
        low[a] = high[a] = e[0].v[first + a];
    for (size_t i = 1; i < count; i++)
        for (int a = 0; a < 3; a++) {
            float x = e[i].v[first + a];
            low[a] = x < low[a] ? x : low[a];
            high[a] = x > high[a] ? x : high[a];
        }
    int axis = 0;
    for (int a = 1; a < 3; a++)
        if (high[a] - low[a] > high[axis] - low[axis])
            axis = a;
    *extent = high[axis] - low[axis];
    return first + axis;
}

typedef struct Subset {
    CoRayEntry *entries;
    size_t count;
    bool by_direction;
} Subset;

// Splits a subset at a multiple of 64 next to its middle. False when it is one group.
static bool split(const Subset *subset, Subset *left, Subset *right)
{
    if (subset->count <= CO_SORT_GROUP)
        return false;
    float extent = 0.0f;
    int axis = 0;
    bool by_direction = subset->by_direction || subset->count <= RUN_MOST;
    if (!by_direction)
        axis = longest_axis(subset->entries, subset->count, 0, &extent);
    if (by_direction || !(extent > 0.0f)) {
        by_direction = true;
        axis = longest_axis(subset->entries, subset->count, 3, &extent);
    }
    size_t groups = (subset->count + CO_SORT_GROUP - 1) / CO_SORT_GROUP;
    size_t middle = (groups + 1) / 2 * CO_SORT_GROUP;
    if (extent > 0.0f)
        select_median(subset->entries, subset->count, middle, axis);
    *left = (Subset){subset->entries, middle, by_direction};
    *right = (Subset){subset->entries + middle, subset->count - middle, by_direction};
    return true;
}

static void split_all(Subset subset)
{
    Subset left, right;
    while (split(&subset, &left, &right)) {
        split_all(left);
        subset = right;
    }
}

typedef struct Level {
    Subset subsets[2 << LEVELS_SHARED];
    size_t count;
} Level;

typedef struct Step {
    const Level *from;
    Level *to; // subset i becomes subsets 2i and 2i + 1
} Step;

static void split_level(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Step *step = context;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        Subset *out = &step->to->subsets[2 * i];
        if (!split(&step->from->subsets[i], &out[0], &out[1])) {
            out[0] = step->from->subsets[i];
            out[1] = (Subset){NULL, 0, true};
        }
    }
}

static void finish_level(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Level *level = context;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        split_all(level->subsets[i]);
}

void co_split_rays(CoRayEntry *entries, size_t count)
{
    Level levels[2] = {{.count = 1}, {.count = 0}};
    levels[0].subsets[0] = (Subset){entries, count, false};
    Level *now = &levels[0], *next = &levels[1];
    for (int i = 0; i < LEVELS_SHARED; i++) {
        Step step = {now, next};
        co_parallel_for(now->count, 1, split_level, &step);
        next->count = now->count * 2;
        Level *t = now;
        now = next;
        next = t;
    }
    co_parallel_for(now->count, 1, finish_level, now);
}
