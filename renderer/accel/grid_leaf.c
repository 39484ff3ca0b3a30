#include "accel/grid_leaf.h"

#include "accel/grid_tile.h"
#include "simd/lanes4.h"

#include <stddef.h>
#include <string.h>

// Of both boxes, where two patches are one leaf.
#define PAIR_AREA 1.0

// The tiles of a leaf: of a pair two.
static void find_tiles(const CoPatchTable *table, const uint32_t *ids, size_t count,
                       CoGridTile tiles[2])
{
    for (size_t k = 0; k < count; k++)
        tiles[k] = co_grid_find_tile(table, ids[k]);
}

// Whether two patches are so close together that few rays enter the box of both for neither.
static bool is_pair_close(const CoBuildPrim prims[2])
{
    CoBox boxes[3];
    co_box_empty(&boxes[2]);
    for (int k = 0; k < 2; k++) {
        memcpy(boxes[k].lo, prims[k].lo, sizeof boxes[k].lo);
        memcpy(boxes[k].hi, prims[k].hi, sizeof boxes[k].hi);
        co_box_extend(&boxes[2], boxes[k].lo, boxes[k].hi);
    }
    return co_box_area(&boxes[2]) <= PAIR_AREA * (co_box_area(&boxes[0]) + co_box_area(&boxes[1]));
}

static bool is_far(const uint32_t *patches, size_t count)
{
    return patches[count - 1] - patches[0] > UINT16_MAX;
}

static size_t list_bytes(const uint32_t *patches, size_t count)
{
    if (is_far(patches, count))
        return sizeof(CoGridList) + (count - 1) * sizeof *patches;
    size_t bytes = offsetof(CoGridList, near) + (count - 1) * sizeof(uint16_t);
    return (bytes + CO_LEAF_UNIT - 1) & ~(size_t)(CO_LEAF_UNIT - 1);
}

static size_t write_list(const uint32_t *patches, size_t count, unsigned char *out)
{
    size_t bytes = list_bytes(patches, count), at = offsetof(CoGridList, near);
    bool far = is_far(patches, count);
    CoGridList list = {patches[0], (uint16_t)(far ? count | CO_LIST_FAR : count)};
    memcpy(out, &list, sizeof list);
    if (far) {
        memcpy(out + sizeof list, patches + 1, bytes - sizeof list);
        return bytes;
    }
    uint16_t near[CO_LIST_PATCHES] = {0};
    for (size_t k = 1; k < count; k++)
        near[k - 1] = (uint16_t)(patches[k] - patches[0]);
    memcpy(out + at, near, bytes - at);
    return bytes;
}

// Patches of level 0: their triangles, and the points these share.
typedef struct Numbered {
    CoLeafCorners corners;
    uint32_t tris[CO_LEAF_WIDTH], tri_count;
} Numbered;

static void put_triangle(Numbered *out, uint32_t tri, uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t corner[3] = {a, b, c};
    for (int k = 0; k < 3; k++)
        out->corners.corner[k][out->tri_count] = (uint8_t)corner[k];
    out->tris[out->tri_count++] = tri;
}

// False when they are more than a leaf holds.
static bool number_patches(const CoPatchTable *table, const uint32_t *patches, size_t count,
                           Numbered *out)
{
    Co16 points = co16_set1(UINT32_MAX); // no point has this number
    uint32_t point_count = 0;
    out->tri_count = 0;
    for (size_t k = 0; k < count; k++) {
        uint32_t room[CO_PATCH_WORDS];
        const uint32_t *words = co_patch_words(table, patches[k], room);
        const uint32_t tri = co_patch_first_tri(table, patches[k]);
        const uint32_t corners = co_patch_is_fan(table, words) ? 3 : 4;
        uint32_t at[4];
        for (uint32_t c = 0; c < corners; c++) {
            uint32_t same = co16_equal(&points, words[c]);
            if (!same && point_count == CO_LEAF_WIDTH)
                return false;
            if (!same)
                co16_put(&points, point_count, words[c]);
            at[c] = same ? (uint32_t)__builtin_ctz(same) : point_count++;
        }
        if (out->tri_count + corners - 2 > CO_LEAF_WIDTH)
            return false;
        put_triangle(out, tri, at[0], at[1], at[2]);
        if (corners == 4)
            put_triangle(out, tri + 1, at[0], at[2], at[3]);
    }
    co16_store(out->corners.points, &points);
    out->corners.point_count = point_count;
    return true;
}

// The lowest number of a point, or CO_GRID_FAR where others are not near it.
static uint32_t find_base(const CoLeafCorners *corners)
{
    uint32_t low = UINT32_MAX, high = 0;
    for (uint32_t k = 0; k < corners->point_count; k++) {
        low = corners->points[k] < low ? corners->points[k] : low;
        high = corners->points[k] > high ? corners->points[k] : high;
    }
    return high - low <= UINT16_MAX ? low : CO_GRID_FAR;
}

static bool numbered_fits(const CoMesh *mesh, CoLeafShape *out)
{
    Numbered leaf;
    if (!number_patches(mesh->patches, out->ids, out->count, &leaf))
        return false;
    const uint32_t count = leaf.corners.point_count;
    bool is_far = find_base(&leaf.corners) == CO_GRID_FAR;
    size_t bytes = sizeof(uint32_t) * (1 + (is_far ? count : (count + 1) / 2));
    out->bytes = (uint32_t)co_leaf_bytes(leaf.tris, leaf.tri_count, bytes);
    return true;
}

static size_t write_numbered(const CoMesh *mesh, const uint32_t *patches, size_t count,
                             unsigned char *out)
{
    const unsigned char *begin = out;
    Numbered leaf;
    number_patches(mesh->patches, patches, count, &leaf);
    const uint32_t base = find_base(&leaf.corners), point_count = leaf.corners.point_count;
    bool is_near = co_leaf_is_near(leaf.tris, leaf.tri_count);
    const uint32_t first = leaf.tris[0] | (is_near ? CO_LEAF_NEAR : 0);
    uint16_t near[CO_LEAF_WIDTH] = {0};
    for (uint32_t k = 0; k < point_count; k++)
        near[k] = (uint16_t)(leaf.corners.points[k] - base);
    out = co_leaf_put_corners(out, &leaf.corners, leaf.tri_count);
    memcpy(out, &first, sizeof first);
    memcpy(out + sizeof first, &base, sizeof base);
    out += sizeof first + sizeof base;
    size_t bytes = base == CO_GRID_FAR ? 4 * point_count : (point_count + 1) / 2 * 4;
    memcpy(out, base == CO_GRID_FAR ? (const void *)leaf.corners.points : near, bytes);
    return (size_t)(co_leaf_put_runs(out + bytes, leaf.tris, leaf.tri_count) - begin);
}

static void approach(const void *context, const CoBuildPrim *prims, size_t count)
{
    const CoPatchTable *table = ((const CoMesh *)context)->patches;
    for (size_t i = 0; i < count; i++)
        co_patch_approach(table, prims[i].id);
}

static bool leaf_fits(const void *context, const CoBuildPrim *prims, size_t count, CoLeafShape *out)
{
    const CoMesh *mesh = context;
    out->count = (uint32_t)count;
    out->ref = CO_REF_LEAF;
    for (size_t k = 0; k < count; k++)
        out->ids[k] = prims[k].id;
    co_leaf_sort(out->ids, count);
    if (co_grid_is_numbered(mesh->patches))
        return numbered_fits(mesh, out);
    if (co_grid_is_block(mesh->patches)) {
        out->ref |= prims[0].id;
        out->bytes = 0;
    } else if (co_grid_is_list(mesh->patches)) {
        out->bytes = (uint32_t)list_bytes(out->ids, count);
    } else {
        CoGridTile tiles[2];
        if (count > 1 && !is_pair_close(prims))
            return false;
        find_tiles(mesh->patches, out->ids, count, tiles);
        out->bytes = (uint32_t)co_grid_tile_bytes(mesh->patches, tiles, count);
    }
    return true;
}

static size_t emit_leaf(const void *context, const uint32_t *ids, size_t count, unsigned char *out)
{
    const CoMesh *mesh = context;
    if (co_grid_is_numbered(mesh->patches))
        return write_numbered(mesh, ids, count, out);
    if (co_grid_is_list(mesh->patches))
        return write_list(ids, count, out);
    CoGridTile tiles[2];
    size_t bytes;
    find_tiles(mesh->patches, ids, count, tiles);
    co_grid_write_tiles(mesh, tiles, count, out, &bytes);
    return bytes;
}

// Faces are not worth a second block: they take few bytes as it is.
static size_t list_size(const CoPatchTable *table)
{
    return (co_grid_has_faces(table) ? 1 : 2) * co_grid_list_step(table);
}

CoLeafRule co_grid_rule(const CoMesh *mesh)
{
    const CoPatchTable *table = mesh->patches;
    CoLeafRule rule = {leaf_fits, emit_leaf, NULL, NULL, mesh, 1, CO_NODE_WIDTH};
    if (co_grid_is_numbered(table)) {
        bool has_pairs = table->unit_shift > 0 && !table->first_tri;
        rule.approach = approach;
        rule.most = has_pairs ? CO_LEAF_WIDTH / 2 : CO_LEAF_WIDTH;
        rule.flat = 0;
    } else if (co_grid_is_list(table)) {
        rule.most = list_size(table);
        rule.flat = 0;
    } else if (co_grid_is_paired(table)) {
        rule.most = 2;
        rule.flat = 0;
    }
    return rule;
}

static CoBox numbered_box(const CoMesh *mesh, const unsigned char *leaf)
{
    const uint32_t count = (leaf[0] >> 4) + 1u;
    const uint32_t *words = (const void *)(leaf + co_leaf_first((leaf[0] & 15u) + 1u));
    uint32_t points[CO_LEAF_WIDTH];
    CoBox box;
    co_box_empty(&box);
    co_grid_points(words + 1, count, mesh->point_count - 1, points);
    for (uint32_t k = 0; k < count; k++)
        co_grid_extend(mesh, points[k], &box);
    return box;
}

CoBox co_grid_refit(const CoMesh *mesh, uint32_t ref, unsigned char *leaves)
{
    const CoPatchTable *table = mesh->patches;
    unsigned char *leaf = leaves + CO_LEAF_UNIT * (size_t)(ref & CO_REF_LEAF_PLACE);
    if (co_grid_is_block(table))
        return co_grid_box(mesh, ref & ~CO_REF_LEAF);
    if (co_grid_is_numbered(table))
        return numbered_box(mesh, leaf);
    if (co_grid_is_list(table)) {
        CoBox all;
        uint32_t patches[CO_LIST_PATCHES];
        uint32_t count = co_grid_list((const CoGridList *)(const void *)leaf, patches);
        co_box_empty(&all);
        for (uint32_t k = 0; k < count; k++) {
            CoBox box = co_grid_box(mesh, patches[k]);
            co_box_extend(&all, box.lo, box.hi);
        }
        return all;
    }
    const CoGridLeaf *old = (const CoGridLeaf *)(const void *)leaf;
    uint32_t room[CO_PATCH_WORDS];
    CoGridTile tiles[2] = {{.patch = old->patch}};
    tiles[0].shift = co_patch_shift(table, co_patch_words(table, old->patch, room));
    if (old->blocks & CO_TILE_PLACED) {
        tiles[0].i = old->at[0];
        tiles[0].j = old->at[1];
    }
    const size_t count = co_grid_is_pair(old) ? 2 : 1;
    if (count > 1)
        tiles[1] = co_grid_find_tile(table, co_grid_second(old));
    size_t bytes;
    return co_grid_write_tiles(mesh, tiles, count, leaf, &bytes);
}

void co_grid_attach(CoBvh *bvh, const CoMesh *mesh)
{
    bvh->patches = mesh->patches;
    bvh->points = mesh->points;
    bvh->last_point = mesh->point_count - 1;
    bvh->plans = co_grid_plans(mesh->patches);
    bvh->grid = co_grid_is_numbered(mesh->patches) ? CO_GRID_NUMBERED
                : co_grid_is_list(mesh->patches)   ? CO_GRID_LIST
                : co_grid_is_block(mesh->patches)  ? CO_GRID_BLOCK
                                                   : CO_GRID_TILE;
    bvh->block_shift = co_grid_block_shift(mesh->patches);
    if (co_grid_is_block(mesh->patches)) {
        bvh->leaf_at = (const void *)mesh->patches->words;
        bvh->leaf_stride = mesh->patches->stride * sizeof *mesh->patches->words >> bvh->block_shift;
    }
}
