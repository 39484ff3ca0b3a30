// Single rays: each goes down a tree with a stack of the children it still has to visit. Part of
// traverse.c.

#ifndef CO_ACCEL_KERNELS_SINGLE_H
#define CO_ACCEL_KERNELS_SINGLE_H

// A child that is entered: the bits of the distance, which are in the order of distances (but for
// negative ones, which are merely visited in another order), above its reference.
typedef uint64_t Entered;
#define ENTERED_ANYWHERE 0xff80000000000000u // at -infinity

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
    bool is_swapped = *second >> 32 < *first >> 32;
    Entered swap = (*first ^ *second) & -(uint64_t)is_swapped;
    *first ^= swap;
    *second ^= swap;
}

// Chooses the nearest child of `bits`, which are not 0, and puts the others on the stack, the
// nearest of them last. Most nodes have one or two.
static inline uint32_t descend(Entered *stack, uint32_t *height, const CoWideNode *node,
                               uint32_t bits, const float entry[CO_NODE_WIDTH])
{
    uint32_t first = (uint32_t)__builtin_ctz(bits);
    bits &= bits - 1;
    if (!bits)
        return node->child[first];
    Entered nearest = entered_child(node, entry, first);
    Entered other = entered_child(node, entry, (uint32_t)__builtin_ctz(bits));
    uint32_t base = *height, top = base + 1;
    order(&nearest, &other);
    stack[base] = other;
    for (bits &= bits - 1; bits; bits &= bits - 1) {
        uint32_t at = top++;
        other = entered_child(node, entry, (uint32_t)__builtin_ctz(bits));
        order(&nearest, &other);
        for (; at > base && stack[at - 1] >> 32 < other >> 32; at--)
            stack[at] = stack[at - 1];
        stack[at] = other;
    }
    *height = top;
    return (uint32_t)nearest;
}

// The same for a ray that any hit ends: in no order.
static inline uint32_t descend_any(Entered *stack, uint32_t *height, const CoWideNode *node,
                                   uint32_t bits)
{
    uint32_t first = (uint32_t)__builtin_ctz(bits), top = *height;
    for (bits &= bits - 1; bits; bits &= bits - 1)
        stack[top++] = ENTERED_ANYWHERE | node->child[__builtin_ctz(bits)];
    *height = top;
    return node->child[first];
}

static inline bool is_empty(const CoObject *object)
{
    return object->top ? object->top->tree.node_count == 0
                       : !object->bvh || object->bvh->tree.node_count == 0;
}

static inline Walk walk_of(const CoObject *object, uint32_t path)
{
    return (Walk){object->top ? &object->top->tree : &object->bvh->tree,
                  object->top ? NULL : object->bvh, object, path};
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

static void enter_instance(Group *group, Ray *ray, const Slab *tight, const Walk *walk,
                           uint32_t index);

// One ray through what lies below `ref`. tight: in a group, slabs for meshes that stand as they
// are.
static void walk_slabs(Group *group, Ray *ray, const Slab *slab, const Slab *tight,
                       const Walk *walk, uint32_t ref)
{
    Entered stack[CO_STACK_SIZE];
    float entry[CO_NODE_WIDTH];
    uint32_t height = 0, nodes = 0;
    const CoBvh *bvh = walk->bvh;
    const bool is_any = group->occlusion >> ray->slot & 1u;
    for (;;) {
        if (!(ref & CO_REF_LEAF)) {
            const CoWideNode *node = &walk->tree->nodes[ref];
            uint32_t bits = slab_node(node, slab, co_lane_set1(ray->to), entry);
            nodes++;
            if (ray->is_huge)
                bits &= present_children(node);
            if (bits) {
                if (bvh && (bits & (bits - 1)))
                    prefetch_children(bvh, node, bits);
                ref = is_any ? descend_any(stack, &height, node, bits)
                             : descend(stack, &height, node, bits, entry);
                continue;
            }
        } else if (!bvh) {
            enter_instance(group, ray, tight, walk, ref & ~CO_REF_LEAF);
        } else if (bvh->patches) {
            if (trace_grid_leaf(group, ray, bvh, ref, walk->path))
                break;
        } else if (trace_leaf(group, ray, bvh, ref, walk->path)) {
            break;
        }
        while (height > 0 && !(entered_at(stack[height - 1]) <= ray->to))
            height--;
        if (height == 0)
            break;
        ref = (uint32_t)stack[--height];
    }
    count_nodes(group, walk, nodes, nodes);
}

static void walk_single(Group *group, Ray *ray, const Walk *walk, uint32_t ref)
{
    Slab slab, tight;
    slab_load(ray, &slab);
    if (!walk->bvh)
        slab_fill(ray, ray->near_tight, ray->far_tight, &tight);
    walk_slabs(group, ray, &slab, &tight, walk, ref);
}

// Where a ray enters and leaves an instance, and may still hit.
typedef struct Passage {
    float entry, exit, from, to;
} Passage;

// Through a mesh that stands in its group as it is: the ray stays what it is, but for the padding.
// That of `tight` suits everything up to the ray's distance.
static void enter_in_place(Group *group, Ray *ray, const Slab *tight, const Walk *below,
                           float distance, const Passage *passage)
{
    float entry = ray->entry, exit = ray->exit, pad = ray->pad;
    ray->entry = passage->entry;
    ray->exit = passage->exit;
    ray->to = passage->to;
    ray->pad = padding(distance, 0.0f, 0.0f);
    walk_slabs(group, ray, tight, NULL, below, 0);
    ray->entry = entry;
    ray->exit = exit;
    ray->pad = pad;
}

// Through an object in a space of its own.
static void enter_space(Group *group, const Ray *ray, Ray *inner, const Walk *below,
                        const Passage *passage)
{
    inner->entry = passage->entry;
    inner->exit = passage->exit;
    inner->from = passage->from;
    inner->to = passage->to;
    inner->slot = ray->slot;
    if (co_four_same3(inner->dir, ray->dir)) // many transforms only move
        ray_share_direction(ray, inner);
    else
        ray_set_direction(inner);
    if (ray_set_origin(inner, &below->tree->box, below->bvh ? 0.0f : CO_TRANSFORM_SLACK))
        walk_single(group, inner, below, 0);
}

// One ray of a group's space through one of its instances.
static void enter_instance(Group *group, Ray *ray, const Slab *tight, const Walk *walk,
                           uint32_t index)
{
    const CoTop *top = walk->object->top;
    const CoInstance *instance = &walk->object->instances[index];
    const CoObject *object = &group->scene->objects[instance->object];
    const CoBox *box = &top->boxes[index];
    if (instance->hidden_from && group->flags && group->flags[ray->slot] & instance->hidden_from)
        return;
    Passage passage = {.entry = ray->entry, .exit = ray->exit};
    float to = ray->to;
    if (is_empty(object) ||
        !slab_box(ray, box_corner(box->lo), box_corner(box->hi), &passage.entry, &passage.exit))
        return;
    passage.from = float_max(ray->from, passage.entry);
    passage.to = float_min(to, passage.exit);
    if (!(passage.from <= passage.to))
        return;
    const Walk below = walk_of(object, walk->path + top->first_path[index]);
    Ray inner;
    ray_transform(ray, &instance->to_object, &inner);
    float distance = box_distance(ray->org, &below.tree->box);
    if (below.bvh && distance <= ray->distance && co_four_same3(inner.org, ray->org) &&
        co_four_same3(inner.dir, ray->dir))
        enter_in_place(group, ray, tight, &below, distance, &passage);
    else
        enter_space(group, ray, &inner, &below, &passage);
    ray->to = float_min(to, group->best_t[ray->slot]);
}

#endif
