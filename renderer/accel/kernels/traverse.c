// Traversal of groups of up to 64 rays: as a stream while several of them are active, one by one
// below.
//
// Source: Eisenacher et al. 2013, 3.1; Tsakok 2009. A group goes down a tree with one 64-bit mask
// of active rays per node, so that a node is fetched once for all of them and tested for many at a
// time. Where few are left, each goes on alone: that is the measure of coherence. Compiled once per
// instruction set.

#include "accel/kernels/traverse.h"
#include "accel/kernels/stream.h"

// Active rays up to which each goes on alone, and to a vector of a leaf, triangle by triangle.
enum {
    SINGLE_MOST = 3,
    LEAF_SINGLE_MOST = 2
};

// Of a group, by slot.
typedef struct Group {
    const CoAccelScene *scene;
    CoTraverseStats *stats;
    float tnear[CO_GROUP_RAYS];
    float best_t[CO_GROUP_RAYS]; // first tfar; -inf for an occlusion ray that is blocked
    float best_u[CO_GROUP_RAYS], best_v[CO_GROUP_RAYS];
    uint32_t best_path[CO_GROUP_RAYS], best_tri[CO_GROUP_RAYS];
    uint64_t found, occlusion; // one bit per slot
    uint32_t hits;             // so far; tells whether a test may come out otherwise now
} Group;

// A tree in the space of the rays: of a mesh, or else the top of a group.
typedef struct Walk {
    const CoTree *tree;
    const CoBvh *bvh;
    const CoObject *object;
    uint32_t path; // of the mesh; first one of the group
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
    float t, u, v;
    uint32_t path, tri;
} Hit;

// Offers a hit to a ray, which ends at `exit` at the latest, and sets where it ends now. Returns
// true when the ray needs no more.
static inline bool offer_hit(Group *group, uint32_t slot, const Hit *hit, float exit, float *to)
{
    float best = group->best_t[slot];
    if (!(hit->t > group->tnear[slot] && hit->t <= best))
        return false;
    // Before the first hit best is tfar with ids 0, which no tie is below.
    if (hit->t == best &&
        (hit->path > group->best_path[slot] ||
         (hit->path == group->best_path[slot] && hit->tri >= group->best_tri[slot])))
        return false;
    group->found |= 1ull << slot;
    group->hits++;
    if (group->occlusion >> slot & 1u) {
        group->best_t[slot] = *to = -INFINITE;
        return true;
    }
    group->best_t[slot] = hit->t;
    group->best_u[slot] = hit->u;
    group->best_v[slot] = hit->v;
    group->best_path[slot] = hit->path;
    group->best_tri[slot] = hit->tri;
    *to = float_min(exit, hit->t);
    return false;
}

static inline CoTriLeaf open_leaf(const CoBvh *bvh, uint32_t ref, uint32_t *count)
{
    *count = (ref >> CO_REF_COUNT_SHIFT & 7u) + 1;
    return co_leaf_open(bvh->leaves + (size_t)(ref & CO_REF_LEAF_PLACE) * CO_LEAF_UNIT, *count);
}

// One ray against a leaf. Returns true when it needs no more.
static __attribute__((noinline)) bool trace_leaf(Group *group, Ray *ray, const CoBvh *bvh,
                                                 uint32_t ref, uint32_t path)
{
    LeafHits hits;
    Shear shear;
    uint32_t count;
    const CoTriLeaf leaf = open_leaf(bvh, ref, &count);
    shear_load(ray, &shear);
    group->stats->triangles += count;
    shear_points(&leaf, &shear, CO_LEAF_WIDTH, &hits);
    uint32_t pierced = pierce_triangles(&leaf, &shear, count, &hits);
    for (; pierced; pierced &= pierced - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(pierced);
        if ((hits.unsure >> i & 1u) && !pierce_lane(&leaf, &shear, i, &hits))
            continue;
        Hit hit = {hits.t[i], hits.u[i], hits.v[i], path, leaf.tri[i]};
        if (clamp_hit(&leaf, ray, i, &hit.t) &&
            offer_hit(group, ray->slot, &hit, ray->exit, &ray->to))
            return true;
    }
    return false;
}

#include "accel/kernels/grid_blocks.h"

// The rays `active` of the vector at j, which share a major axis, against a leaf.
static void stream_leaf_vector(Group *group, Rays *rays, uint32_t j, uint32_t active, uint32_t axis,
                               const CoTriLeaf *leaf, uint32_t count, uint32_t path)
{
    StreamPoints points;
    StreamHits hits;
    Ray ray;
    stream_points(leaf, rays, axis, j, &points);
    const CoWide sz = co_wide_load(rays->inv[axis] + j);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t pierced = stream_pierce(leaf, i, &points, sz, active, &hits);
        for (; pierced; pierced &= pierced - 1) {
            uint32_t lane = (uint32_t)__builtin_ctz(pierced);
            if ((hits.unsure >> lane & 1u) &&
                !stream_pierce_lane(leaf, i, &points, rays->inv[axis][j + lane], lane, &hits))
                continue;
            Hit hit = {hits.t[lane], hits.u[lane], hits.v[lane], path, leaf->tri[i]};
            rays_single(rays, j + lane, &ray);
            if (clamp_hit(leaf, &ray, i, &hit.t) &&
                offer_hit(group, ray.slot, &hit, ray.exit, &rays->to[j + lane])) {
                rays->done |= 1ull << (j + lane);
                active &= ~(1u << lane);
            }
        }
    }
}

static void stream_leaf(Group *group, Rays *rays, uint64_t active, const CoBvh *bvh, uint32_t ref,
                        uint32_t path)
{
    Ray ray;
    if (bvh->patches) {
        for (; active; active &= active - 1) {
            uint32_t j = (uint32_t)__builtin_ctzll(active);
            rays_single(rays, j, &ray);
            trace_grid_leaf(group, &ray, bvh, ref, path);
            rays_settle(rays, j, ray.to);
        }
        return;
    }
    uint32_t count;
    const CoTriLeaf leaf = open_leaf(bvh, ref, &count);
    for (uint32_t axis = 0; axis < 3; axis++) {
        uint64_t along = active & rays->along[axis];
        for (uint32_t j = 0; next_vector(along, &j); j += CO_WIDE_WIDTH) {
            uint32_t bits = (uint32_t)(along >> j & WIDE_MASK);
            if (__builtin_popcount(bits) > LEAF_SINGLE_MOST) {
                group->stats->triangles += count * (uint32_t)__builtin_popcount(bits);
                stream_leaf_vector(group, rays, j, bits, axis, &leaf, count, path);
                continue;
            }
            for (; bits; bits &= bits - 1) {
                uint32_t at = j + (uint32_t)__builtin_ctz(bits);
                rays_single(rays, at, &ray);
                trace_leaf(group, &ray, bvh, ref, path);
                rays_settle(rays, at, ray.to);
            }
        }
    }
}

#include "accel/kernels/single.h"

// Rays `active` of a group go on alone, below `ref`.
static void walk_alone(Group *group, Rays *rays, uint64_t active, const Walk *walk, uint32_t ref)
{
    for (; active; active &= active - 1) {
        uint32_t j = (uint32_t)__builtin_ctzll(active);
        Ray ray;
        rays_single(rays, j, &ray);
        walk_single(group, &ray, walk, ref);
        rays_settle(rays, j, ray.to);
    }
}

static void trace_instance(Group *group, Rays *rays, uint64_t active, const Walk *walk,
                           uint32_t index);

typedef struct StreamEntry {
    uint64_t active; // rays that entered it
    float entry;     // of one of them
    uint32_t node;
    uint32_t child; // of that node
    uint32_t hits;  // of the group when they did
} StreamEntry;

// Pushes the children that are entered, the nearest last.
static uint32_t push_children(const Group *group, const StreamNode *found, uint32_t node,
                              StreamEntry *stack, uint32_t height)
{
    uint32_t base = height;
    for (uint32_t i = 0; i < CO_NODE_WIDTH; i++) {
        uint64_t active = found->active[i];
        if (!active)
            continue;
        uint32_t at = height++;
        float entry = found->entry[i][__builtin_ctzll(active)];
        for (; at > base && stack[at - 1].entry < entry; at--)
            stack[at] = stack[at - 1];
        stack[at] = (StreamEntry){active, entry, node, i, group->hits};
    }
    return height;
}

// Rays `active`, whose directions have the same signs, through a tree.
static void walk_stream(Group *group, Rays *rays, uint64_t active, const Walk *walk)
{
    StreamEntry stack[CO_STACK_SIZE];
    StreamNode found;
    const CoWideNode *nodes = walk->tree->nodes;
    const StreamRows rows = stream_rows(rays, (uint32_t)__builtin_ctzll(active));
    uint32_t height = 0, ref = 0;
    for (;;) {
        uint32_t most = (uint32_t)__builtin_popcountll(active);
        if (most <= SINGLE_MOST) {
            walk_alone(group, rays, active, walk, ref);
        } else if (!(ref & CO_REF_LEAF)) {
            stream_node(&nodes[ref], rays, &rows, active, &found);
            height = push_children(group, &found, ref, stack, height);
            count_nodes(group, walk, 1, most);
        } else if (walk->bvh) {
            stream_leaf(group, rays, active, walk->bvh, ref, walk->path);
        } else {
            trace_instance(group, rays, active, walk, ref & ~CO_REF_LEAF);
        }
        do {
            if (height == 0)
                return;
            const StreamEntry *at = &stack[--height];
            active = at->active & ~rays->done;
            if (active && at->hits != group->hits)
                active = stream_child(&nodes[at->node], at->child, rays, &rows, active);
            ref = nodes[at->node].child[at->child];
        } while (!active);
    }
}

// All rays through an object in whose space they are.
static void trace_object(Group *group, Rays *rays, const CoObject *object, uint32_t path)
{
    const Walk walk = walk_of(object, path);
    rays_prepare(rays, &walk.tree->box, object->top ? CO_TRANSFORM_SLACK : 0.0f);
    uint64_t left = ~0ull >> (CO_GROUP_RAYS - rays->count);
    uint64_t alone = left & rays->huge;
    left &= ~alone;
    while (left) {
        uint32_t j = (uint32_t)__builtin_ctzll(left);
        uint64_t same = same_signs(rays, left, j);
        left &= ~same;
        if (__builtin_popcountll(same) <= SINGLE_MOST)
            alone |= same;
        else
            walk_stream(group, rays, same, &walk);
    }
    if (alone)
        walk_alone(group, rays, alone, &walk, 0);
}

// Takes ray j to the end of `inner`, if it meets the box.
static inline void take_inner(const Rays *rays, uint32_t j, const CoBox *box, Rays *inner)
{
    float from = rays->entry[j], to = rays->exit[j];
    for (int k = 0; k < 3; k++) {
        float inv = rays->inv[k][j], org = rays->org[k][j];
        float own = __builtin_fabsf(org) * 0x1p-23f;
        float shift = __builtin_copysignf(own + rays->pad[j], rays->dir[k][j]);
        float near = inv < 0.0f ? box->hi[k] : box->lo[k];
        float far = inv < 0.0f ? box->lo[k] : box->hi[k];
        from = float_max((near - (org + shift)) * inv, from);
        to = float_min((far - (org - shift)) * inv, to);
    }
    uint32_t n = inner->count;
    for (int k = 0; k < 3; k++) {
        inner->org[k][n] = rays->org[k][j];
        inner->dir[k][n] = rays->dir[k][j];
    }
    inner->entry[n] = from;
    inner->exit[n] = to;
    inner->from[n] = float_max(rays->from[j], from);
    inner->to[n] = float_min(rays->to[j], to);
    inner->slot[n] = rays->slot[j];
    inner->outer[n] = (uint8_t)j;
    inner->count += from <= to && inner->from[n] <= inner->to[n];
}

// Rays `active` of a group's space through one of its instances.
static void trace_instance(Group *group, Rays *rays, uint64_t active, const Walk *walk,
                           uint32_t index)
{
    const CoTop *top = walk->object->top;
    const CoInstance *instance = &walk->object->instances[index];
    const CoObject *object = &group->scene->objects[instance->object];
    if (is_empty(object))
        return;
    Rays inner;
    inner.count = 0;
    for (; active; active &= active - 1)
        take_inner(rays, (uint32_t)__builtin_ctzll(active), &top->boxes[index], &inner);
    if (inner.count == 0)
        return;
    rays_pad(&inner);
    rays_transform(&inner, &instance->to_object);
    trace_object(group, &inner, object, walk->path + top->first_path[index]);
    for (uint32_t n = 0; n < inner.count; n++)
        rays_settle(rays, inner.outer[n], group->best_t[inner.slot[n]]);
}

// The power of two that brings the largest component of a direction into [1, 2), as far as it is
// one that a float holds, and its inverse. 0 for a direction that is zero or not finite.
static inline float direction_scale(const float dir[3], float *inverse)
{
    float largest = float_max(__builtin_fabsf(dir[0]), __builtin_fabsf(dir[1]));
    largest = float_max(__builtin_fabsf(dir[2]), largest);
    bool is_finite = __builtin_fabsf(dir[0]) < INFINITE && __builtin_fabsf(dir[1]) < INFINITE &&
                     __builtin_fabsf(dir[2]) < INFINITE;
    *inverse = 0.0f;
    if (!is_finite || largest == 0.0f)
        return 0.0f;
    union {
        float f;
        uint32_t u;
    } bits = {largest};
    // Exponents 1 to 253 have an inverse that is a normal number; beyond them nothing overflows
    // yet.
    uint32_t exponent = bits.u >> 23;
    exponent = exponent < 1 ? 1 : exponent > 253 ? 253 : exponent;
    bits.u = exponent << 23;
    *inverse = bits.f;
    bits.u = (254 - exponent) << 23;
    return bits.f;
}

// Takes a ray into the group. Distances inside are those along the scaled direction.
static inline bool take_ray(Group *group, const CoRayBatch *batch, size_t i, uint32_t slot,
                            Ray *ray, float *scale)
{
    float org[3] = {batch->org_x[i], batch->org_y[i], batch->org_z[i]};
    float dir[3] = {batch->dir_x[i], batch->dir_y[i], batch->dir_z[i]};
    float tnear = batch->tnear[i], tfar = batch->tfar[i], inverse;
    float s = direction_scale(dir, &inverse);
    for (int k = 0; k < 3; k++)
        if (!(__builtin_fabsf(org[k]) < INFINITE))
            s = 0.0f;
    *scale = s;
    if (s == 0.0f || tnear != tnear || tfar != tfar)
        return false;
    ray->org = (CoFour){org[0], org[1], org[2], 0.0f};
    ray->dir = (CoFour){dir[0] * s, dir[1] * s, dir[2] * s, 0.0f};
    ray->entry = -INFINITE;
    ray->exit = INFINITE;
    ray->slot = slot;
    ray->from = group->tnear[slot] = float_max(tnear * inverse, -__FLT_MAX__);
    ray->to = group->best_t[slot] = tfar * inverse;
    group->best_u[slot] = 0.0f;
    group->best_v[slot] = 0.0f;
    group->best_path[slot] = 0;
    group->best_tri[slot] = 0;
    return true;
}

static inline void add_ray(Rays *rays, const Ray *ray)
{
    uint32_t j = rays->count++;
    for (int k = 0; k < 3; k++) {
        rays->org[k][j] = ray->org[k];
        rays->dir[k][j] = ray->dir[k];
    }
    rays->entry[j] = ray->entry;
    rays->exit[j] = ray->exit;
    rays->from[j] = ray->from;
    rays->to[j] = ray->to;
    rays->slot[j] = (uint8_t)ray->slot;
}

static void give_hit(const Group *group, uint32_t slot, float scale, CoHitBatch *hits, size_t i)
{
    bool is_found = group->found >> slot & 1u, is_shadow = group->occlusion >> slot & 1u;
    bool has_hit = is_found && !is_shadow;
    float t = has_hit ? float_min(group->best_t[slot] * scale, __FLT_MAX__) : 0.0f;
    hits->t[i] = is_found ? t : INFINITE;
    hits->u[i] = has_hit ? group->best_u[slot] : 0.0f;
    hits->v[i] = has_hit ? group->best_v[slot] : 0.0f;
    hits->instance[i] = has_hit ? group->best_path[slot] : COHORT_INVALID_ID;
    hits->tri[i] = has_hit ? group->best_tri[slot] : COHORT_INVALID_ID;
}

static void give_invalid(CoHitBatch *hits, size_t i)
{
    hits->t[i] = __builtin_nanf("");
    hits->u[i] = 0.0f;
    hits->v[i] = 0.0f;
    hits->instance[i] = COHORT_INVALID_ID;
    hits->tri[i] = COHORT_INVALID_ID;
}

static inline void open_group(Group *group, const CoAccelScene *scene, CoTraverseStats *stats)
{
    group->scene = scene;
    group->stats = stats;
    group->found = 0;
    group->occlusion = 0;
    group->hits = 0;
    stats->groups++;
}

static void trace_run(const CoAccelScene *scene, const CoRayBatch *batch, const uint8_t *occlusion,
                      CoHitBatch *hits, size_t begin, uint32_t count, CoTraverseStats *stats)
{
    Group group;
    Rays rays;
    float scale[CO_GROUP_RAYS];
    uint64_t valid = 0;
    open_group(&group, scene, stats);
    rays.count = 0;
    for (uint32_t slot = 0; slot < count; slot++) {
        Ray ray;
        if (take_ray(&group, batch, begin + slot, slot, &ray, &scale[slot])) {
            valid |= 1ull << slot;
            add_ray(&rays, &ray);
        }
        if (occlusion && occlusion[begin + slot])
            group.occlusion |= 1ull << slot;
    }
    stats->invalid += count - rays.count;
    const CoObject *root = &scene->objects[scene->root];
    if (rays.count && root->top && !is_empty(root)) {
        rays_pad(&rays);
        trace_object(&group, &rays, root, 0);
    }
    for (uint32_t slot = 0; slot < count; slot++) {
        if (valid >> slot & 1u)
            give_hit(&group, slot, scale[slot], hits, begin + slot);
        else
            give_invalid(hits, begin + slot);
    }
}

static void trace_single(const CoAccelScene *scene, const CoRayBatch *batch,
                         const uint8_t *occlusion, CoHitBatch *hits, size_t i,
                         CoTraverseStats *stats)
{
    Group group;
    Ray ray;
    float scale;
    open_group(&group, scene, stats);
    if (!take_ray(&group, batch, i, 0, &ray, &scale)) {
        stats->invalid++;
        give_invalid(hits, i);
        return;
    }
    group.occlusion = occlusion && occlusion[i];
    const CoObject *root = &scene->objects[scene->root];
    if (root->top && !is_empty(root)) {
        const Walk walk = walk_of(root, 0);
        if (ray_prepare(&ray, &walk.tree->box, CO_TRANSFORM_SLACK))
            walk_single(&group, &ray, &walk, 0);
    }
    give_hit(&group, 0, scale, hits, i);
}

void CO_LANE_NAME(co_accel_traverse)(const CoAccelScene *scene, const CoRayBatch *rays,
                                     const uint8_t *occlusion, CoHitBatch *hits, size_t begin,
                                     size_t end, bool grouped, CoTraverseStats *stats)
{
    for (size_t i = begin; !grouped && i < end; i++)
        trace_single(scene, rays, occlusion, hits, i, stats);
    for (size_t i = begin; grouped && i < end; i += CO_GROUP_RAYS) {
        uint32_t count = (uint32_t)(end - i < CO_GROUP_RAYS ? end - i : CO_GROUP_RAYS);
        trace_run(scene, rays, occlusion, hits, i, count, stats);
    }
}
