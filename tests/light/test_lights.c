// All lights of a scene: shares of the choice, one density on both sides, and what a ray crosses.

#include "light_fixture.h"

static const CoVec3 origin = {0, 0, 0}, up = {0, 0, 1};

static CoLights *three_lamps(void)
{
    CohortLightDesc d[3] = {test_light(COHORT_LIGHT_RECT), test_light(COHORT_LIGHT_SPHERE),
                            test_light(COHORT_LIGHT_DOME)};
    test_place(&d[0], 0.0, 0.0, 5.0);
    d[0].intensity = 7.0f;
    test_place(&d[1], 0.0, 0.0, 3.0);
    d[1].no_shadow = true;
    return test_lights(d, NULL, 3);
}

static void shares_are_the_chances_of_the_choice(void **state)
{
    (void)state;
    CoLights *lights = three_lamps();
    double chosen[3] = {0}, share[3] = {0};
    enum {
        DRAWS = 4096
    };
    for (int i = 0; i < DRAWS; i++) {
        CoLightSample s;
        assert_true(co_light_sample(lights, origin, up, ((float)i + 0.5f) / DRAWS, 0.3f, 0.6f, &s));
        chosen[s.emitter] += 1.0 / DRAWS;
        share[s.emitter] = (double)s.share;
        assert_true(co_light_pdf(lights, origin, up, s.emitter, s.wi) ==
                    co_light_sample_pdf(lights, origin, up, &s, s.wi));
    }
    test_near(share[0] + share[1] + share[2], 1.0, 1e-6);
    for (int i = 0; i < 3; i++)
        assert_true(fabs(chosen[i] - share[i]) < 2.0 / DRAWS);
    co_lights_destroy(lights);
}

static void one_light_is_no_choice(void **state)
{
    (void)state;
    CohortLightDesc d[2] = {test_light(COHORT_LIGHT_DOME), test_light(COHORT_LIGHT_DISK)};
    d[1].hidden = true;
    CoLights *lights = test_lights(d, NULL, 2);
    CoLightSample s;
    assert_int_equal(co_lights_count(lights), 1);
    assert_false(co_lights_have_choice(lights));
    assert_true(co_light_sample(lights, origin, up, NAN, 0.5f, 0.5f, &s));
    assert_true(s.emitter == 0 && s.share == 1.0f);
    assert_true(co_light_is_dome(lights, 0) && !co_light_is_dome(lights, 1));
    assert_true(co_light_pdf(lights, origin, up, 7, up) == 0.0f);
    co_lights_destroy(lights);
}

typedef struct Seen {
    uint32_t emitters[8];
    float t[8];
    int count;
} Seen;

static void note(void *context, const CoLightHit *hit)
{
    Seen *seen = context;
    seen->emitters[seen->count] = hit->emitter;
    seen->t[seen->count++] = hit->t;
}

static void a_ray_collects_all_that_it_crosses(void **state)
{
    (void)state;
    CoLights *lights = three_lamps();
    Seen all = {0}, near = {0}, past = {0};
    co_light_collect(lights, origin, up, 0.0f, INFINITY, note, &all);
    assert_int_equal(all.count, 3);
    assert_true(all.t[0] == 5.0f && fabsf(all.t[1] - 2.5f) < 1e-6f && isinf(all.t[2]));
    co_light_collect(lights, origin, up, 0.0f, 4.0f, note, &near); // a surface ends it
    assert_true(near.count == 1 && near.emitters[0] == 1);
    co_light_collect(lights, origin, up, 4.0f, INFINITY, note, &past);
    assert_true(past.count == 2 && past.emitters[0] == 0 && past.emitters[1] == 2);
    assert_true(co_lights_max_radiance(lights) == 7.0f);
    assert_true(co_lights_have_shadowless(lights) && co_light_is_shadowless(lights, 1));
    assert_false(co_light_is_shadowless(lights, 0) || co_light_is_shadowless(lights, 9));
    co_lights_destroy(lights);
}

// A light ray ends at its light, by closest approach where it passes by.
static void light_rays_end_at_their_light(void **state)
{
    (void)state;
    CoLights *lights = three_lamps();
    CoVec3 radiance, wide = co_normalize(co_vec3(1, 0, 1));
    assert_true(co_light_ray_end(lights, origin, up, 0, &radiance) == 5.0f);
    assert_true(radiance.x == 7.0f);
    test_near((double)co_light_ray_end(lights, origin, wide, 1, &radiance), 3.0 * sqrt(0.5), 1e-6);
    assert_true(radiance.x == 1.0f);
    CoVec3 again = co_light_ray_radiance(lights, origin, up, 0);
    assert_true(again.x == 7.0f);
    assert_true(co_light_ray_radiance(lights, co_vec3(0, 0, 6), up, 0).x == 0.0f); // from behind
    assert_true(co_light_ray_end(lights, origin, up, 9, &radiance) == 0.0f && radiance.x == 0.0f);
    co_lights_destroy(lights);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shares_are_the_chances_of_the_choice),
        cmocka_unit_test(one_light_is_no_choice),
        cmocka_unit_test(a_ray_collects_all_that_it_crosses),
        cmocka_unit_test(light_rays_end_at_their_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
