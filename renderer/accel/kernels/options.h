// What a scene may ask of a hit beside that it is the nearest: that it lies behind what a ray has
// passed, such as a cut-out, and that its instance is not hidden from it. Part of traverse.c.
// tests/bench/bare_kernel.c does without, to tell what they cost where nothing asks for them.

#ifndef CO_ACCEL_KERNELS_OPTIONS_H
#define CO_ACCEL_KERNELS_OPTIONS_H

// Where hits of a ray begin.
static inline float start_of(const Group *group, uint32_t slot)
{
    return group->tnear[slot];
}

// Of a vector of rays that stand in their slots.
static inline CoWide starts_of(const Group *group, uint32_t j)
{
    return co_wide_load(group->tnear + j);
}

// Instances are seen by most.
static inline bool is_hidden(const Group *group, const Ray *ray, const CoPlaced *placed)
{
    return placed->hidden_from && group->flags && group->flags[ray->slot] & placed->hidden_from;
}

static uint64_t hide(const Group *group, const Rays *rays, uint64_t active, uint32_t hidden)
{
    for (uint64_t left = group->flags ? active : 0; left; left &= left - 1) {
        uint32_t j = (uint32_t)__builtin_ctzll(left);
        if (group->flags[rays->slot[j]] & hidden)
            active &= ~(1ull << j);
    }
    return active;
}

// Of `active` those that may meet an instance.
static inline uint64_t not_hidden(const Group *group, const Rays *rays, uint64_t active,
                                  const CoPlaced *placed)
{
    return placed->hidden_from ? hide(group, rays, active, placed->hidden_from) : active;
}

#endif
