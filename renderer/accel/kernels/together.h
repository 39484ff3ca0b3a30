// Rays of a group through a tree together, from node to node while any of them is active. Part of
// traverse.c.
//
// Source: Tsakok 2009; for bounds of many rays: Boulos, Wald, Shirley 2006 (interval arithmetic).

#ifndef CO_ACCEL_KERNELS_TOGETHER_H
#define CO_ACCEL_KERNELS_TOGETHER_H

// A child to be visited, by the rays that entered it.
typedef struct StreamChild {
    uint64_t active;
    uint64_t nearer; // rays that have come to end nearer since it was tested
    const CoWideNode *node;
    uint32_t place; // among its children; BOUNDED: only bounds of the rays were tested
    uint32_t ref;
} StreamChild;

#define BOUNDED ((uint32_t)CO_NODE_WIDTH)

// A walk of rays whose directions have the same signs.
typedef struct Stream {
    Group *group;
    Rays *rays;
    const Walk *walk;
    StreamSlabs slabs;
    Beam beam;
    uint32_t height;
    uint32_t late_next, late_count;
    StreamChild late[LATE_PLACES]; // a ring
    // Two trees deep: of the group and of a mesh that stands in it as it is. The first is no child.
    StreamChild stack[1 + LATE_STACK + 2 * CO_STACK_SIZE];
} Stream;

static void trace_instance(Stream *stream, uint64_t active, uint32_t index);

// Makes known which rays have come to end nearer.
static inline void spread_nearer(Stream *stream)
{
    uint64_t nearer = stream->rays->nearer;
    stream->rays->nearer = 0;
    stream->stack[stream->height].nearer |= nearer;
    for (uint32_t i = 0; i < LATE_PLACES; i++)
        stream->late[i].nearer |= nearer;
}

// Asks for the instances among the children that are entered.
static inline __attribute__((always_inline)) void
prefetch_placed(const CoTop *top, const CoWideNode *node, uint32_t bits)
{
    for (; bits; bits &= bits - 1) {
        uint32_t ref = node->child[__builtin_ctz(bits)];
        if (ref & CO_REF_LEAF)
            __builtin_prefetch(&top->placed[ref & ~CO_REF_LEAF]);
    }
}

// Puts the children that rays enter on the stack, the nearest last. They are tested once for all
// rays while these are many, and then, when their turn comes, ray by ray; for few rays at once.
static inline void visit_node(Stream *stream, uint32_t ref, uint64_t active)
{
    const CoWideNode *node = &stream->walk->tree->nodes[ref];
    StreamNode found;
    uint32_t most = (uint32_t)__builtin_popcountll(active), bounded = 0;
    if (most > NARROW_MOST && stream->beam.is_safe) {
        bounded = BOUNDED;
        beam_node(node, &stream->beam, &stream->slabs, active, &found);
    } else {
        stream_node(node, stream->rays, &stream->slabs, active, &found);
    }
    if (!stream->walk->bvh)
        prefetch_placed(stream->walk->object->top, node, found.bits);
    count_nodes(stream->group, stream->walk, 1, most);
    stream->height += (uint32_t)__builtin_popcount(found.bits);
    StreamChild *child = &stream->stack[stream->height];
    for (; found.bits; found.bits &= found.bits - 1) {
        uint32_t place = co_take_least(found.order) & (CO_NODE_WIDTH - 1u);
        *child-- = (StreamChild){found.active[place], 0, node, place | bounded, node->child[place]};
    }
}

// Takes the nearest child that was found last off the stack.
static inline StreamChild take_child(Stream *stream)
{
    StreamChild *child = &stream->stack[stream->height--];
    child[-1].nearer |= child->nearer;
    return *child;
}

// Drops rays that do not enter a child, or not any more. False when none is left.
static inline bool revisit(const Stream *stream, StreamChild *child)
{
    const uint64_t stale = child->place & BOUNDED ? ~0ull : child->nearer;
    child->place &= ~BOUNDED;
    child->nearer = 0;
    child->active &= ~stream->rays->done;
    if (child->active & stale)
        child->active &= ~stale | stream_child(child->node, child->place, stream->rays,
                                               &stream->slabs, child->active & stale);
    return child->active != 0;
}

static inline void visit(Stream *stream, const StreamChild *child)
{
    const Walk *walk = stream->walk;
    if (!(child->ref & CO_REF_LEAF)) {
        visit_node(stream, child->ref, child->active);
        return;
    }
    if (walk->bvh)
        stream_leaf(&(StreamAsk){stream->group, stream->rays, walk, &stream->slabs, &stream->beam},
                    child->active, child->ref);
    else
        trace_instance(stream, child->active, child->ref & ~CO_REF_LEAF);
    if (stream->rays->nearer)
        spread_nearer(stream);
}

// Where nodes or leaves of a mesh stand.
typedef struct Shelf {
    const char *at;
    size_t stride;
} Shelf;

// Asks for a node or leaf of a mesh. Which of them it is cannot be guessed: no branch is taken on
// it.
static inline __attribute__((always_inline)) void prefetch_child(const Shelf shelves[2],
                                                                 uint32_t ref)
{
    const Shelf *shelf = &shelves[ref >> 31];
    const char *at = shelf->at + (ref & CO_REF_LEAF_PLACE) * shelf->stride;
    for (size_t line = 0; line < sizeof(CoWideNode); line += 64) // usual leaves are smaller
        __builtin_prefetch(at + line);
}

// What few rays enter is asked for, and its turn comes when others have been asked for: by then it
// is there. Puts off a child and takes the one that has waited longest in its place; false when
// none has waited long enough.
static inline bool put_off(Stream *stream, const Shelf shelves[2], StreamChild *child)
{
    StreamChild *place = &stream->late[stream->late_next];
    const StreamChild latest = *child;
    const bool is_full = stream->late_count == LATE_PLACES;
    prefetch_child(shelves, child->ref);
    if (is_full)
        *child = *place;
    *place = latest;
    stream->late_next = (stream->late_next + 1) % LATE_PLACES;
    stream->late_count += !is_full;
    return is_full;
}

static inline StreamChild take_late(Stream *stream)
{
    return stream->late[(stream->late_next - stream->late_count--) % LATE_PLACES];
}

// Rays `active` through a tree. What is on the stack stays there.
static void descend_tree(Stream *stream, uint64_t active)
{
    const uint32_t base = stream->height;
    const CoBvh *bvh = stream->walk->bvh;
    const bool waits = bvh != NULL;
    Shelf shelves[2] = {{0}};
    if (waits) {
        shelves[0] = (Shelf){(const char *)bvh->tree.nodes, sizeof(CoWideNode)};
        shelves[1] = (Shelf){(const char *)bvh->leaf_at, bvh->leaf_stride};
    }
    StreamChild child;
    visit_node(stream, 0, active);
    for (;;) {
        if (stream->height > base) {
            child = take_child(stream);
            if (child.place & BOUNDED && !revisit(stream, &child))
                continue;
            // Going deep first needs two trees' depths; what is put off needs more while there is
            // room. It is asked for even if no ray enters it any more: that shows later.
            if (waits && __builtin_popcountll(child.active) <= LATE_MOST &&
                stream->height - base <= LATE_STACK && !put_off(stream, shelves, &child))
                continue;
            if (!revisit(stream, &child))
                continue;
        } else if (stream->late_count > 0) {
            child = take_late(stream);
            if (!revisit(stream, &child))
                continue;
        } else {
            return;
        }
        visit(stream, &child);
    }
}

// Rays `active`, whose directions have the same signs, through a tree.
static void walk_stream(Group *group, Rays *rays, uint64_t active, const Walk *walk)
{
    Stream stream;
    const uint32_t any = (uint32_t)__builtin_ctzll(active);
    stream.group = group;
    stream.rays = rays;
    stream.walk = walk;
    stream.slabs = stream_slabs(rays, any);
    stream.height = stream.late_next = stream.late_count = 0;
    stream.stack[0].nearer = 0;
    stream.beam.is_safe = false;
    if (__builtin_popcountll(active) > NARROW_MOST)
        beam_load(rays, any, &stream.beam);
    descend_tree(&stream, active);
}

// Rays that share little of a tree: of many signs, and by far not of one direction around which the
// signs change. Of sorted rays there are hardly such groups; alone they are faster.
static inline bool is_scattered(const Rays *rays, uint64_t all)
{
    uint32_t octants = 0;
    for (uint64_t left = all; left; octants++)
        left &= ~same_signs(rays, left, (uint32_t)__builtin_ctzll(left));
    if (octants < SCATTERED_OCTANTS)
        return false;
    float spread = 0.0f, largest = 0.0f;
    for (int k = 0; k < 3; k++) {
        CoWide low = co_wide_load(rays->dir[k]), high = low;
        for (uint32_t j = 0; j < rays->count; j += CO_WIDE_WIDTH) {
            low = co_wide_min(co_wide_load(rays->dir[k] + j), low);
            high = co_wide_max(co_wide_load(rays->dir[k] + j), high);
        }
        float most = most_of(high), least = least_of(low);
        spread = float_max(most - least, spread);
        largest = float_max(float_max(most, -least), largest);
    }
    return spread > largest;
}

// All rays through an object in whose space they are.
static void trace_object(Group *group, Rays *rays, const Walk *object)
{
    const Walk walk = *object;
    // Where nothing is transformed, nothing is off.
    rays->is_tight = walk.is_in_place;
    rays_prepare(rays, &walk.tree->box, rays->is_tight ? 0.0f : CO_TRANSFORM_SLACK);
    if (!walk.bvh && rays->is_tight && rays->signed_zero) {
        rays->is_tight = false;
        rays_prepare(rays, &walk.tree->box, CO_TRANSFORM_SLACK);
    }
    uint64_t left = ~0ull >> (CO_GROUP_RAYS - rays->count);
    const uint64_t alone = is_scattered(rays, left) ? left : left & rays->huge;
    walk_alone(group, rays, alone, &walk);
    left &= ~alone;
    while (left) {
        uint64_t same = same_signs(rays, left, (uint32_t)__builtin_ctzll(left));
        left &= ~same;
        walk_stream(group, rays, same, &walk);
    }
}

// Takes those of the rays `active` that meet the box to the end of `inner`. Of an instance: hits
// are within the box.
static inline void take_inner(const Rays *rays, const StreamSlabs *slabs, uint64_t active,
                              const CoBox *box, bool is_instance, Rays *inner)
{
    for (uint32_t j = 0; next_vector(active, &j); j += CO_WIDE_WIDTH) {
        CoWide lane[10];
        float fields[10][CO_WIDE_WIDTH];
        lane[6] = co_wide_load(rays->entry + j);
        lane[7] = co_wide_load(rays->exit + j);
        StreamBoxes boxes;
        stream_boxes(rays, slabs, j, co_wide_load(rays->pad + j), &boxes);
        uint32_t bits = enter_box(&boxes, box, &lane[6], &lane[7]);
        lane[8] = co_wide_max(co_wide_load(rays->from + j), lane[6]);
        lane[9] = co_wide_min(co_wide_load(rays->to + j), lane[7]);
        bits &= co_wide_bits(co_wide_le(lane[8], lane[9])) & (uint32_t)(active >> j);
        bits &= (uint32_t)WIDE_MASK;
        const float *const own[4] = {rays->entry, rays->exit, rays->from, rays->to};
        for (int f = 0; f < 4 && !is_instance; f++)
            lane[6 + f] = co_wide_load(own[f] + j);
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

static inline void pad_placed(Rays *rays, uint64_t active, const CoBox *box)
{
    for (uint32_t j = 0; next_vector(active, &j); j += CO_WIDE_WIDTH)
        co_wide_store(rays->placed_pad + j, rays_padding(rays, j, box));
}

// Through a mesh that stands in its group as it is: the rays stay what they are.
static void walk_in_place(Stream *stream, uint64_t active, const Walk *below)
{
    const Walk *walk = stream->walk;
    const StreamSlabs slabs = stream->slabs;
    const Rays *rays = stream->rays;
    stream->walk = below;
    pad_placed(stream->rays, active, &below->tree->box);
    if (!rays->is_tight) {
        stream->slabs.near_c = rays->near_tight;
        stream->slabs.far_c = rays->far_tight;
    }
    descend_tree(stream, active);
    stream->walk = walk;
    stream->slabs = slabs;
}

// Rays that were taken from others, transformed unless that is NULL, and tells these where they end
// now.
static inline void trace_inner(Group *group, Rays *rays, Rays *inner, const CoAffine *to_object,
                               const Walk *below)
{
    if (inner->count == 0)
        return;
    inner->is_in_order = rays->is_in_order && inner->count == rays->count;
    rays_pad(inner);
    if (to_object)
        rays_transform(inner, to_object);
    trace_object(group, inner, below);
    for (uint32_t n = 0; n < inner->count; n++)
        rays_settle(rays, inner->outer[n], group->best_t[inner->slot[n]]);
}

// Rays `active` through a layer of their group. In a function of its own: most groups have none.
static __attribute__((noinline)) void trace_layer(Stream *stream, uint64_t active, uint32_t index)
{
    const Walk below = walk_of_layer(stream->walk, index);
    Rays inner;
    inner.count = 0;
    take_inner(stream->rays, &stream->slabs, active, &below.tree->box, false, &inner);
    trace_inner(stream->group, stream->rays, &inner, NULL, &below);
}

// Rays `active` of a group's space through one of its instances, or a layer.
static void trace_instance(Stream *stream, uint64_t active, uint32_t index)
{
    Group *group = stream->group;
    Rays *rays = stream->rays;
    const CoPlaced *placed = &stream->walk->object->top->placed[index];
    const uint32_t path = stream->walk->path + placed->first_path;
    active = not_hidden(group, rays, active, placed);
    if (placed->is_in_place && active && !(active & rays->signed_zero)) {
        const Walk below = {&placed->bvh->tree, placed->bvh, NULL, path, true, true};
        walk_in_place(stream, active, &below);
        return;
    }
    if (placed->is_layer) {
        trace_layer(stream, active, index);
        return;
    }
    const CoInstance *instance = &stream->walk->object->instances[index];
    const CoObject *object = &group->scene->objects[instance->object];
    if (is_empty(object))
        return;
    Rays inner;
    inner.count = 0;
    take_inner(rays, &stream->slabs, active, &placed->box, true, &inner);
    const Walk below = walk_of_placed(placed, object, path);
    trace_inner(group, rays, &inner, placed->is_baked ? NULL : &instance->to_object, &below);
}

#endif
