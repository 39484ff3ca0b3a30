// Traversal of groups of up to 64 rays, and of single ones.
//
// Source: Eisenacher et al. 2013, 3.1; Tsakok 2009. A group goes down a tree with one 64-bit mask
// of active rays per node, so that a node is fetched once for all of them. How many are active is
// the measure of coherence: it decides whether bounds of all, or each of them, are tested against a
// node's children. Compiled once per instruction set.

#include "accel/kernels/traverse.h"
#include "accel/kernels/stream.h"

enum {
    NARROW_MOST = 32,     // active rays up to which each is tested against all children at once
    LEAF_SINGLE_MOST = 8, // to a leaf, up to which each is tested against all triangles,
    VECTOR_SINGLE_MOST = CO_WIDE_WIDTH > 8 ? 6 : 4, // and to a vector of rays
    SCATTERED_OCTANTS = 4, // signs of directions from which on rays go alone, if they go far apart
    LATE_MOST = 8,         // to a node or leaf, up to which it is asked for before it is looked at
    LATE_PLACES = 4,       // such that are asked for at a time
    LATE_STACK = 64        // nodes on a stack up to which anything is put off
};

// Of a group, by slot.
typedef struct Group {
    const CoAccelScene *scene;
    CoTraverseStats *stats;
    float tnear[CO_GROUP_RAYS];
    float best_t[CO_GROUP_RAYS]; // first tfar; -inf for an occlusion ray that is blocked
    float best_u[CO_GROUP_RAYS], best_v[CO_GROUP_RAYS];
    float best_path[CO_GROUP_RAYS], best_tri[CO_GROUP_RAYS]; // numbers, see id_lane
    uint64_t found, occlusion;                               // one bit per slot
    const uint8_t *flags;                                    // by slot, or NULL
    const CoRayHit *after; // of a single ray: hits up to this one do not count; NULL: all do
} Group;

#include "accel/kernels/options.h"

// Numbers that go where lanes go: as the bits of floats.
static inline float id_lane(uint32_t id)
{
    union {
        uint32_t u;
        float f;
    } bits = {id};
    return bits.f;
}

static inline uint32_t lane_id(float lane)
{
    union {
        float f;
        uint32_t u;
    } bits = {lane};
    return bits.u;
}

// A tree in the space of the rays: of a mesh, or else the top of a group.
typedef struct Walk {
    const CoTree *tree;
    const CoBvh *bvh;
    const CoObject *object;
    uint32_t path;    // of the mesh; first one of the group
    bool is_placed;   // a mesh that stands in a group as it is: the rays are those of the group
    bool is_in_place; // nothing below is transformed
} Walk;

static inline void count_nodes(Group *group, const Walk *walk, uint32_t fetched, uint32_t tested)
{
    if (walk->bvh) {
        group->stats->bottom_nodes += tested;
    } else {
        group->stats->top_nodes_grouped += fetched;
        group->stats->top_nodes_single += tested;
    }
}

typedef struct Hit {
    Place at;
    uint32_t path, tri;
} Hit;

// Not behind its start, nor what it has met.
static inline bool is_within_ray(const Group *group, uint32_t slot, float t)
{
    return t > start_of(group, slot) && t <= group->best_t[slot];
}

static inline bool is_after(const Hit *hit, const CoRayHit *after)
{
    return hit->path > after->instance || (hit->path == after->instance && hit->tri > after->tri);
}

// Offers a hit to a ray, which ends at `exit` at the latest, and sets where it ends now, before
// that is known to the last bit. Returns true when the ray needs no more.
static inline __attribute__((always_inline)) bool offer_hit(Group *group, uint32_t slot,
                                                            const Hit *hit, float exit, float *to)
{
    float best = group->best_t[slot];
    if (!is_within_ray(group, slot, hit->at.t) || (group->after && !is_after(hit, group->after)))
        return false;
    // Before the first hit best is tfar with ids 0, which no tie is below.
    if (hit->at.t == best && (hit->path > lane_id(group->best_path[slot]) ||
                              (hit->path == lane_id(group->best_path[slot]) &&
                               hit->tri >= lane_id(group->best_tri[slot]))))
        return false;
    group->found |= 1ull << slot;
    if (group->occlusion >> slot & 1u) {
        group->best_t[slot] = *to = -INFINITE;
        return true;
    }
    group->best_t[slot] = hit->at.t;
    group->best_u[slot] = hit->at.u;
    group->best_v[slot] = hit->at.v;
    group->best_path[slot] = id_lane(hit->path);
    group->best_tri[slot] = id_lane(hit->tri);
    *to = float_min(exit, hit->at.most);
    return false;
}

static inline CoTriLeaf open_leaf(const CoBvh *bvh, uint32_t ref, uint32_t *count)
{
    CoTriLeaf leaf = co_leaf_open(bvh->leaves + (size_t)(ref & CO_REF_LEAF_PLACE) * CO_LEAF_UNIT);
    *count = leaf.count;
    return leaf;
}

// Offers a ray the triangles `pierced` of a leaf. Returns true when it needs no more. Always
// inline, as is what tests a ray against a leaf: to spill registers for calls costs as much as the
// test.
static inline __attribute__((always_inline)) bool
offer_pierced(Group *group, Ray *ray, const CoTriLeaf *leaf, const Shear *shear, uint32_t pierced,
              uint32_t path, const LeafHits *hits, const bool is_flat)
{
    const uint32_t slot = ray->slot;
    for (; pierced; pierced &= pierced - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(pierced);
        Hit hit = {.path = path};
        if (!place_hit(leaf, shear, i, hits, start_of(group, slot), group->best_t[slot], is_flat,
                       &hit.at) ||
            !clamp_hit(leaf, ray, i, &hit.at) || !is_within_ray(group, slot, hit.at.t))
            continue;
        hit.tri = co_leaf_tri(leaf, i);
        if (offer_hit(group, slot, &hit, ray->exit, &ray->to))
            return true;
    }
    return false;
}

#include "accel/kernels/grid_blocks.h"

// Clamps what a vector of rays found of triangle i, as clamp_hit does. Returns those of `pierced`
// that pass and do not end before.
static inline uint32_t clamp_vector(const Rays *rays, uint32_t j, const StreamBoxes *boxes,
                                    const CoTriLeaf *leaf, uint32_t i, uint32_t pierced,
                                    StreamHits *hits)
{
    CoBox box;
    CoWide from = co_wide_load(rays->entry + j), to = co_wide_load(rays->exit + j);
    for (int k = 0; k < 3; k++) {
        const float *points = leaf->points[k];
        float a = points[co_leaf_corner(leaf, 0, i)], b = points[co_leaf_corner(leaf, 1, i)];
        float c = points[co_leaf_corner(leaf, 2, i)];
        box.lo[k] = float_min(float_min(a, b), c);
        box.hi[k] = float_max(float_max(a, b), c);
    }
    pierced &= enter_box(boxes, &box, &from, &to);
    CoWide t = co_wide_max(co_wide_min(co_wide_load(hits->t), to), from);
    co_wide_store(hits->t, t);
    return pierced & co_wide_bits(co_wide_le(t, co_wide_load(rays->to + j)));
}

// Offers what rays of the vector at j found of a triangle, one by one. Returns those that need no
// more.
static inline uint32_t offer_each(Group *group, Rays *rays, uint32_t j, uint32_t pierced,
                                  const StreamHits *hits, uint32_t path, uint32_t tri)
{
    uint32_t done = 0;
    rays->nearer |= (uint64_t)pierced << j;
    for (; pierced; pierced &= pierced - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(pierced), at = j + lane;
        float t = hits->t[lane];
        Hit hit = {{t, hits->u[lane], hits->v[lane], t, t}, path, tri};
        if (offer_hit(group, rays->slot[at], &hit, rays->exit[at], &rays->to[at]))
            done |= 1u << lane;
    }
    rays->done |= (uint64_t)done << j;
    return done;
}

// The same, at once where no hit is as near as the one before, as offer_hit has it.
static inline uint32_t offer_vector(Group *group, Rays *rays, uint32_t j, uint32_t pierced,
                                    const StreamHits *hits, uint32_t path, uint32_t tri)
{
    if (!rays->is_in_order || (uint32_t)(group->occlusion >> j) & pierced)
        return offer_each(group, rays, j, pierced, hits, path, tri);
    CoWide t = co_wide_load(hits->t), best = co_wide_load(group->best_t + j);
    pierced &= co_wide_bits(co_wide_lt(starts_of(group, j), t));
    uint32_t nearer = pierced & co_wide_bits(co_wide_lt(t, best));
    uint32_t tied = pierced & ~co_wide_bits(co_wide_ne(t, best));
    CoWideMask mask = co_wide_mask(nearer);
    const CoWide from[6] = {t,
                            t,
                            co_wide_load(hits->u),
                            co_wide_load(hits->v),
                            co_wide_set1(id_lane(path)),
                            co_wide_set1(id_lane(tri))};
    float *const to[6] = {rays->to + j,      group->best_t + j,    group->best_u + j,
                          group->best_v + j, group->best_path + j, group->best_tri + j};
    for (int k = 0; k < 6; k++)
        co_wide_store(to[k], co_wide_select(mask, from[k], co_wide_load(to[k])));
    group->found |= (uint64_t)nearer << j;
    rays->nearer |= (uint64_t)nearer << j;
    return tied ? offer_each(group, rays, j, tied, hits, path, tri) : 0;
}

// Of `triangles` those that rays `active` of a vector pierce or may, and which do. No branch is
// taken on what cannot be guessed.
static inline uint32_t list_pierced(const CoTriLeaf *leaf, const StreamPoints *points,
                                    uint32_t active, uint32_t triangles,
                                    uint32_t pierced[CO_LEAF_WIDTH])
{
    uint32_t any = 0;
    for (; triangles; triangles &= triangles - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(triangles);
        CoWide edge[3];
        pierced[i] = stream_pierce(leaf, i, points, edge) & active;
        any |= (uint32_t)(pierced[i] != 0) << i;
    }
    return any;
}

// As stream_pierce_lane, for the ray at j + lane of a flat mesh.
static __attribute__((noinline)) bool stream_flat_lane(const CoTriLeaf *leaf, uint32_t i,
                                                       const StreamPoints *points, const Rays *rays,
                                                       uint32_t j, uint32_t lane, StreamHits *hits)
{
    float corner[3][3];
    uint32_t point[3];
    Shear shear;
    rays_shear(rays, j + lane, &shear);
    for (uint32_t c = 0; c < 3; c++) {
        point[c] = co_leaf_corner(leaf, c, i);
        corner[0][c] = points->x[point[c]][lane];
        corner[1][c] = points->y[point[c]][lane];
        corner[2][c] = points->z[point[c]][lane];
    }
    Place at;
    if (!pierce_unsure(leaf, &shear, point, (const float(*)[3])corner, true, &at))
        return false;
    hits->t[lane] = at.t;
    hits->u[lane] = at.u;
    hits->v[lane] = at.v;
    return true;
}

// The rays `active` of the vector at j, which share a major axis, against triangles of a leaf.
static void stream_leaf_vector(Group *group, Rays *rays, const StreamSlabs *slabs, uint32_t j,
                               uint32_t active, uint32_t axis, const Walk *walk,
                               const CoTriLeaf *leaf, uint32_t triangles)
{
    StreamPoints points;
    StreamBoxes boxes;
    StreamHits hits;
    uint32_t rays_of[CO_LEAF_WIDTH];
    stream_points(leaf, rays, axis, j, &points);
    uint32_t any = list_pierced(leaf, &points, active, triangles, rays_of);
    if (!any)
        return;
    StreamLine line = {.dir = co_wide_load(rays->dir[axis] + j),
                       .sz = co_wide_load(rays->inv[axis] + j),
                       .from = rays->is_in_order ? starts_of(group, j) : co_wide_set1(-INFINITE)};
    line.size = co_wide_set1(0.0f);
    for (int k = 0; k < 3 && leaf->is_flat; k++)
        line.size = co_wide_max(co_wide_abs(co_wide_load(rays->org[k] + j)), line.size);
    const bool is_placed = walk->is_placed;
    stream_boxes(rays, slabs, j, co_wide_load((is_placed ? rays->placed_pad : rays->pad) + j),
                 &boxes);
    for (; any; any &= any - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(any), pierced = rays_of[i] & active;
        line.to = co_wide_load(rays->to + j);
        pierced = stream_place(leaf, i, &points, &line, pierced, &hits);
        if (!pierced)
            continue;
        for (uint32_t unsure = hits.unsure; unsure; unsure &= unsure - 1) {
            uint32_t lane = (uint32_t)__builtin_ctz(unsure);
            bool is_met =
                leaf->is_flat
                    ? stream_flat_lane(leaf, i, &points, rays, j, lane, &hits)
                    : stream_pierce_lane(leaf, i, &points, rays->dir[axis][j + lane], lane, &hits);
            if (!is_met)
                pierced &= ~(1u << lane);
        }
        pierced = clamp_vector(rays, j, &boxes, leaf, i, pierced, &hits);
        active &= ~offer_vector(group, rays, j, pierced, &hits, walk->path, co_leaf_tri(leaf, i));
    }
}

// What rays of a group ask of a leaf with.
typedef struct StreamAsk {
    Group *group;
    Rays *rays;
    const Walk *walk;
    const StreamSlabs *slabs;
    const Beam *beam;
} StreamAsk;

// Ray j on its own where a walk has brought it.
static inline void take_single(const Rays *rays, uint32_t j, const StreamSlabs *slabs,
                               const Walk *walk, Ray *ray)
{
    rays_single(rays, j, ray);
    if (!walk->is_placed)
        return;
    for (int k = 0; k < 3; k++) {
        ray->near_c[k] = slabs->near_c[k][j];
        ray->far_c[k] = slabs->far_c[k][j];
    }
    pad_for(ray, walk->bvh);
}

// Ray j alone against triangles of a leaf.
static inline __attribute__((always_inline)) void
stream_leaf_ray(Group *group, Rays *rays, uint32_t j, const Walk *walk, const CoTriLeaf *leaf,
                uint32_t count, uint32_t triangles, const bool is_flat)
{
    LeafHits hits;
    Shear shear;
    Ray ray;
    rays_shear(rays, j, &shear);
    group->stats->triangles += count;
    const float *const points[3] = {leaf->points[shear.x], leaf->points[shear.y],
                                    leaf->points[shear.z]};
    shear_rows(leaf, points, &shear, &hits);
    uint32_t pierced = pierce_triangles(leaf, count, &hits) & triangles;
    if (!pierced)
        return;
    rays_clamping(rays, j, walk->is_placed, &ray);
    offer_pierced(group, &ray, leaf, &shear, pierced, walk->path, &hits, is_flat);
    rays_settle(rays, j, ray.to);
}

// Many rays against `triangles` among the first `count` of a leaf, those by vectors that have
// company along their major axis. Returns the others, and what triangles these may meet.
static __attribute__((noinline)) uint64_t stream_leaf_many(const StreamAsk *ask, uint64_t active,
                                                           const CoTriLeaf *leaf, uint32_t count,
                                                           uint32_t *triangles)
{
    Rays *rays = ask->rays;
    uint64_t others = 0;
    if (ask->beam->is_safe)
        *triangles &= beam_leaf(leaf, count, ask->beam, ask->slabs);
    const uint32_t left = (uint32_t)__builtin_popcount(*triangles);
    for (uint32_t axis = 0; axis < 3 && left; axis++) {
        uint64_t along = active & rays->along[axis];
        for (uint32_t j = 0; next_vector(along, &j); j += CO_WIDE_WIDTH) {
            uint32_t bits = (uint32_t)(along >> j & WIDE_MASK);
            if (__builtin_popcount(bits) <= VECTOR_SINGLE_MOST) {
                others |= (uint64_t)bits << j;
                continue;
            }
            ask->group->stats->triangles += left * (uint32_t)__builtin_popcount(bits);
            stream_leaf_vector(ask->group, rays, ask->slabs, j, bits, axis, ask->walk, leaf,
                               *triangles);
        }
    }
    return others;
}

// Rays `active` against `triangles` among the first `count` of a leaf.
static inline __attribute__((always_inline)) void
stream_triangles(const StreamAsk *ask, uint64_t active, const CoTriLeaf *leaf, uint32_t count,
                 uint32_t triangles, const bool is_flat)
{
    if (__builtin_popcountll(active) > LEAF_SINGLE_MOST)
        active = stream_leaf_many(ask, active, leaf, count, &triangles);
    for (; active; active &= active - 1)
        stream_leaf_ray(ask->group, ask->rays, (uint32_t)__builtin_ctzll(active), ask->walk, leaf,
                        count, triangles, is_flat);
}

// A leaf of a flat mesh. In a function of its own, so that others do not pay for it.
static __attribute__((noinline)) void stream_flat_leaf(const StreamAsk *ask, uint64_t active,
                                                       uint32_t ref)
{
    uint32_t count;
    CoTriLeaf leaf = open_leaf(ask->walk->bvh, ref, &count);
    leaf.is_flat = true;
    stream_triangles(ask, active, &leaf, count, (1u << count) - 1u, true);
}

#include "accel/kernels/grid_stream.h"

// In a function of its own: what goes from node to node would spill its registers for it.
static __attribute__((noinline)) void stream_leaf(const StreamAsk *ask, uint64_t active,
                                                  uint32_t ref)
{
    if (ask->walk->bvh->patches) {
        stream_grid_leaf(ask, active, ref);
        return;
    }
    if (ask->walk->bvh->is_flat) {
        stream_flat_leaf(ask, active, ref);
        return;
    }
    uint32_t count;
    const CoTriLeaf leaf = open_leaf(ask->walk->bvh, ref, &count);
    stream_triangles(ask, active, &leaf, count, (1u << count) - 1u, false);
}

#include "accel/kernels/single.h"

// Rays `active` of a group go through a tree alone.
static void walk_alone(Group *group, Rays *rays, uint64_t active, const Walk *walk)
{
    for (; active; active &= active - 1) {
        uint32_t j = (uint32_t)__builtin_ctzll(active);
        Ray ray;
        rays_single(rays, j, &ray);
        walk_single(group, &ray, walk, rays->is_tight);
        rays_settle(rays, j, ray.to);
    }
}

#include "accel/kernels/intake.h"
#include "accel/kernels/together.h"

static void trace_run(const CoAccelScene *scene, const CoRayBatch *batch, const uint8_t *flags,
                      CoHitBatch *hits, size_t begin, uint32_t count, bool grouped,
                      CoTraverseStats *stats)
{
    Group group;
    Rays rays;
    Intake in;
    open_group(&group, scene, flags ? flags + begin : NULL, stats);
    if (count == CO_GROUP_RAYS)
        prefetch_hits(hits, begin);
    read_batch(batch, begin, count, &rays, &in);
    scale_rays(&rays, &in, &group);
    for (uint32_t slot = 0; flags && slot < count; slot++)
        group.occlusion |= (uint64_t)(flags[begin + slot] & CO_TRAVERSE_OCCLUSION) << slot;
    rays.count = count;
    drop_invalid(&rays, in.scale);
    rays.is_in_order = rays.count == count;
    stats->invalid += count - rays.count;
    const CoObject *root = &scene->objects[scene->root];
    if (rays.count && root->top && !is_empty(root)) {
        rays_pad(&rays);
        const Walk walk = walk_of(root, 0);
        if (grouped)
            trace_object(&group, &rays, &walk);
        else
            trace_each(&group, &rays, root);
    }
    give_hits(&group, in.scale, hits, begin, count);
    for (uint32_t slot = 0; slot < count && rays.count < count; slot++)
        if (in.scale[slot] == 0.0f)
            give_none(hits, begin + slot, __builtin_nanf(""));
}

void CO_LANE_NAME(co_accel_traverse)(const CoAccelScene *scene, const CoRayBatch *rays,
                                     const uint8_t *flags, CoHitBatch *hits, size_t begin,
                                     size_t end, bool grouped, CoTraverseStats *stats)
{
    for (size_t i = begin; i < end; i += CO_GROUP_RAYS) {
        uint32_t count = (uint32_t)(end - i < CO_GROUP_RAYS ? end - i : CO_GROUP_RAYS);
        if (end - i >= 2 * CO_GROUP_RAYS)
            prefetch_batch(rays, i + CO_GROUP_RAYS);
        trace_run(scene, rays, flags, hits, i, count, grouped, stats);
    }
}

#ifndef co_accel_traverse // benchmarks rename it, and ask for nothing else
// The neighbors of a distance above 0, along with 0 and infinity.
static inline float neighbor(float t, int step)
{
    union {
        float f;
        int32_t i;
    } bits = {t};
    bits.i += step;
    return bits.f;
}

// A group of the one ray: by what a group of many would do to it.
static bool next_of_ray(Group *group, const CoAccelScene *scene, Ray *ray)
{
    const CoObject *root = &scene->objects[scene->root];
    if (!root->top || is_empty(root))
        return false;
    const Walk walk = walk_of(root, 0);
    const bool is_tight = walk.is_in_place && ray_is_plain(ray);
    if (!ray_prepare(ray, &walk.tree->box, is_tight ? 0.0f : CO_TRANSFORM_SLACK))
        return false;
    walk_single(group, ray, &walk, is_tight);
    return group->found;
}

bool CO_LANE_NAME(co_accel_next)(const CoAccelScene *scene, CoVec3 org, CoVec3 dir, uint8_t flags,
                                 CoRayHit *hit)
{
    float inverse, scale = direction_scale(dir.x, dir.y, dir.z, &inverse);
    if (!(hit->t > 0.0f && hit->t < INFINITE) || scale == 0.0f)
        return false;
    CoTraverseStats ignored = {0};
    Group group;
    open_group(&group, scene, &flags, &ignored);
    group.after = hit;
    Ray ray = {.org = {org.x, org.y, org.z, 0.0f},
               .dir = {dir.x * scale, dir.y * scale, dir.z * scale, 0.0f},
               .entry = -INFINITE,
               .exit = INFINITE};
    ray.from = group.tnear[0] = neighbor(hit->t, -1) * inverse;
    ray.to = group.best_t[0] = neighbor(hit->t, 1) * inverse;
    group.best_path[0] = group.best_tri[0] = id_lane(0);
    if (!next_of_ray(&group, scene, &ray))
        return false;
    *hit = (CoRayHit){group.best_t[0] * scale, group.best_u[0], group.best_v[0],
                      lane_id(group.best_path[0]), lane_id(group.best_tri[0])};
    return true;
}
#endif
