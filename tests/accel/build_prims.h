// Boxes to build trees over, for the tests of the builder's parts.

#ifndef TESTS_ACCEL_BUILD_PRIMS_H
#define TESTS_ACCEL_BUILD_PRIMS_H

#include "accel/split.h"
#include "accel_scene.h"
#include "base/memory.h"

// How boxes lie.
typedef enum PrimKind {
    PRIMS_ANYWHERE,
    PRIMS_ON_A_LINE, // no extent but along x
    PRIMS_IN_ONE_PLACE,
    PRIMS_HUGE, // up to the largest floats
    PRIMS_TINY, // denormal
    PRIM_KINDS
} PrimKind;

static inline void prims_fill(CoBuildPrim *prims, size_t count, PrimKind kind, uint64_t seed)
{
    Random random = {seed};
    for (size_t i = 0; i < count; i++) {
        CoVec3 center = random_vec3(&random, -1.0f, 1.0f), size = random_vec3(&random, 0.0f, 0.1f);
        if (kind == PRIMS_IN_ONE_PLACE)
            center = size = co_vec3(0.5f, -0.25f, 1.0f);
        if (kind == PRIMS_ON_A_LINE)
            center.y = center.z = size.y = size.z = 0.0f;
        float scale = kind == PRIMS_HUGE ? 3e38f : kind == PRIMS_TINY ? 1e-42f : 1.0f;
        CoVec3 lo = co_scale(co_sub(center, size), 0.9f * scale);
        CoVec3 hi = co_scale(co_add(center, size), 0.9f * scale);
        prims[i] = (CoBuildPrim){.id = (uint32_t)i};
        co_vec3_store(prims[i].lo, lo);
        co_vec3_store(prims[i].hi, hi);
    }
}

static inline CoBox prims_box(const CoBuildPrim *prims, size_t count)
{
    CoBox box;
    co_box_empty(&box);
    for (size_t i = 0; i < count; i++)
        co_box_extend(&box, prims[i].lo, prims[i].hi);
    return box;
}

static inline void assert_same_box(const CoBox *a, const CoBox *b)
{
    for (int k = 0; k < 3; k++)
        assert_true(a->lo[k] == b->lo[k] && a->hi[k] == b->hi[k]);
}

// Each id in [0, count) once.
static inline void assert_all_there(const CoBuildPrim *prims, size_t count)
{
    unsigned char *seen = calloc(count + 1, 1);
    for (size_t i = 0; i < count; i++) {
        assert_true(prims[i].id < count && !seen[prims[i].id]);
        seen[prims[i].id] = 1;
    }
    free(seen);
}

#endif
