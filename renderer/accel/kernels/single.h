// Single rays, several in turns: while one waits for memory another is worked on. Part of
// traverse.c.

#ifndef CO_ACCEL_KERNELS_SINGLE_H
#define CO_ACCEL_KERNELS_SINGLE_H

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

static void enter_instance(Group *group, Ray *ray, const Walk *walk, uint32_t index);

// One ray through what lies below `ref`.
static void walk_single(Group *group, Ray *ray, const Walk *walk, uint32_t ref)
{
    StackEntry stack[CO_STACK_SIZE];
    float entry[CO_NODE_WIDTH];
    uint32_t height = 0, nodes = 0;
    Slab slab;
    slab_load(ray, &slab);
    const CoBvh *bvh = walk->bvh;
    for (;;) {
        if (!(ref & CO_REF_LEAF)) {
            const CoWideNode *node = &walk->tree->nodes[ref];
            uint32_t bits = slab_node(node, &slab, co_lane_set1(ray->to), entry);
            nodes++;
            if (ray->is_huge)
                bits &= present_children(node);
            if (bits) {
                if (bvh && (bits & (bits - 1)))
                    prefetch_children(bvh, node, bits);
                ref = descend(stack, &height, node, bits, entry);
                continue;
            }
        } else if (!bvh) {
            enter_instance(group, ray, walk, ref & ~CO_REF_LEAF);
        } else if (bvh->patches) {
            if (trace_grid_leaf(group, ray, bvh, ref, walk->path))
                break;
        } else if (trace_leaf(group, ray, bvh, ref, walk->path)) {
            break;
        }
        while (height > 0 && !(stack[height - 1].entry <= ray->to))
            height--;
        if (height == 0)
            break;
        ref = stack[--height].ref;
    }
    count_nodes(group, walk, nodes, nodes);
}

// One ray of a group's space through one of its instances.
static void enter_instance(Group *group, Ray *ray, const Walk *walk, uint32_t index)
{
    const CoTop *top = walk->object->top;
    const CoInstance *instance = &walk->object->instances[index];
    const CoObject *object = &group->scene->objects[instance->object];
    const CoBox *box = &top->boxes[index];
    if (instance->hidden_from && group->flags && group->flags[ray->slot] & instance->hidden_from)
        return;
    Ray inner;
    inner.entry = ray->entry;
    inner.exit = ray->exit;
    if (is_empty(object) ||
        !slab_box(ray, box_corner(box->lo), box_corner(box->hi), &inner.entry, &inner.exit))
        return;
    inner.from = float_max(ray->from, inner.entry);
    inner.to = float_min(ray->to, inner.exit);
    inner.slot = ray->slot;
    if (!(inner.from <= inner.to))
        return;
    const Walk below = walk_of(object, walk->path + top->first_path[index]);
    ray_transform(ray, &instance->to_object, &inner);
    if (!ray_prepare(&inner, &below.tree->box, object->top ? CO_TRANSFORM_SLACK : 0.0f))
        return;
    walk_single(group, &inner, &below, 0);
    ray->to = float_min(ray->to, group->best_t[ray->slot]);
}

#endif
