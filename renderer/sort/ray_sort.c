#include "sort/ray_sort.h"

#include "base/parallel.h"
#include "sort/hilbert.h"
#include "sort/ray_entry.h"

#include <stdatomic.h>
#include <string.h>

#define GRAIN 16384
#define PREFETCH 16         // entries ahead
#define ORIGIN_BITS_MAX 10u // per axis
#define DIRECTION_BITS 7u   // per axis, within a run
#define PINHOLE_BITS 13u    // per axis, where all origins are one point
#define FACE_BITS 3u
#define DIRECTION_KEY_BITS (2 * DIGIT_BITS)
#define PINHOLE_KEY_BITS (2 * PINHOLE_BITS + FACE_BITS)
#define DIGIT_BITS 9u // of the sort within a run; two hold a direction key

_Static_assert(2 * DIRECTION_BITS + FACE_BITS <= DIRECTION_KEY_BITS, "nothing of the position");

typedef struct Run Run;

typedef struct Sort {
    CoRayBatch *batch;
    CoRayEntry *entries;
    uint64_t *items; // key above, index of the entry below
    uint64_t *temp;
    Run *runs;    // per worker
    size_t valid; // entries with finite origins; the others come behind them
    CoVec3 low;   // of the origins
    float scale;  // origin to cells, 0 where all are one point
    uint32_t index_bits, origin_bits;
} Sort;

// --- to and from entries ------------------------------------------------------------------------

static bool is_valid(const CoRayBatch *b, size_t i)
{
    return isfinite(b->org_x[i]) && isfinite(b->org_y[i]) && isfinite(b->org_z[i]);
}

static void store_entry(const CoRayBatch *b, size_t i, CoRayEntry *out)
{
    *out =
        (CoRayEntry){{b->org_x[i], b->org_y[i], b->org_z[i], b->dir_x[i], b->dir_y[i], b->dir_z[i]},
                     b->tnear[i],
                     b->tfar[i],
                     b->record[i]};
}

static void load_entry(CoRayBatch *b, size_t i, const CoRayEntry *entry)
{
    b->org_x[i] = entry->v[0];
    b->org_y[i] = entry->v[1];
    b->org_z[i] = entry->v[2];
    b->dir_x[i] = entry->v[3];
    b->dir_y[i] = entry->v[4];
    b->dir_z[i] = entry->v[5];
    b->tnear[i] = entry->tnear;
    b->tfar[i] = entry->tfar;
    b->record[i] = entry->record;
}

static void store_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Sort *sort = context;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        store_entry(sort->batch, i, &sort->entries[i]);
}

static void load_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Sort *sort = context;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        load_entry(sort->batch, i, &sort->entries[i]);
}

typedef struct Scan {
    const CoRayBatch *batch;
    atomic_size_t invalid;
    _Atomic uint32_t low[3], high[3]; // ordered bits of floats
} Scan;

// Floats in the order of their values as unsigned integers.
static uint32_t ordered(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

static float unordered(uint32_t bits)
{
    float x;
    bits = bits & 0x80000000u ? bits & 0x7fffffffu : ~bits;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static void widen(Scan *scan, int axis, float low, float high)
{
    uint32_t l = ordered(low), h = ordered(high), held = atomic_load(&scan->low[axis]);
    while (l < held && !atomic_compare_exchange_weak(&scan->low[axis], &held, l))
        ;
    held = atomic_load(&scan->high[axis]);
    while (h > held && !atomic_compare_exchange_weak(&scan->high[axis], &held, h))
        ;
}

static void scan_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    Scan *scan = context;
    const CoRayBatch *b = scan->batch;
    const float *org[3] = {b->org_x, b->org_y, b->org_z};
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    size_t invalid = 0;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        if (!is_valid(b, i)) {
            invalid++;
            continue;
        }
        for (int a = 0; a < 3; a++) {
            low[a] = org[a][i] < low[a] ? org[a][i] : low[a];
            high[a] = org[a][i] > high[a] ? org[a][i] : high[a];
        }
    }
    if (invalid < end - begin)
        for (int a = 0; a < 3; a++)
            widen(scan, a, low[a], high[a]);
    atomic_fetch_add(&scan->invalid, invalid);
}

// Bounds of the origins, and how many are finite.
static void find_bounds(Sort *sort, float *extent)
{
    Scan scan = {.batch = sort->batch};
    for (int a = 0; a < 3; a++)
        atomic_store(&scan.low[a], UINT32_MAX);
    co_parallel_for(sort->batch->count, GRAIN, scan_range, &scan);
    sort->valid = sort->batch->count - atomic_load(&scan.invalid);
    *extent = 0.0f;
    float low[3] = {0};
    for (int a = 0; a < 3 && sort->valid > 0; a++) {
        low[a] = unordered(atomic_load(&scan.low[a]));
        *extent = fmaxf(*extent, unordered(atomic_load(&scan.high[a])) - low[a]);
    }
    sort->low = co_vec3_load(low);
}

// --- exact --------------------------------------------------------------------------------------

static void move_invalid_last(CoRayEntry *entries, size_t count)
{
    size_t end = count;
    for (size_t i = 0; i < end;) {
        const float *v = entries[i].v;
        if (isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2])) {
            i++;
            continue;
        }
        CoRayEntry t = entries[i];
        entries[i] = entries[--end];
        entries[end] = t;
    }
}

static void sort_exact(Sort *sort)
{
    co_parallel_for(sort->batch->count, GRAIN, store_range, sort);
    if (sort->valid < sort->batch->count)
        move_invalid_last(sort->entries, sort->batch->count);
    co_split_rays(sort->entries, sort->valid);
    co_parallel_for(sort->batch->count, GRAIN, load_range, sort);
}

// --- fast ---------------------------------------------------------------------------------------

// Face of the cube around the origin that d meets, then the place on it.
static uint32_t direction_key(const float *d, uint32_t bits)
{
    uint32_t face = co_ray_bin(co_vec3_load(d));
    uint32_t major = face / 2, minor = major == 0 ? 1 : 0, other = major == 2 ? 1 : 2;
    float half = (float)(1u << (bits - 1)), most = (float)((1u << bits) - 1);
    float scale = half / fabsf(d[major]);
    float u = d[minor] * scale + half, v = d[other] * scale + half;
    uint32_t x = u > 0.0f ? (uint32_t)(u < most ? u : most) : 0; // NaN: 0
    uint32_t y = v > 0.0f ? (uint32_t)(v < most ? v : most) : 0;
    return face << (2 * bits) | co_hilbert2(x, y, bits);
}

static uint32_t origin_key(const Sort *sort, const float *o)
{
    float most = (float)((1u << sort->origin_bits) - 1);
    uint32_t x = (uint32_t)co_clamp((o[0] - sort->low.x) * sort->scale, 0.0f, most);
    uint32_t y = (uint32_t)co_clamp((o[1] - sort->low.y) * sort->scale, 0.0f, most);
    uint32_t z = (uint32_t)co_clamp((o[2] - sort->low.z) * sort->scale, 0.0f, most);
    return co_hilbert3(x, y, z, sort->origin_bits);
}

// The highest key bit says "invalid".
static void key_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Sort *sort = context;
    uint32_t key_bits = sort->scale > 0.0f ? 3 * sort->origin_bits : PINHOLE_KEY_BITS;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        CoRayEntry *entry = &sort->entries[i];
        store_entry(sort->batch, i, entry);
        uint64_t key = (uint64_t)1 << key_bits;
        if (is_valid(sort->batch, i))
            key = sort->scale > 0.0f ? origin_key(sort, entry->v)
                                     : direction_key(entry->v + 3, PINHOLE_BITS);
        sort->items[i] = key << sort->index_bits | i;
    }
}

// A counting sort of one run, by one digit of the direction key, from `from` to `to`.
static void sort_digit(const uint32_t *from, uint32_t *to, size_t count, uint32_t shift)
{
    uint32_t next[1 << DIGIT_BITS] = {0}, sum = 0, mask = (1u << DIGIT_BITS) - 1;
    for (size_t i = 0; i < count; i++)
        next[from[i] >> shift & mask]++;
    for (uint32_t digit = 0; digit <= mask; digit++) {
        uint32_t n = next[digit];
        next[digit] = sum;
        sum += n;
    }
    for (size_t i = 0; i < count; i++)
        to[next[from[i] >> shift & mask]++] = from[i];
}

// One run, in cache.
struct Run {
    CoRayEntry entries[CO_SORT_RUN];
    uint32_t keys[CO_SORT_RUN], temp[CO_SORT_RUN]; // position in the run above, direction key below
};

// Collects each run from all over memory, sorts it by direction and writes it to the batch.
static void finish_runs(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Sort *sort = context;
    uint64_t mask = ((uint64_t)1 << sort->index_bits) - 1;
    Run *r = &sort->runs[worker];
    for (size_t run = begin; run < end; run++) {
        size_t first = run * CO_SORT_RUN, count = sort->valid - first;
        count = count < CO_SORT_RUN ? count : CO_SORT_RUN;
        const uint64_t *items = sort->items + first;
        for (size_t i = 0; i < count; i++) {
            size_t ahead = i + PREFETCH < count ? i + PREFETCH : i;
            const CoRayEntry *next = &sort->entries[items[ahead] & mask];
            __builtin_prefetch(next);
            __builtin_prefetch(&next->record); // often on the next cache line
            r->entries[i] = sort->entries[items[i] & mask];
            r->keys[i] = (uint32_t)i << DIRECTION_KEY_BITS |
                         direction_key(r->entries[i].v + 3, DIRECTION_BITS);
        }
        if (sort->scale > 0.0f) {
            sort_digit(r->keys, r->temp, count, 0);
            sort_digit(r->temp, r->keys, count, DIGIT_BITS);
        }
        for (size_t i = 0; i < count; i++)
            load_entry(sort->batch, first + i, &r->entries[r->keys[i] >> DIRECTION_KEY_BITS]);
    }
}

static void sort_fast(Sort *sort, float extent, void *histograms)
{
    size_t count = sort->batch->count;
    sort->index_bits = co_radix_bits((uint32_t)count);
    sort->origin_bits = (63 - sort->index_bits) / 3;
    if (sort->origin_bits > ORIGIN_BITS_MAX)
        sort->origin_bits = ORIGIN_BITS_MAX;
    float cells = (float)(1u << sort->origin_bits);
    sort->scale = extent > 0.0f ? cells / extent : 0.0f;
    if (!isfinite(sort->scale)) // all within a denormal of each other
        sort->scale = 0.0f;
    co_parallel_for(count, GRAIN, key_range, sort);
    uint32_t key_bits = sort->scale > 0.0f ? 3 * sort->origin_bits : PINHOLE_KEY_BITS;
    key_bits += sort->valid < count;
    sort->items =
        co_radix_sort(sort->items, sort->temp, count, sort->index_bits, key_bits, histograms);
    co_parallel_for((sort->valid + CO_SORT_RUN - 1) / CO_SORT_RUN, 1, finish_runs, sort);
    uint64_t mask = ((uint64_t)1 << sort->index_bits) - 1;
    for (size_t i = sort->valid; i < count; i++)
        load_entry(sort->batch, i, &sort->entries[sort->items[i] & mask]);
}

bool co_sort_rays(CoRayBatch *batch, CohortSorter sorter, CoSortScratch *scratch, CohortError *err)
{
    size_t count = batch->count;
    if (count < 2)
        return true;
    size_t entry_bytes = (count * sizeof(CoRayEntry) + 63) & ~(size_t)63;
    size_t item_bytes = (count * sizeof(uint64_t) + 63) & ~(size_t)63;
    bool is_exact = sorter == COHORT_SORTER_EXACT;
    size_t run_bytes = co_worker_count() * sizeof(Run);
    size_t bytes = entry_bytes;
    if (!is_exact)
        bytes += 2 * item_bytes + co_radix_histogram_bytes() + run_bytes;
    char *memory = co_sort_scratch_reserve(scratch, bytes, err);
    if (!memory)
        return false;
    Sort sort = {.batch = batch, .entries = (CoRayEntry *)(void *)memory};
    float extent;
    find_bounds(&sort, &extent);
    if (is_exact) {
        sort_exact(&sort);
        return true;
    }
    sort.items = (uint64_t *)(void *)(memory + entry_bytes);
    sort.temp = (uint64_t *)(void *)(memory + entry_bytes + item_bytes);
    char *histograms = memory + entry_bytes + 2 * item_bytes;
    sort.runs = (Run *)(void *)(histograms + co_radix_histogram_bytes());
    sort_fast(&sort, extent, histograms);
    return true;
}
