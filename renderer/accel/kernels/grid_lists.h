// Leaves that list patches or faces of coarse grids (grid_leaf.h), a block or two of them. Part of
// traverse.c.

#ifndef CO_ACCEL_KERNELS_GRID_LISTS_H
#define CO_ACCEL_KERNELS_GRID_LISTS_H

// Points of one that is near, in the order of its plan.
static inline void near_indices(const CoPatchTable *table, uint32_t patch, uint32_t out[8])
{
    uint32_t points[CO_PATCH_NEAR_POINTS];
    co_patch_near_points(table, patch, points);
    out[0] = points[0];
    out[1] = points[3];
    out[2] = points[1];
    out[3] = points[5];
    out[4] = points[4];
    out[5] = out[6] = out[7] = points[2];
}

// Up to 2 triangular patches with 2 squares a side, by plan.
static inline CoTriLeaf open_planned_pair(const CoBvh *bvh, const uint32_t *patches, uint32_t count,
                                          GridBlock *block)
{
    const CoPatchTable *table = bvh->patches;
    const CoGridPlan *plan = bvh->plans;
    const uint32_t second = patches[count > 1 ? 1 : 0];
    if (table->nears) {
        near_indices(table, patches[0], block->index);
        near_indices(table, second, block->index + 8);
    }
    for (uint32_t i = 0; !table->nears && i < CO_LEAF_WIDTH; i += CO_LANE_WIDTH) {
        const uint32_t patch = i < 8 ? patches[0] : second, at = i % 8;
        const uint32_t *words = table->words + (size_t)patch * table->stride;
        co_lane_along(words, plan->word + at, plan->step + at, block->index + i);
    }
    block->count = CO_GRID_LIST_TRIS;
    block->valid = count > 1 ? 0xffu : 0xfu;
    number_rows(block, patches[0] << table->unit_shift, second << table->unit_shift);
    CoTriLeaf leaf = gather_block(block, bvh->points);
    leaf.corner = plan->corner;
    return leaf;
}

// The same of any: their 6 points, row by row, and 4 triangles; one with 1 a side has the first
// triangle, of which the corners stand where that has them.
static inline CoTriLeaf open_triangles(const CoBvh *bvh, const uint32_t *patches, uint32_t count,
                                       GridBlock *block)
{
    const CoPatchTable *table = bvh->patches;
    const uint8_t corner[12] = {0x10, 0x31, 0x76, 0x97, 0x41, 0x42,
                                0xa7, 0xa8, 0x33, 0x54, 0x99, 0xba};
    uint32_t tri[2];
    memcpy(block->corner, corner, sizeof corner);
    block->count = CO_GRID_LIST_TRIS;
    block->valid = 0;
    for (uint32_t q = 0; q < 2; q++) {
        const uint32_t patch = patches[q < count ? q : 0];
        uint32_t room[CO_PATCH_WORDS];
        const uint32_t *words = co_patch_words(table, patch, room);
        const uint32_t m = 1u << co_patch_shift(table, words);
        uint32_t *index = block->index + 6 * q;
        for (uint32_t k = 0; k < 6; k++) {
            uint32_t i = k < 3 ? k : k < 5 ? k - 2 : 2, j = k < 3 ? 0 : k < 5 ? 1 : 2;
            i = i < m ? i : m;
            j = j < i ? j : i;
            co_patch_settle(table, words, m, &i, &j);
            index[k] = co_patch_point(table, words, m, i, j);
        }
        tri[q] = co_patch_first_tri(table, patch);
        block->valid |= (q < count ? m > 1 ? 15u : 1u : 0) << 4 * q;
    }
    for (uint32_t k = 12; k < CO_LEAF_WIDTH; k++)
        block->index[k] = block->index[0];
    number_rows(block, tri[0], tri[1]);
    return gather_block(block, bvh->points);
}

// Up to 4 faces of three corners and a center, which are fans of 3, or 2 with the middles of their
// edges, of 6 triangles.
static inline CoTriLeaf open_faces(const CoBvh *bvh, const uint32_t *faces, uint32_t count,
                                   GridBlock *block)
{
    const uint8_t fans[18] = {0x10, 0x42, 0x65, 0x98, 0xca, 0xed, 0x21, 0x50, 0x46,
                              0xa9, 0xd8, 0xce, 0x33, 0x73, 0x77, 0xbb, 0xfb, 0xff};
    const uint8_t quads[18] = {0x00, 0x11, 0x22, 0x77, 0x88, 0x99, 0x63, 0x64, 0x65,
                               0xda, 0xdb, 0xdc, 0x56, 0x36, 0x46, 0xcd, 0xad, 0xbd};
    const uint32_t room = bvh->patches->stride, step = co_grid_list_step(bvh->patches);
    const uint32_t own = 12 / step; // triangles of a face
    memcpy(block->corner, room > 4 ? quads : fans, sizeof fans);
    for (uint32_t q = 0; q < step; q++)
        co_patch_face_points(bvh->patches, faces[q < count ? q : 0], block->index + room * q);
    for (uint32_t i = room * step; i < CO_LEAF_WIDTH; i++)
        block->index[i] = block->index[0];
    block->count = 12;
    block->valid = (1u << own * (count < step ? count : step)) - 1u;
    block->first = own * faces[0];
    block->starts = 1;
    for (uint32_t q = 1; q < step && q < count; q++) {
        block->starts |= (uint16_t)(1u << own * q);
        block->skipped[q - 1] = own * (faces[q] - q) - block->first;
    }
    return gather_block(block, bvh->points);
}

static inline CoTriLeaf open_patches(const CoBvh *bvh, const uint32_t *patches, uint32_t count,
                                     GridBlock *block)
{
    if (co_grid_has_faces(bvh->patches))
        return open_faces(bvh, patches, count, block);
    if (bvh->plans)
        return open_planned_pair(bvh, patches, count, block);
    return open_triangles(bvh, patches, count, block);
}

static inline uint32_t open_list(const CoBvh *bvh, uint32_t ref, uint32_t patches[CO_LIST_PATCHES])
{
    const void *at = bvh->leaves + (size_t)(ref & CO_REF_LEAF_PLACE) * CO_LEAF_UNIT;
    return co_grid_list(at, patches);
}

static inline bool trace_list(Group *group, Ray *ray, const Shear *shear, const CoBvh *bvh,
                              uint32_t ref, uint32_t path)
{
    uint32_t patches[CO_LIST_PATCHES], count = open_list(bvh, ref, patches);
    const uint32_t step = co_grid_list_step(bvh->patches);
    GridBlock block;
    for (uint32_t k = 0; k < count; k += step) {
        const CoTriLeaf leaf = open_patches(bvh, patches + k, count - k, &block);
        if (trace_block(group, ray, shear, &leaf, block.valid, path))
            return true;
    }
    return false;
}

#endif
