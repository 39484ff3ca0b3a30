// What is hidden from some rays: a roof that casts no shadow, and one that the camera looks
// through.

#include "shed.h"

enum {
    NO_ROOF = 1
};

// Seen from height z, lit from height `light_z`.
static void render_shed(uint32_t hidden_from, double z, double light_z, float out[SHED_VALUES])
{
    CohortError err = {0};
    CohortLightDesc light = cohort_light_default(COHORT_LIGHT_RECT);
    light.width = light.height = 4.0f;
    test_identity(light.transform);
    light.transform[3][2] = light_z;
    CohortScene *scene = shed_create(hidden_from != NO_ROOF, hidden_from, &light, &err);
    shed_commit(scene, z, &err);
    CohortRenderSettings settings = {.spp = 16, .max_depth = 3, .hide_lights = true};
    shed_render(scene, &settings, out, &err);
}

static void what_no_light_ray_meets_casts_no_shadow(void **state)
{
    (void)state;
    float open[SHED_VALUES], shaded[SHED_VALUES], through[SHED_VALUES], seen[SHED_VALUES];
    render_shed(NO_ROOF, 0.0, 3.0, open);
    render_shed(0, 0.0, 3.0, shaded);
    render_shed(COHORT_HIDDEN_FROM_SHADOW | COHORT_HIDDEN_FROM_INDIRECT, 0.0, 3.0, through);
    assert_true(open[0] > 0.0f && shaded[0] == 0.0f);
    assert_memory_equal(open, through, sizeof open);
    // From above it is still there.
    render_shed(COHORT_HIDDEN_FROM_SHADOW | COHORT_HIDDEN_FROM_INDIRECT, 2.0, 0.0, seen);
    assert_true(seen[0] == 0.0f && seen[3] == 1.0f);
}

static void the_camera_looks_through(void **state)
{
    (void)state;
    float open[SHED_VALUES], blocked[SHED_VALUES], through[SHED_VALUES], shaded[SHED_VALUES];
    render_shed(NO_ROOF, 2.0, 0.0, open);
    render_shed(0, 2.0, 0.0, blocked);
    render_shed(COHORT_HIDDEN_FROM_CAMERA, 2.0, 0.0, through);
    assert_true(open[0] > 0.0f && blocked[0] == 0.0f);
    assert_memory_equal(open, through, sizeof open); // a black roof takes what the sky would have
    render_shed(COHORT_HIDDEN_FROM_CAMERA, 2.0, 3.0, shaded);
    assert_true(shaded[0] == 0.0f); // and casts its shadow
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_no_light_ray_meets_casts_no_shadow),
        cmocka_unit_test(the_camera_looks_through),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
