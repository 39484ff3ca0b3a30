#include "accel/build.h"

#include "accel/grid_leaf.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "simd/lanes4.h"

#include <string.h>

// A leaf of one triangle; those of more take less for each.
enum {
    LEAF_PRIM_BYTES = 48
};

// The triangles of a leaf and the distinct points they share.
typedef struct Corners {
    uint32_t points[CO_LEAF_WIDTH];
    uint8_t corner[3][CO_LEAF_WIDTH]; // into points
    size_t point_count;
} Corners;

// False when there are more points than a leaf holds.
static bool share_points(const CoMesh *mesh, const CoBuildPrim *prims, size_t count, Corners *out)
{
    Co8 points = co8_set1(UINT32_MAX); // no point has this index
    uint32_t point_count = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t tri[3];
        co_mesh_triangle(mesh, prims[i].id, tri);
        for (size_t c = 0; c < 3; c++) {
            uint32_t same = co8_equal(&points, tri[c]);
            if (!same && point_count == CO_LEAF_WIDTH)
                return false;
            if (!same)
                co8_put(&points, point_count, tri[c]);
            out->corner[c][i] = (uint8_t)(same ? (uint32_t)__builtin_ctz(same) : point_count++);
        }
    }
    co8_store(out->points, &points);
    out->point_count = point_count;
    return true;
}

// Asks for the points too, which are wanted when the leaf is written.
static bool leaf_fits(const void *context, const CoBuildPrim *prims, size_t count, size_t *bytes)
{
    const CoMesh *mesh = context;
    Corners corners;
    if (!share_points(mesh, prims, count, &corners))
        return false;
    for (size_t j = 0; j < corners.point_count; j++)
        __builtin_prefetch(mesh->points + 3 * (size_t)corners.points[j]);
    *bytes = co_leaf_size(count, corners.point_count);
    return true;
}

static uint32_t emit_leaf(const void *context, const CoBuildPrim *prims, size_t count,
                          unsigned char *out, size_t *bytes)
{
    const CoMesh *mesh = context;
    Corners corners;
    share_points(mesh, prims, count, &corners);
    *bytes = co_leaf_size(count, corners.point_count);
    memset(out, 0, *bytes);
    out[0] = (unsigned char)corners.point_count;
    for (size_t c = 0; c < 3; c++)
        memcpy(out + 1 + c * count, corners.corner[c], count);
    out += co_leaf_tri_offset(count);
    for (size_t i = 0; i < count; i++, out += sizeof(uint32_t))
        memcpy(out, &prims[i].id, sizeof(uint32_t));
    for (size_t j = 0; j < corners.point_count; j++, out += sizeof(float))
        for (size_t k = 0; k < 3; k++)
            memcpy(out + k * corners.point_count * sizeof(float),
                   &mesh->points[3 * (size_t)corners.points[j] + k], sizeof(float));
    return CO_REF_LEAF | (uint32_t)(count - 1) << CO_REF_COUNT_SHIFT;
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
