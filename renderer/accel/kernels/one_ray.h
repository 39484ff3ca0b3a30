// One ray in the space of one object or group, ready for slab tests.
//
// Slabs are canonical and conservative. A plane's distance is (plane - org') * inv with org' moved
// against (near planes) or along (far planes) the direction by a padding that covers the rounding
// of the triangle test, of the instance transforms and of the slab arithmetic itself (see
// ray_prepare). Both roundings are monotone in the plane, so a box inside another never starts
// before it or ends after it: no tree can cull what the triangle's own box lets pass. Nodes are
// tested with fewer operations, plane * inv + c, and a little more padding: a node's slab contains
// the canonical slabs of all boxes within it.

#ifndef CO_ACCEL_KERNELS_ONE_RAY_H
#define CO_ACCEL_KERNELS_ONE_RAY_H

#include "accel/node.h"
#include "simd/four.h"
#include "simd/lane.h"

#define INFINITE __builtin_inff()

// What a ray in object space may be off by, in group space, in units of its origin's largest
// coordinate and of the distance to the far side of the group: less than 40 roundings of 2^-24.
#define CO_TRANSFORM_SLACK 0x1p-18f

// Lengths of directions that transforms may make: those between hold slabs that are floats.
// Components below 1e-18 of the largest, or that are nearly denormal, are taken as that: the
// padding keeps planes far enough that such a ray still passes all boxes which it touches.
#define CO_DIRECTION_LEAST 1e-29f
#define CO_DIRECTION_MOST 1e37f
#define CO_COMPONENT_LEAST 1e-37f

// Of every padding: among denormals rounding is no longer relative.
#define CO_LEAST_SLACK 0x1p-145f

typedef struct Ray {
    CoFour org, dir, inv;    // inv = 1 / dir, finite and never 0
    CoFour near_c, far_c;    // of a node's slabs
    const CoBvh *padded_for; // whose triangles `pad` is for, if it is for any
    float pad;               // of the canonical slabs of triangles
    float placed_pad;        // in a group: of those of instances
    float entry, exit;       // of the instances' boxes on the way here
    float from, to;          // where hits may lie, as far as is known
    float shear_x, shear_y;  // see triangle.h
    uint32_t major;          // axis of the largest direction component
    uint32_t near_row[3];    // rows of CoWideNode.planes; the far one is near_row ^ 1
    uint32_t slot;           // which ray of the group
    bool is_huge;            // a node's slabs may overflow: children are to be looked at
    bool is_fit;             // the direction is neither infinite nor zero
} Ray;

// A ray's slab constants, one value in all lanes, and where the planes it meets first and last
// stand in a node.
typedef struct Slab {
    CoLane inv[3], from;
    size_t near_at[3], far_at[3];
} Slab;

// The same, by how wide the slabs are padded.
typedef struct SlabEnds {
    CoLane near_c[3], far_c[3];
} SlabEnds;

static inline void slab_load(const Ray *ray, Slab *slab)
{
    for (int k = 0; k < 3; k++) {
        slab->inv[k] = co_lane_set1(ray->inv[k]);
        slab->near_at[k] = CO_NODE_WIDTH * (size_t)ray->near_row[k];
        slab->far_at[k] = slab->near_at[k] ^ CO_NODE_WIDTH;
    }
    slab->from = co_lane_set1(ray->from);
}

static inline void slab_ends(CoFour near_c, CoFour far_c, SlabEnds *ends)
{
    for (int k = 0; k < 3; k++) {
        ends->near_c[k] = co_lane_set1(near_c[k]);
        ends->far_c[k] = co_lane_set1(far_c[k]);
    }
}

// Tests the 8 children of a node up to `to`. Returns one bit per child that is entered and where.
// What is not a number does not cull.
static inline uint32_t slab_node(const CoWideNode *node, const Slab *slab, const SlabEnds *ends,
                                 CoLane to, float entry[CO_NODE_WIDTH])
{
    const float *planes = node->planes[0];
    uint32_t bits = 0;
    for (int i = 0; i < CO_NODE_WIDTH; i += CO_LANE_WIDTH) {
        CoLane near = slab->from, far = to, near_side[3], far_side[3];
        for (int k = 0; k < 3; k++) {
            CoLane near_plane = co_lane_load(planes + slab->near_at[k] + i);
            CoLane far_plane = co_lane_load(planes + slab->far_at[k] + i);
            near_side[k] = co_lane_muladd(near_plane, slab->inv[k], ends->near_c[k]);
            far_side[k] = co_lane_muladd(far_plane, slab->inv[k], ends->far_c[k]);
        }
        // Two steps, not three: this is what the next node waits for.
        near =
            co_lane_max(co_lane_max(near_side[1], near_side[2]), co_lane_max(near_side[0], near));
        far = co_lane_min(co_lane_min(far_side[1], far_side[2]), co_lane_min(far_side[0], far));
        co_lane_store(entry + i, near);
        bits |= co_lane_bits(co_lane_le(near, far)) << i;
    }
    return bits;
}

// Children that are there.
static inline uint32_t present_children(const CoWideNode *node)
{
    uint32_t bits = 0;
    for (uint32_t i = 0; i < CO_NODE_WIDTH; i++)
        bits |= (uint32_t)(node->child[i] != CO_REF_NONE) << i;
    return bits;
}

static inline float float_min(float a, float b)
{
    return a < b ? a : b;
}

static inline float float_max(float a, float b)
{
    return a > b ? a : b;
}

// Narrows [*from, *to] to a single box by the canonical arithmetic. False when nothing is left.
static inline bool slab_box(const Ray *ray, float pad, CoFour lo, CoFour hi, float *from, float *to)
{
    CoFour own = co_four_abs(ray->org) * 0x1p-23f;
    CoFour shift = co_four_copysign(own + pad, ray->inv);
    CoFourBits is_negative = ray->inv < co_four_set1(0.0f);
    CoFour near = (co_four_select(is_negative, hi, lo) - (ray->org + shift)) * ray->inv;
    CoFour far = (co_four_select(is_negative, lo, hi) - (ray->org - shift)) * ray->inv;
    *from = co_four_largest3(near, *from);
    *to = co_four_smallest3(far, *to);
    return *from <= *to;
}

static inline CoFour box_corner(const float v[3])
{
    return (CoFour){v[0], v[1], v[2], 0.0f};
}

// Takes a ray into an instance's space: org and dir, the latter not normalised, so that t is
// shared.
static inline void ray_transform(const Ray *ray, const CoAffine *to_object, Ray *out)
{
    CoFour column[4];
    for (int k = 0; k < 4; k++)
        column[k] = (CoFour){to_object->m[0][k], to_object->m[1][k], to_object->m[2][k], 0.0f};
    CoFour org = column[0] * ray->org[0] + column[1] * ray->org[1] + column[2] * ray->org[2];
    out->org = org + column[3];
    out->dir = column[0] * ray->dir[0] + column[1] * ray->dir[1] + column[2] * ray->dir[2];
}

// 1, 2, 0: without a branch, as no axis is likelier than another.
static inline uint32_t next_axis(uint32_t axis)
{
    return 9u >> 2 * axis & 3u;
}

// Derives what depends on the direction alone.
static inline void ray_set_direction(Ray *ray)
{
    CoFour dir = ray->dir, a = co_four_abs(dir);
    float largest = co_four_largest3(a, 0.0f);
    CoFour tiny = co_four_set1(float_max(largest * 1e-18f, CO_COMPONENT_LEAST));
    CoFour d = co_four_select(a < tiny, co_four_copysign(tiny, dir), dir);
    CoFourBits is_negative = d < co_four_set1(0.0f);
    uint32_t x_over_y = a[0] > a[1], x_over_z = a[0] > a[2], y_over_z = a[1] > a[2];
    uint32_t z = 2 - 2 * (x_over_y & x_over_z) - (~x_over_y & y_over_z);
    union {
        CoFour four;
        float axis[4];
    } from = {dir}, slope;
    slope.four = dir / co_four_set1(from.axis[z]);
    ray->inv = co_four_set1(1.0f) / d;
    for (uint32_t k = 0; k < 3; k++)
        ray->near_row[k] = 2 * k + (uint32_t)(is_negative[k] & 1);
    ray->major = z;
    ray->shear_x = slope.axis[next_axis(z)];
    ray->shear_y = slope.axis[next_axis(next_axis(z))];
    ray->is_fit = largest > CO_DIRECTION_LEAST && co_four_below3(a, CO_DIRECTION_MOST);
}

// The same for a ray whose direction is that of another.
static inline void ray_share_direction(const Ray *from, Ray *ray)
{
    ray->inv = from->inv;
    for (uint32_t k = 0; k < 3; k++)
        ray->near_row[k] = from->near_row[k];
    ray->major = from->major;
    ray->shear_x = from->shear_x;
    ray->shear_y = from->shear_y;
    ray->is_fit = from->is_fit;
}

// From a point to the farthest plane of a box.
static inline float box_distance(CoFour org, const CoBox *box)
{
    CoFour reach = co_four_max(org - box_corner(box->lo), co_four_set1(0.0f));
    reach = co_four_max(box_corner(box->hi) - org, reach);
    return float_min(co_four_largest3(reach, 0.0f), 3e38f);
}

// Of the canonical slabs, see ray_set_origin.
static inline float padding(float distance, float largest_org, float relative)
{
    return (distance * (0x1p-20f + relative) + largest_org * relative) + CO_LEAST_SLACK;
}

// Slabs of triangles are padded by what the box of their mesh asks for. That of a mesh in place is
// taken when a triangle may be hit.
static inline void pad_for(Ray *ray, const CoBvh *bvh)
{
    if (ray->padded_for == bvh)
        return;
    ray->padded_for = bvh;
    ray->pad = padding(box_distance(ray->org, &bvh->tree.box), 0.0f, 0.0f);
}

// False for a ray that a transform made infinite or zero: it hits nothing.
static inline bool ray_is_fit(const Ray *ray)
{
    return ray->is_fit && co_four_below3(co_four_abs(ray->org), 3e38f);
}

// Derives the constants for what lies in `box`. The padding is, in units of the largest distance D
// from the origin to a plane of the box: 6 x 2^-24 for the shear (a point is off by 2 D + 4 D
// units), 3 for the slab's own three roundings, rounded up to 16; plus two units of the origin's
// coordinate, so that adding it is never lost. `relative` adds what the transforms of instances
// below may be off by, in units of D and of the origin. A node's plane * inv + c is off by at most
// 4 units of the origin's coordinate and 6 of D, each times inv, if the product is rounded: 8 more
// of both. What may overflow becomes NaN, which never culls. Returns ray_is_fit. Always inline: it
// is done for every instance that a ray alone enters, and the compiler changes its mind.
static inline __attribute__((always_inline)) bool ray_set_origin(Ray *ray, const CoBox *box,
                                                                 float relative)
{
    const CoFour nan = co_four_set1(__builtin_nanf(""));
    CoFour org = ray->org, inv = ray->inv, size = co_four_abs(org);
    float distance = box_distance(org, box);
    ray->pad = ray->placed_pad = padding(distance, co_four_largest3(size, 0.0f), relative);
    ray->padded_for = NULL;
    CoFour reach = size + distance;
    CoFour rounding = size * 0x1p-23f + reach * 0x1p-21f;
    CoFour shift = co_four_copysign(rounding + (ray->pad + CO_LEAST_SLACK), inv);
    CoFourBits is_safe = reach * co_four_abs(inv) < co_four_set1(0x1p125f);
    ray->near_c = co_four_select(is_safe, (org + shift) * -inv, nan);
    ray->far_c = co_four_select(is_safe, (org - shift) * -inv, nan);
    ray->is_huge = !(is_safe[0] & is_safe[1] & is_safe[2]);
    return ray_is_fit(ray);
}

// The node constants for meshes that stand in a group as they are: as if all in `box` were one
// mesh.
static inline void ray_tight(const Ray *ray, const CoBox *box, CoFour *near_c, CoFour *far_c)
{
    CoFour org = ray->org, inv = ray->inv, size = co_four_abs(org);
    const CoFour nan = co_four_set1(__builtin_nanf(""));
    float distance = box_distance(org, box), pad = padding(distance, 0.0f, 0.0f);
    CoFour reach = size + distance;
    CoFour rounding = size * 0x1p-23f + reach * 0x1p-21f;
    CoFour shift = co_four_copysign(rounding + (pad + CO_LEAST_SLACK), inv);
    CoFourBits is_safe = reach * co_four_abs(inv) < co_four_set1(0x1p125f);
    *near_c = co_four_select(is_safe, (org + shift) * -inv, nan);
    *far_c = co_four_select(is_safe, (org - shift) * -inv, nan);
}

// Whether the identity changes no bit of the ray: it does where there is a minus zero.
static inline bool ray_is_plain(const Ray *ray)
{
    CoFourBits minus = (CoFourBits)ray->org == INT32_MIN;
    minus |= (CoFourBits)ray->dir == INT32_MIN;
    return !(minus[0] | minus[1] | minus[2]);
}

static inline bool ray_prepare(Ray *ray, const CoBox *box, float relative)
{
    ray_set_direction(ray);
    return ray_set_origin(ray, box, relative);
}

#endif
