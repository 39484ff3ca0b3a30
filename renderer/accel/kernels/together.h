// Rays of a group through a tree together, from node to node while any of them is active. Part of
// traverse.c.
//
// Source: Tsakok 2009; for bounds of many rays: Boulos, Wald, Shirley 2006 (interval arithmetic).

#ifndef CO_ACCEL_KERNELS_TOGETHER_H
#define CO_ACCEL_KERNELS_TOGETHER_H

static void trace_instance(Group *group, Rays *rays, const StreamRows *rows, uint64_t active,
                           const Walk *walk, uint32_t index);

typedef struct StreamEntry {
    uint64_t active; // rays that entered the child
    float entry;     // of the first of them, at the earliest
    uint32_t node;
    uint32_t child; // of that node
    uint32_t hits;  // of the group when they did
} StreamEntry;

// A walk of rays whose directions have the same signs.
typedef struct Stream {
    Group *group;
    Rays *rays;
    const Walk *walk;
    StreamRows rows;
    Beam beam;
    uint32_t height, late_first, late_count;
    StreamEntry late[LATE_PLACES]; // a ring
    StreamEntry stack[LATE_STACK + CO_NODE_WIDTH + CO_STACK_SIZE];
} Stream;

// Pushes the children that are entered, the nearest last.
static inline void push_children(Stream *stream, uint32_t node, const StreamNode *found,
                                 uint32_t hits)
{
    StreamEntry *stack = stream->stack;
    uint32_t base = stream->height, height = base;
    for (uint32_t bits = found->bits; bits; bits &= bits - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(bits), at = height++;
        for (; at > base && stack[at - 1].entry < found->entry[i]; at--)
            stack[at] = stack[at - 1];
        stack[at] = (StreamEntry){found->active[i], found->entry[i], node, i, hits};
    }
    stream->height = height;
}

// Rays that still enter a child. Sets its reference.
static inline uint64_t revisit(const Stream *stream, const StreamEntry *entry, uint32_t *ref)
{
    const CoWideNode *node = &stream->walk->tree->nodes[entry->node];
    uint64_t active = entry->active & ~stream->rays->done;
    *ref = node->child[entry->child];
    if (active && entry->hits != stream->group->hits)
        active = stream_child(node, entry->child, stream->rays, &stream->rows, active);
    return active;
}

// A node's children are tested once for all rays while they are many, and then, when their turn
// comes, ray by ray; for few rays at once.
static inline void visit_node(Stream *stream, uint32_t ref, uint64_t active)
{
    const CoWideNode *node = &stream->walk->tree->nodes[ref];
    uint32_t most = (uint32_t)__builtin_popcountll(active), hits = stream->group->hits;
    StreamNode found;
    if (most > NARROW_MOST) {
        hits = UINT32_MAX;
        found.bits = beam_node(node, &stream->beam, &stream->rows, found.entry);
        for (int i = 0; i < CO_NODE_WIDTH; i++)
            found.active[i] = active;
    } else {
        stream_node(node, stream->rays, &stream->rows, active, &found);
    }
    push_children(stream, ref, &found, hits);
    count_nodes(stream->group, stream->walk, 1, most);
}

static inline void visit(Stream *stream, uint32_t ref, uint64_t active)
{
    const Walk *walk = stream->walk;
    if (!(ref & CO_REF_LEAF))
        visit_node(stream, ref, active);
    else if (walk->bvh)
        stream_leaf(stream->group, stream->rays, &stream->rows, active, walk->bvh, ref, walk->path);
    else
        trace_instance(stream->group, stream->rays, &stream->rows, active, walk,
                       ref & ~CO_REF_LEAF);
}

static inline void visit_late(Stream *stream)
{
    uint32_t ref, at = stream->late_first;
    stream->late_first = (at + 1) % LATE_PLACES;
    stream->late_count--;
    uint64_t active = revisit(stream, &stream->late[at], &ref);
    if (active)
        visit(stream, ref, active);
}

// Asks for a node or leaf of a mesh and comes back to it when others have been asked for: by then
// it is there.
static inline void defer(Stream *stream, const StreamEntry *entry, uint64_t active, uint32_t ref)
{
    const CoBvh *bvh = stream->walk->bvh;
    const char *at = (const char *)&bvh->tree.nodes[ref];
    if (ref & CO_REF_LEAF)
        at = (const char *)bvh->leaf_at + (ref & CO_REF_LEAF_PLACE) * bvh->leaf_stride;
    StreamEntry late = *entry;
    late.active = active;
    late.hits = stream->group->hits;
    for (size_t line = 0; line < sizeof(CoWideNode); line += 64) // usual leaves are smaller
        __builtin_prefetch(at + line);
    if (stream->late_count == LATE_PLACES)
        visit_late(stream);
    stream->late[(stream->late_first + stream->late_count++) % LATE_PLACES] = late;
}

// Rays `active`, whose directions have the same signs, through a tree.
static void walk_stream(Group *group, Rays *rays, uint64_t active, const Walk *walk)
{
    Stream stream;
    const uint32_t any = (uint32_t)__builtin_ctzll(active);
    stream.group = group;
    stream.rays = rays;
    stream.walk = walk;
    stream.rows = stream_rows(rays, any);
    stream.height = stream.late_first = stream.late_count = 0;
    stream.beam = (Beam){.is_safe = false};
    if (__builtin_popcountll(active) > NARROW_MOST)
        beam_load(rays, any, &stream.beam);
    visit_node(&stream, 0, active);
    while (stream.height > 0 || stream.late_count > 0) {
        if (stream.height == 0) {
            visit_late(&stream);
            continue;
        }
        uint32_t ref;
        const StreamEntry *entry = &stream.stack[--stream.height];
        active = revisit(&stream, entry, &ref);
        if (!active)
            continue;
        // Going deep first needs CO_STACK_SIZE; what is put off needs more while there is room.
        if (walk->bvh && __builtin_popcountll(active) <= LATE_MOST && stream.height <= LATE_STACK)
            defer(&stream, entry, active, ref);
        else
            visit(&stream, ref, active);
    }
}

// All rays through an object in whose space they are.
static void trace_object(Group *group, Rays *rays, const CoObject *object, uint32_t path)
{
    const Walk walk = walk_of(object, path);
    rays_prepare(rays, &walk.tree->box, object->top ? CO_TRANSFORM_SLACK : 0.0f);
    uint64_t left = ~0ull >> (CO_GROUP_RAYS - rays->count);
    walk_alone(group, rays, left & rays->huge, &walk);
    left &= ~rays->huge;
    while (left) {
        uint64_t same = same_signs(rays, left, (uint32_t)__builtin_ctzll(left));
        left &= ~same;
        walk_stream(group, rays, same, &walk);
    }
}

// Takes those of the rays `active` that meet the box to the end of `inner`.
static inline void take_inner(const Rays *rays, const StreamRows *rows, uint64_t active,
                              const CoBox *box, Rays *inner)
{
    for (uint32_t j = 0; next_vector(active, &j); j += CO_WIDE_WIDTH) {
        CoWide lane[10];
        float fields[10][CO_WIDE_WIDTH];
        uint32_t bits = enter_box(rays, rows, j, box, &lane[6], &lane[7]);
        lane[8] = co_wide_max(co_wide_load(rays->from + j), lane[6]);
        lane[9] = co_wide_min(co_wide_load(rays->to + j), lane[7]);
        bits &= co_wide_bits(co_wide_le(lane[8], lane[9])) & (uint32_t)(active >> j);
        bits &= (uint32_t)WIDE_MASK;
        float *const to[10] = {inner->org[0], inner->org[1], inner->org[2], inner->dir[0],
                               inner->dir[1], inner->dir[2], inner->entry,  inner->exit,
                               inner->from,   inner->to};
        for (int k = 0; k < 3; k++) {
            lane[k] = co_wide_load(rays->org[k] + j);
            lane[3 + k] = co_wide_load(rays->dir[k] + j);
        }
        uint32_t n = inner->count;
        for (int f = 0; f < 10; f++)
            co_wide_store(bits == WIDE_MASK ? to[f] + n : fields[f], lane[f]);
        for (uint32_t left = bits; left; left &= left - 1, n++) {
            uint32_t i = (uint32_t)__builtin_ctz(left);
            inner->slot[n] = rays->slot[j + i];
            inner->outer[n] = (uint8_t)(j + i);
            for (int f = 0; f < 10 && bits != WIDE_MASK; f++)
                to[f][n] = fields[f][i];
        }
        inner->count = n;
    }
}

// Rays that may meet what is hidden from some.
static uint64_t not_hidden(const Group *group, const Rays *rays, uint64_t active, uint32_t hidden)
{
    for (uint64_t left = group->flags ? active : 0; left; left &= left - 1) {
        uint32_t j = (uint32_t)__builtin_ctzll(left);
        if (group->flags[rays->slot[j]] & hidden)
            active &= ~(1ull << j);
    }
    return active;
}

// Rays `active` of a group's space through one of its instances.
static void trace_instance(Group *group, Rays *rays, const StreamRows *rows, uint64_t active,
                           const Walk *walk, uint32_t index)
{
    const CoTop *top = walk->object->top;
    const CoInstance *instance = &walk->object->instances[index];
    const CoObject *object = &group->scene->objects[instance->object];
    if (is_empty(object))
        return;
    if (instance->hidden_from)
        active = not_hidden(group, rays, active, instance->hidden_from);
    Rays inner;
    inner.count = 0;
    take_inner(rays, rows, active, &top->placed[index].box, &inner);
    if (inner.count == 0)
        return;
    rays_pad(&inner);
    rays_transform(&inner, &instance->to_object);
    trace_object(group, &inner, object, walk->path + top->first_path[index]);
    for (uint32_t n = 0; n < inner.count; n++)
        rays_settle(rays, inner.outer[n], group->best_t[inner.slot[n]]);
}

#endif
