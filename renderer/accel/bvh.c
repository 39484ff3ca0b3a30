#include "accel/build.h"

#include "accel/grid_leaf.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "simd/lanes4.h"

#include <string.h>

// A leaf of one triangle; those of more take less for each.
enum {
    LEAF_PRIM_BYTES = 64
};

// The triangles of a leaf and the distinct points they share.
typedef struct Corners {
    uint32_t points[CO_LEAF_POINTS];
    uint8_t corner[3][CO_LEAF_WIDTH]; // into points
    uint32_t point_count;
} Corners;

// False when there are more points than a leaf holds.
static bool share_points(const CoMesh *mesh, const CoBuildPrim *prims, size_t count, Corners *out)
{
    Co8 points[2] = {co8_set1(UINT32_MAX), co8_set1(UINT32_MAX)}; // no point has this index
    uint32_t point_count = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t tri[3];
        co_mesh_triangle(mesh, prims[i].id, tri);
        for (size_t c = 0; c < 3; c++) {
            uint32_t same = co8_equal(&points[0], tri[c]) | co8_equal(&points[1], tri[c]) << 8;
            if (!same && point_count == CO_LEAF_POINTS)
                return false;
            if (!same)
                co8_put(&points[point_count / 8], point_count % 8, tri[c]);
            out->corner[c][i] = (uint8_t)(same ? (uint32_t)__builtin_ctz(same) : point_count++);
        }
    }
    co8_store(out->points, &points[0]);
    co8_store(out->points + 8, &points[1]);
    out->point_count = point_count;
    return true;
}

static uint32_t least_id(const CoBuildPrim *prims, size_t count, bool *is_near)
{
    uint32_t least = prims[0].id, most = least;
    for (size_t i = 1; i < count; i++) {
        least = prims[i].id < least ? prims[i].id : least;
        most = prims[i].id > most ? prims[i].id : most;
    }
    *is_near = most - least <= UINT16_MAX;
    return least;
}

// Asks for the points too, which are wanted when the leaf is written.
static bool leaf_fits(const void *context, const CoBuildPrim *prims, size_t count, size_t *bytes)
{
    const CoMesh *mesh = context;
    Corners corners;
    bool is_near;
    if (!share_points(mesh, prims, count, &corners))
        return false;
    for (size_t j = 0; j < corners.point_count; j++)
        __builtin_prefetch(mesh->points + 3 * (size_t)corners.points[j]);
    least_id(prims, count, &is_near);
    *bytes = co_leaf_size((uint32_t)count, corners.point_count, is_near);
    return true;
}

// Corner 0 of triangle 0, which is the first point that was found, is put last.
static void pack_corners(const Corners *corners, uint32_t count, uint32_t *words)
{
    const uint32_t row = (count + 7) / 8, points = corners->point_count;
    memset(words, 0, 3 * sizeof *words * row);
    for (uint32_t c = 0; c < 3; c++) {
        for (uint32_t i = 0; i < count; i++) {
            uint32_t place = corners->corner[c][i];
            place = place ? place - 1 : points - 1;
            words[c * row + i / 8] |= place << 4 * (i & 7);
        }
    }
}

static unsigned char *put(unsigned char *out, const void *bytes, size_t count)
{
    memcpy(out, bytes, count);
    return out + count;
}

static unsigned char *put_tris(unsigned char *out, const CoBuildPrim *prims, size_t count,
                               uint32_t first, bool is_near)
{
    for (size_t i = is_near ? 0 : 1; i < count; i++) {
        uint16_t above = (uint16_t)(prims[i].id - first);
        out = is_near ? put(out, &above, sizeof above) : put(out, &prims[i].id, sizeof prims[i].id);
    }
    return out;
}

static uint32_t emit_leaf(const void *context, const CoBuildPrim *prims, size_t count,
                          unsigned char *out, size_t *bytes)
{
    const CoMesh *mesh = context;
    Corners corners;
    bool is_near;
    uint32_t n = (uint32_t)count, words[3 * CO_LEAF_WIDTH / 8];
    share_points(mesh, prims, count, &corners);
    pack_corners(&corners, n, words);
    uint32_t least = least_id(prims, count, &is_near), points = corners.point_count;
    uint32_t first = is_near ? least | CO_LEAF_NEAR : prims[0].id;
    *bytes = co_leaf_size(n, points, is_near);
    memset(out + *bytes - CO_LEAF_UNIT, 0, CO_LEAF_UNIT);
    out = put(out, words, 3 * sizeof *words * ((n + 7) / 8));
    out = put(out, &first, sizeof first);
    for (size_t k = 0; k < 3; k++)
        for (uint32_t j = 1; j <= points; j++) // the first last
            out = put(out, &mesh->points[3 * (size_t)corners.points[j % points] + k], sizeof(float));
    put_tris(out, prims, count, least, is_near);
    return CO_REF_LEAF | (n - 1) << CO_REF_COUNT_SHIFT;
}

static CoBox triangle_box(const CoMesh *mesh, uint32_t id)
{
    CoBox box;
    uint32_t tri[3];
    co_box_empty(&box);
    co_mesh_triangle(mesh, id, tri);
    for (int c = 0; c < 3; c++) {
        const float *p = mesh->points + 3 * (size_t)tri[c];
        co_box_extend(&box, p, p);
    }
    return box;
}

static void approach(const void *context, const CoBuildPrim *prims, size_t count)
{
    const CoMesh *mesh = context;
    for (size_t i = 0; i < count; i++)
        __builtin_prefetch(mesh->indices + 3 * (size_t)prims[i].id);
}

typedef struct PrimFill {
    const CoMesh *mesh;
    CoBuildPrim *prims;
} PrimFill;

static void fill_prims(void *context, size_t begin, size_t end, uint32_t worker)
{
    PrimFill *fill = context;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        uint32_t id = (uint32_t)i;
        CoBox box =
            fill->mesh->patches ? co_grid_box(fill->mesh, id) : triangle_box(fill->mesh, id);
        memcpy(fill->prims[i].lo, box.lo, sizeof box.lo);
        memcpy(fill->prims[i].hi, box.hi, sizeof box.hi);
        fill->prims[i].id = id;
        fill->prims[i].unused = 0;
    }
}

static void take_parts(CoBvh *bvh, const CoMesh *mesh, const CoTreeParts *parts)
{
    bvh->tree = parts->tree;
    bvh->points = mesh->points;
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
    CoLeafRule rule = {leaf_fits, emit_leaf, approach, mesh, CO_LEAF_WIDTH, LEAF_PRIM_BYTES};
    CoPrimArray prims = {.count = mesh->tri_count};
    if (mesh->patches) {
        rule = co_grid_rule(mesh);
        prims.count = co_grid_count(mesh);
    }
    CoBvh *bvh = co_alloc_zero(CO_MEMORY_ACCEL, sizeof *bvh);
    prims.capacity = prims.count;
    prims.prims = co_alloc(CO_MEMORY_ACCEL, prims.count * sizeof *prims.prims);
    if (!bvh || (!prims.prims && prims.count)) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "no memory to build a tree over %u triangles",
                mesh->tri_count);
        co_prims_free(&prims);
        co_bvh_destroy(bvh);
        return NULL;
    }
    PrimFill fill = {mesh, prims.prims};
    co_parallel_for(prims.count, mesh->patches ? 1024 : 16384, fill_prims, &fill);
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
    co_tree_clear(&bvh->tree);
    co_free(CO_MEMORY_ACCEL, bvh->leaves, bvh->leaf_capacity);
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
