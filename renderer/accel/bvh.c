#include "accel/build.h"

#include "accel/grid_leaf.h"
#include "accel/shards.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "simd/lanes4.h"

#include <string.h>

enum {
    SLOTS_LOG2 = 7 // of a leaf's points by a hash of their index, mostly one or none in a slot
};

// Without a branch on whether a point is there, which nothing predicts. False when there are more
// points than a leaf holds.
static bool share_points(const CoMesh *mesh, const uint32_t *tris, size_t count, CoLeafCorners *out)
{
    uint8_t slots[1 << SLOTS_LOG2] = {0}; // 1 + the number of a point; 0: none
    uint32_t points[1 + CO_LEAF_WIDTH + 3] = {0}, last = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t tri[3];
        co_mesh_triangle(mesh, tris[i], tri);
        for (size_t c = 0; c < 3; c++) {
            uint32_t slot = tri[c] * 0x9e3779b1u >> (32 - SLOTS_LOG2), at = slots[slot];
            while ((at != 0) & (points[at] != tri[c])) {
                slot = (slot + 1) % (1 << SLOTS_LOG2);
                at = slots[slot];
            }
            last += at == 0;
            at = at ? at : last;
            points[at] = tri[c];
            slots[slot] = (uint8_t)at;
            out->corner[c][i] = (uint8_t)(at - 1);
        }
        if (last > CO_LEAF_WIDTH)
            return false;
    }
    memcpy(out->points, points + 1, sizeof out->points);
    out->point_count = last;
    return true;
}

static unsigned char *put(unsigned char *out, const void *bytes, size_t count)
{
    memcpy(out, bytes, count);
    return out + count;
}

unsigned char *co_leaf_put_corners(unsigned char *out, const CoLeafCorners *corners, size_t count)
{
    const size_t row = (count + 1) / 2;
    *out++ = (unsigned char)((count - 1) | (corners->point_count - 1) << 4);
    memset(out, 0, co_leaf_first((uint32_t)count) - 1);
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < count; i++)
            out[c * row + i / 2] |= (unsigned char)(corners->corner[c][i] << 4 * (i & 1));
    return out + co_leaf_first((uint32_t)count) - 1;
}

unsigned char *co_leaf_put_runs(unsigned char *out, const uint32_t *tris, size_t count)
{
    const bool near = co_leaf_is_near(tris, count);
    uint32_t skipped[CO_LEAF_WIDTH], starts = 1, runs = 0;
    for (uint32_t i = 1; i < count; i++) {
        if (tris[i] == tris[i - 1] + 1)
            continue;
        starts |= 1u << i;
        skipped[runs++] = tris[i] - tris[0] - i;
    }
    out = put(out, &(uint16_t){(uint16_t)starts}, sizeof(uint16_t));
    if (!near || runs % 2 == 0)
        memset(out + (near ? 2 * runs : 0), 0, sizeof(uint16_t));
    if (!near)
        return put(out + sizeof(uint16_t), skipped, runs * sizeof *skipped);
    for (uint32_t i = 0; i < runs; i++)
        out = put(out, &(uint16_t){(uint16_t)skipped[i]}, sizeof(uint16_t));
    return out + (runs % 2 ? 0 : sizeof(uint16_t));
}

void co_leaf_sort(uint32_t *numbers, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        uint32_t number = numbers[i];
        size_t at = i;
        for (; at > 0 && numbers[at - 1] > number; at--)
            numbers[at] = numbers[at - 1];
        numbers[at] = number;
    }
}

size_t co_leaf_bytes(const uint32_t *tris, size_t count, size_t point_bytes)
{
    size_t runs = 1;
    for (size_t i = 1; i < count; i++)
        runs += tris[i] != tris[i - 1] + 1;
    size_t tail = co_leaf_is_near(tris, count) ? (2 * runs + 3) & ~(size_t)3 : 4 * runs;
    return co_leaf_first((uint32_t)count) + 4 + point_bytes + tail;
}

// Told without a look at their points where triangles share none. That is for speed alone.
static bool are_too_many(const CoMesh *mesh, const uint32_t *ids, size_t count)
{
    const size_t most = CO_LEAF_WIDTH / 3;
    uint64_t bits = 0;
    if (count <= most || mesh->point_count < 3 * (size_t)mesh->tri_count)
        return false;
    for (size_t i = 0; i < count; i++)
        bits |= (uint64_t)1 << (ids[i] * 0x9e3779b1u >> 26);
    for (size_t i = 0; i < most; i++)
        bits &= bits - 1;
    return bits != 0;
}

// Puts ids in order. Returns how many points their triangles have, 0 if too many.
static uint32_t count_points(const CoMesh *mesh, const CoBuildPrim *prims, size_t count,
                             CoLeafShape *out)
{
    CoLeafCorners corners;
    for (size_t i = 0; i < count; i++)
        out->ids[i] = prims[i].id;
    if (are_too_many(mesh, out->ids, count) || !share_points(mesh, out->ids, count, &corners))
        return 0;
    co_leaf_sort(out->ids, count);
    return corners.point_count;
}

static bool shape_of(size_t count, uint32_t points, CoLeafShape *out)
{
    out->count = (uint32_t)count;
    out->bytes = (uint32_t)co_leaf_bytes(out->ids, count, 12 * points);
    out->ref = CO_REF_LEAF;
    return true;
}

static bool leaf_fits(const void *context, const CoBuildPrim *prims, size_t count, CoLeafShape *out)
{
    uint32_t points = count_points(context, prims, count, out);
    return points && shape_of(count, points, out);
}

// Each triangle stands in a leaf once.
static bool shards_fit(const void *context, const CoBuildPrim *prims, size_t count,
                       CoLeafShape *out)
{
    uint32_t points = count_points(context, prims, count, out);
    size_t kept = 1;
    if (!points)
        return false;
    for (size_t i = 1; i < count; i++)
        if (out->ids[i] != out->ids[kept - 1])
            out->ids[kept++] = out->ids[i];
    return shape_of(kept, points, out);
}

static size_t emit_leaf(const void *context, const uint32_t *tris, size_t count, unsigned char *out)
{
    const CoMesh *mesh = context;
    const unsigned char *begin = out;
    CoLeafCorners corners;
    share_points(mesh, tris, count, &corners);
    uint32_t first = tris[0] | (co_leaf_is_near(tris, count) ? CO_LEAF_NEAR : 0);
    out = co_leaf_put_corners(out, &corners, count);
    out = put(out, &first, sizeof first);
    for (size_t k = 0; k < 3; k++)
        for (size_t j = 0; j < corners.point_count; j++)
            out = put(out, &mesh->points[3 * (size_t)corners.points[j] + k], sizeof(float));
    out = co_leaf_put_runs(out, tris, count);
    return (size_t)(out - begin);
}

// Of 12 bytes, which may lie in two cache lines.
static void prefetch_three(const void *three)
{
    __builtin_prefetch(three);
    __builtin_prefetch((const char *)three + 8);
}

static void approach(const void *context, const CoBuildPrim *prims, size_t count)
{
    const CoMesh *mesh = context;
    for (size_t i = 0; i < count; i++)
        prefetch_three(mesh->indices + 3 * (size_t)prims[i].id);
}

// The far one's corners, then, once these are there, its points.
static void expect(const void *context, uint32_t near_id, uint32_t far_id)
{
    const CoMesh *mesh = context;
    uint32_t tri[3];
    prefetch_three(mesh->indices + 3 * (size_t)far_id);
    co_mesh_triangle(mesh, near_id, tri);
    for (int c = 0; c < 3; c++)
        prefetch_three(mesh->points + 3 * (size_t)tri[c]);
}

typedef struct PrimFill {
    const CoMesh *mesh;
    CoBuildPrim *prims;
    CoBoxAreas *areas; // of blocks of triangles
} PrimFill;

static void fill_patches(void *context, size_t begin, size_t end, uint32_t worker)
{
    PrimFill *fill = context;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        CoBox box = co_grid_box(fill->mesh, (uint32_t)i);
        memcpy(fill->prims[i].lo, box.lo, sizeof box.lo);
        memcpy(fill->prims[i].hi, box.hi, sizeof box.hi);
        fill->prims[i].id = (uint32_t)i;
    }
}

static void fill_triangles(void *context, size_t begin, size_t end, uint32_t worker)
{
    PrimFill *fill = context;
    (void)worker;
    for (size_t b = begin; b < end; b++) {
        Co4 sum = co4_set1(0.0f), most = sum;
        size_t stop = co_shards_block_end(b, fill->mesh->tri_count);
        for (size_t i = b * CO_SHARDS_BLOCK; i < stop; i++) {
            Co4 area = co_shards_whole(fill->mesh, (uint32_t)i, &fill->prims[i]);
            sum = co4_add(sum, area);
            most = co4_max(area, most);
        }
        fill->areas[b] = (CoBoxAreas){co4_first(sum), co4_first(most)};
    }
}

// False when memory ends.
static bool fill_prims(const CoMesh *mesh, CoPrimArray *prims, bool *has_shards)
{
    PrimFill fill = {.mesh = mesh, .prims = prims->prims};
    size_t blocks = co_shards_blocks(mesh->tri_count);
    *has_shards = false;
    if (mesh->patches || prims->count == 0) {
        bool is_alone = co_build_threads(prims->count) == 1;
        co_parallel_for_parts(prims->count, is_alone ? prims->count : 1024, fill_patches, &fill);
        return true;
    }
    fill.areas = co_alloc(CO_MEMORY_ACCEL, blocks * sizeof *fill.areas);
    if (!fill.areas)
        return false;
    co_parallel_for_parts(blocks, co_shards_grain(mesh->tri_count), fill_triangles, &fill);
    bool is_done = co_shards_make(mesh, fill.areas, prims, has_shards);
    co_free(CO_MEMORY_ACCEL, fill.areas, blocks * sizeof *fill.areas);
    return is_done;
}

static void take_parts(CoBvh *bvh, const CoMesh *mesh, const CoTreeParts *parts)
{
    bvh->tree = parts->tree;
    bvh->is_flat = mesh->is_flat;
    bvh->leaves = parts->leaves;
    bvh->leaf_bytes = parts->leaf_bytes;
    bvh->leaf_capacity = parts->leaf_capacity;
    bvh->leaf_at = bvh->leaves;
    bvh->leaf_stride = CO_LEAF_UNIT;
    if (mesh->patches)
        co_grid_attach(bvh, mesh);
}

CoBvh *co_bvh_create(const CoMesh *mesh, CohortError *err)
{
    CO_CHECK_NULL(mesh->tri_count < CO_REF_NONE, err, COHORT_ERROR_LIMIT,
                  "a mesh of more than 2^31 - 2 triangles; split the mesh");
    CoLeafRule rule = {leaf_fits, emit_leaf, approach, expect, mesh, CO_LEAF_WIDTH, 0};
    CoPrimArray prims = {.count = mesh->tri_count};
    if (mesh->patches) {
        rule = co_grid_rule(mesh);
        prims.count = co_grid_count(mesh);
    }
    CoBvh *bvh = co_alloc_zero(CO_MEMORY_ACCEL, sizeof *bvh);
    prims.capacity = prims.count;
    prims.prims = co_alloc(CO_MEMORY_ACCEL, prims.count * sizeof *prims.prims);
    if (!bvh || (!prims.prims && prims.count) || !fill_prims(mesh, &prims, &bvh->has_shards)) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "no memory to build a tree over %u triangles",
                mesh->tri_count);
        co_prims_free(&prims);
        co_bvh_destroy(bvh);
        return NULL;
    }
    if (bvh->has_shards)
        rule.fits = shards_fit;
    CoTreeParts parts;
    if (!co_tree_build(&prims, &rule, &parts, err)) {
        co_bvh_destroy(bvh);
        return NULL;
    }
    take_parts(bvh, mesh, &parts);
    return bvh;
}

void co_bvh_destroy(CoBvh *bvh)
{
    if (!bvh)
        return;
    if (bvh->block) {
        co_bvh_block_leave(bvh->block);
    } else {
        co_tree_clear(&bvh->tree);
        co_free(CO_MEMORY_ACCEL, bvh->leaves, bvh->leaf_capacity);
    }
    co_free(CO_MEMORY_ACCEL, bvh, sizeof *bvh);
}

size_t co_bvh_bytes(const CoBvh *bvh)
{
    return sizeof *bvh + bvh->tree.node_capacity * sizeof *bvh->tree.nodes + bvh->leaf_capacity;
}

size_t co_bvh_leaf_bytes(const CoBvh *bvh)
{
    return bvh->leaf_capacity;
}
