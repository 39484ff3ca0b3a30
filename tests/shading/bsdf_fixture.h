// Materials, directions and numbers for tests of scattering.

#ifndef TESTS_SHADING_FIXTURE_H
#define TESTS_SHADING_FIXTURE_H

#include "base/hash.h"
#include "math/warp.h"
#include "shading/bsdf.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const double test_pi = 3.14159265358979323846;

typedef struct TestRandom {
    uint32_t state;
} TestRandom;

static inline float test_next(TestRandom *random)
{
    random->state = co_hash32(random->state + 0x9e3779b9u);
    return (float)(random->state >> 8) * 0x1p-24f;
}

// The registry's defaults.
static inline CoPreviewSurface test_surface(void)
{
    CoPreviewSurface s;
    memset(&s, 0, sizeof s);
    s.diffuse_color = co_vec3_splat(0.18f);
    s.roughness = 0.5f;
    s.clearcoat_roughness = 0.01f;
    s.opacity = 1.0f;
    s.ior = 1.5f;
    return s;
}

static inline CoVec3 test_direction(float degrees_off_z, float around)
{
    float s, c, sa, ca;
    co_sincosf(degrees_off_z * CO_PI / 180.0f, &s, &c);
    co_sincosf(around, &sa, &ca);
    return co_vec3(s * ca, s * sa, c);
}

static const CoVec3 test_up = {0.0f, 0.0f, 1.0f};

static inline CoBsdf test_bsdf(const CoPreviewSurface *surface, CoVec3 wo)
{
    CoBsdf bsdf;
    co_bsdf_preview(surface, test_up, test_up, wo, &bsdf);
    return bsdf;
}

// Share of light from everywhere (radiance 1) that is sent to wo, over all lobes, by sampling.
static inline CoVec3 test_furnace(const CoBsdf *bsdf, CoVec3 wo, int grid)
{
    double sum[3] = {0, 0, 0};
    TestRandom random = {1};
    for (int k = 0; k < grid * grid; k++) {
        CoBsdfSample s;
        float u0 = ((float)(k / grid) + 0.5f) / (float)grid;
        float u1 = ((float)(k % grid) + 0.5f) / (float)grid, pdf = 1.0f;
        if (!co_bsdf_sample(bsdf, wo, test_next(&random), u0, u1, &s))
            continue;
        CoVec3 w = s.weight;
        if (!s.is_delta) {
            w = co_bsdf_eval(bsdf, wo, s.wi, &pdf);
            w = pdf > 0.0f ? co_scale(w, 1.0f / pdf) : co_vec3_splat(0.0f);
        }
        sum[0] += (double)w.x;
        sum[1] += (double)w.y;
        sum[2] += (double)w.z;
    }
    double n = (double)grid * grid;
    return co_vec3((float)(sum[0] / n), (float)(sum[1] / n), (float)(sum[2] / n));
}

#endif
