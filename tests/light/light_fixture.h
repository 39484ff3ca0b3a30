// Lights for tests: descriptions with the schema's defaults, and a scene of a few of them.

#ifndef TESTS_LIGHT_FIXTURE_H
#define TESTS_LIGHT_FIXTURE_H

#include "light/light_internal.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const double test_pi = 3.14159265358979323846;
static const float identity_rgb[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
static const double zero_frame[3] = {0, 0, 0};

static inline CohortLightDesc test_light(CohortLightType type)
{
    CohortLightDesc d;
    memset(&d, 0, sizeof d);
    d.path = "/light";
    d.type = type;
    for (int i = 0; i < 4; i++)
        d.transform[i][i] = 1.0;
    d.color[0] = d.color[1] = d.color[2] = 1.0f;
    d.intensity = d.diffuse = d.specular = d.width = d.height = 1.0f;
    d.color_temperature = 6500.0f;
    d.radius = 0.5f;
    d.angle_degrees = 0.53f;
    d.shaping_cone_angle_degrees = 90.0f;
    return d;
}

static inline void test_place(CohortLightDesc *d, double x, double y, double z)
{
    d->transform[3][0] = x;
    d->transform[3][1] = y;
    d->transform[3][2] = z;
}

// Rows of the linear part times these.
static inline void test_stretch(CohortLightDesc *d, double x, double y, double z)
{
    const double s[3] = {x, y, z};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            d->transform[i][j] *= s[i];
}

// Turns what the transform makes by an angle around an axis of the world, before its translation.
static inline void test_turn(CohortLightDesc *d, int axis, double degrees)
{
    double c = cos(degrees * test_pi / 180.0), s = sin(degrees * test_pi / 180.0);
    int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (int i = 0; i < 3; i++) {
        double p = d->transform[i][a], q = d->transform[i][b];
        d->transform[i][a] = p * c - q * s;
        d->transform[i][b] = p * s + q * c;
    }
}

// A light by itself, and one with an image.
static inline CoLight light_with(const CohortLightDesc *desc, const CoLightImage *image)
{
    CoLight light;
    assert_true(co_light_setup(&light, desc, image, zero_frame, identity_rgb, NULL));
    return light;
}

static inline CoLight light_of(const CohortLightDesc *desc)
{
    return light_with(desc, NULL);
}

static inline CoLights *test_lights(const CohortLightDesc *descs, const CoLightImage *images,
                                    uint32_t count)
{
    CohortError err = {0};
    CoLights *lights =
        co_lights_create(descs, images, count, zero_frame, identity_rgb, 10.0f, &err);
    assert_non_null(lights);
    return lights;
}

typedef struct TestHits {
    int count;
    CoLightHit last;
} TestHits;

static inline void test_count_hit(void *context, const CoLightHit *hit)
{
    TestHits *hits = context;
    hits->count++;
    hits->last = *hit;
}

static inline TestHits test_collect(const CoLights *lights, CoVec3 org, CoVec3 dir)
{
    TestHits hits = {0};
    co_light_collect(lights, org, dir, 0.0f, INFINITY, test_count_hit, &hits);
    return hits;
}

// Irradiance at org from light samples on an n x n grid for each choice of light.
static inline CoVec3 test_irradiance(const CoLights *lights, CoVec3 org, CoVec3 n, int grid)
{
    double sum[3] = {0, 0, 0};
    for (int i = 0; i < grid; i++)
        for (int j = 0; j < grid; j++) {
            CoLightSample s;
            CoVec3 radiance;
            float u0 = ((float)i + 0.5f) / (float)grid, u1 = ((float)j + 0.5f) / (float)grid;
            float uc = (float)((i * 7 + j * 13) % grid) / (float)grid;
            if (!co_light_sample(lights, org, n, uc, u0, u1, &s))
                continue;
            float pdf = co_light_pdf(lights, org, n, s.emitter, s.wi);
            co_light_ray_end(lights, org, s.wi, s.emitter, &radiance);
            float cosine = fmaxf(co_dot(n, s.wi), 0.0f);
            assert_true(pdf > 0.0f && isfinite(pdf));
            sum[0] += (double)(radiance.x * cosine / pdf);
            sum[1] += (double)(radiance.y * cosine / pdf);
            sum[2] += (double)(radiance.z * cosine / pdf);
        }
    double count = (double)grid * grid;
    return co_vec3((float)(sum[0] / count), (float)(sum[1] / count), (float)(sum[2] / count));
}

static inline void test_near(double got, double want, double tolerance)
{
    if (!(fabs(got - want) <= tolerance * fabs(want)))
        fail_msg("got %.9g, want %.9g within %g of it", got, want, tolerance);
}

#endif
