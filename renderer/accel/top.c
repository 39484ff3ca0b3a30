// Top levels: boxes of instances, what of a group stands in its tree, and the tree.

#include "accel/bake.h"
#include "accel/build.h"
#include "accel/layers.h"
#include "base/error.h"
#include "base/memory.h"

#include <float.h>
#include <string.h>

// A ray in object space is off by the rounding of to_object (its entries, three products, three
// sums) and of the ray itself; to_object and to_group are each other's inverse only to rounding.
// In sum less than 40 units of 2^-24 of the largest coordinate; the ray's own share is added by the
// kernel.
#define BOX_PADDING 0x1p-18

static bool single_fits(const void *context, const CoBuildPrim *prims, size_t count,
                        CoLeafShape *out)
{
    (void)context;
    *out = (CoLeafShape){.ref = CO_REF_LEAF | prims[0].id};
    return count == 1;
}

static float to_float_range(double x)
{
    double most = (double)FLT_MAX;
    return (float)(x < -most ? -most : x > most ? most : x);
}

// The box of a placed object, padded. False when there is nothing in it or it cannot be placed.
static bool instance_box(const CoInstance *instance, const CoObject *object, CoBox *out)
{
    const float *lo = &object->box_min.x, *hi = &object->box_max.x;
    if (!(lo[0] <= hi[0] && lo[1] <= hi[1] && lo[2] <= hi[2]))
        return false;
    double box_lo[3], box_hi[3], size = 0.0;
    for (int r = 0; r < 3; r++) {
        const float *m = instance->to_group.m[r];
        double sum_lo = (double)m[3], sum_hi = sum_lo, magnitude = fabs(sum_lo);
        for (int k = 0; k < 3; k++) {
            double a = (double)m[k] * (double)lo[k], b = (double)m[k] * (double)hi[k];
            sum_lo += a < b ? a : b;
            sum_hi += a < b ? b : a;
            magnitude += fmax(fabs(a), fabs(b));
        }
        if (!isfinite(sum_lo) || !isfinite(sum_hi))
            return false;
        box_lo[r] = sum_lo;
        box_hi[r] = sum_hi;
        size = fmax(size, magnitude);
    }
    for (int r = 0; r < 3; r++) {
        out->lo[r] = to_float_range(box_lo[r] - BOX_PADDING * size);
        out->hi[r] = to_float_range(box_hi[r] + BOX_PADDING * size);
    }
    return true;
}

static uint64_t object_paths(const CoObject *object)
{
    return object->mesh ? 1 : object->top ? object->top->path_count : 0;
}

static bool is_identity(const CoAffine *a)
{
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 4; k++)
            if (a->m[r][k] != (float)(r == k))
                return false;
    return true;
}

static bool is_within(const CoBox *inner, const CoBox *outer)
{
    for (int k = 0; k < 3; k++)
        if (!(outer->lo[k] <= inner->lo[k] && inner->hi[k] <= outer->hi[k]))
            return false;
    return true;
}

// Says what a walk wants to know of an instance, but for its paths.
static void place(const CoInstance *instance, const CoObject *object, CoPlaced *out)
{
    const CoBvh *bvh = object->top ? NULL : object->bvh;
    *out = (CoPlaced){.hidden_from = instance->hidden_from, .bvh = bvh};
    if (!instance_box(instance, object, &out->box))
        co_box_empty(&out->box);
    if (bvh && bvh->tree.node_count > 0)
        out->is_in_place = is_identity(&instance->to_object);
    else
        out->bvh = NULL;
}

// The same of its tree, once that is known.
static void place_tree(CoPlaced *placed)
{
    const CoBvh *bvh = placed->bvh;
    if (!bvh)
        return;
    placed->nodes = bvh->tree.nodes;
    if (placed->nodes->child[0] & CO_REF_LEAF && placed->nodes->child[1] == CO_REF_NONE)
        placed->root = placed->nodes->child[0];
    placed->is_in_place |= placed->is_baked;
    placed->is_in_place &= is_within(&bvh->tree.box, &placed->box);
}

// Numbers the paths, measures the depth and places the instances. False when memory is out.
static bool survey(CoTop *top, const CoInstance *instances, const CoObject *objects)
{
    top->depth = 1;
    top->path_count = 0;
    for (uint32_t i = 0; i < top->count; i++) {
        const CoObject *object = &objects[instances[i].object];
        place(&instances[i], object, &top->placed[i]);
        top->placed[i].first_path = (uint32_t)top->path_count;
        top->path_count += object_paths(object);
        if (object->top && object->top->depth >= top->depth)
            top->depth = object->top->depth + 1;
    }
    if (!co_bake(top, instances, objects))
        return false;
    for (uint32_t i = 0; i < top->count; i++)
        place_tree(&top->placed[i]);
    return co_layers_plan(top, instances, objects);
}

bool co_top_measure(CoTop *top, const CoInstance *instances, const CoObject *objects)
{
    for (uint32_t i = 0; i < top->count; i++) {
        CoBox box;
        if (instance_box(&instances[i], &objects[instances[i].object], &box) ==
            co_box_is_empty(&top->placed[i].box))
            return false;
    }
    return survey(top, instances, objects) && top->depth <= CO_GROUP_DEPTH_MAX;
}

static bool build_tree(const CoTop *top, const uint32_t *members, uint32_t count, CoTree *out,
                       CohortError *err)
{
    CoLeafRule rule = {.fits = single_fits, .most = 1};
    CoPrimArray prims = {.count = count, .capacity = count};
    CoTreeParts parts;
    prims.prims = co_alloc(CO_MEMORY_ACCEL, count * sizeof *prims.prims);
    CO_CHECK(prims.prims || count == 0, err, COHORT_ERROR_OUT_OF_MEMORY,
             "no memory to build a tree over %u instances", count);
    for (uint32_t i = 0; i < count; i++) {
        const CoBox *box = &top->placed[members[i]].box;
        memcpy(prims.prims[i].lo, box->lo, sizeof box->lo);
        memcpy(prims.prims[i].hi, box->hi, sizeof box->hi);
        prims.prims[i].id = members[i];
    }
    bool is_built = co_tree_build(&prims, &rule, &parts, err);
    *out = parts.tree;
    return is_built;
}

// Of the group and its layers, the inner ones first.
static bool build_trees(CoTop *top, CohortError *err)
{
    CoLayerLists lists;
    bool is_built = co_layers_list(top, &lists);
    if (!is_built)
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "no memory to list %u instances", top->count);
    for (uint32_t l = top->layer_count + 1; is_built && l-- > 0;) {
        const uint32_t *members = lists.members + lists.starts[l];
        CoTree *tree = l ? &top->layers[l - 1].tree : &top->tree;
        is_built = build_tree(top, members, lists.starts[l + 1] - lists.starts[l], tree, err);
        if (l)
            top->placed[top->count + l - 1].box = tree->box;
    }
    co_layer_lists_clear(&lists);
    return is_built;
}

CoTop *co_top_create(const CoInstance *instances, uint32_t count, const CoObject *objects,
                     CohortError *err)
{
    CO_CHECK_NULL(count < CO_REF_NONE / 2, err, COHORT_ERROR_LIMIT,
                  "a group of more than 2^30 - 2 instances; split it into groups");
    CoTop *top = co_alloc_zero(CO_MEMORY_ACCEL, sizeof *top);
    bool is_built = top != NULL;
    if (is_built && count) {
        top->count = count;
        top->placed = co_alloc(CO_MEMORY_ACCEL, count * sizeof *top->placed);
        is_built = top->placed != NULL;
    }
    if (is_built && survey(top, instances, objects)) {
        is_built = top->depth <= CO_GROUP_DEPTH_MAX ||
                   CO_FAIL(err, COHORT_ERROR_LIMIT, "groups are nested more than %d deep",
                           CO_GROUP_DEPTH_MAX);
        is_built = is_built && build_trees(top, err);
    } else {
        is_built = CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "no memory for a group of %u instances",
                           count);
    }
    if (!is_built) {
        co_top_destroy(top);
        return NULL;
    }
    return top;
}

void co_top_destroy(CoTop *top)
{
    if (!top)
        return;
    co_tree_clear(&top->tree);
    co_bake_clear(top);
    co_free(CO_MEMORY_ACCEL, top->placed,
            ((size_t)top->count + top->layer_count) * sizeof *top->placed);
    co_layers_clear(top);
    co_free(CO_MEMORY_ACCEL, top, sizeof *top);
}

size_t co_top_bytes(const CoTop *top)
{
    return sizeof *top + top->tree.node_capacity * sizeof *top->tree.nodes +
           ((size_t)top->count + top->layer_count) * sizeof *top->placed + co_bake_bytes(top) +
           co_layers_bytes(top);
}
