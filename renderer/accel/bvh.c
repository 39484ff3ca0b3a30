#include "accel/build.h"

#include "accel/grid_leaf.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <string.h>

// Collects the distinct points of triangles; false when there are more than a leaf holds.
static bool distinct_points(const CoMesh *mesh, const CoBuildPrim *prims, size_t count,
                            uint32_t points[CO_LEAF_WIDTH], size_t *point_count)
{
    *point_count = 0;
    uint32_t tri[3];
    for (size_t i = 0; i < 3 * count; i++) {
        if (i % 3 == 0)
            co_mesh_triangle(mesh, prims[i / 3].id, tri);
        uint32_t point = tri[i % 3];
        size_t j = 0;
        while (j < *point_count && points[j] != point)
            j++;
        if (j < *point_count)
            continue;
        if (j == CO_LEAF_WIDTH)
            return false;
        points[(*point_count)++] = point;
    }
    return true;
}

static bool leaf_fits(const void *context, const CoBuildPrim *prims, size_t count, size_t *bytes)
{
    uint32_t points[CO_LEAF_WIDTH];
    size_t point_count;
    bool fits = distinct_points(context, prims, count, points, &point_count);
    *bytes = fits ? co_leaf_size(count, point_count) : 0;
    return fits;
}

static uint8_t find_point(const uint32_t *points, uint32_t point)
{
    uint8_t j = 0;
    while (points[j] != point)
        j++;
    return j;
}

static void pack_leaf(unsigned char *bytes, const CoMesh *mesh, const CoBuildPrim *prims,
                      size_t count, const uint32_t *points, size_t point_count)
{
    bytes[0] = (unsigned char)point_count;
    unsigned char *corner = bytes + 1;
    for (size_t i = 0; i < count; i++) {
        uint32_t tri[3];
        co_mesh_triangle(mesh, prims[i].id, tri);
        for (size_t c = 0; c < 3; c++)
            corner[c * count + i] = find_point(points, tri[c]);
    }
    bytes += co_leaf_tri_offset(count);
    for (size_t i = 0; i < count; i++, bytes += sizeof(uint32_t))
        memcpy(bytes, &prims[i].id, sizeof(uint32_t));
    for (size_t k = 0; k < 3; k++)
        for (size_t j = 0; j < point_count; j++, bytes += sizeof(float))
            memcpy(bytes, &mesh->points[3 * (size_t)points[j] + k], sizeof(float));
}

static uint32_t emit_leaf(const void *context, const CoBuildPrim *prims, size_t count,
                          unsigned char *out)
{
    uint32_t points[CO_LEAF_WIDTH];
    size_t point_count;
    distinct_points(context, prims, count, points, &point_count);
    memset(out, 0, co_leaf_size(count, point_count));
    pack_leaf(out, context, prims, count, points, point_count);
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
    CoLeafRule rule = {leaf_fits, emit_leaf, mesh, CO_LEAF_WIDTH};
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
