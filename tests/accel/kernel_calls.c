#include "kernel_calls.h"

#include "accel/kernels/stream.h"

// Nodes are written as builders write them.
static CoBox make_node(const CoBox *boxes, uint32_t box_count, CoWideNode *node)
{
    CoBox all;
    co_box_empty(&all);
    co_wide_node_clear(node);
    for (uint32_t i = 0; i < box_count; i++) {
        co_wide_node_set(node, (int)i, &boxes[i], CO_REF_LEAF | i);
        co_box_extend(&all, boxes[i].lo, boxes[i].hi);
    }
    return all;
}

static void call_alone(const CoBox *boxes, uint32_t box_count, const CoWideNode *node, Ray *ray,
                       KernelAnswer *out)
{
    Slab slab;
    SlabEnds ends;
    slab_load(ray, &slab);
    slab_ends(ray->near_c, ray->far_c, &ends);
    out->is_huge = ray->is_huge;
    out->alone.bits = slab_node(node, &slab, &ends, co_lane_set1(ray->to), out->alone.entry);
    if (ray->is_huge)
        out->alone.bits &= present_children(node);
    out->interval.bits = 0;
    for (uint32_t i = 0; i < box_count; i++) {
        out->interval.entry[i] = ray->from;
        out->exit[i] = ray->to;
        out->interval.bits |=
            (uint32_t)slab_box(ray, ray->pad, box_corner(boxes[i].lo), box_corner(boxes[i].hi),
                               &out->interval.entry[i], &out->exit[i])
            << i;
    }
}

// At most what the order of a child was made from.
static float ordered_entry(uint16_t order)
{
    union {
        uint32_t u;
        float f;
    } bits = {(uint32_t)order << 16 | (order >> 15 ? 0xffffu : 0)};
    return bits.f;
}

// Those of one mix of signs.
static void call_together(const CoWideNode *node, const Rays *rays, uint64_t same,
                          KernelAnswer *out)
{
    const StreamSlabs slabs = stream_slabs(rays, (uint32_t)__builtin_ctzll(same));
    StreamNode found, bounds;
    Beam beam;
    KernelNode all;
    stream_node(node, rays, &slabs, same, &found);
    beam_load(rays, (uint32_t)__builtin_ctzll(same), &beam);
    if (beam.is_safe)
        beam_node(node, &beam, &slabs, same, &bounds);
    else
        bounds = found;
    all.bits = bounds.bits;
    for (uint32_t i = 0; i < CO_NODE_WIDTH; i++) {
        uint64_t again = stream_child(node, i, rays, &slabs, same);
        all.entry[i] = ordered_entry(bounds.order[i]);
        for (uint64_t left = same; left; left &= left - 1) {
            uint32_t j = (uint32_t)__builtin_ctzll(left);
            KernelAnswer *answer = &out[rays->slot[j]];
            answer->together.bits |= (uint32_t)(found.active[i] >> j & 1u) << i;
            answer->together.entry[i] = ordered_entry(found.order[i]); // of the first ray
            answer->again |= (uint32_t)(again >> j & 1u) << i;
        }
    }
    for (uint64_t left = same; left; left &= left - 1)
        out[rays->slot[__builtin_ctzll(left)]].beam = all;
}

void CO_LANE_NAME(kernel_calls)(const CoBox *boxes, uint32_t box_count, float relative,
                                const KernelRay *rays, uint32_t count, KernelAnswer *out)
{
    CoWideNode node;
    CoBox all = make_node(boxes, box_count, &node);
    Rays group;
    group.count = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t j = group.count++;
        Ray ray = {.from = rays[i].from, .to = rays[i].to, .entry = -INFINITE, .exit = INFINITE};
        for (int k = 0; k < 3; k++) {
            ray.org[k] = group.org[k][j] = rays[i].org[k];
            ray.dir[k] = group.dir[k][j] = rays[i].dir[k];
        }
        group.entry[j] = -INFINITE;
        group.exit[j] = INFINITE;
        group.from[j] = rays[i].from;
        group.to[j] = rays[i].to;
        group.slot[j] = (uint8_t)i;
        out[i] = (KernelAnswer){.is_fit = ray_prepare(&ray, &all, relative)};
        if (out[i].is_fit)
            call_alone(boxes, box_count, &node, &ray, &out[i]);
    }
    rays_pad(&group);
    rays_prepare(&group, &all, relative);
    uint64_t left = (~0ull >> (CO_GROUP_RAYS - count)) & ~group.huge;
    while (left) {
        uint64_t same = same_signs(&group, left, (uint32_t)__builtin_ctzll(left));
        call_together(&node, &group, same, out);
        left &= ~same;
    }
}
