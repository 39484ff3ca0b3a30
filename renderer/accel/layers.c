#include "accel/layers.h"

#include "accel/build.h"
#include "base/memory.h"

#include <math.h>
#include <string.h>

#define TAG CO_MEMORY_ACCEL

enum {
    LAYERS_DEEP = 3, // within each other
    SMALLER = 32     // times: the sides of a layer against those of what holds it
};

// Nodes are padded by 2^-20 of a tree's size and more; where instances are transformed by 2^-18.
// That is to be at most a quarter of a triangle of a mesh in place, or else a sixteenth of what is
// placed.
#define IN_PLACE_REACH 0x1p18
#define PLACED_REACH 0x1p14

// An instance while layers are sought.
typedef struct Member {
    CoBox box;
    uint32_t id;
    float reach; // size of a tree up to which it may stand there
} Member;

typedef struct Planner {
    CoTop *top;
    bool is_out_of_memory;
} Planner;

static float reach_of(const CoPlaced *placed, const CoMesh *mesh)
{
    double size = co_box_size(&placed->box);
    if (placed->is_in_place)
        return (float)fmin(IN_PLACE_REACH * size / sqrt((double)mesh->tri_count + 1.0), 3e38);
    return (float)fmin(PLACED_REACH * size, 3e38);
}

static bool any_out_of_reach(const Member *members, uint32_t count, double size)
{
    for (uint32_t i = 0; i < count; i++)
        if ((double)members[i].reach < size)
            return true;
    return false;
}

static CoBox box_of(const Member *members, uint32_t count)
{
    CoBox box;
    co_box_empty(&box);
    for (uint32_t i = 0; i < count; i++)
        co_box_extend(&box, members[i].box.lo, members[i].box.hi);
    return box;
}

static float center_of(const Member *member, int axis)
{
    return 0.5f * member->box.lo[axis] + 0.5f * member->box.hi[axis];
}

// Brings members whose size, or whose center along an axis from 0 on, is at most so much to the
// front. Returns how many.
static uint32_t bring_forward(Member *members, uint32_t count, int axis, double most)
{
    uint32_t front = 0;
    for (uint32_t i = 0; i < count; i++) {
        double x = axis < 0 ? co_box_size(&members[i].box) : (double)center_of(&members[i], axis);
        if (!(x <= most))
            continue;
        Member moved = members[i];
        members[i] = members[front];
        members[front++] = moved;
    }
    return front;
}

// Halves the longest axis of their centers; returns how many are in the first half.
static uint32_t halve(Member *members, uint32_t count)
{
    CoBox centers;
    co_box_empty(&centers);
    for (uint32_t i = 0; i < count; i++) {
        float at[3];
        for (int k = 0; k < 3; k++)
            at[k] = center_of(&members[i], k);
        co_box_extend(&centers, at, at);
    }
    int axis = 0;
    double middle = 0.0, longest = -1.0;
    for (int k = 0; k < 3; k++) {
        double lo = (double)centers.lo[k], hi = (double)centers.hi[k];
        if (hi - lo > longest) {
            axis = k;
            longest = hi - lo;
            middle = 0.5 * (lo + hi);
        }
    }
    return bring_forward(members, count, axis, middle);
}

static bool add_layer(Planner *p, uint32_t parent)
{
    CoTop *top = p->top;
    void *layers = top->layers;
    p->is_out_of_memory =
        !co_grow(TAG, &layers, top->layer_count, &top->layer_capacity, sizeof *top->layers);
    top->layers = layers;
    if (!p->is_out_of_memory)
        top->layers[top->layer_count++] = (CoLayer){.parent = parent};
    return !p->is_out_of_memory;
}

static void plan_layer(Planner *p, Member *members, uint32_t count, uint32_t layer, uint32_t depth);

// Members of a layer of that size, all small for it: a layer where they stand close together, or
// else looked for in both halves.
static void gather(Planner *p, Member *members, uint32_t count, double size, uint32_t layer,
                   uint32_t depth)
{
    CoBox box = box_of(members, count);
    if (p->is_out_of_memory || count < 2 || !any_out_of_reach(members, count, size))
        return;
    if (co_box_size(&box) <= size / SMALLER) {
        uint32_t inner = p->top->layer_count;
        if (!add_layer(p, layer))
            return;
        for (uint32_t i = 0; i < count; i++)
            p->top->placed[members[i].id].layer = inner;
        plan_layer(p, members, count, inner, depth + 1);
        return;
    }
    uint32_t half = halve(members, count);
    if (half == 0 || half == count)
        return;
    gather(p, members, half, size, layer, depth);
    gather(p, members + half, count - half, size, layer, depth);
}

static void plan_layer(Planner *p, Member *members, uint32_t count, uint32_t layer, uint32_t depth)
{
    CoBox box = box_of(members, count);
    double size = co_box_size(&box);
    if (depth < LAYERS_DEEP)
        gather(p, members, bring_forward(members, count, -1, size / SMALLER), size, layer, depth);
}

// Which stand in place, once it is known in how large a tree, and whether all of a layer do. boxes:
// by layer + 1.
static void settle(CoTop *top, const CoInstance *instances, const CoObject *objects, CoBox *boxes)
{
    for (uint32_t l = 0; l <= top->layer_count; l++)
        co_box_empty(&boxes[l]);
    for (uint32_t i = 0; i < top->count; i++) {
        const CoPlaced *placed = &top->placed[i];
        if (!co_box_is_empty(&placed->box))
            co_box_extend(&boxes[placed->layer + 1], placed->box.lo, placed->box.hi);
    }
    top->is_in_place = true;
    for (uint32_t l = top->layer_count; l-- > 0;) {
        top->layers[l].is_in_place = true;
        co_box_extend(&boxes[top->layers[l].parent + 1], boxes[l + 1].lo, boxes[l + 1].hi);
    }
    for (uint32_t i = 0; i < top->count; i++) {
        CoPlaced *placed = &top->placed[i];
        if (placed->is_in_place)
            placed->is_in_place = (double)reach_of(placed, objects[instances[i].object].mesh) >=
                                  co_box_size(&boxes[placed->layer + 1]);
        if (placed->layer == CO_LAYER_NONE)
            top->is_in_place &= placed->is_in_place || co_box_is_empty(&placed->box);
        else
            top->layers[placed->layer].is_in_place &= placed->is_in_place;
    }
    for (uint32_t l = top->layer_count; l-- > 0;) {
        bool *outer = top->layers[l].parent == CO_LAYER_NONE
                          ? &top->is_in_place
                          : &top->layers[top->layers[l].parent].is_in_place;
        *outer = *outer && top->layers[l].is_in_place;
    }
}

static uint32_t list_members(CoTop *top, const CoInstance *instances, const CoObject *objects,
                             Member *members)
{
    uint32_t used = 0;
    for (uint32_t i = 0; i < top->count; i++) {
        CoPlaced *placed = &top->placed[i];
        placed->layer = CO_LAYER_NONE;
        if (!co_box_is_empty(&placed->box))
            members[used++] =
                (Member){placed->box, i, reach_of(placed, objects[instances[i].object].mesh)};
    }
    return used;
}

// Room for the layers behind the instances.
static bool make_room(CoTop *top)
{
    const size_t count = top->count, all = count + top->layer_count;
    if (all == count)
        return true;
    CoPlaced *placed = co_realloc(TAG, top->placed, count * sizeof *placed, all * sizeof *placed);
    if (!placed)
        return false;
    for (size_t i = count; i < all; i++)
        placed[i] = (CoPlaced){.is_layer = true, .layer = top->layers[i - count].parent};
    top->placed = placed;
    return true;
}

bool co_layers_plan(CoTop *top, const CoInstance *instances, const CoObject *objects)
{
    Planner planner = {.top = top};
    Member *members = co_alloc(TAG, top->count * sizeof *members);
    if (!members && top->count)
        return false;
    plan_layer(&planner, members, list_members(top, instances, objects, members), CO_LAYER_NONE, 0);
    co_free(TAG, members, top->count * sizeof *members);
    CoBox *boxes = co_alloc(TAG, (top->layer_count + 1) * sizeof *boxes);
    if (boxes)
        settle(top, instances, objects, boxes);
    co_free(TAG, boxes, (top->layer_count + 1) * sizeof *boxes);
    bool is_done = !planner.is_out_of_memory && boxes && make_room(top);
    if (!is_done) // there are no places for them
        top->layer_count = 0;
    return is_done;
}

static bool is_listed(const CoPlaced *placed)
{
    return placed->is_layer || !co_box_is_empty(&placed->box);
}

bool co_layers_list(const CoTop *top, CoLayerLists *out)
{
    const uint32_t lists = top->layer_count + 1, all = top->count + top->layer_count;
    *out = (CoLayerLists){.start_count = lists + 1, .member_count = all};
    out->starts = co_alloc_zero(TAG, out->start_count * sizeof *out->starts);
    out->members = co_alloc(TAG, out->member_count * sizeof *out->members);
    if (!out->starts || (!out->members && all))
        return false;
    for (uint32_t i = 0; i < all; i++)
        out->starts[top->placed[i].layer + 2] += is_listed(&top->placed[i]);
    for (uint32_t l = 0; l < lists; l++)
        out->starts[l + 1] += out->starts[l];
    for (uint32_t i = 0; i < all; i++)
        if (is_listed(&top->placed[i]))
            out->members[out->starts[top->placed[i].layer + 1]++] = i;
    // Each start has moved to its list's end.
    memmove(out->starts + 1, out->starts, lists * sizeof *out->starts);
    out->starts[0] = 0;
    return true;
}

void co_layer_lists_clear(CoLayerLists *lists)
{
    co_free(TAG, lists->starts, lists->start_count * sizeof *lists->starts);
    co_free(TAG, lists->members, lists->member_count * sizeof *lists->members);
    *lists = (CoLayerLists){0};
}

void co_layers_clear(CoTop *top)
{
    for (uint32_t l = 0; l < top->layer_count; l++)
        co_tree_clear(&top->layers[l].tree);
    co_free(TAG, top->layers, top->layer_capacity * sizeof *top->layers);
    top->layers = NULL;
    top->layer_capacity = 0;
}

size_t co_layers_bytes(const CoTop *top)
{
    size_t bytes = top->layer_capacity * sizeof *top->layers;
    for (uint32_t l = 0; l < top->layer_count; l++)
        bytes += top->layers[l].tree.node_capacity * sizeof *top->layers[l].tree.nodes;
    return bytes;
}
