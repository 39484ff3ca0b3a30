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

typedef struct Hit {
    float t, u, v;
    uint32_t path, tri;
} Hit;

// Offers ray j a hit. Returns true when the ray needs no more.
static inline bool offer_hit(Group *group, Rays *rays, uint32_t j, const Hit *hit)
{
    uint32_t slot = rays->slot[j];
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
        group->best_t[slot] = rays->to[j] = -INFINITE;
        rays->done |= 1ull << j;
        return true;
    }
    group->best_t[slot] = hit->t;
    group->best_u[slot] = hit->u;
    group->best_v[slot] = hit->v;
    group->best_path[slot] = hit->path;
    group->best_tri[slot] = hit->tri;
    rays->to[j] = float_min(rays->exit[j], hit->t);
    return false;
}

// One ray against a leaf. Returns true when it needs no more.
static bool trace_leaf(Group *group, Rays *rays, uint32_t j, const Shear *shear,
                       const CoTriLeaf *leaf, uint32_t count, uint32_t path)
{
    LeafHits hits;
    group->stats->triangles += count;
    shear_points(leaf, shear, CO_LEAF_WIDTH, &hits);
    uint32_t pierced = pierce_triangles(leaf, shear, count, &hits);
    for (; pierced; pierced &= pierced - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(pierced);
        if ((hits.unsure >> i & 1u) && !pierce_lane(leaf, shear, i, &hits))
            continue;
        Hit hit = {hits.t[i], hits.u[i], hits.v[i], path, leaf->tri[i]};
        if (clamp_hit(leaf, rays, j, i, &hit.t) && offer_hit(group, rays, j, &hit))
            return true;
    }
    return false;
}

#include "accel/kernels/grid_blocks.h"

static inline CoTriLeaf open_leaf(const CoBvh *bvh, uint32_t ref, uint32_t *count)
{
    *count = (ref >> CO_REF_COUNT_SHIFT & 7u) + 1;
    return co_leaf_open(bvh->leaves + (size_t)(ref & CO_REF_LEAF_PLACE) * CO_LEAF_UNIT, *count);
}

// The rays `active` of the vector at j, which share a major axis, against a leaf.
static void stream_leaf_vector(Group *group, Rays *rays, uint32_t j, uint32_t active, uint32_t axis,
                               const CoTriLeaf *leaf, uint32_t count, uint32_t path)
{
    StreamPoints points;
    StreamHits hits;
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
            if (clamp_hit(leaf, rays, j + lane, i, &hit.t) &&
                offer_hit(group, rays, j + lane, &hit))
                active &= ~(1u << lane);
        }
    }
}

static void stream_leaf(Group *group, Rays *rays, uint64_t active, const CoBvh *bvh, uint32_t ref,
                        uint32_t path)
{
    if (bvh->patches) {
        for (; active; active &= active - 1) {
            uint32_t j = (uint32_t)__builtin_ctzll(active);
            const Slab slab = slab_load(rays, j);
            const Shear shear = shear_of(rays, j);
            trace_grid_leaf(group, rays, j, &slab, &shear, bvh, ref, path);
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
                uint32_t ray = j + (uint32_t)__builtin_ctz(bits);
                const Shear shear = shear_of(rays, ray);
                trace_leaf(group, rays, ray, &shear, &leaf, count, path);
            }
        }
    }
}

typedef struct StackEntry {
    uint32_t ref;
    float entry;
} StackEntry;

// Chooses the nearest child of `bits`, which are not 0, and puts the others on the stack, the
// nearest of them last. Most nodes have one or two.
static inline uint32_t descend(StackEntry *stack, uint32_t *height, const CoWideNode *node,
                               uint32_t bits, const float entry[CO_NODE_WIDTH])
{
    uint32_t first = (uint32_t)__builtin_ctz(bits);
    bits &= bits - 1;
    if (!bits)
        return node->child[first];
    StackEntry nearest = {node->child[first], entry[first]};
    uint32_t base = *height, top = base;
    for (; bits; bits &= bits - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(bits), at = top++;
        StackEntry other = {node->child[i], entry[i]};
        bool is_nearer = other.entry < nearest.entry;
        StackEntry pushed = is_nearer ? nearest : other;
        nearest = is_nearer ? other : nearest;
        for (; at > base && stack[at - 1].entry < pushed.entry; at--)
            stack[at] = stack[at - 1];
        stack[at] = pushed;
    }
    *height = top;
    return nearest.ref;
}

// Asks for what the entered children hold: a leaf of usual size and most of a node are two lines.
static inline void prefetch_children(const CoBvh *bvh, const CoWideNode *node, uint32_t bits)
{
    for (; bits; bits &= bits - 1) {
        uint32_t ref = node->child[__builtin_ctz(bits)];
        const char *at = (const char *)&bvh->tree.nodes[ref];
        if (ref & CO_REF_LEAF)
            at = (const char *)bvh->leaf_at + (ref & CO_REF_LEAF_PLACE) * bvh->leaf_stride;
        __builtin_prefetch(at);
        __builtin_prefetch(at + 64);
        __builtin_prefetch(at + 128);
    }
}

static void trace_instance(Group *group, Rays *rays, uint64_t active, const CoObject *parent,
                           uint32_t index, uint32_t base);

// One ray through what lies below `ref`.
static void walk_single(Group *group, Rays *rays, uint32_t j, const Walk *walk, uint32_t ref)
{
    StackEntry stack[CO_STACK_SIZE];
    float entry[CO_NODE_WIDTH];
    uint32_t height = 0;
    const Slab slab = slab_load(rays, j);
    const Shear shear = shear_of(rays, j);
    const CoLane from = co_lane_set1(rays->from[j]);
    const bool is_huge = rays->huge >> j & 1u;
    for (;;) {
        if (!(ref & CO_REF_LEAF)) {
            const CoWideNode *node = &walk->tree->nodes[ref];
            uint32_t bits = slab_node(node, &slab, from, co_lane_set1(rays->to[j]), entry);
            *(walk->bvh ? &group->stats->bottom_nodes : &group->stats->top_nodes_grouped) += 1;
            group->stats->top_nodes_single += !walk->bvh;
            if (is_huge)
                bits &= present_children(node);
            if (bits) {
                if (walk->bvh)
                    prefetch_children(walk->bvh, node, bits);
                ref = descend(stack, &height, node, bits, entry);
                continue;
            }
        } else if (walk->bvh && walk->bvh->patches) {
            if (trace_grid_leaf(group, rays, j, &slab, &shear, walk->bvh, ref, walk->path))
                return;
        } else if (walk->bvh) {
            uint32_t count;
            const CoTriLeaf leaf = open_leaf(walk->bvh, ref, &count);
            if (trace_leaf(group, rays, j, &shear, &leaf, count, walk->path))
                return;
        } else {
            trace_instance(group, rays, 1ull << j, walk->object, ref & ~CO_REF_LEAF, walk->path);
        }
        do {
            if (height == 0)
                return;
            height--;
        } while (!(stack[height].entry <= rays->to[j]));
        ref = stack[height].ref;
    }
}

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
            for (; active; active &= active - 1)
                walk_single(group, rays, (uint32_t)__builtin_ctzll(active), walk, ref);
        } else if (!(ref & CO_REF_LEAF)) {
            stream_node(&nodes[ref], rays, &rows, active, &found);
            height = push_children(group, &found, ref, stack, height);
            if (walk->bvh) {
                group->stats->bottom_nodes += most;
            } else {
                group->stats->top_nodes_grouped++;
                group->stats->top_nodes_single += most;
            }
        } else if (walk->bvh) {
            stream_leaf(group, rays, active, walk->bvh, ref, walk->path);
        } else {
            trace_instance(group, rays, active, walk->object, ref & ~CO_REF_LEAF, walk->path);
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
    const Walk walk = {object->top ? &object->top->tree : &object->bvh->tree,
                       object->top ? NULL : object->bvh, object, path};
    rays_prepare(rays, &walk.tree->box, object->top ? CO_TRANSFORM_SLACK : 0.0f);
    uint64_t left = ~0ull >> (CO_GROUP_RAYS - rays->count);
    while (left) {
        uint32_t j = (uint32_t)__builtin_ctzll(left);
        uint64_t same = same_signs(rays, left & ~rays->huge, j);
        if (same == 0 || same == 1ull << j) {
            walk_single(group, rays, j, &walk, 0);
            left &= left - 1;
        } else {
            walk_stream(group, rays, same, &walk);
            left &= ~same;
        }
    }
}

// Copies ray j to the end of `inner`.
static inline void take_inner(const Rays *rays, uint32_t j, float from, float to, Rays *inner)
{
    uint32_t n = inner->count++;
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
}

// Rays `active` of a group's space through one of its instances.
static void trace_instance(Group *group, Rays *rays, uint64_t active, const CoObject *parent,
                           uint32_t index, uint32_t base)
{
    const CoInstance *instance = &parent->instances[index];
    const CoObject *object = &group->scene->objects[instance->object];
    const CoBox *box = &parent->top->boxes[index];
    bool is_empty = object->top ? object->top->tree.node_count == 0
                                : !object->bvh || object->bvh->tree.node_count == 0;
    if (is_empty)
        return;
    Rays inner;
    inner.count = 0;
    for (; active; active &= active - 1) {
        uint32_t j = (uint32_t)__builtin_ctzll(active);
        float from = rays->entry[j], to = rays->exit[j];
        if (slab_box(rays, j, box->lo, box->hi, &from, &to) &&
            float_max(from, rays->from[j]) <= float_min(to, rays->to[j]))
            take_inner(rays, j, from, to, &inner);
    }
    if (inner.count == 0)
        return;
    rays_pad(&inner);
    rays_transform(&inner, &instance->to_object);
    trace_object(group, &inner, object, base + parent->top->first_path[index]);
    for (uint32_t n = 0; n < inner.count; n++) {
        uint32_t j = inner.outer[n];
        float best = group->best_t[inner.slot[n]];
        rays->to[j] = float_min(rays->to[j], best);
        if (best == -INFINITE)
            rays->done |= 1ull << j;
    }
}

// The power of two that brings the largest component of a direction into [1, 2), as far as it is
// one that a float holds. 0 for a direction that is zero or not finite.
static float direction_scale(const float dir[3])
{
    float largest = 0.0f;
    for (int k = 0; k < 3; k++) {
        float a = __builtin_fabsf(dir[k]);
        if (!(a < INFINITE))
            return 0.0f;
        largest = float_max(largest, a);
    }
    if (largest == 0.0f)
        return 0.0f;
    union {
        float f;
        uint32_t u;
    } bits = {largest};
    // Exponents 1 to 253 have an inverse that is a normal number; beyond them nothing overflows
    // yet.
    uint32_t exponent = bits.u >> 23;
    exponent = exponent < 1 ? 1 : exponent > 253 ? 253 : exponent;
    bits.u = (254 - exponent) << 23;
    return bits.f;
}

// Takes a ray into the group. Distances inside are those along the scaled direction.
static bool take_ray(Group *group, Rays *rays, const CoRayBatch *batch, size_t i, uint32_t slot,
                     float *scale)
{
    float org[3] = {batch->org_x[i], batch->org_y[i], batch->org_z[i]};
    float dir[3] = {batch->dir_x[i], batch->dir_y[i], batch->dir_z[i]};
    float tnear = batch->tnear[i], tfar = batch->tfar[i], s = direction_scale(dir);
    for (int k = 0; k < 3; k++)
        if (!(__builtin_fabsf(org[k]) < INFINITE))
            s = 0.0f;
    *scale = s;
    if (s == 0.0f || tnear != tnear || tfar != tfar)
        return false;
    uint32_t j = rays->count++;
    for (int k = 0; k < 3; k++) {
        rays->org[k][j] = org[k];
        rays->dir[k][j] = dir[k] * s;
    }
    rays->entry[j] = -INFINITE;
    rays->exit[j] = INFINITE;
    rays->slot[j] = (uint8_t)slot;
    rays->from[j] = group->tnear[slot] = float_max(tnear / s, -__FLT_MAX__);
    rays->to[j] = group->best_t[slot] = tfar / s;
    group->best_u[slot] = 0.0f;
    group->best_v[slot] = 0.0f;
    group->best_path[slot] = 0;
    group->best_tri[slot] = 0;
    return true;
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

static void trace_run(const CoAccelScene *scene, const CoRayBatch *batch, const uint8_t *occlusion,
                      CoHitBatch *hits, size_t begin, uint32_t count, CoTraverseStats *stats)
{
    Group group;
    Rays rays;
    float scale[CO_GROUP_RAYS];
    uint64_t valid = 0;
    group.scene = scene;
    group.stats = stats;
    group.found = 0;
    group.occlusion = 0;
    group.hits = 0;
    rays.count = 0;
    for (uint32_t slot = 0; slot < count; slot++) {
        if (take_ray(&group, &rays, batch, begin + slot, slot, &scale[slot]))
            valid |= 1ull << slot;
        if (occlusion && occlusion[begin + slot])
            group.occlusion |= 1ull << slot;
    }
    stats->groups++;
    stats->invalid += count - rays.count;
    const CoObject *root = &scene->objects[scene->root];
    if (rays.count && root->top && root->top->tree.node_count) {
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

void CO_LANE_NAME(co_accel_traverse)(const CoAccelScene *scene, const CoRayBatch *rays,
                                     const uint8_t *occlusion, CoHitBatch *hits, size_t begin,
                                     size_t end, bool grouped, CoTraverseStats *stats)
{
    size_t most = grouped ? CO_GROUP_RAYS : 1;
    for (size_t i = begin; i < end; i += most) {
        uint32_t count = (uint32_t)(end - i < most ? end - i : most);
        trace_run(scene, rays, occlusion, hits, i, count, stats);
    }
}
