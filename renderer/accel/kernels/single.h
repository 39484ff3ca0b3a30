// Single rays: each goes down a tree with a stack of the children it still has to visit. Part of
// traverse.c.

#ifndef CO_ACCEL_KERNELS_SINGLE_H
#define CO_ACCEL_KERNELS_SINGLE_H

// A child that is entered: the bits of the distance, which are in the order of distances (but for
// negative ones, which are merely visited in another order), above its reference.
typedef uint64_t Entered;
#define ENTERED_ANYWHERE 0xff80000000000000u // at -infinity

// Below what a walk of a tree has put on its stack. No leaf is at the last place.
#define REF_END 0xffffffffu

static inline Entered entered_child(const CoWideNode *node, const float entry[CO_NODE_WIDTH],
                                    uint32_t i)
{
    union {
        float f;
        uint32_t u;
    } bits = {entry[i]};
    return (uint64_t)bits.u << 32 | node->child[i];
}

static inline float entered_at(Entered child)
{
    union {
        uint32_t u;
        float f;
    } bits = {(uint32_t)(child >> 32)};
    return bits.f;
}

// Puts the nearer of two first; no branch, as it would be guessed wrong half the time.
static inline void order(Entered *first, Entered *second)
{
    Entered a = *first, b = *second;
    bool is_swapped = b < a;
    *first = is_swapped ? b : a;
    *second = is_swapped ? a : b;
}

// Where children are: nodes, and leaves or instances, which are `stride` bytes apart.
typedef struct Below {
    const CoWideNode *nodes;
    const void *leaves;
    size_t stride;
} Below;

static inline Below below_walk(const Walk *walk)
{
    const CoBvh *bvh = walk->bvh;
    if (bvh)
        return (Below){walk->tree->nodes, bvh->leaf_at, bvh->leaf_stride};
    return (Below){walk->tree->nodes, walk->object->top->placed, sizeof(CoPlaced)};
}

// Asks for a child. Always inline: the compiler drops calls of functions that do no more.
static inline __attribute__((always_inline)) void ask_for(const Below *below, uint32_t ref)
{
    const char *at = (const char *)&below->nodes[ref];
    if (ref & CO_REF_LEAF)
        at = (const char *)below->leaves + (ref & CO_REF_LEAF_PLACE) * below->stride;
    for (size_t line = 0; line < sizeof(CoWideNode); line += 64) // usual leaves are smaller
        __builtin_prefetch(at + line);
}

// Asks for a leaf of triangles but for its first line: where its points begin is not known before
// that is there, and to wait for one line after the other takes twice as long.
static inline __attribute__((always_inline)) void ask_for_rest(const Below *mesh, uint32_t ref)
{
    const char *at = (const char *)mesh->leaves + (size_t)(ref & CO_REF_LEAF_PLACE) * CO_LEAF_UNIT;
    for (size_t line = 64; line < sizeof(CoWideNode); line += 64) // as above
        __builtin_prefetch(at + line);
}

// Chooses the nearest child of `bits`, which are not 0, and puts the others on the stack, the
// nearest of them last. Most nodes have one or two. Returns the stack's new top.
static inline __attribute__((always_inline)) Entered *descend(Entered *top, const CoWideNode *node,
                                                              uint32_t bits,
                                                              const float entry[CO_NODE_WIDTH],
                                                              const Below *below, uint32_t *ref)
{
    uint32_t first = (uint32_t)__builtin_ctz(bits);
    bits &= bits - 1;
    if (!bits) {
        *ref = node->child[first];
        return top;
    }
    Entered nearest = entered_child(node, entry, first);
    Entered other = entered_child(node, entry, (uint32_t)__builtin_ctz(bits));
    ask_for(below, (uint32_t)nearest);
    ask_for(below, (uint32_t)other);
    order(&nearest, &other);
    *top = other;
    Entered *base = top++;
    for (bits &= bits - 1; bits; bits &= bits - 1) {
        Entered *at = top++;
        other = entered_child(node, entry, (uint32_t)__builtin_ctz(bits));
        ask_for(below, (uint32_t)other);
        order(&nearest, &other);
        for (; at > base && at[-1] < other; at--)
            *at = at[-1];
        *at = other;
    }
    *ref = (uint32_t)nearest;
    return top;
}

// The same for a ray that any hit ends: in no order.
static inline __attribute__((always_inline)) Entered *
descend_any(Entered *top, const CoWideNode *node, uint32_t bits, const Below *below, uint32_t *ref)
{
    *ref = node->child[__builtin_ctz(bits)];
    for (bits &= bits - 1; bits; bits &= bits - 1) {
        uint32_t child = node->child[__builtin_ctz(bits)];
        ask_for(below, child);
        *top++ = ENTERED_ANYWHERE | child;
    }
    return top;
}

static inline bool is_empty(const CoObject *object)
{
    return object->top ? object->top->tree.node_count == 0
                       : !object->bvh || object->bvh->tree.node_count == 0;
}

// Through the mesh `bvh` or, where that is NULL, the group. Stored once, where it stays: a copy of
// what has just been stored field by field waits until that has reached the cache.
static inline Walk walk_through(const CoObject *object, const CoBvh *bvh, uint32_t path)
{
    return (Walk){.tree = bvh ? &bvh->tree : &object->top->tree,
                  .bvh = bvh,
                  .object = object,
                  .path = path,
                  .is_in_place = !object->top || object->top->is_in_place};
}

static inline Walk walk_of(const CoObject *object, uint32_t path)
{
    return walk_through(object, object->top ? NULL : object->bvh, path);
}

// Below an instance.
static inline Walk walk_of_placed(const CoPlaced *placed, const CoObject *object, uint32_t path)
{
    const CoBvh *own = object->top ? NULL : object->bvh;
    return walk_through(object, placed->is_baked ? placed->bvh : own, path);
}

// Of a layer of the group that is walked.
static inline Walk walk_of_layer(const Walk *walk, uint32_t index)
{
    const CoTop *top = walk->object->top;
    const CoLayer *layer = &top->layers[index - top->count];
    Walk below = *walk;
    below.tree = &layer->tree;
    below.is_in_place = layer->is_in_place;
    return below;
}

static inline __attribute__((always_inline)) bool test_leaf(Group *group, Ray *ray,
                                                            const Shear *shear, const CoBvh *bvh,
                                                            uint32_t ref, uint32_t path,
                                                            const bool is_flat)
{
    LeafHits hits;
    uint32_t count;
    const CoTriLeaf leaf = open_leaf(bvh, ref, &count);
    uint32_t pierced;
    group->stats->triangles += count;
    if (is_flat && is_few(&leaf)) {
        pierced = pierce_few(&leaf, count, shear, &hits);
    } else {
        shear_points(&leaf, shear, &hits);
        pierced = pierce_triangles(&leaf, count, &hits);
    }
    if (!pierced)
        return false;
    pad_for(ray, bvh);
    return offer_pierced(group, ray, &leaf, shear, pierced, path, &hits, is_flat);
}

static __attribute__((noinline)) bool trace_flat_leaf(Group *group, Ray *ray, const Shear *shear,
                                                      const CoBvh *bvh, uint32_t ref, uint32_t path)
{
    return test_leaf(group, ray, shear, bvh, ref, path, true);
}

// One ray against a leaf. Returns true when it needs no more.
static __attribute__((noinline)) bool trace_leaf(Group *group, Ray *ray, const Shear *shear,
                                                 const CoBvh *bvh, uint32_t ref, uint32_t path)
{
    return test_leaf(group, ray, shear, bvh, ref, path, false);
}

// Counts the nodes of a walk, `below` of them in meshes in place.
static inline void count_visited(Group *group, const CoBvh *bvh, uint32_t nodes, uint32_t below)
{
    below = bvh ? nodes : below;
    group->stats->bottom_nodes += below;
    group->stats->top_nodes_grouped += nodes - below;
    group->stats->top_nodes_single += nodes - below;
}

static void enter_instance(Group *group, Ray *ray, const Walk *walk, uint32_t index);

static inline const SlabEnds *ends_in_place(const Ray *ray, const CoTree *tree, SlabEnds *out)
{
    CoFour near_c, far_c;
    ray_tight(ray, &tree->box, &near_c, &far_c);
    slab_ends(near_c, far_c, out);
    return out;
}

// One ray through a tree that it has been prepared for. A mesh that stands in its group as it is
// is part of the group's tree: the ray stays what it is. Nothing is lost with the instance's box,
// which holds those of all its triangles: their canonical slabs lie in its own.
// is_tight: in a group, the slabs of the ray are those for meshes in place. is_any: a constant.
static inline __attribute__((always_inline)) void
walk_slabs(Group *group, Ray *ray, const Walk *walk, bool is_tight, const bool is_any)
{
    Entered stack[2 * CO_STACK_SIZE], *top = stack;
    float entry[CO_NODE_WIDTH];
    Slab slab;
    SlabEnds own, tight;
    Shear shear;
    slab_load(ray, &slab);
    slab_ends(ray->near_c, ray->far_c, &own);
    shear_load(ray, &shear);
    const bool is_plain = is_tight || (!walk->bvh && ray_is_plain(ray));
    const SlabEnds *in_place = is_tight ? &own : NULL; // of meshes, once there is one
    Below level = below_walk(walk);
    const SlabEnds *ends = &own;
    const CoBvh *bvh = walk->bvh;
    uint32_t ref = 0, path = walk->path, visited = 0, below = 0, before = 0;
    *top++ = ENTERED_ANYWHERE | REF_END;
    for (;;) {
        if (!(ref & CO_REF_LEAF)) {
            const CoWideNode *node = &level.nodes[ref];
            uint32_t bits = slab_node(node, &slab, ends, co_lane_set1(ray->to), entry);
            visited++;
            if (ray->is_huge)
                bits &= present_children(node);
            if (bits) {
                top = is_any ? descend_any(top, node, bits, &level, &ref)
                             : descend(top, node, bits, entry, &level, &ref);
                continue;
            }
        } else if (ref == REF_END) {
            if (bvh == walk->bvh)
                break;
            below += visited - before;
            level = below_walk(walk);
            ends = &own;
            bvh = NULL;
        } else if (bvh) {
            if (!bvh->patches)
                ask_for_rest(&level, ref);
            if (bvh->patches   ? trace_grid_leaf(group, ray, &shear, bvh, ref, path)
                : bvh->is_flat ? trace_flat_leaf(group, ray, &shear, bvh, ref, path)
                               : trace_leaf(group, ray, &shear, bvh, ref, path)) {
                below += visited - before;
                break;
            }
        } else {
            const CoPlaced *placed = &walk->object->top->placed[ref & ~CO_REF_LEAF];
            if (placed->is_in_place && is_plain) {
                if (!is_hidden(group, ray, placed)) {
                    before = visited;
                    bvh = placed->bvh;
                    level = (Below){placed->nodes, bvh->leaf_at, bvh->leaf_stride};
                    if (!in_place)
                        in_place = ends_in_place(ray, walk->tree, &tight);
                    ends = in_place;
                    path = walk->path + placed->first_path;
                    *top++ = ENTERED_ANYWHERE | REF_END;
                    ref = placed->root;
                    if (bvh->patches)
                        pad_for(ray, bvh);
                    continue;
                }
            } else {
                enter_instance(group, ray, walk, ref & ~CO_REF_LEAF);
            }
        }
        Entered child;
        do
            child = *--top;
        while (!(entered_at(child) <= ray->to));
        ref = (uint32_t)child;
    }
    count_visited(group, walk->bvh, visited, below);
}

static __attribute__((noinline)) void walk_nearest(Group *group, Ray *ray, const Walk *walk,
                                                   bool is_tight)
{
    walk_slabs(group, ray, walk, is_tight, false);
}

static __attribute__((noinline)) void walk_any(Group *group, Ray *ray, const Walk *walk,
                                               bool is_tight)
{
    walk_slabs(group, ray, walk, is_tight, true);
}

static void walk_single(Group *group, Ray *ray, const Walk *walk, bool is_tight)
{
    if (group->occlusion >> ray->slot & 1u)
        walk_any(group, ray, walk, is_tight);
    else
        walk_nearest(group, ray, walk, is_tight);
}

// Sets where a ray of a group's space enters and leaves an instance, and may still hit. False when
// it does not.
static inline bool enter_box_of(const Ray *ray, const CoPlaced *placed, Ray *inner)
{
    inner->entry = ray->entry;
    inner->exit = ray->exit;
    bool is_in = slab_box(ray, ray->placed_pad, box_corner(placed->box.lo),
                          box_corner(placed->box.hi), &inner->entry, &inner->exit);
    inner->from = float_max(ray->from, inner->entry);
    inner->to = float_min(ray->to, inner->exit);
    return is_in && inner->from <= inner->to;
}

// A ray of a group's space, and of a mesh's, against the only leaf of that: it wants no slabs but
// the canonical ones, and those when a triangle may be hit.
static inline __attribute__((always_inline)) void test_only_leaf(Group *group, const Ray *ray,
                                                                 Ray *inner, const CoPlaced *placed,
                                                                 uint32_t path, const bool is_flat)
{
    LeafHits hits;
    Shear shear;
    uint32_t count;
    const CoTriLeaf leaf = open_leaf(placed->bvh, placed->root, &count);
    shear_load(inner, &shear);
    group->stats->triangles += count;
    shear_points(&leaf, &shear, &hits);
    uint32_t pierced = pierce_triangles(&leaf, count, &hits);
    if (!pierced || !enter_box_of(ray, placed, inner))
        return;
    inner->padded_for = NULL;
    pad_for(inner, placed->bvh);
    offer_pierced(group, inner, &leaf, &shear, pierced, path, &hits, is_flat);
}

static __attribute__((noinline)) void enter_flat_leaf(Group *group, const Ray *ray, Ray *inner,
                                                      const CoPlaced *placed, uint32_t path)
{
    test_only_leaf(group, ray, inner, placed, path, true);
}

static __attribute__((noinline)) void enter_other_leaf(Group *group, const Ray *ray, Ray *inner,
                                                       const CoPlaced *placed, uint32_t path)
{
    test_only_leaf(group, ray, inner, placed, path, false);
}

// In functions of their own: most instances have a tree, and would spill registers for what hits
// take.
static inline void enter_leaf(Group *group, const Ray *ray, Ray *inner, const CoPlaced *placed,
                              uint32_t path)
{
    if (!ray_is_fit(inner))
        return;
    if (placed->bvh->is_flat)
        enter_flat_leaf(group, ray, inner, placed, path);
    else
        enter_other_leaf(group, ray, inner, placed, path);
}

// One ray through a layer of its group: it stays what it is, but is prepared for less space.
static __attribute__((noinline)) void enter_layer(Group *group, Ray *ray, const Walk *walk,
                                                  uint32_t index)
{
    const Walk below = walk_of_layer(walk, index);
    const bool is_tight = below.is_in_place && ray_is_plain(ray);
    Ray inner = *ray;
    if (ray_set_origin(&inner, &below.tree->box, is_tight ? 0.0f : CO_TRANSFORM_SLACK))
        walk_single(group, &inner, &below, is_tight);
    ray->to = float_min(ray->to, group->best_t[ray->slot]);
}

// One ray of a group's space through one of its instances, in a space of its own, or a layer.
static __attribute__((noinline)) void enter_instance(Group *group, Ray *ray, const Walk *walk,
                                                     uint32_t index)
{
    const CoPlaced *placed = &walk->object->top->placed[index];
    if (placed->is_layer) {
        enter_layer(group, ray, walk, index);
        return;
    }
    const CoInstance *instance = &walk->object->instances[index];
    const CoObject *object = &group->scene->objects[instance->object];
    const bool is_leaf = placed->root && !placed->bvh->patches;
    Ray inner;
    inner.slot = ray->slot;
    if (is_hidden(group, ray, placed) || is_empty(object) ||
        (!is_leaf && !enter_box_of(ray, placed, &inner)))
        return;
    const Walk below = walk_of_placed(placed, object, walk->path + placed->first_path);
    if (placed->is_baked) {
        inner.org = ray->org;
        inner.dir = ray->dir;
    } else {
        ray_transform(ray, &instance->to_object, &inner);
    }
    if (co_four_same3(inner.dir, ray->dir)) // many transforms only move
        ray_share_direction(ray, &inner);
    else
        ray_set_direction(&inner);
    if (is_leaf)
        enter_leaf(group, ray, &inner, placed, below.path);
    else if (ray_set_origin(&inner, &below.tree->box, below.bvh ? 0.0f : CO_TRANSFORM_SLACK))
        walk_single(group, &inner, &below, false);
    ray->to = float_min(ray->to, group->best_t[ray->slot]);
}

// Rays of a batch, one by one.
static void trace_each(Group *group, Rays *rays, const CoObject *root)
{
    const Walk walk = walk_of(root, 0);
    const bool is_tight = walk.is_in_place;
    rays_prepare(rays, &walk.tree->box, is_tight ? 0.0f : CO_TRANSFORM_SLACK);
    for (uint32_t j = 0; j < rays->count; j++) {
        Ray ray;
        rays_single(rays, j, &ray);
        bool is_plain = ray_is_plain(&ray);
        if (is_tight && !is_plain)
            ray_set_origin(&ray, &walk.tree->box, CO_TRANSFORM_SLACK);
        walk_single(group, &ray, &walk, is_tight && is_plain);
    }
}

#endif
