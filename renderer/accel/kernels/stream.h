// Many rays at once: the active ones of a group against the children of a node and the triangles of
// a leaf, CO_WIDE_WIDTH rays to a vector. The arithmetic of each ray is that of rays.h and
// triangle.h.
//
// Source: Tsakok 2009; Eisenacher et al. 2013, 3.1. The active rays are a 64-bit mask; vectors
// without an active ray are skipped.

#ifndef CO_ACCEL_KERNELS_STREAM_H
#define CO_ACCEL_KERNELS_STREAM_H

#include "accel/kernels/rays.h"
#include "accel/kernels/triangle.h"

#define WIDE_MASK ((uint64_t)(CO_WIDE_WIDTH == 64 ? ~0ull : (1ull << CO_WIDE_WIDTH) - 1u))

// What rays with the same signs have of slabs: rows of CoWideNode.planes that they enter by, and
// the constants of nodes.
typedef struct StreamSlabs {
    uint32_t near[3];
    const float (*near_c)[CO_RAYS_ROOM], (*far_c)[CO_RAYS_ROOM];
} StreamSlabs;

static inline StreamSlabs stream_slabs(const Rays *rays, uint32_t j)
{
    StreamSlabs slabs = {.near_c = rays->near_c, .far_c = rays->far_c};
    for (uint32_t k = 0; k < 3; k++)
        slabs.near[k] = 2 * k + (uint32_t)(rays->negative[k] >> j & 1u);
    return slabs;
}

// Rays of `active` whose direction has the signs of ray j's.
static inline uint64_t same_signs(const Rays *rays, uint64_t active, uint32_t j)
{
    for (int k = 0; k < 3; k++)
        active &= rays->negative[k] >> j & 1u ? rays->negative[k] : ~rays->negative[k];
    return active;
}

// Vectors [*first, 64) that hold an active ray, in turn: advances to the next. False when none is
// left.
static inline bool next_vector(uint64_t active, uint32_t *first)
{
    if (*first >= CO_GROUP_RAYS || active >> *first == 0)
        return false;
    *first += (uint32_t)__builtin_ctzll(active >> *first) & ~(uint32_t)(CO_WIDE_WIDTH - 1);
    return true;
}

// Bounds of rays with the same signs, for what has to be asked once for all of them: by row of
// CoWideNode.planes, least and most of 1 / dir and those times the outermost origin.
typedef struct Beam {
    float inv[2][3]; // least and most
    float near_c[2][3], far_c[2][3];
    float from, to;
    bool is_safe; // nothing overflows: it can be used
} Beam;

static inline float least_of(CoWide a)
{
    float lanes[CO_WIDE_WIDTH], least;
    co_wide_store(lanes, a);
    least = lanes[0];
    for (int i = 1; i < CO_WIDE_WIDTH; i++)
        least = float_min(lanes[i], least);
    return least;
}

static inline float most_of(CoWide a)
{
    return -least_of(co_wide_sub(co_wide_set1(0.0f), a));
}

// Of all rays whose direction has the signs of ray j's. A ray's own slabs are shifted by at
// most 1.5 of its padding and 5/8 of what is taken of its origin here; the rest covers the
// roundings of beam_node, which are 3 units of the largest origin and distance.
static inline void beam_load(const Rays *rays, uint32_t j, Beam *beam)
{
    const CoWide zero = co_wide_set1(0.0f);
    CoWide low[3], high[3], least[3], most[3], shift = zero;
    CoWide from = co_wide_set1(INFINITE), to = co_wide_set1(-INFINITE);
    CoWide sign[3];
    for (int k = 0; k < 3; k++) {
        sign[k] = co_wide_set1(rays->negative[k] >> j & 1u ? -1.0f : 1.0f);
        low[k] = least[k] = co_wide_set1(INFINITE);
        high[k] = most[k] = co_wide_set1(-INFINITE);
    }
    for (uint32_t i = 0; i < rays->count; i += CO_WIDE_WIDTH) {
        CoWide inv[3];
        for (int k = 0; k < 3; k++)
            inv[k] = co_wide_load(rays->inv[k] + i);
        CoWideMask is_in = co_wide_lt(zero, co_wide_mul(inv[0], sign[0]));
        is_in = co_wide_and(is_in, co_wide_lt(zero, co_wide_mul(inv[1], sign[1])));
        is_in = co_wide_and(is_in, co_wide_lt(zero, co_wide_mul(inv[2], sign[2])));
        CoWide pad = co_wide_load(rays->pad + i);
        pad = co_wide_add(pad, pad);
        for (int k = 0; k < 3; k++) {
            CoWide org = co_wide_load(rays->org[k] + i);
            CoWide own = co_wide_mul(co_wide_abs(org), co_wide_set1(0x1p-20f));
            shift = co_wide_max(co_wide_select(is_in, co_wide_add(pad, own), zero), shift);
            low[k] = co_wide_select(is_in, co_wide_min(org, low[k]), low[k]);
            high[k] = co_wide_select(is_in, co_wide_max(org, high[k]), high[k]);
            least[k] = co_wide_select(is_in, co_wide_min(inv[k], least[k]), least[k]);
            most[k] = co_wide_select(is_in, co_wide_max(inv[k], most[k]), most[k]);
        }
        from = co_wide_select(is_in, co_wide_min(co_wide_load(rays->from + i), from), from);
        to = co_wide_select(is_in, co_wide_max(co_wide_load(rays->to + i), to), to);
    }
    float margin = 2.0f * most_of(shift);
    beam->from = least_of(from);
    beam->to = most_of(to);
    beam->is_safe = true;
    for (int k = 0; k < 3; k++) {
        float lo = least_of(low[k]) - margin, hi = most_of(high[k]) + margin;
        bool is_negative = rays->negative[k] >> j & 1u;
        float near = is_negative ? lo : hi, far = is_negative ? hi : lo;
        beam->inv[0][k] = least_of(least[k]);
        beam->inv[1][k] = most_of(most[k]);
        for (int m = 0; m < 2; m++) {
            float reach =
                (__builtin_fabsf(lo) + __builtin_fabsf(hi)) * __builtin_fabsf(beam->inv[m][k]);
            beam->is_safe = beam->is_safe && reach < 0x1p120f;
            beam->near_c[m][k] = -near * beam->inv[m][k];
            beam->far_c[m][k] = -far * beam->inv[m][k];
        }
    }
}

// What became of a node: who enters each child, and in what order they are to be visited.
typedef struct StreamNode {
    _Alignas(64) uint64_t active[CO_NODE_WIDTH];
    uint16_t order[CO_NODE_WIDTH]; // all ones: no ray enters it
    uint32_t bits;                 // children that any ray enters
} StreamNode;

// The upper half of where the first ray enters, which orders as well as all of it (but for negative
// ones, which are merely visited in another order).
static inline void stream_order(const float entry[CO_NODE_WIDTH], uint16_t order[CO_NODE_WIDTH])
{
    uint32_t bits[CO_NODE_WIDTH];
    __builtin_memcpy(bits, entry, sizeof bits);
    for (int i = 0; i < CO_NODE_WIDTH; i++)
        order[i] = (uint16_t)(bits[i] >> 16);
}

// An entry whose order is all ones.
static inline CoLane nowhere(void)
{
    union {
        uint32_t u;
        float f;
    } bits = {~0u};
    return co_lane_set1(bits.f);
}

// Bounds of many rays against all children.
static inline void beam_node(const CoWideNode *node, const Beam *beam, const StreamSlabs *slabs,
                             uint64_t active, StreamNode *out)
{
    float entry[CO_NODE_WIDTH];
    out->bits = 0;
    for (int i = 0; i < CO_NODE_WIDTH; i += CO_LANE_WIDTH) {
        CoLane near = co_lane_set1(beam->from), far = co_lane_set1(beam->to);
        for (int k = 0; k < 3; k++) {
            CoLane plane = co_lane_load(node->planes[slabs->near[k]] + i), inv[2], ends[2];
            for (int m = 0; m < 2; m++) {
                inv[m] = co_lane_set1(beam->inv[m][k]);
                ends[m] = co_lane_muladd(plane, inv[m], co_lane_set1(beam->near_c[m][k]));
            }
            near = co_lane_max(co_lane_min(ends[0], ends[1]), near);
            plane = co_lane_load(node->planes[slabs->near[k] ^ 1u] + i);
            for (int m = 0; m < 2; m++)
                ends[m] = co_lane_muladd(plane, inv[m], co_lane_set1(beam->far_c[m][k]));
            far = co_lane_min(co_lane_max(ends[0], ends[1]), far);
        }
        CoLaneMask enters = co_lane_le(near, far);
        co_lane_store(entry + i, co_lane_select(enters, near, nowhere()));
        out->bits |= co_lane_bits(enters) << i;
    }
    for (int i = 0; i < CO_NODE_WIDTH; i++)
        out->active[i] = active;
    stream_order(entry, out->order);
}

// Triangles of a leaf whose boxes a ray may enter.
static inline uint32_t beam_leaf(const CoTriLeaf *leaf, uint32_t count, const Beam *beam,
                                 const StreamSlabs *slabs)
{
    uint32_t bits = 0;
    for (uint32_t i = 0; i < count; i += CO_WIDE_WIDTH) {
        CoWide near = co_wide_set1(beam->from), far = co_wide_set1(beam->to);
        for (int k = 0; k < 3; k++) {
            CoWide points[POINT_VECTORS], corner[3], ends[2];
            for (int p = 0; p < POINT_VECTORS; p++)
                points[p] = co_wide_load(leaf->points[k] + p * CO_WIDE_WIDTH);
            for (uint32_t c = 0; c < 3; c++)
                corner[c] = co_wide_lookup16(points, leaf->corner + c * leaf->row, i);
            CoWide lo = co_wide_min(co_wide_min(corner[0], corner[1]), corner[2]);
            CoWide hi = co_wide_max(co_wide_max(corner[0], corner[1]), corner[2]);
            CoWide first = slabs->near[k] & 1u ? hi : lo, last = slabs->near[k] & 1u ? lo : hi;
            for (int m = 0; m < 2; m++)
                ends[m] = co_wide_muladd(first, co_wide_set1(beam->inv[m][k]),
                                         co_wide_set1(beam->near_c[m][k]));
            near = co_wide_max(co_wide_min(ends[0], ends[1]), near);
            for (int m = 0; m < 2; m++)
                ends[m] = co_wide_muladd(last, co_wide_set1(beam->inv[m][k]),
                                         co_wide_set1(beam->far_c[m][k]));
            far = co_wide_min(co_wide_max(ends[0], ends[1]), far);
        }
        bits |= co_wide_bits(co_wide_le(near, far)) << i;
    }
    return bits & ((1u << count) - 1u);
}

// Few rays, each against all children.
static inline void stream_node(const CoWideNode *node, const Rays *rays, const StreamSlabs *slabs,
                               uint64_t active, StreamNode *out)
{
    enum {
        PARTS = CO_NODE_WIDTH / CO_LANE_WIDTH
    };
    CoLaneSets sets[PARTS];
    CoLane first[PARTS];
    float entry[CO_NODE_WIDTH];
    for (int p = 0; p < PARTS; p++) {
        sets[p] = co_lane_sets_empty();
        first[p] = nowhere();
    }
    for (; active; active &= active - 1) {
        uint32_t j = (uint32_t)__builtin_ctzll(active);
        for (int p = 0; p < PARTS; p++) {
            CoLane near = co_lane_set1(rays->from[j]), far = co_lane_set1(rays->to[j]);
            for (int k = 0; k < 3; k++) {
                const float *planes = node->planes[slabs->near[k]] + p * CO_LANE_WIDTH;
                const float *others = node->planes[slabs->near[k] ^ 1u] + p * CO_LANE_WIDTH;
                CoLane inv = co_lane_set1(rays->inv[k][j]);
                CoLane near_c = co_lane_set1(slabs->near_c[k][j]);
                CoLane far_c = co_lane_set1(slabs->far_c[k][j]);
                near = co_lane_max(co_lane_muladd(co_lane_load(planes), inv, near_c), near);
                far = co_lane_min(co_lane_muladd(co_lane_load(others), inv, far_c), far);
            }
            CoLaneMask enters = co_lane_le(near, far);
            first[p] = co_lane_select(enters, co_lane_min(first[p], near), first[p]);
            sets[p] = co_lane_sets_put(sets[p], enters, 1ull << j);
        }
    }
    out->bits = 0;
    for (int p = 0; p < PARTS; p++) {
        co_lane_sets_store(out->active + p * CO_LANE_WIDTH, sets[p]);
        co_lane_store(entry + p * CO_LANE_WIDTH, first[p]);
        uint32_t bits = co_lane_bits(co_lane_le(first[p], co_lane_set1(INFINITE)));
        out->bits |= bits << p * CO_LANE_WIDTH;
    }
    stream_order(entry, out->order);
}

// Rays of `active` that still enter child i of a node.
static inline uint64_t stream_child(const CoWideNode *node, uint32_t i, const Rays *rays,
                                    const StreamSlabs *slabs, uint64_t active)
{
    uint64_t left = 0;
    for (uint32_t j = 0; next_vector(active, &j); j += CO_WIDE_WIDTH) {
        CoWide near = co_wide_load(rays->from + j), far = co_wide_load(rays->to + j);
        for (int k = 0; k < 3; k++) {
            CoWide inv = co_wide_load(rays->inv[k] + j);
            CoWide near_plane = co_wide_set1(node->planes[slabs->near[k]][i]);
            CoWide far_plane = co_wide_set1(node->planes[slabs->near[k] ^ 1u][i]);
            near_plane = co_wide_muladd(near_plane, inv, co_wide_load(slabs->near_c[k] + j));
            far_plane = co_wide_muladd(far_plane, inv, co_wide_load(slabs->far_c[k] + j));
            near = co_wide_max(near_plane, near);
            far = co_wide_min(far_plane, far);
        }
        left |= (uint64_t)co_wide_bits(co_wide_le(near, far)) << j;
    }
    return left & active;
}

// What the canonical slabs of boxes have in common for a vector of rays.
typedef struct StreamBoxes {
    CoWide near_org[3], far_org[3], inv[3];
    uint32_t near_side[3]; // 1: rays enter by the high plane
} StreamBoxes;

static inline void stream_boxes(const Rays *rays, const StreamSlabs *slabs, uint32_t j, CoWide pad,
                                StreamBoxes *out)
{
    for (uint32_t k = 0; k < 3; k++) {
        CoWide org = co_wide_load(rays->org[k] + j), inv = co_wide_load(rays->inv[k] + j);
        CoWide shift = co_wide_mul(co_wide_abs(org), co_wide_set1(0x1p-23f));
        shift = co_wide_copysign(co_wide_add(shift, pad), inv);
        out->near_side[k] = slabs->near[k] & 1u;
        out->near_org[k] = co_wide_add(org, shift);
        out->far_org[k] = co_wide_sub(org, shift);
        out->inv[k] = inv;
    }
}

// Narrows [*from, *to] to a box, as slab_box has it. Returns rays for which something is left.
static inline uint32_t enter_box(const StreamBoxes *boxes, const CoBox *box, CoWide *from,
                                 CoWide *to)
{
    const float *planes[2] = {box->lo, box->hi};
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t side = boxes->near_side[k];
        CoWide near = co_wide_sub(co_wide_set1(planes[side][k]), boxes->near_org[k]);
        CoWide far = co_wide_sub(co_wide_set1(planes[side ^ 1u][k]), boxes->far_org[k]);
        *from = co_wide_max(co_wide_mul(near, boxes->inv[k]), *from);
        *to = co_wide_min(co_wide_mul(far, boxes->inv[k]), *to);
    }
    return co_wide_bits(co_wide_le(*from, *to));
}

// A leaf's points along CO_WIDE_WIDTH rays with the same major axis.
typedef struct StreamPoints {
    _Alignas(64) float x[CO_LEAF_WIDTH][CO_WIDE_WIDTH];
    float y[CO_LEAF_WIDTH][CO_WIDE_WIDTH], z[CO_LEAF_WIDTH][CO_WIDE_WIDTH];
} StreamPoints;

static inline void stream_points(const CoTriLeaf *leaf, const Rays *rays, uint32_t axis, uint32_t j,
                                 StreamPoints *out)
{
    uint32_t x = axis == 2 ? 0 : axis + 1, y = x == 2 ? 0 : x + 1;
    CoWide org_x = co_wide_load(rays->org[x] + j), org_y = co_wide_load(rays->org[y] + j);
    CoWide org_z = co_wide_load(rays->org[axis] + j);
    CoWide sx = co_wide_load(rays->shear_x + j), sy = co_wide_load(rays->shear_y + j);
    for (size_t i = 0; i < leaf->point_count; i++) {
        CoWide pz = co_wide_sub(co_wide_set1(leaf->points[axis][i]), org_z);
        CoWide px = co_wide_sub(co_wide_set1(leaf->points[x][i]), org_x);
        CoWide py = co_wide_sub(co_wide_set1(leaf->points[y][i]), org_y);
        co_wide_store(out->x[i], co_wide_sub(px, co_wide_mul(sx, pz)));
        co_wide_store(out->y[i], co_wide_sub(py, co_wide_mul(sy, pz)));
        co_wide_store(out->z[i], pz);
    }
}

// What the vector found of one triangle.
typedef struct StreamHits {
    _Alignas(64) float t[CO_WIDE_WIDTH], u[CO_WIDE_WIDTH], v[CO_WIDE_WIDTH];
    uint32_t unsure;
} StreamHits;

// Edge functions of triangle i. Returns rays whose line pierces it or may.
static inline uint32_t stream_pierce(const CoTriLeaf *leaf, uint32_t i, const StreamPoints *points,
                                     CoWide edge[3])
{
    const CoWide zero = co_wide_set1(0.0f);
    CoWide x[3], y[3];
    for (uint32_t c = 0; c < 3; c++) {
        uint32_t corner = co_leaf_corner(leaf, c, i);
        x[c] = co_wide_load(points->x[corner]);
        y[c] = co_wide_load(points->y[corner]);
    }
    for (int c = 0; c < 3; c++) {
        int p = (c + 2) % 3, q = (c + 1) % 3;
        edge[c] = co_wide_sub(co_wide_mul(x[p], y[q]), co_wide_mul(y[p], x[q]));
    }
    CoWide least = co_wide_min(co_wide_min(edge[0], edge[1]), edge[2]);
    CoWide most = co_wide_max(co_wide_max(edge[0], edge[1]), edge[2]);
    return ~co_wide_bits(co_wide_and(co_wide_lt(least, zero), co_wide_lt(zero, most)));
}

// A vector of rays along their major axis, and where what they may still hit lies.
typedef struct StreamLine {
    CoWide dir, sz; // 1 / dir
    CoWide from, to;
    CoWide size; // largest coordinate of the origin, where the mesh is flat
} StreamLine;

// See correct_distance.
static inline CoWide stream_correct(const CoWide x[3], const CoWide y[3], const CoWide z[3],
                                    CoWide inv, CoWide sum, const StreamLine *line)
{
    CoWide left[3], t = co_wide_mul(sum, line->sz);
    for (int c = 0; c < 3; c++) {
        int p = (c + 2) % 3, q = (c + 1) % 3;
        CoWide a = co_wide_mul(x[p], y[q]), b = co_wide_mul(y[p], x[q]);
        CoWide off = co_wide_sub(co_wide_residue(x[p], y[q], a), co_wide_residue(y[p], x[q], b));
        CoWide weight = co_wide_mul(co_wide_add(co_wide_sub(a, b), off), inv);
        left[c] = co_wide_mul(weight, co_wide_sub(z[c], sum));
    }
    left[0] = co_wide_add(co_wide_add(left[0], left[1]), left[2]);
    left[0] = co_wide_sub(left[0], co_wide_residue(t, line->dir, sum));
    return co_wide_add(t, co_wide_mul(left[0], line->sz));
}

// See is_depth_sure.
static inline CoWideMask stream_depth_is_sure(const CoWide x[3], const CoWide y[3],
                                              const CoWide z[3], CoWide sum, CoWide det)
{
    CoWide largest = co_wide_set1(0.0f);
    for (int c = 0; c < 3; c++) {
        int p = (c + 2) % 3, q = (c + 1) % 3;
        largest = co_wide_max(largest, co_wide_abs(co_wide_mul(x[p], y[q])));
    }
    CoWide extent =
        co_wide_add(co_wide_abs(co_wide_sub(z[1], z[0])), co_wide_abs(co_wide_sub(z[2], z[0])));
    CoWide size = co_wide_abs(det);
    largest = co_wide_add(largest, size);
    CoWide part = co_wide_mul(extent, co_wide_set1(CO_DEPTH_IS_SURE));
    CoWide depth = co_wide_max(co_wide_abs(sum), co_wide_mul(part, co_wide_set1(CO_NO_SLIVER)));
    return co_wide_lt(co_wide_mul(largest, part), co_wide_mul(depth, size));
}

// Not vast, see is_vast.
static inline CoWideMask stream_is_near(const CoWide x[3], const CoWide y[3], const CoWide z[3],
                                        CoWide sum, CoWide origin)
{
    CoWide far = co_wide_set1(0.0f);
    for (int c = 0; c < 3; c++)
        far = co_wide_max(
            co_wide_add(co_wide_add(co_wide_abs(x[c]), co_wide_abs(y[c])), co_wide_abs(z[c])), far);
    CoWide near = co_wide_max(co_wide_abs(sum), origin);
    return co_wide_lt(far, co_wide_mul(near, co_wide_set1(CO_VAST)));
}

// Where triangle i is on the rays `pierced`. Returns those that may hit it, see place_hit.
static inline uint32_t stream_place(const CoTriLeaf *leaf, uint32_t i, const StreamPoints *points,
                                    const StreamLine *line, uint32_t pierced, StreamHits *out)
{
    CoWide edge[3], x[3], y[3], z[3];
    stream_pierce(leaf, i, points, edge);
    CoWide det = co_wide_add(co_wide_add(edge[0], edge[1]), edge[2]), size = co_wide_abs(det);
    CoWideMask sure =
        co_wide_and(co_wide_lt(co_wide_set1(1e-30f), size), co_wide_lt(size, co_wide_set1(1e30f)));
    CoWide smallest = co_wide_min(co_wide_abs(edge[0]), co_wide_abs(edge[1]));
    smallest = co_wide_min(smallest, co_wide_abs(edge[2]));
    sure = co_wide_and(sure, co_wide_lt(co_wide_set1(0.0f), smallest));
    CoWide inv = co_wide_div(co_wide_set1(1.0f), det);
    for (uint32_t c = 0; c < 3; c++) {
        uint32_t corner = co_leaf_corner(leaf, c, i);
        x[c] = co_wide_load(points->x[corner]);
        y[c] = co_wide_load(points->y[corner]);
        z[c] = co_wide_load(points->z[corner]);
    }
    CoWide u = co_wide_mul(edge[1], inv), v = co_wide_mul(edge[2], inv);
    CoWide sum = co_wide_mul(u, co_wide_sub(z[1], z[0]));
    sum = co_wide_add(z[0], co_wide_add(sum, co_wide_mul(v, co_wide_sub(z[2], z[0]))));
    sure = co_wide_and(sure, stream_depth_is_sure(x, y, z, sum, det));
    if (leaf->is_flat)
        sure = co_wide_and(sure, stream_is_near(x, y, z, sum, line->size));
    CoWide less = co_wide_mul(sum, co_wide_mul(line->sz, co_wide_set1(CO_CORRECTED_LEAST)));
    CoWide more = co_wide_mul(sum, co_wide_mul(line->sz, co_wide_set1(CO_CORRECTED_MOST)));
    CoWide least = co_wide_min(less, more), most = co_wide_max(less, more);
    uint32_t off = co_wide_bits(co_wide_le(most, line->from));
    off |= co_wide_bits(co_wide_lt(line->to, least));
    pierced &= ~(off & co_wide_bits(sure));
    if (!pierced)
        return 0;
    CoWide t = stream_correct(x, y, z, inv, sum, line);
    co_wide_store(out->t, co_wide_max(co_wide_min(t, most), least));
    co_wide_store(out->u, u);
    co_wide_store(out->v, v);
    out->unsure = pierced & ~co_wide_bits(sure);
    return pierced;
}

// Decides by doubles whether ray `lane` of the vector hits triangle i.
static inline bool stream_pierce_lane(const CoTriLeaf *leaf, uint32_t i, const StreamPoints *points,
                                      float dir, uint32_t lane, StreamHits *hits)
{
    float corner[3][3];
    for (uint32_t c = 0; c < 3; c++) {
        uint32_t point = co_leaf_corner(leaf, c, i);
        corner[0][c] = points->x[point][lane];
        corner[1][c] = points->y[point][lane];
        corner[2][c] = points->z[point][lane];
    }
    Place at;
    if (!pierce_exactly((const float(*)[3])corner, dir, &at))
        return false;
    hits->t[lane] = at.t;
    hits->u[lane] = at.u;
    hits->v[lane] = at.v;
    return true;
}

#endif
