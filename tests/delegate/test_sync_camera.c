// The renderer's camera from a host's: units, aspect ratios, and numbers that are none.

#include "prims/sync.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

// 20 x 10 tenths of a unit wide, 40 long.
static CoPrim plain_camera(void)
{
    CoPrim prim = {.camera = cohort_camera_source_default()};
    prim.camera.horizontal_aperture = 20.0;
    prim.camera.vertical_aperture = 10.0;
    prim.camera.focal_length = 40.0;
    return prim;
}

static CohortCameraDesc desc_of(const CoPrim *prim, CohortConformPolicy policy, double pixel_aspect,
                                uint32_t width, uint32_t height)
{
    CohortRenderPassState state = {.conform = policy, .pixel_aspect_ratio = pixel_aspect};
    CohortCameraDesc desc;
    co_camera_desc(prim, &state, width, height, &desc);
    return desc;
}

static void assert_window(const CohortCameraDesc *desc, double half_width, double half_height)
{
    const double want[] = {-half_width, half_width, -half_height, half_height};
    for (int i = 0; i < 4; i++)
        assert_true(fabs(desc->window[i] - want[i]) < 1e-12);
}

// An image twice as wide as high fits; a square one is made to, in each of the ways.
static void aspects_conform(void **state)
{
    (void)state;
    static const struct {
        CohortConformPolicy policy;
        double wide[2], tall[2]; // half sizes for 100 x 100 and 400 x 100
    } cases[] = {{COHORT_CONFORM_EXPAND_APERTURE, {0.25, 0.25}, {0.5, 0.125}},
                 {COHORT_CONFORM_CROP_APERTURE, {0.125, 0.125}, {0.25, 0.0625}},
                 {COHORT_CONFORM_ADJUST_WIDTH, {0.125, 0.125}, {0.5, 0.125}},
                 {COHORT_CONFORM_ADJUST_HEIGHT, {0.25, 0.25}, {0.25, 0.0625}},
                 {COHORT_CONFORM_ADJUST_PIXEL_ASPECT, {0.25, 0.125}, {0.25, 0.125}}};
    CoPrim prim = plain_camera();
    for (size_t i = 0; i < 5; i++) {
        CohortCameraDesc desc = desc_of(&prim, cases[i].policy, 1.0, 200, 100);
        assert_window(&desc, 0.25, 0.125);
        desc = desc_of(&prim, cases[i].policy, 1.0, 100, 100);
        assert_window(&desc, cases[i].wide[0], cases[i].wide[1]);
        desc = desc_of(&prim, cases[i].policy, 1.0, 400, 100);
        assert_window(&desc, cases[i].tall[0], cases[i].tall[1]);
    }
}

// Pixels twice as wide as high make a square image's aperture two to one; zero stands for one.
static void pixels_have_an_aspect(void **state)
{
    (void)state;
    CoPrim prim = plain_camera();
    CohortCameraDesc desc = desc_of(&prim, COHORT_CONFORM_EXPAND_APERTURE, 2.0, 100, 100);
    assert_window(&desc, 0.25, 0.125);
    const double none[] = {0.0, -1.0, (double)NAN, HUGE_VAL};
    for (int i = 0; i < 4; i++) {
        desc = desc_of(&prim, COHORT_CONFORM_EXPAND_APERTURE, none[i], 200, 100);
        assert_window(&desc, 0.25, 0.125);
    }
}

// Orthographic apertures are tenths of a unit themselves, and have no lens.
static void orthographic_apertures(void **state)
{
    (void)state;
    CoPrim prim = plain_camera();
    prim.camera.orthographic = true;
    prim.camera.f_stop = 1.0;
    prim.camera.focus_distance = 3.0;
    prim.camera.horizontal_offset = 5.0;
    CohortCameraDesc desc = desc_of(&prim, COHORT_CONFORM_EXPAND_APERTURE, 1.0, 200, 100);
    assert_true(desc.window[0] == -0.5 && desc.window[1] == 1.5 && desc.window[3] == 0.5);
    assert_true(desc.orthographic && desc.lens_radius == 0.0);
}

// Half of focal length over stop, in units; none without a stop or a focus, or when switched off.
static void lenses(void **state)
{
    (void)state;
    CoPrim prim = plain_camera();
    prim.camera.f_stop = 2.0;
    prim.camera.focus_distance = 5.0;
    CohortCameraDesc desc = desc_of(&prim, COHORT_CONFORM_EXPAND_APERTURE, 1.0, 200, 100);
    assert_true(fabs(desc.lens_radius - 1.0) < 1e-12 && desc.focus_distance == 5.0);
    prim.camera.focus_distance = HUGE_VAL;
    desc = desc_of(&prim, COHORT_CONFORM_EXPAND_APERTURE, 1.0, 200, 100);
    assert_true(desc.lens_radius > 0.0 && isfinite(desc.focus_distance));
    CohortRenderPassState off = {.disable_depth_of_field = true};
    co_camera_desc(&prim, &off, 200, 100, &desc);
    assert_true(desc.lens_radius == 0.0);
    prim.camera.focus_distance = 0.0;
    desc = desc_of(&prim, COHORT_CONFORM_EXPAND_APERTURE, 1.0, 200, 100);
    assert_true(desc.lens_radius == 0.0);
}

// Whatever a host gives, the window is a window; and equal cameras are equal bytes.
static void nonsense_is_replaced(void **state)
{
    (void)state;
    const double values[] = {0.0, -1.0, (double)NAN, HUGE_VAL, -HUGE_VAL};
    for (int i = 0; i < 5; i++) {
        CoPrim prim = plain_camera();
        double *const fields[] = {&prim.camera.horizontal_aperture,
                                  &prim.camera.vertical_aperture,
                                  &prim.camera.focal_length,
                                  &prim.camera.horizontal_offset,
                                  &prim.camera.vertical_offset,
                                  &prim.camera.clip_near,
                                  &prim.camera.f_stop,
                                  &prim.camera.focus_distance};
        for (size_t k = 0; k < sizeof fields / sizeof *fields; k++)
            *fields[k] = values[i];
        CohortCameraDesc desc = desc_of(&prim, COHORT_CONFORM_CROP_APERTURE, 1.0, 30, 20), again;
        for (int k = 0; k < 4; k++)
            assert_true(isfinite(desc.window[k]));
        assert_true(desc.window[0] < desc.window[1] && desc.window[2] < desc.window[3]);
        assert_true(isfinite(desc.clip_near) && !isnan(desc.lens_radius));
        memset(&again, 0xa5, sizeof again);
        CohortRenderPassState state_again = {.conform = COHORT_CONFORM_CROP_APERTURE};
        co_camera_desc(&prim, &state_again, 30, 20, &again);
        assert_memory_equal(&desc, &again, sizeof desc);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(aspects_conform),        cmocka_unit_test(pixels_have_an_aspect),
        cmocka_unit_test(orthographic_apertures), cmocka_unit_test(lenses),
        cmocka_unit_test(nonsense_is_replaced),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
