// co_bsdf_sample against the density of co_bsdf_eval: chi-square over roughness, angle and
// material.

#include "bsdf_fixture.h"

enum {
    RINGS = 12,
    SPOKES = 16,
    BINS = RINGS * SPOKES,
    FINE = 24,
    DRAWS = 60000
};

static int bin_of(CoVec3 axis, float versine, CoVec3 d)
{
    CoVec3 s, t;
    co_basis(axis, &s, &t);
    CoVec3 away = co_sub(d, axis);
    float ring = 0.5f * co_dot(away, away) / versine * RINGS;
    float turn = co_atan2f(co_dot(d, t), co_dot(d, s)) * (0.5f / CO_PI) + 0.5f;
    return ring < RINGS ? (int)ring * SPOKES + (int)(turn * SPOKES) % SPOKES : -1;
}

static double expect(const CoBsdf *bsdf, CoVec3 wo, CoVec3 axis, float versine,
                     double expected[BINS])
{
    CoVec3 s, t;
    co_basis(axis, &s, &t);
    double total = 0.0;
    for (int bin = 0; bin < BINS; bin++) {
        double sum = 0.0;
        for (int k = 0; k < FINE * FINE; k++) {
            float ring = (float)(bin / SPOKES) + ((float)(k / FINE) + 0.5f) / FINE;
            float turn = (float)(bin % SPOKES) + ((float)(k % FINE) + 0.5f) / FINE;
            float h = ring / RINGS * versine, sine, cosine, pdf;
            co_sincosf((turn / SPOKES - 0.5f) * 2.0f * CO_PI, &sine, &cosine);
            float r = sqrtf(fmaxf(h * (2.0f - h), 0.0f));
            CoVec3 d = co_from_frame(s, t, axis, co_vec3(r * cosine, r * sine, 1.0f - h));
            co_bsdf_eval(bsdf, wo, d, &pdf);
            sum += (double)pdf;
        }
        expected[bin] = sum / (FINE * FINE) * 2.0 * test_pi * (double)versine / BINS;
        total += expected[bin];
    }
    return total;
}

// Bins are rings around `axis` out to `versine`; what falls outside is one bin more.
static void check(const CoPreviewSurface *surface, float degrees, CoVec3 axis, float versine)
{
    static double expected[BINS];
    CoVec3 wo = test_direction(degrees, 0.4f);
    CoBsdf bsdf = test_bsdf(surface, wo);
    double total = expect(&bsdf, wo, axis, versine, expected);
    uint32_t count[BINS] = {0}, outside = 0;
    TestRandom random = {(uint32_t)(degrees * 10.0f)};
    for (int i = 0; i < DRAWS; i++) {
        CoBsdfSample sample;
        float uc = test_next(&random), u0 = test_next(&random), u1 = test_next(&random), pdf;
        if (!co_bsdf_sample(&bsdf, wo, uc, u0, u1, &sample) || sample.is_delta) {
            outside++;
            continue;
        }
        co_bsdf_eval(&bsdf, wo, sample.wi, &pdf);
        assert_true(pdf > 0.0f);
        int bin = bin_of(axis, versine, sample.wi);
        if (bin < 0)
            outside++;
        else
            count[bin]++;
    }
    assert_true(total < 1.01);
    double rest = fmax(1.0 - total, 0.0) * DRAWS, rest_count = outside, chi2 = 0.0;
    int freedom = 0;
    for (int bin = 0; bin < BINS; bin++) {
        double want = expected[bin] * DRAWS;
        if (want < 15.0) {
            rest += want;
            rest_count += count[bin];
            continue;
        }
        chi2 += (count[bin] - want) * (count[bin] - want) / want;
        freedom++;
    }
    double rest_scale = rest + 1e-6 * DRAWS * DRAWS; // the midpoint rule's own error
    chi2 += (rest_count - rest) * (rest_count - rest) / rest_scale;
    if (!(chi2 < freedom + 1 + 5.0 * sqrt(2.0 * freedom + 2.0) + 0.1 * freedom))
        fail_msg("roughness %g, metallic %g, %g degrees: chi-square %g with %d bins",
                 (double)surface->roughness, (double)surface->metallic, (double)degrees, chi2,
                 freedom);
}

static const float angles[] = {0.0f, 20.0f, 45.0f, 70.0f, 85.0f};

static void rough_lobes_are_drawn_as_they_say(void **state)
{
    (void)state;
    const float roughnesses[] = {0.4f, 0.5f, 0.7f, 1.0f};
    for (int r = 0; r < 4; r++)
        for (int a = 0; a < 5; a++)
            for (int metallic = 0; metallic < 2; metallic++) {
                CoPreviewSurface s = test_surface();
                s.roughness = roughnesses[r];
                s.metallic = (float)metallic;
                check(&s, angles[a], test_up, 1.0f);
            }
}

static void narrow_lobes_are_drawn_as_they_say(void **state)
{
    (void)state;
    const float roughnesses[] = {0.05f, 0.1f, 0.2f, 0.3f};
    for (int r = 0; r < 4; r++)
        for (int a = 0; a < 5; a++) {
            CoPreviewSurface s = test_surface();
            s.roughness = roughnesses[r];
            s.metallic = 1.0f;
            CoVec3 wo = test_direction(angles[a], 0.4f);
            float alpha = s.roughness * s.roughness;
            CoVec3 mirrored = co_vec3(-wo.x, -wo.y, wo.z);
            // At grazing angles the lobe is a sliver: bins must not be wider than it.
            float reach = angles[a] > 60.0f ? 4.0f : 20.0f;
            check(&s, angles[a], mirrored, fminf(reach * alpha * alpha, 1.0f));
        }
}

static void mixtures_are_drawn_as_they_say(void **state)
{
    (void)state;
    for (int a = 0; a < 5; a++) {
        CoPreviewSurface s = test_surface();
        s.clearcoat = 0.8f;
        s.clearcoat_roughness = 0.6f;
        s.opacity = 0.7f;
        check(&s, angles[a], test_up, 1.0f);
        s.use_specular_workflow = true;
        s.specular_color = co_vec3(0.5f, 0.2f, 0.9f);
        check(&s, angles[a], test_up, 1.0f);
        s.diffuse_color = co_vec3(0.0f, 0.0f, 0.0f);
        check(&s, angles[a], test_up, 1.0f);
    }
}

// Weights of samples stay near the reflectance: importance sampling of the visible normals.
static void weights_are_bounded(void **state)
{
    (void)state;
    TestRandom random = {5};
    for (int k = 0; k < 200000; k++) {
        CoPreviewSurface s = test_surface();
        s.roughness = test_next(&random);
        s.metallic = test_next(&random);
        s.clearcoat = test_next(&random);
        s.clearcoat_roughness = test_next(&random);
        CoVec3 wo = test_direction(89.9f * test_next(&random), 6.0f * test_next(&random));
        CoBsdf bsdf = test_bsdf(&s, wo);
        CoBsdfSample sample;
        float uc = test_next(&random), u0 = test_next(&random), u1 = test_next(&random), pdf;
        if (!co_bsdf_sample(&bsdf, wo, uc, u0, u1, &sample) || sample.is_delta)
            continue;
        CoVec3 f = co_bsdf_eval(&bsdf, wo, sample.wi, &pdf);
        assert_true(pdf > 0.0f && co_max3(f) / pdf < 8.0f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rough_lobes_are_drawn_as_they_say),
        cmocka_unit_test(narrow_lobes_are_drawn_as_they_say),
        cmocka_unit_test(mixtures_are_drawn_as_they_say),
        cmocka_unit_test(weights_are_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
