// Traversal of groups of up to 64 rays: as a stream while several of them are active, one by one
// below.
//
// Source: Eisenacher et al. 2013, 3.1; Tsakok 2009. A group goes down a tree with one 64-bit mask
// of active rays per node, so that a node is fetched once for all of them and tested for many at a
// time. Where few are left, each goes on alone: that is the measure of coherence. Compiled once per
// instruction set.

#include "accel/kernels/traverse.h"
#include "accel/kernels/stream.h"

enum {
    NARROW_MOST = 16,     // active rays up to which each is tested against all children at once
    LEAF_SINGLE_MOST = 2, // to a vector of a leaf, up to which each is tested against all triangles
    LATE_LEAVES = 2       // leaves asked for and not yet looked at
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

// Offers a ray the triangles `pierced` of a leaf. Returns true when it needs no more.
static inline bool offer_pierced(Group *group, Ray *ray, const CoTriLeaf *leaf, const Shear *shear,
                                 uint32_t pierced, uint32_t path, LeafHits *hits)
{
    for (; pierced; pierced &= pierced - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(pierced);
        if ((hits->unsure >> i & 1u) && !pierce_lane(leaf, shear, i, hits))
            continue;
        Hit hit = {hits->t[i], hits->u[i], hits->v[i], path, leaf->tri[i]};
        if (clamp_hit(leaf, ray, i, &hit.t) &&
            offer_hit(group, ray->slot, &hit, ray->exit, &ray->to))
            return true;
    }
    return false;
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
    return offer_pierced(group, ray, &leaf, &shear, pierced, path, &hits);
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

// Ray j alone against a leaf; the whole of it is looked at only if it hits.
static inline void stream_leaf_ray(Group *group, Rays *rays, uint32_t j, const CoTriLeaf *leaf,
                                   uint32_t count, uint32_t path)
{
    LeafHits hits;
    Shear shear;
    Ray ray;
    rays_shear(rays, j, &shear);
    group->stats->triangles += count;
    shear_points(leaf, &shear, CO_LEAF_WIDTH, &hits);
    uint32_t pierced = pierce_triangles(leaf, &shear, count, &hits);
    if (!pierced)
        return;
    rays_single(rays, j, &ray);
    if (offer_pierced(group, &ray, leaf, &shear, pierced, path, &hits))
        rays->done |= 1ull << j;
    rays->to[j] = ray.to;
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
            for (; bits; bits &= bits - 1)
                stream_leaf_ray(group, rays, j + (uint32_t)__builtin_ctz(bits), &leaf, count, path);
        }
    }
}

#include "accel/kernels/single.h"

// Rays `active` of a group go through a tree alone.
static void walk_alone(Group *group, Rays *rays, uint64_t active, const Walk *walk)
{
    for (; active; active &= active - 1) {
        uint32_t j = (uint32_t)__builtin_ctzll(active);
        Ray ray;
        rays_single(rays, j, &ray);
        walk_single(group, &ray, walk, 0);
        rays_settle(rays, j, ray.to);
    }
}

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
    uint32_t height, late_first, late_count;
    StreamEntry late[LATE_LEAVES]; // a ring
    StreamEntry stack[CO_STACK_SIZE];
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

static inline void visit_late(Stream *stream)
{
    uint32_t ref, at = stream->late_first;
    stream->late_first = (at + 1) % LATE_LEAVES;
    stream->late_count--;
    uint64_t active = revisit(stream, &stream->late[at], &ref);
    if (active)
        stream_leaf(stream->group, stream->rays, active, stream->walk->bvh, ref,
                    stream->walk->path);
}

// Asks for a leaf and comes back to it when others have been asked for: by then it is there.
static inline void defer_leaf(Stream *stream, const StreamEntry *entry, uint64_t active,
                              uint32_t ref)
{
    const CoBvh *bvh = stream->walk->bvh;
    const char *leaf = (const char *)bvh->leaf_at + (ref & CO_REF_LEAF_PLACE) * bvh->leaf_stride;
    StreamEntry late = *entry;
    late.active = active;
    late.hits = stream->group->hits;
    __builtin_prefetch(leaf);
    __builtin_prefetch(leaf + 64);
    __builtin_prefetch(leaf + 128);
    if (stream->late_count == LATE_LEAVES)
        visit_late(stream);
    stream->late[(stream->late_first + stream->late_count++) % LATE_LEAVES] = late;
}

// A node's children are tested once for all rays while they are many, and then, when their turn
// comes, ray by ray; for few rays at once.
static inline void visit_node(Stream *stream, uint32_t ref, uint64_t active, const Beam *beam)
{
    const CoWideNode *node = &stream->walk->tree->nodes[ref];
    uint32_t most = (uint32_t)__builtin_popcountll(active), hits = stream->group->hits;
    StreamNode found;
    if (most > NARROW_MOST) {
        hits = UINT32_MAX;
        found.bits = beam_node(node, beam, &stream->rows, found.entry);
        for (int i = 0; i < CO_NODE_WIDTH; i++)
            found.active[i] = active;
    } else {
        stream_node(node, stream->rays, &stream->rows, active, &found);
    }
    if (stream->walk->bvh && (found.bits & (found.bits - 1)))
        prefetch_children(stream->walk->bvh, node, found.bits);
    push_children(stream, ref, &found, hits);
    count_nodes(stream->group, stream->walk, 1, most);
}

// Rays `active`, whose directions have the same signs, through a tree.
static void walk_stream(Group *group, Rays *rays, uint64_t active, const Walk *walk)
{
    Stream stream;
    Beam beam = {.is_safe = false};
    const uint32_t any = (uint32_t)__builtin_ctzll(active);
    stream.group = group;
    stream.rays = rays;
    stream.walk = walk;
    stream.rows = stream_rows(rays, any);
    stream.height = stream.late_first = stream.late_count = 0;
    if (__builtin_popcountll(active) > NARROW_MOST)
        beam_load(rays, any, &beam);
    visit_node(&stream, 0, active, &beam);
    while (stream.height > 0) {
        uint32_t ref;
        const StreamEntry *entry = &stream.stack[--stream.height];
        active = revisit(&stream, entry, &ref);
        if (!active)
            continue;
        if (!(ref & CO_REF_LEAF))
            visit_node(&stream, ref, active, &beam);
        else if (walk->bvh && __builtin_popcountll(active) > NARROW_MOST)
            stream_leaf(group, rays, active, walk->bvh, ref, walk->path);
        else if (walk->bvh)
            defer_leaf(&stream, entry, active, ref);
        else
            trace_instance(group, rays, &stream.rows, active, walk, ref & ~CO_REF_LEAF);
    }
    while (stream.late_count)
        visit_late(&stream);
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

// Where rays enter and leave a box, as slab_box has it. Returns those that do.
static inline uint32_t enter_box(const Rays *rays, const StreamRows *rows, uint32_t j,
                                 const CoBox *box, CoWide *from, CoWide *to)
{
    const float *planes[2] = {box->lo, box->hi};
    *from = co_wide_load(rays->entry + j);
    *to = co_wide_load(rays->exit + j);
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t near_side = rows->near[k] & 1u;
        CoWide org = co_wide_load(rays->org[k] + j), inv = co_wide_load(rays->inv[k] + j);
        CoWide shift = co_wide_mul(co_wide_abs(org), co_wide_set1(0x1p-23f));
        shift = co_wide_add(shift, co_wide_load(rays->pad + j));
        shift = co_wide_copysign(shift, inv);
        CoWide near = co_wide_sub(co_wide_set1(planes[near_side][k]), co_wide_add(org, shift));
        CoWide far = co_wide_sub(co_wide_set1(planes[near_side ^ 1u][k]), co_wide_sub(org, shift));
        *from = co_wide_max(co_wide_mul(near, inv), *from);
        *to = co_wide_min(co_wide_mul(far, inv), *to);
    }
    return co_wide_bits(co_wide_le(*from, *to));
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

// Rays `active` of a group's space through one of its instances.
static void trace_instance(Group *group, Rays *rays, const StreamRows *rows, uint64_t active,
                           const Walk *walk, uint32_t index)
{
    const CoTop *top = walk->object->top;
    const CoInstance *instance = &walk->object->instances[index];
    const CoObject *object = &group->scene->objects[instance->object];
    if (is_empty(object))
        return;
    Rays inner;
    inner.count = 0;
    take_inner(rays, rows, active, &top->boxes[index], &inner);
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
