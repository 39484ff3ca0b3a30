// Triangles in shards: where a box is much larger than what its triangle takes up of it, a tree is
// cheaper over several smaller boxes of the same triangle.
//
// A leaf keeps whole triangles, so a test of one gives the same hit in any of them. No hit is lost
// at a cut. The point where a kernel finds a triangle is off it by the rounding of its sheared
// corners, 6 units of 2^-24 of the distance to the far side of the mesh, and of t, 4 more; slabs
// are padded by 16, of which their own rounding takes 3 (kernels/one_ray.h: by a distance to the
// mesh, so that it does not matter how small a box is or how far from the triangle's corners). The
// nearest point of the triangle itself lies in one of its shards, as these cover it; hence the hit
// lies in that shard's padded box, t within its slab, and no node above it is culled before t.
// Where the triangle is cut, and how often, hits do not depend on.
//
// A refit would give leaves the boxes of whole triangles, for which the tree is no good: it is
// refused.
//
// Source: Ernst, Greiner 2007, "Early Split Clipping for Bounding Volume Hierarchies"; a budget
// that goes where it saves most: Karras, Aila 2013, "Fast Parallel Construction of High-Quality
// Bounding Volume Hierarchies", 5. Private to the builder.

#ifndef CO_ACCEL_SHARDS_H
#define CO_ACCEL_SHARDS_H

#include "accel/build.h"
#include "simd/lanes4.h"

enum {
    CO_SHARDS_BLOCK = 512 // triangles that are measured together
};

// The areas of the boxes of one block.
typedef struct CoBoxAreas {
    float sum, largest;
} CoBoxAreas;

// Of a box, three times.
static inline Co4 co_shards_area(Co4 lo, Co4 hi)
{
    Co4 size = co4_sub(hi, lo), sides = co4_mul(size, co4_yzx(size)), next = co4_yzx(sides);
    return co4_add(co4_add(sides, next), co4_yzx(next));
}

// A triangle as it is. Returns the area of its box, three times.
static inline Co4 co_shards_whole(const CoMesh *mesh, uint32_t id, CoBuildPrim *out)
{
    uint32_t tri[3];
    Co4 lo = co4_set1(INFINITY), hi = co4_set1(-INFINITY);
    co_mesh_triangle(mesh, id, tri);
    for (int c = 0; c < 3; c++) {
        Co4 p = co4_load3(mesh->points + 3 * (size_t)tri[c]);
        lo = co4_min(p, lo);
        hi = co4_max(p, hi);
    }
    co4_store3(out->lo, lo);
    co4_store3(out->hi, hi);
    out->id = id;
    return co_shards_area(lo, hi);
}

static inline size_t co_shards_blocks(size_t count)
{
    return (count + CO_SHARDS_BLOCK - 1) / CO_SHARDS_BLOCK;
}

// How many of them a thread takes at once.
static inline size_t co_shards_grain(size_t count)
{
    size_t blocks = co_shards_blocks(count);
    return co_build_threads(count) == 1 ? blocks : blocks / 256 + 1;
}

static inline size_t co_shards_block_end(size_t block, size_t count)
{
    size_t begin = block * CO_SHARDS_BLOCK;
    return count - begin < CO_SHARDS_BLOCK ? count : begin + CO_SHARDS_BLOCK;
}

// Replaces triangles by shards where that pays. prims[i] is the box of triangle i; the first shard
// takes its place, others follow all triangles, about 0.3 of their number, seldom 0.4. Meshes whose
// triangles are about as large as they are apart stay as they are. *are_shards: something has
// changed. False when memory ends; prims may be freed then. The same for any number of threads, all
// of which help.
bool co_shards_make(const CoMesh *mesh, const CoBoxAreas *areas, CoPrimArray *prims,
                    bool *are_shards);

#endif
