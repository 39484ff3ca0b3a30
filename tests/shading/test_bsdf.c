// What lobes reflect: closed forms, energy, reciprocity, sides, mirrors, and hostile inputs.

#include "bsdf_fixture.h"

static void near(float got, double want, double tolerance)
{
    if (!(fabs((double)got - want) <= tolerance))
        fail_msg("got %.9g, want %.9g within %g", (double)got, want, tolerance);
}

static void lambert_reflects_its_albedo(void **state)
{
    (void)state;
    CoVec3 wo = test_direction(60.0f, 1.0f), albedo = co_vec3(0.2f, 0.5f, 1.0f);
    CoBsdf bsdf;
    float pdf;
    co_bsdf_lambert(albedo, test_up, test_up, wo, &bsdf);
    CoVec3 f = co_bsdf_eval(&bsdf, wo, test_direction(30.0f, 2.0f), &pdf);
    double cosine = cos(test_pi / 6.0);
    near(f.y, 0.5 * cosine / test_pi, 1e-6);
    near(pdf, cosine / test_pi, 1e-6);
    CoVec3 all = test_furnace(&bsdf, wo, 64);
    near(all.x, 0.2, 1e-5);
    near(all.z, 1.0, 1e-5);
    CoVec3 shown = co_bsdf_albedo(&bsdf, wo);
    assert_true(shown.x == albedo.x && shown.y == albedo.y && shown.z == albedo.z);
    assert_true(co_bsdf_has_smooth(&bsdf));
}

static void fresnel_terms_follow_the_specification(void **state)
{
    (void)state;
    CoPreviewSurface s = test_surface();
    CoBsdf b = test_bsdf(&s, test_up);
    near(b.f0.x, 0.04, 1e-6);
    near(b.f90.x, 1.0, 0.0);
    near(b.diffuse.x, 0.18, 1e-7);
    s.metallic = 0.5f;
    s.diffuse_color = co_vec3(0.8f, 0.4f, 0.0f);
    b = test_bsdf(&s, test_up);
    near(b.f90.y, 0.7, 1e-6);                         // lerp(1, 0.4, 0.5)
    near(b.f0.y, 0.5 * 0.04 * 0.7 + 0.5 * 0.7, 1e-6); // lerp(R t, t, 0.5)
    near(b.diffuse.y, 0.2, 1e-6);
    s.use_specular_workflow = true;
    s.specular_color = co_vec3(0.1f, 0.2f, 0.3f);
    b = test_bsdf(&s, test_up);
    assert_true(b.f0.z == 0.3f && b.f90.z == 1.0f && b.diffuse.x == 0.8f);
    near(b.alpha, 0.25, 1e-7);
    near(b.coat_f0, 0.04, 1e-6);
}

// The whole value at one pair of directions, by hand.
static void a_value_is_the_sum_of_its_lobes(void **state)
{
    (void)state;
    CoPreviewSurface s = test_surface();
    s.roughness = 0.6f;
    CoVec3 wo = test_direction(40.0f, 0.0f), wi = test_direction(20.0f, 2.5f);
    CoBsdf b = test_bsdf(&s, wo);
    float pdf;
    CoVec3 f = co_bsdf_eval(&b, wo, wi, &pdf);
    double h[3] = {(double)(wo.x + wi.x), (double)(wo.y + wi.y), (double)(wo.z + wi.z)};
    double l = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    double cos_h = h[2] / l,
           cos_d = ((double)wo.x * h[0] + (double)wo.y * h[1] + (double)wo.z * h[2]) / l;
    double a2 = pow(0.36, 2.0), d = cos_h * cos_h * (a2 - 1.0) + 1.0;
    double ndf = a2 / (test_pi * d * d), fr = 0.04 + 0.96 * pow(1.0 - cos_d, 5.0);
    double ci = (double)wi.z, co = (double)wo.z;
    double li = (sqrt(1.0 + a2 * (1.0 / (ci * ci) - 1.0)) - 1.0) / 2.0;
    double lo = (sqrt(1.0 + a2 * (1.0 / (co * co) - 1.0)) - 1.0) / 2.0;
    double specular = ndf * fr / (4.0 * co) / (1.0 + li + lo);
    double diffuse = 0.18 / test_pi * (1.0 - fmax(fr, (double)b.reflected.x)) * ci;
    near(f.x, specular + diffuse, 1e-5 * (specular + diffuse));
}

static void no_lobe_makes_energy(void **state)
{
    (void)state;
    const float roughnesses[] = {0.0f, 0.05f, 0.2f, 0.5f, 0.8f, 1.0f};
    const float degrees[] = {0.0f, 30.0f, 60.0f, 80.0f, 88.0f, 89.9f};
    for (int r = 0; r < 6; r++)
        for (int a = 0; a < 6; a++) {
            CoVec3 wo = test_direction(degrees[a], 0.3f);
            CoPreviewSurface s = test_surface();
            s.metallic = 1.0f; // specular alone, F = 1
            s.diffuse_color = co_vec3_splat(1.0f);
            s.roughness = roughnesses[r];
            CoBsdf b = test_bsdf(&s, wo);
            float all = test_furnace(&b, wo, 128).x;
            assert_true(all <= 1.001f);
            assert_true(all > 0.3f);
            if (r <= 1 && a <= 3)
                assert_true(all > 0.99f);
            if (r == 5 && a == 0)
                near(all, 1.0 - log(2.0), 1e-3); // alpha 1, normal incidence: closed form

            s = test_surface(); // white plastic: diffuse and specular together
            s.diffuse_color = co_vec3_splat(1.0f);
            s.roughness = roughnesses[r];
            b = test_bsdf(&s, wo);
            assert_true(test_furnace(&b, wo, 128).x <= 1.02f);
            s.opacity = 0.5f; // and what goes through
            b = test_bsdf(&s, wo);
            assert_true(test_furnace(&b, wo, 128).x <= 1.02f);

            s = test_surface(); // clearcoat alone, F = 1
            s.ior = 0.0f;
            s.clearcoat = 1.0f;
            s.clearcoat_roughness = roughnesses[r];
            s.use_specular_workflow = true;
            s.diffuse_color = co_vec3_splat(0.0f);
            b = test_bsdf(&s, wo);
            b.f90 = co_vec3_splat(0.0f);
            assert_true(test_furnace(&b, wo, 128).x <= 1.02f);

            s = test_surface(); // diffuse, dimmed
            s.diffuse_color = co_vec3_splat(1.0f);
            s.use_specular_workflow = true;
            b = test_bsdf(&s, wo);
            b.alpha = 0.0f;
            b.p_diffuse = 1.0f;
            b.p_specular = b.p_coat = b.p_through = 0.0f;
            assert_true(test_furnace(&b, wo, 64).x <= 1.0f);
        }
}

static void the_albedo_table_is_what_the_lobe_reflects(void **state)
{
    (void)state;
    for (int r = 1; r <= 20; r++)
        for (int a = 1; a <= 20; a++) {
            float cosine = (float)a * 0.05f;
            CoVec3 wo = co_vec3(0.0f, sqrtf(1.0f - cosine * cosine), cosine);
            CoPreviewSurface s = test_surface();
            s.diffuse_color = co_vec3_splat(0.0f);
            s.roughness = (float)r * 0.05f;
            CoBsdf b = test_bsdf(&s, wo);
            // Straight lines between the nodes: coarse at grazing angles.
            near(b.reflected.x, (double)test_furnace(&b, wo, 100).x, cosine < 0.2f ? 0.07 : 0.012);
        }
}

static bool goes_through(const CoBsdfSample *sample, CoVec3 wo)
{
    return sample->wi.x == -wo.x && sample->wi.y == -wo.y && sample->wi.z == -wo.z;
}

static void what_is_not_mirrored_goes_through(void **state)
{
    (void)state;
    CoPreviewSurface s = test_surface();
    s.opacity = 0.0f;
    s.roughness = 0.0f;
    CoVec3 wo = test_direction(75.0f, 0.3f);
    CoBsdf b = test_bsdf(&s, wo);
    assert_false(co_bsdf_has_smooth(&b));
    near(b.p_specular + b.p_through, 1.0, 1e-6);
    near(test_furnace(&b, wo, 64).x, 1.0, 1e-5);
    CoBsdfSample sample;
    assert_true(co_bsdf_sample(&b, wo, 0.999f, 0.5f, 0.5f, &sample));
    assert_true(sample.is_delta && goes_through(&sample, wo));
    assert_true(co_bsdf_sample(&b, wo, 0.0f, 0.5f, 0.5f, &sample));
    assert_true(sample.is_delta && sample.wi.z > 0.0f);
    near(co_dot(sample.wi, co_vec3(-wo.x, -wo.y, wo.z)), 1.0, 1e-6);
}

static void opacity_counts_in_transparent_mode_only(void **state)
{
    (void)state;
    CoPreviewSurface s = test_surface();
    s.opacity = 0.25f;
    CoVec3 wo = test_direction(10.0f, 0.0f);
    assert_true(test_bsdf(&s, wo).opacity == 0.25f && test_bsdf(&s, wo).p_through > 0.0f);
    s.opacity_presence = true;
    assert_true(test_bsdf(&s, wo).opacity == 1.0f && test_bsdf(&s, wo).p_through == 0.0f);
    s.opacity_presence = false;
    s.opacity_threshold = 0.1f;
    assert_true(test_bsdf(&s, wo).opacity == 1.0f);
    // Only the diffuse part is scaled.
    s.opacity_threshold = 0.0f;
    CoBsdf thin = test_bsdf(&s, wo);
    s.opacity = 1.0f;
    CoBsdf full = test_bsdf(&s, wo);
    float pdf;
    CoVec3 wi = test_direction(50.0f, 2.0f);
    thin.diffuse = full.diffuse = co_vec3_splat(0.0f);
    assert_true(co_bsdf_eval(&thin, wo, wi, &pdf).x == co_bsdf_eval(&full, wo, wi, &pdf).x);
}

static void light_may_run_either_way(void **state)
{
    (void)state;
    TestRandom random = {3};
    for (int k = 0; k < 20000; k++) {
        CoPreviewSurface s = test_surface();
        s.roughness = 0.1f + 0.9f * test_next(&random);
        s.metallic = test_next(&random);
        s.clearcoat = test_next(&random);
        s.clearcoat_roughness = 0.1f + 0.9f * test_next(&random);
        CoVec3 wo = test_direction(88.0f * test_next(&random), 6.28f * test_next(&random));
        CoVec3 wi = test_direction(88.0f * test_next(&random), 6.28f * test_next(&random));
        CoBsdf there = test_bsdf(&s, wo), back = test_bsdf(&s, wi);
        there.diffuse = back.diffuse = co_vec3_splat(0.0f); // dimmed by the loss towards wo
        float pdf, f = co_bsdf_eval(&there, wo, wi, &pdf).x / wi.z;
        float g = co_bsdf_eval(&back, wi, wo, &pdf).x / wo.z;
        assert_true(fabsf(f - g) <= 2e-4f * fmaxf(f, g));
    }
}

static void surfaces_have_two_sides(void **state)
{
    (void)state;
    CoPreviewSurface s = test_surface();
    CoVec3 wo = test_direction(30.0f, 1.0f), wi = test_direction(50.0f, 3.0f), f[4];
    float pdf[4];
    for (int i = 0; i < 4; i++) {
        CoVec3 ns = i & 1 ? co_neg(test_up) : test_up, ng = i & 2 ? co_neg(test_up) : test_up;
        CoBsdf b;
        co_bsdf_preview(&s, ns, ng, wo, &b);
        f[i] = co_bsdf_eval(&b, wo, wi, &pdf[i]);
        assert_true(f[0].x > 0.0f);
        near(f[i].x, (double)f[0].x, 1e-6);
        near(pdf[i], (double)pdf[0], 1e-6);
        float below;
        co_bsdf_eval(&b, wo, co_neg(wi), &below);
        assert_true(below == 0.0f);
    }
}

static void light_does_not_leak_through_the_geometric_surface(void **state)
{
    (void)state;
    TestRandom random = {9};
    CoPreviewSurface s = test_surface();
    s.clearcoat = 0.5f;
    for (int k = 0; k < 50000; k++) {
        CoVec3 ns = test_direction(120.0f * test_next(&random), 6.28f * test_next(&random));
        CoVec3 wo = test_direction(89.9f * test_next(&random), 6.28f * test_next(&random)), f;
        CoBsdf b;
        co_bsdf_preview(&s, ns, test_up, wo, &b);
        assert_true(co_dot(b.n, wo) > 0.0f && co_dot(b.ng, wo) > 0.0f);
        assert_true(fabsf(co_dot(b.n, b.n) - 1.0f) < 1e-5f);
        CoBsdfSample sample;
        float uc = test_next(&random), u0 = test_next(&random), u1 = test_next(&random), pdf;
        if (co_bsdf_sample(&b, wo, uc, u0, u1, &sample))
            assert_true(sample.wi.z > 0.0f || (sample.is_delta && goes_through(&sample, wo)));
        CoVec3 below = test_direction(91.0f + 88.0f * u0, 6.28f * u1);
        f = co_bsdf_eval(&b, wo, below, &pdf);
        assert_true(co_max3(f) == 0.0f && pdf == 0.0f);
    }
}

static void mirrors_begin_below_the_least_alpha(void **state)
{
    (void)state;
    CoPreviewSurface s = test_surface();
    s.metallic = 1.0f;
    s.roughness = 0.0316f;
    assert_true(test_bsdf(&s, test_up).alpha == 0.0f);
    assert_false(co_bsdf_has_smooth(&(CoBsdf){.p_specular = 1.0f}));
    s.roughness = 0.0317f;
    CoBsdf b = test_bsdf(&s, test_up);
    assert_true(b.alpha >= CO_BSDF_ALPHA_MIN && co_bsdf_has_smooth(&b));
}

// Any floats at all.
static float hostile(TestRandom *random)
{
    static const float values[] = {0.0f,   1.0f,   0.5f, -1.0f,    2.0f,      1e6f,   1e-6f, 1e30f,
                                   -1e30f, 1e-30f, NAN,  INFINITY, -INFINITY, 0.999f, -0.0f, 1e-4f};
    return values[(int)(test_next(random) * 16.0f)];
}

static CoVec3 hostile3(TestRandom *random)
{
    float x = hostile(random), y = hostile(random);
    return co_vec3(x, y, hostile(random));
}

static bool is_plain(CoVec3 v)
{
    return co_is_finite3(v) && v.x >= 0.0f && v.y >= 0.0f && v.z >= 0.0f;
}

static void any_input_gives_numbers(void **state)
{
    (void)state;
    TestRandom random = {11};
    for (int k = 0; k < 300000; k++) {
        CoPreviewSurface s = {.diffuse_color = hostile3(&random),
                              .specular_color = hostile3(&random),
                              .metallic = hostile(&random),
                              .roughness = hostile(&random),
                              .clearcoat = hostile(&random),
                              .clearcoat_roughness = hostile(&random),
                              .opacity = hostile(&random),
                              .opacity_threshold = hostile(&random),
                              .ior = hostile(&random),
                              .use_specular_workflow = k & 1,
                              .opacity_presence = k & 2};
        float angle = k % 3 == 0 ? 90.0f : 90.0f * test_next(&random);
        CoVec3 wo = test_direction(angle, 6.28f * test_next(&random));
        CoVec3 ns =
            k % 5 == 0 ? hostile3(&random) : test_direction(100.0f * test_next(&random), 1.0f);
        CoBsdf b;
        co_bsdf_preview(&s, ns, k % 7 == 0 ? hostile3(&random) : test_up, wo, &b);
        float sum = b.p_diffuse + b.p_specular + b.p_coat + b.p_through;
        assert_true(fabsf(sum - 1.0f) < 1e-5f || sum == 0.0f);
        assert_true(is_plain(co_bsdf_albedo(&b, wo)));
        CoBsdfSample sample;
        float uc = test_next(&random), u0 = test_next(&random), u1 = test_next(&random), pdf = 0.0f;
        if (co_bsdf_sample(&b, wo, uc, u0, u1, &sample)) {
            assert_true(is_plain(sample.weight) && fabsf(co_length(sample.wi) - 1.0f) < 1e-5f);
            assert_true(is_plain(co_bsdf_eval(&b, wo, sample.wi, &pdf)) && isfinite(pdf));
            assert_true(sample.is_delta || pdf > 0.0f);
        }
        assert_true(is_plain(co_bsdf_eval(&b, wo, test_direction(180.0f * u0, 6.28f * u1), &pdf)));
        assert_true(isfinite(pdf) && pdf >= 0.0f);
    }
}

static void the_ends_of_the_unit_interval_are_safe(void **state)
{
    (void)state;
    const float ends[] = {0.0f, 0.5f, 0x1.fffffep-1f};
    CoPreviewSurface s = test_surface();
    s.clearcoat = 1.0f;
    s.clearcoat_roughness = 0.04f;
    s.opacity = 0.5f;
    for (int k = 0; k < 81; k++) {
        CoVec3 wo = test_direction(k % 3 == 0 ? 0.0f : k % 3 == 1 ? 89.99f : 45.0f, 0.0f);
        CoBsdf b = test_bsdf(&s, wo);
        CoBsdfSample sample;
        float pdf;
        if (!co_bsdf_sample(&b, wo, ends[k / 27], ends[k / 9 % 3], ends[k / 3 % 3], &sample))
            continue;
        assert_true(co_is_finite3(sample.wi));
        assert_true(is_plain(co_bsdf_eval(&b, wo, sample.wi, &pdf)) && isfinite(pdf));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lambert_reflects_its_albedo),
        cmocka_unit_test(fresnel_terms_follow_the_specification),
        cmocka_unit_test(a_value_is_the_sum_of_its_lobes),
        cmocka_unit_test(no_lobe_makes_energy),
        cmocka_unit_test(the_albedo_table_is_what_the_lobe_reflects),
        cmocka_unit_test(what_is_not_mirrored_goes_through),
        cmocka_unit_test(opacity_counts_in_transparent_mode_only),
        cmocka_unit_test(light_may_run_either_way),
        cmocka_unit_test(surfaces_have_two_sides),
        cmocka_unit_test(light_does_not_leak_through_the_geometric_surface),
        cmocka_unit_test(mirrors_begin_below_the_least_alpha),
        cmocka_unit_test(any_input_gives_numbers),
        cmocka_unit_test(the_ends_of_the_unit_interval_are_safe),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
