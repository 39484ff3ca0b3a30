// Traversal of groups of up to 64 rays: the top levels as a stream, the meshes ray by ray.
//
// Source: Eisenacher et al. 2013, 3.1 (streaming packets in the top level, single rays below);
// Tsakok 2009. A group goes down a top level with one 64-bit mask of active rays per node, so that
// a node is fetched once for all of them. Compiled once per instruction set.

#include "accel/kernels/traverse.h"
#include "accel/kernels/rays.h"
#include "accel/kernels/triangle.h"

#define INFINITE __builtin_inff()

// Of a group, by slot.
typedef struct Group {
    const CoAccelScene *scene;
    CoTraverseStats *stats;
    float tnear[CO_GROUP_RAYS];
    float best_t[CO_GROUP_RAYS]; // first tfar; -inf for an occlusion ray that is blocked
    float best_u[CO_GROUP_RAYS], best_v[CO_GROUP_RAYS];
    uint32_t best_path[CO_GROUP_RAYS], best_tri[CO_GROUP_RAYS];
    uint64_t found, occlusion; // one bit per slot
} Group;

// Offers a hit. Returns true when the ray needs no more.
static inline bool offer_hit(Group *group, uint32_t slot, float t, const LeafHits *hits,
                             uint32_t path, uint32_t i, uint32_t tri)
{
    float best = group->best_t[slot];
    if (!(t > group->tnear[slot] && t <= best))
        return false;
    // Before the first hit best is tfar with ids 0, which no tie is below.
    if (t == best && (path > group->best_path[slot] ||
                      (path == group->best_path[slot] && tri >= group->best_tri[slot])))
        return false;
    group->found |= 1ull << slot;
    if (group->occlusion >> slot & 1u) {
        group->best_t[slot] = -INFINITE;
        return true;
    }
    group->best_t[slot] = t;
    group->best_u[slot] = hits->u[i];
    group->best_v[slot] = hits->v[i];
    group->best_path[slot] = path;
    group->best_tri[slot] = tri;
    return false;
}

static bool trace_leaf(Group *group, const Rays *rays, uint32_t j, const Shear *shear,
                       const CoTriLeaf *leaf, uint32_t count, uint32_t path)
{
    LeafHits hits;
    group->stats->triangles += count;
    shear_points(leaf, shear, CO_LEAF_WIDTH, &hits);
    uint32_t pierced = pierce_triangles(leaf, shear, count, &hits);
    for (; pierced; pierced &= pierced - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(pierced);
        if ((hits.unsure >> i & 1u) && !pierce_exactly(leaf, shear, i, &hits))
            continue;
        float t = hits.t[i];
        if (clamp_hit(leaf, rays, j, i, &t) &&
            offer_hit(group, rays->slot[j], t, &hits, path, i, leaf->tri[i]))
            return true;
    }
    return false;
}

#include "accel/kernels/grid_blocks.h"

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

// One ray through one mesh.
static void trace_mesh(Group *group, const Rays *rays, uint32_t j, const CoBvh *bvh, uint32_t path)
{
    StackEntry stack[CO_STACK_SIZE];
    float entry[CO_NODE_WIDTH];
    uint32_t slot = rays->slot[j], height = 0, ref = 0;
    const Slab slab = slab_load(rays, j);
    const Shear shear = shear_of(rays, j);
    const CoLane from = co_lane_set1(float_max(group->tnear[slot], rays->entry[j]));
    for (;;) {
        if (ref & CO_REF_LEAF && bvh->patches) {
            if (trace_grid_leaf(group, rays, j, &slab, &shear, bvh, ref, path))
                return;
        } else if (ref & CO_REF_LEAF) {
            uint32_t count = (ref >> CO_REF_COUNT_SHIFT & 7u) + 1;
            size_t place = (size_t)(ref & CO_REF_LEAF_PLACE) * CO_LEAF_UNIT;
            const CoTriLeaf leaf = co_leaf_open(bvh->leaves + place, count);
            if (trace_leaf(group, rays, j, &shear, &leaf, count, path))
                return;
        } else {
            const CoWideNode *node = &bvh->tree.nodes[ref];
            float to = float_min(rays->exit[j], group->best_t[slot]);
            uint32_t bits = slab_node(node, &slab, from, co_lane_set1(to), entry);
            group->stats->bottom_nodes++;
            if (bits) {
                prefetch_children(bvh, node, bits);
                ref = descend(stack, &height, node, bits, entry);
                continue;
            }
        }
        do {
            if (height == 0)
                return;
            height--;
        } while (!(stack[height].entry <= group->best_t[slot]));
        ref = stack[height].ref;
    }
}

static void trace_group(Group *group, Rays *rays, const CoObject *object, uint32_t base);

// Rays `active` of a group's space through one of its instances.
static void trace_instance(Group *group, const Rays *rays, uint64_t active, const CoObject *parent,
                           uint32_t index, uint32_t base)
{
    const CoInstance *instance = &parent->instances[index];
    const CoObject *object = &group->scene->objects[instance->object];
    const CoBox *box = &parent->top->boxes[index];
    Rays inner;
    inner.count = 0;
    for (; active; active &= active - 1) {
        uint32_t j = (uint32_t)__builtin_ctzll(active), n = inner.count, slot = rays->slot[j];
        float from = rays->entry[j], to = rays->exit[j];
        if (!slab_box(rays, j, box->lo, box->hi, &from, &to) ||
            !(float_max(from, group->tnear[slot]) <= float_min(to, group->best_t[slot])))
            continue;
        for (int k = 0; k < 3; k++) {
            inner.org[k][n] = rays->org[k][j];
            inner.dir[k][n] = rays->dir[k][j];
        }
        inner.entry[n] = from;
        inner.exit[n] = to;
        inner.slot[n] = (uint8_t)slot;
        inner.count++;
    }
    if (inner.count == 0)
        return;
    uint32_t path = base + parent->top->first_path[index];
    rays_pad(&inner);
    rays_transform(&inner, &instance->to_object);
    if (object->top) {
        trace_group(group, &inner, object, path);
    } else if (object->bvh && object->bvh->tree.node_count) {
        rays_prepare(&inner, &object->bvh->tree.box, 0.0f);
        for (uint32_t j = 0; j < inner.count; j++)
            trace_mesh(group, &inner, j, object->bvh, path);
    }
}

typedef struct GroupEntry {
    uint64_t active; // rays that enter it, by their place in Rays
    float entry;     // of the first of them
    uint32_t ref;
} GroupEntry;

// Tests the active rays against a node and pushes its children, the nearest last.
static uint32_t push_group(Group *group, const Rays *rays, uint64_t active, const CoWideNode *node,
                           GroupEntry *stack, uint32_t height)
{
    uint64_t child_active[CO_NODE_WIDTH] = {0};
    float entry[CO_NODE_WIDTH], first[CO_NODE_WIDTH];
    uint32_t entered = 0, base = height;
    for (int i = 0; i < CO_NODE_WIDTH; i++)
        first[i] = INFINITE;
    for (uint64_t left = active; left; left &= left - 1) {
        uint32_t j = (uint32_t)__builtin_ctzll(left), slot = rays->slot[j];
        const Slab slab = slab_load(rays, j);
        float from = float_max(group->tnear[slot], rays->entry[j]);
        float to = float_min(rays->exit[j], group->best_t[slot]);
        uint32_t bits = slab_node(node, &slab, co_lane_set1(from), co_lane_set1(to), entry);
        entered |= bits;
        for (; bits; bits &= bits - 1) {
            uint32_t i = (uint32_t)__builtin_ctz(bits);
            child_active[i] |= 1ull << j;
            first[i] = float_min(entry[i], first[i]);
        }
    }
    for (; entered; entered &= entered - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(entered), at = height++;
        GroupEntry pushed = {child_active[i], first[i], node->child[i]};
        for (; at > base && stack[at - 1].entry < pushed.entry; at--)
            stack[at] = stack[at - 1];
        stack[at] = pushed;
    }
    return height;
}

// All rays of `rays` through a group's top level. `base`: path id of its first path.
static void trace_group(Group *group, Rays *rays, const CoObject *object, uint32_t base)
{
    GroupEntry stack[CO_STACK_SIZE];
    const CoTop *top = object->top;
    if (top->tree.node_count == 0)
        return;
    rays_prepare(rays, &top->tree.box, CO_TRANSFORM_SLACK);
    uint64_t all = ~0ull >> (CO_GROUP_RAYS - rays->count);
    uint32_t height = 1;
    stack[0] = (GroupEntry){all, -INFINITE, 0};
    while (height) {
        GroupEntry at = stack[--height];
        if (at.ref & CO_REF_LEAF) {
            trace_instance(group, rays, at.active, object, at.ref & ~CO_REF_LEAF, base);
            continue;
        }
        group->stats->top_nodes_grouped++;
        group->stats->top_nodes_single += (uint64_t)__builtin_popcountll(at.active);
        height = push_group(group, rays, at.active, &top->tree.nodes[at.ref], stack, height);
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
    group->tnear[slot] = float_max(tnear / s, -__FLT_MAX__);
    group->best_t[slot] = tfar / s;
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
    if (rays.count && root->top) {
        rays_pad(&rays);
        trace_group(&group, &rays, root, 0);
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
