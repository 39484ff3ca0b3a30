// From the inputs of UsdPreviewSurface to lobes: reflectances, workflows, clamps, opacity.

#include "bsdf_fixture.h"

#include <math.h>

static void assert_gray(CoVec3 c, float want)
{
    assert_true(fabsf(c.x - want) < 1e-6f && fabsf(c.y - want) < 1e-6f &&
                fabsf(c.z - want) < 1e-6f);
}

static void reflectance_follows_the_ior(void **state)
{
    (void)state;
    static const float pairs[][2] = {{1.5f, 0.04f}, {1.0f, 0.0f},        {2.0f, 1.0f / 9.0f},
                                     {0.0f, 1.0f},  {INFINITY, 1.0f},    {-3.0f, 0.04f},
                                     {NAN, 0.04f},  {1.0f / 1.5f, 0.04f}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        CoPreviewSurface s = test_surface();
        s.ior = pairs[i][0];
        CoBsdf bsdf = test_bsdf(&s, test_up);
        assert_gray(bsdf.f0, pairs[i][1]);
        assert_gray(bsdf.f90, 1.0f);
        assert_true(fabsf(bsdf.coat_f0 - pairs[i][1]) < 1e-6f);
    }
}

static void metals_reflect_their_color(void **state)
{
    (void)state;
    CoPreviewSurface s = test_surface();
    s.diffuse_color = co_vec3(0.8f, 0.4f, 0.2f);
    s.metallic = 1.0f;
    CoBsdf metal = test_bsdf(&s, test_up);
    assert_true(metal.f0.x == 0.8f && metal.f0.y == 0.4f && metal.f90.z == 0.2f);
    assert_gray(metal.diffuse, 0.0f);
    s.metallic = 0.5f;
    CoBsdf half = test_bsdf(&s, test_up);
    assert_true(fabsf(half.diffuse.x - 0.4f) < 1e-6f);
    // t = lerp(1, color, m); F0 = lerp(R t, t, m).
    assert_true(fabsf(half.f0.y - 0.5f * (0.04f * 0.7f + 0.7f)) < 1e-6f);
    assert_true(fabsf(half.f90.y - 0.7f) < 1e-6f);
}

static void the_specular_workflow_takes_its_own_color(void **state)
{
    (void)state;
    CoPreviewSurface s = test_surface();
    s.use_specular_workflow = true;
    s.specular_color = co_vec3(0.3f, 0.2f, 0.1f);
    s.metallic = 1.0f; // of no account
    CoBsdf bsdf = test_bsdf(&s, test_up);
    assert_true(bsdf.f0.x == 0.3f && bsdf.f0.z == 0.1f);
    assert_gray(bsdf.f90, 1.0f);
    assert_gray(bsdf.diffuse, 0.18f);
}

static void inputs_are_clamped(void **state)
{
    (void)state;
    static const float odd[] = {-1.0f, 7.0f, NAN, INFINITY, -INFINITY};
    static const float kept[] = {0.0f, 1.0f, 0.0f, 1.0f, 0.0f};
    for (int i = 0; i < 5; i++) {
        CoPreviewSurface s = test_surface();
        s.diffuse_color = co_vec3_splat(odd[i]);
        s.roughness = s.clearcoat_roughness = s.clearcoat = s.opacity = odd[i];
        CoBsdf bsdf = test_bsdf(&s, test_up);
        assert_gray(bsdf.diffuse, kept[i]);
        assert_true(bsdf.alpha == kept[i] && bsdf.coat_alpha == kept[i]);
        assert_true(bsdf.coat == kept[i] && bsdf.opacity == kept[i]);
        float sum = bsdf.p_diffuse + bsdf.p_specular + bsdf.p_coat + bsdf.p_through;
        assert_true(fabsf(sum - 1.0f) < 1e-5f);
    }
    CoPreviewSurface s = test_surface();
    s.roughness = 0.03f; // below what a lobe can have
    assert_true(test_bsdf(&s, test_up).alpha == 0.0f);
}

static void opacity_is_of_transparent_mode(void **state)
{
    (void)state;
    CoPreviewSurface s = test_surface();
    s.opacity = 0.25f;
    assert_true(test_bsdf(&s, test_up).opacity == 0.25f);
    s.opacity_presence = true;
    assert_true(test_bsdf(&s, test_up).opacity == 1.0f);
    s.opacity_presence = false;
    s.opacity_threshold = 0.1f;
    assert_true(test_bsdf(&s, test_up).opacity == 1.0f);
}

static void lambert_is_nothing_but_diffuse(void **state)
{
    (void)state;
    CoBsdf bsdf, black;
    co_bsdf_lambert(co_vec3(0.5f, 2.0f, NAN), test_up, test_up, test_up, &bsdf);
    assert_true(bsdf.is_lambert && bsdf.p_diffuse == 1.0f && bsdf.opacity == 1.0f);
    assert_true(bsdf.diffuse.x == 0.5f && bsdf.diffuse.y == 1.0f && bsdf.diffuse.z == 0.0f);
    co_bsdf_lambert(co_vec3_splat(0.0f), test_up, test_up, test_up, &black);
    assert_true(black.p_diffuse == 0.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reflectance_follows_the_ior),
        cmocka_unit_test(metals_reflect_their_color),
        cmocka_unit_test(the_specular_workflow_takes_its_own_color),
        cmocka_unit_test(inputs_are_clamped),
        cmocka_unit_test(opacity_is_of_transparent_mode),
        cmocka_unit_test(lambert_is_nothing_but_diffuse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
