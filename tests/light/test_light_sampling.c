// Every light sampler against its density: chi-square, total probability, and agreement with the
// rays that meet the light.

#include "light_fixture.h"

#include "base/hash.h"
#include "math/warp.h"

enum {
    RINGS = 12,
    SPOKES = 16,
    BINS = RINGS * SPOKES,
    FINE = 48,
    DRAWS = 60000
};

typedef struct Case {
    const char *name;
    CohortLightDesc desc;
    CoLightImage image;
    CoVec3 org, n;
    CoVec3 axis;   // bins are rings around it
    float versine; // out to this 1 - cos
} Case;

static float dome_pixels[4 * 8 * 16];
static uint32_t random_state;

static float next_random(void)
{
    random_state = co_hash32(random_state + 0x9e3779b9u);
    return (float)(random_state >> 8) * 0x1p-24f;
}

static int bin_of(const Case *c, CoVec3 d)
{
    CoVec3 s, t;
    co_basis(c->axis, &s, &t);
    CoVec3 away = co_sub(d, c->axis);
    float ring = 0.5f * co_dot(away, away) / c->versine * RINGS;
    float turn = co_atan2f(co_dot(d, t), co_dot(d, s)) * (0.5f / CO_PI) + 0.5f;
    int i = ring < RINGS ? (int)ring : -1;
    int j = (int)(turn * SPOKES) % SPOKES;
    return i < 0 ? -1 : i * SPOKES + j;
}

// Probability of each bin by jittered midpoints.
static double integrate(const Case *c, const CoLights *lights, double expected[BINS])
{
    CoVec3 s, t;
    co_basis(c->axis, &s, &t);
    double total = 0.0;
    for (int bin = 0; bin < BINS; bin++) {
        double sum = 0.0;
        for (int k = 0; k < FINE * FINE; k++) {
            float ring = (float)(bin / SPOKES) + ((float)(k / FINE) + next_random()) / FINE;
            float turn = (float)(bin % SPOKES) + ((float)(k % FINE) + next_random()) / FINE;
            float h = ring / RINGS * c->versine, sine, cosine;
            co_sincosf((turn / SPOKES - 0.5f) * 2.0f * CO_PI, &sine, &cosine);
            float r = sqrtf(fmaxf(h * (2.0f - h), 0.0f));
            CoVec3 d = co_from_frame(s, t, c->axis, co_vec3(r * cosine, r * sine, 1.0f - h));
            d = co_normalize(d);
            if (test_collect(lights, c->org, d).count > 0)
                sum += (double)co_light_pdf(lights, c->org, c->n, 0, d);
        }
        expected[bin] = sum / (FINE * FINE) * 2.0 * test_pi * (double)c->versine / BINS;
        total += expected[bin];
    }
    return total;
}

static void check(const Case *c)
{
    static double expected[BINS];
    uint32_t count[BINS] = {0}, outside = 0, none = 0;
    CoLights *lights = test_lights(&c->desc, &c->image, 1);
    double total = integrate(c, lights, expected);
    if (!(fabs(total - 1.0) < 0.004))
        fail_msg("%s: the density sums to %g", c->name, total);
    for (int i = 0; i < DRAWS; i++) {
        CoLightSample sample;
        if (!co_light_sample(lights, c->org, c->n, next_random(), next_random(), next_random(),
                             &sample)) {
            none++;
            continue;
        }
        assert_true(co_light_pdf(lights, c->org, c->n, 0, sample.wi) > 0.0f);
        int bin = bin_of(c, sample.wi);
        if (bin < 0)
            outside++;
        else
            count[bin]++;
    }
    assert_true(outside + none <= DRAWS / 1000);
    double chi2 = 0.0, rest = 0.0, rest_count = 0.0;
    int freedom = 0;
    for (int bin = 0; bin < BINS; bin++) {
        double want = expected[bin] * DRAWS;
        if (want < 20.0) {
            rest += want;
            rest_count += count[bin];
            continue;
        }
        chi2 += (count[bin] - want) * (count[bin] - want) / want;
        freedom++;
    }
    if (rest > 20.0) {
        chi2 += (rest_count - rest) * (rest_count - rest) / rest;
        freedom++;
    }
    // 5 standard deviations, and what the midpoints leave at the light's edge.
    if (!(chi2 < freedom + 5.0 * sqrt(2.0 * freedom) + 0.25 * freedom))
        fail_msg("%s: chi-square %g with %d bins", c->name, chi2, freedom);
    co_lights_destroy(lights);
}

static Case new_case(const char *name, CohortLightDesc desc, CoVec3 org, CoVec3 axis, float versine)
{
    Case c = {.name = name, .desc = desc, .org = org, .n = co_normalize(axis)};
    c.axis = co_normalize(axis);
    c.versine = versine;
    random_state = 17;
    return c;
}

static void rects_are_sampled_as_they_say(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_RECT);
    test_place(&d, 0, 0, 1);
    Case c = new_case("rect, large", d, co_vec3(0.2f, 0.1f, 0.0f), co_vec3(0, 0, 1), 0.6f);
    check(&c);
    c = new_case("rect, edge on", d, co_vec3(2.0f, 0.5f, 0.7f), co_vec3(-2.0f, -0.5f, 0.3f), 0.06f);
    check(&c);
    c = new_case("rect, far", d, co_vec3(3.0f, 2.0f, -9.0f), co_vec3(-3, -2, 10), 0.004f);
    check(&c);
    test_stretch(&d, 2.0, 0.5, 1.0);
    d.transform[1][0] = 0.4;
    c = new_case("rect, sheared", d, co_vec3(0.3f, 0.0f, 0.0f), co_vec3(0, 0, 1), 0.8f);
    check(&c);
    c = new_case("rect, almost touched", test_light(COHORT_LIGHT_RECT),
                 co_vec3(0.1f, -0.2f, -0.01f), co_vec3(0, 0, 1), 1.0f);
    check(&c);
}

static void disks_are_sampled_as_they_say(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DISK);
    test_place(&d, 0, 0, 1);
    Case c = new_case("disk", d, co_vec3(0.3f, 0.0f, 0.0f), co_vec3(-0.1f, 0, 1), 0.4f);
    check(&c);
    test_stretch(&d, 3.0, 1.0, 1.0);
    d.transform[0][2] = 0.5;
    c = new_case("disk, an ellipse askew", d, co_vec3(0.3f, 0.0f, -1.0f), co_vec3(0, 0, 1), 0.5f);
    check(&c);
}

static void spheres_are_sampled_as_they_say(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    Case c = new_case("sphere", d, co_vec3(0, 0, -2), co_vec3(0, 0, 1), 0.04f);
    check(&c);
    c = new_case("sphere, near", d, co_vec3(0, 0, -0.52f), co_vec3(0, 0, 1), 1.0f);
    check(&c);
    test_stretch(&d, 2.0, 0.7, 1.0);
    test_turn(&d, 1, 30.0);
    c = new_case("ellipsoid", d, co_vec3(0.4f, 0.3f, -2), co_vec3(-0.2f, -0.1f, 1), 0.25f);
    check(&c);
}

static void inside_spheres_it_is_dark(void **state)
{
    (void)state;
    CohortLightDesc d[2] = {test_light(COHORT_LIGHT_SPHERE), test_light(COHORT_LIGHT_SPHERE)};
    test_stretch(&d[1], 2.0, 0.7, 1.0);
    const CoVec3 org = co_vec3(0.2f, 0.1f, -0.1f), n = co_vec3(0, 0, 1);
    for (int i = 0; i < 2; i++) {
        CoLights *lights = test_lights(&d[i], NULL, 1);
        CoLightSample sample;
        for (int k = 0; k < 64; k++) {
            CoVec3 dir = co_warp_cone(2.0f, next_random(), next_random());
            assert_false(
                co_light_sample(lights, org, n, 0.5f, next_random(), next_random(), &sample));
            assert_true(co_light_pdf(lights, org, n, 0, dir) == 0.0f);
            assert_int_equal(test_collect(lights, org, dir).count, 0);
        }
        co_lights_destroy(lights);
    }
    // With another light in the choice, that one is always chosen.
    d[1] = test_light(COHORT_LIGHT_DOME);
    CoLights *lights = test_lights(d, NULL, 2);
    for (int k = 0; k < 64; k++) {
        CoLightSample sample;
        assert_true(
            co_light_sample(lights, org, n, next_random(), next_random(), next_random(), &sample));
        assert_true(sample.emitter == 1 && sample.share == 1.0f);
    }
    co_lights_destroy(lights);
}

static void distant_lights_are_sampled_as_they_say(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DISTANT);
    const float angles[] = {0.53f, 40.0f, 250.0f, 360.0f};
    for (int i = 0; i < 4; i++) {
        d.angle_degrees = angles[i];
        float versine = 1.0f - cosf(angles[i] * 0.5f * CO_PI / 180.0f);
        Case c = new_case("distant", d, co_vec3(1, 2, 3), co_vec3(0, 0, 1), versine);
        c.versine = fminf(versine * 1.2f, 2.0f);
        check(&c);
    }
}

static void domes_are_sampled_as_they_say(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DOME);
    Case c = new_case("dome, plain", d, co_vec3(0, 0, 0), co_vec3(0.3f, 1, 0.2f), 2.0f);
    check(&c);
    c.n = co_vec3(0, 0, 0);
    check(&c);
    for (int i = 0; i < 8 * 16; i++)
        for (int k = 0; k < 3; k++)
            dome_pixels[i * 4 + k] = i == 37 ? 40.0f : (float)(i % 11) * 0.1f;
    test_turn(&d, 0, 90.0);
    c = new_case("dome, image", d, co_vec3(0, 0, 0), co_vec3(0, 0, 1), 2.0f);
    c.image = (CoLightImage){dome_pixels, 16, 8};
    check(&c);
}

// ---- Rays and samples agree -----------------------------------------------------------------

static void samples_meet_what_they_aim_at(void **state)
{
    (void)state;
    for (int type = COHORT_LIGHT_RECT; type <= COHORT_LIGHT_DOME; type++) {
        CohortLightDesc d = test_light((CohortLightType)type);
        test_place(&d, 0.3, 0.2, 2.0);
        test_stretch(&d, 1.5, 0.8, 1.1);
        d.shaping_focus = 3.0f;
        CoLights *lights = test_lights(&d, NULL, 1);
        CoVec3 n = co_vec3(0, 0, 1);
        int misses = 0;
        for (int i = 0; i < 20000; i++) {
            CoVec3 org = co_vec3(next_random(), next_random(), next_random()), radiance;
            CoLightSample s;
            assert_true(co_light_sample(lights, org, n, 0.5f, next_random(), next_random(), &s));
            float t = co_light_ray_end(lights, org, s.wi, 0, &radiance);
            TestHits hits = test_collect(lights, org, s.wi);
            if (hits.count == 0) {
                misses++;
                continue;
            }
            assert_int_equal(hits.count, 1);
            assert_true(hits.last.t == t);
            assert_true(hits.last.radiance.x == radiance.x && radiance.x > 0.0f);
        }
        assert_true(misses < 20);
        co_lights_destroy(lights);
    }
}

static void tiny_lights_are_never_missed(void **state)
{
    (void)state;
    for (int type = COHORT_LIGHT_RECT; type <= COHORT_LIGHT_SPHERE; type++) {
        CohortLightDesc d = test_light((CohortLightType)type);
        d.radius = 1e-5f;
        d.width = d.height = 2e-5f;
        d.normalize = true;
        test_place(&d, 0, 0, 100);
        CoLights *lights = test_lights(&d, NULL, 1);
        CoVec3 n = co_vec3(0, 0, 1);
        for (int i = 0; i < 1000; i++) {
            CoVec3 org = co_vec3(next_random(), next_random(), next_random()), radiance;
            CoLightSample s;
            assert_true(co_light_sample(lights, org, n, 0.5f, next_random(), next_random(), &s));
            float pdf = co_light_pdf(lights, org, n, 0, s.wi);
            assert_true(isfinite(pdf) && pdf > 1e10f);
            // As a stored direction has it: off by 1e-7.
            CoVec3 off = co_normalize(co_add(s.wi, co_vec3(1e-7f, -1e-7f, 0.0f)));
            float t = co_light_ray_end(lights, org, off, 0, &radiance);
            assert_true(radiance.x > 0.0f);
            assert_true(fabsf(t / co_length(co_sub(co_vec3(0, 0, 100), org)) - 1.0f) < 1e-4f);
        }
        // Normalized: a point of intensity 1/pi (flat) or 1/(4 pi) over the square of the distance.
        double per_area = type == COHORT_LIGHT_SPHERE ? 0.25 : 1.0;
        test_near((double)test_irradiance(lights, co_vec3(0, 0, 0), n, 16).x, per_area * 1e-4,
                  1e-3);
        co_lights_destroy(lights);
    }
}

static void lights_far_from_the_origin_are_framed(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    test_place(&d, 1e8 + 0.25, -3e8, 2e8 + 3.0);
    const double frame[3] = {1e8, -3e8, 2e8};
    CoLights *lights = co_lights_create(&d, NULL, 1, frame, identity_rgb, 10.0f, NULL);
    CoVec3 radiance;
    float t = co_light_ray_end(lights, co_vec3(0.25f, 0, 0), co_vec3(0, 0, 1), 0, &radiance);
    assert_true(fabsf(t - 2.5f) < 1e-5f && radiance.x == 1.0f);
    co_lights_destroy(lights);
}

static void a_ray_meets_a_sphere_once(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    CoLights *lights = test_lights(&d, NULL, 1);
    TestHits from_outside = test_collect(lights, co_vec3(0, 0, -2), co_vec3(0, 0, 1));
    assert_int_equal(from_outside.count, 1);
    assert_true(fabsf(from_outside.last.t - 1.5f) < 1e-6f);
    assert_int_equal(test_collect(lights, co_vec3(0, 0, -2), co_vec3(0, 0, -1)).count, 0);
    assert_int_equal(test_collect(lights, co_vec3(0, 0.6f, -2), co_vec3(0, 0, 1)).count, 0);
    TestHits hits = {0};
    co_light_collect(lights, co_vec3(0, 0, -2), co_vec3(0, 0, 1), 0.0f, 1.4f, test_count_hit,
                     &hits);
    co_light_collect(lights, co_vec3(0, 0, -2), co_vec3(0, 0, 1), 1.6f, 9.0f, test_count_hit,
                     &hits);
    assert_int_equal(hits.count, 0);
    co_lights_destroy(lights);
}

static void flat_lights_are_dark_behind(void **state)
{
    (void)state;
    const CohortLightType types[] = {COHORT_LIGHT_RECT, COHORT_LIGHT_DISK};
    for (int i = 0; i < 2; i++)
        for (int mirror = 0; mirror < 2; mirror++) {
            CohortLightDesc d = test_light(types[i]);
            test_stretch(&d, mirror ? -1.0 : 1.0, 1.0, 1.0);
            CoLights *lights = test_lights(&d, NULL, 1);
            CoVec3 front = co_vec3(0.1f, 0.1f, -1), back = co_vec3(0.1f, 0.1f, 1), radiance;
            CoVec3 none = co_vec3(0, 0, 0);
            CoLightSample s;
            assert_int_equal(test_collect(lights, front, co_vec3(0, 0, 1)).count, 1);
            assert_int_equal(test_collect(lights, back, co_vec3(0, 0, -1)).count, 0);
            assert_true(co_light_sample(lights, front, none, 0.5f, 0.5f, 0.5f, &s));
            assert_false(co_light_sample(lights, back, none, 0.5f, 0.5f, 0.5f, &s));
            assert_true(co_light_pdf(lights, back, none, 0, co_vec3(0, 0, -1)) == 0.0f);
            co_light_ray_end(lights, back, co_vec3(0, 0, -1), 0, &radiance);
            assert_true(co_max3(radiance) == 0.0f);
            co_lights_destroy(lights);
        }
}

// Points in and on the light, on its plane and its axis, with and without a normal.
static void points_on_the_light_get_numbers(void **state)
{
    (void)state;
    const float places[] = {0.0f, 0.5f, -0.5f, 0.50001f, 1e-8f, -1e-8f, 1e8f, 1e-30f};
    for (int k = 0; k < 5 * 512; k++) {
        CohortLightDesc d = test_light((CohortLightType)(k % 5));
        CoLights *lights = test_lights(&d, NULL, 1);
        int place = k / 5;
        CoVec3 org = co_vec3(places[place % 8], places[place / 8 % 8], places[place / 64]);
        CoVec3 n = k & 1 ? co_vec3(0, 0, 1) : co_vec3(0, 0, 0), radiance;
        for (int i = 0; i < 20; i++) {
            CoLightSample s;
            float u0 = i == 0 ? 0.0f : next_random(), u1 = i == 1 ? 0.0f : next_random();
            if (!co_light_sample(lights, org, n, next_random(), u0, u1, &s))
                continue;
            assert_true(fabsf(co_length(s.wi) - 1.0f) < 1e-5f);
            float pdf = co_light_pdf(lights, org, n, 0, s.wi);
            assert_true(pdf >= 0.0f && isfinite(pdf));
            assert_true(co_light_sample_pdf(lights, org, n, &s, s.wi) == pdf);
            assert_true(co_light_ray_end(lights, org, s.wi, 0, &radiance) >= 0.0f);
            assert_true(co_is_finite3(radiance));
            TestHits hits = test_collect(lights, org, s.wi);
            assert_true(hits.count <= 1 && hits.last.t >= 0.0f);
        }
        co_lights_destroy(lights);
    }
}

static void lights_are_chosen_by_what_they_give(void **state)
{
    (void)state;
    CohortLightDesc d[100];
    for (int i = 0; i < 100; i++) {
        d[i] = test_light((CohortLightType)(i % 3));
        test_place(&d[i], (double)(i % 10) - 5.0, (double)(i / 10) - 5.0, 3.0);
        d[i].intensity = 1.0f + (float)(i % 7);
        d[i].radius = d[i].width = d[i].height = 0.2f;
    }
    CoLights *lights = test_lights(d, NULL, 100);
    assert_int_equal(co_lights_count(lights), 100);
    CoVec3 n = co_vec3(0, 0, 1), org = co_vec3(0.5f, 0.3f, 0);
    double one_by_one = 0.0;
    for (int i = 0; i < 100; i++) {
        CoLights *alone = test_lights(&d[i], NULL, 1);
        one_by_one += (double)test_irradiance(alone, org, n, 24).x;
        co_lights_destroy(alone);
    }
    double sum = 0.0;
    for (int i = 0; i < 200000; i++) {
        CoLightSample s;
        CoVec3 radiance;
        assert_true(
            co_light_sample(lights, org, n, next_random(), next_random(), next_random(), &s));
        co_light_ray_end(lights, org, s.wi, s.emitter, &radiance);
        float pdf = co_light_pdf(lights, org, n, s.emitter, s.wi);
        assert_true(co_light_sample_pdf(lights, org, n, &s, s.wi) == pdf);
        double term = (double)(radiance.x * s.wi.z / pdf);
        assert_true(term < 4.0 * one_by_one); // the estimates follow the contributions
        sum += term;
    }
    test_near(sum / 200000, one_by_one, 0.01);
    co_lights_destroy(lights);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rects_are_sampled_as_they_say),
        cmocka_unit_test(disks_are_sampled_as_they_say),
        cmocka_unit_test(spheres_are_sampled_as_they_say),
        cmocka_unit_test(inside_spheres_it_is_dark),
        cmocka_unit_test(distant_lights_are_sampled_as_they_say),
        cmocka_unit_test(domes_are_sampled_as_they_say),
        cmocka_unit_test(samples_meet_what_they_aim_at),
        cmocka_unit_test(tiny_lights_are_never_missed),
        cmocka_unit_test(lights_far_from_the_origin_are_framed),
        cmocka_unit_test(a_ray_meets_a_sphere_once),
        cmocka_unit_test(flat_lights_are_dark_behind),
        cmocka_unit_test(points_on_the_light_get_numbers),
        cmocka_unit_test(lights_are_chosen_by_what_they_give),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
