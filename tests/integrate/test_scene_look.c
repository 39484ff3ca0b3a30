// The look of a scene at commit: images of lights, what is rebuilt, and what is warned of.

#include "support/scenes.h"

#include <stdio.h>

static CohortScene *dome_scene(const char *texture, uint32_t *id)
{
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
    dome.path = "/sky";
    dome.texture_file = texture;
    *id = cohort_scene_new_light(scene, &err);
    TEST_OK(cohort_scene_set_light(scene, *id, &dome, &err), &err);
    test_camera(scene, 0, 0, 5, 0.1, &err);
    return scene;
}

static float seen(const CohortScene *scene)
{
    CohortError err = {0};
    CohortRenderSettings settings = {.width = 1, .height = 1, .spp = 1};
    float *pixels = test_render(scene, &settings, NULL, &err), value = pixels[0];
    free(pixels);
    return value;
}

// A light whose image cannot be read goes dark, with one warning that names it; a commit that
// changes nothing reads nothing again.
static void a_missing_image_is_dark(void **state)
{
    (void)state;
    CohortError err = {0};
    const CohortDiagnostic *warnings;
    uint32_t id;
    CohortScene *scene = dome_scene("/nonexistent/sky.exr", &id);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    assert_int_equal(cohort_scene_warnings(scene, &warnings), 1);
    assert_string_equal(warnings[0].place, "/sky");
    assert_int_equal(warnings[0].count, 1);
    assert_non_null(strstr(warnings[0].text, "/nonexistent/sky.exr"));
    assert_true(seen(scene) == 0.0f);
    CohortSceneCounts counts;
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    cohort_scene_counts(scene, &counts);
    assert_int_equal(counts.light_builds, 1);
    // With the image gone from it, it shines.
    CohortLightDesc plain = cohort_light_default(COHORT_LIGHT_DOME);
    TEST_OK(cohort_scene_set_light(scene, id, &plain, &err), &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    assert_true(seen(scene) == 1.0f);
    cohort_scene_counts(scene, &counts);
    assert_int_equal(counts.light_builds, 2);
    cohort_scene_destroy(scene);
}

static void what_a_light_cannot_do_is_said(void **state)
{
    (void)state;
    CohortError err = {0};
    const CohortDiagnostic *warnings;
    uint32_t id;
    CohortScene *scene = dome_scene(NULL, &id);
    CohortLightDesc ball = cohort_light_default(COHORT_LIGHT_SPHERE);
    ball.path = "/ball";
    ball.radius = -1.0f;
    uint32_t dark = cohort_scene_new_light(scene, &err);
    TEST_OK(cohort_scene_set_light(scene, dark, &ball, &err), &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    assert_int_equal(cohort_scene_warnings(scene, &warnings), 1);
    assert_string_equal(warnings[0].place, "/ball");
    assert_non_null(strstr(warnings[0].text, "radius"));
    ball.hidden = true; // nobody misses it
    TEST_OK(cohort_scene_set_light(scene, dark, &ball, &err), &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    assert_true(seen(scene) == 1.0f);
    cohort_scene_destroy(scene);
}

// Textures are opened once each, however often the scene is committed.
static void textures_are_opened_once(void **state)
{
    (void)state;
    CohortError err = {0};
    uint32_t id;
    CohortScene *scene = dome_scene(NULL, &id);
    CohortTextureDesc texture = {.path = "/nonexistent/a.png", .asset = "a.png"};
    CohortSceneCounts counts;
    for (uint64_t n = 1; n <= 3; n++) {
        assert_int_not_equal(cohort_scene_new_texture(scene, &texture, &err), COHORT_INVALID_ID);
        TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
        cohort_scene_counts(scene, &counts);
        assert_int_equal(counts.texture_opens, n);
    }
    const CohortDiagnostic *warnings;
    assert_int_equal(cohort_scene_warnings(scene, &warnings), 1);
    assert_int_equal(warnings[0].count, 3);
    cohort_scene_destroy(scene);
}

// A color config that is not there ends the commit, and its name is in the error.
static void a_missing_config_is_an_error(void **state)
{
    (void)state;
    CohortError err = {0};
    uint32_t id;
    CohortScene *scene = dome_scene(NULL, &id);
    CohortSceneOptions options = {.ocio_config = "/nonexistent/c.ocio"};
    assert_false(cohort_scene_commit(scene, &options, &err));
    assert_int_equal(err.code, COHORT_ERROR_COLOR);
    assert_non_null(strstr(err.message, "/nonexistent/c.ocio"));
    CohortError again = {0};
    TEST_OK(cohort_scene_commit(scene, NULL, &again), &again);
    assert_true(seen(scene) == 1.0f);
    cohort_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_missing_image_is_dark),
        cmocka_unit_test(what_a_light_cannot_do_is_said),
        cmocka_unit_test(textures_are_opened_once),
        cmocka_unit_test(a_missing_config_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
