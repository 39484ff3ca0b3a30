// What a render gives away: AOVs, statistics that add up, films that belong to one render only.

#include "support/scenes.h"

#include <stdio.h>
#include <unistd.h>

static const float points[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, gray[] = {0.5f, 0.5f, 0.5f};
static const int32_t indices[] = {0, 1, 2, 3};

// A gray quad that fills the image, with a light behind the camera.
static CohortScene *lit_quad(void)
{
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t matte = test_matte(scene, 0.5f, 0.0f, &err);
    uint32_t quad = test_quads(scene, points, 4, indices, 1, gray, matte, &err);
    CohortInstanceDesc place = test_place(quad, 0, 0, 0, 1);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, &err), &err);
    CohortLightDesc light = cohort_light_default(COHORT_LIGHT_SPHERE);
    light.transform[3][2] = 3.0;
    uint32_t id = cohort_scene_new_light(scene, &err);
    TEST_OK(cohort_scene_set_light(scene, id, &light, &err), &err);
    test_camera(scene, 0, 0, 1, 0.5, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    return scene;
}

static const CohortRenderSettings plain = {
    .width = 8, .height = 8, .spp = 2, .threads = 1, .batch = 256, .aovs = COHORT_AOV_DEPTH};

static CohortRender *render_of(const CohortScene *scene, const CohortRenderSettings *settings)
{
    CohortError err = {0};
    CohortRender *render = cohort_render_create(scene, settings, &err);
    assert_non_null(render);
    return render;
}

static void finish(CohortRender *render)
{
    CohortError err = {0};
    while (!cohort_render_is_done(render))
        TEST_OK(cohort_render_round(render, &err), &err);
}

static void components_of_every_aov(void **state)
{
    (void)state;
    for (uint32_t bit = 1; bit <= COHORT_AOV_ERROR; bit <<= 1) {
        uint32_t want = bit == COHORT_AOV_COLOR                                ? 4
                        : bit == COHORT_AOV_NORMAL || bit == COHORT_AOV_ALBEDO ? 3
                                                                               : 1;
        assert_int_equal(cohort_aov_components((CohortAov)bit), want);
    }
}

// Color is there without being asked for; of the others those that were.
static void aovs_that_were_asked_for(void **state)
{
    (void)state;
    CohortScene *scene = lit_quad();
    CohortRender *render = render_of(scene, &plain);
    float out[4 * 64];
    finish(render);
    assert_true(cohort_render_aov(render, COHORT_AOV_COLOR, out) && out[0] > 0.0f);
    assert_true(cohort_render_aov(render, COHORT_AOV_DEPTH, out) && out[0] < 1.0f);
    assert_false(cohort_render_aov(render, COHORT_AOV_NORMAL, out));
    assert_false(cohort_render_aov(render, (CohortAov)0, out));
    assert_false(cohort_render_aov(render, (CohortAov)(1 << 20), out));
    cohort_render_destroy(render);
    cohort_scene_destroy(scene);
}

// Rays made, traced and ended are the same number, by kind and by end.
static void statistics_add_up(void **state)
{
    (void)state;
    CohortScene *scene = lit_quad();
    CohortRenderSettings settings = plain;
    settings.light_samples = 3;
    CohortRender *render = render_of(scene, &settings);
    CohortRenderStats s;
    cohort_render_stats(render, &s);
    assert_true(s.rounds == 0 && s.rays_made == 0 && s.samples_per_pixel == 0);
    finish(render);
    cohort_render_stats(render, &s);
    assert_int_equal(s.samples_per_pixel, 2);
    assert_int_equal(s.rays_camera, 2 * 64);
    assert_true(s.rays_bsdf > 0 && s.rays_light > s.rays_bsdf);
    assert_int_equal(s.rays_made, s.rays_camera + s.rays_bsdf + s.rays_light);
    assert_int_equal(s.rays_traced, s.rays_made);
    assert_int_equal(s.rays_made, s.ends_hit + s.ends_miss + s.ends_blocked + s.ends_invalid);
    assert_int_equal(s.ray_bytes, 36);
    assert_true(s.ends_light_reached > 0 && s.ends_light_reached <= s.rays_light);
    assert_int_equal(s.texture_lookups, 0);
    assert_non_null(s.isa);
    cohort_render_destroy(render);
    cohort_scene_destroy(scene);
}

// A film goes on in the same image with more samples, and in no other image.
static void films_belong_to_one_image(void **state)
{
    (void)state;
    char path[] = "/tmp/cohort_film_XXXXXX";
    close(mkstemp(path));
    CohortError err = {0};
    CohortScene *scene = lit_quad();
    CohortRender *render = render_of(scene, &plain);
    finish(render);
    TEST_OK(cohort_render_save(render, path, 77, &err), &err);
    // Once a round is done it is too late.
    assert_false(cohort_render_resume(render, path, 77, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    cohort_render_destroy(render);
    CohortRenderSettings others[11];
    for (int i = 0; i < 11; i++)
        others[i] = plain;
    others[0].seed = 1;
    others[1].max_depth = 3;
    others[2].width = 16;
    others[3].filter = COHORT_FILTER_BOX;
    others[4].hide_lights = true;
    others[5].hide_domes = true;
    others[6].aovs = COHORT_AOV_ALBEDO;
    others[7].light_samples = 2;
    others[8].first_hit_samples = 2;
    others[9].no_light_samples_after_split = true;
    others[10].texture_level0 = true;
    for (int i = 0; i < 12; i++) {
        render = render_of(scene, i < 11 ? &others[i] : &plain);
        err = (CohortError){0};
        assert_false(cohort_render_resume(render, path, i < 11 ? 77 : 78, &err));
        assert_int_not_equal(err.code, COHORT_OK);
        cohort_render_destroy(render);
    }
    CohortRenderSettings more = plain;
    more.spp = 4;
    more.batch = 1024;
    more.sort = COHORT_SORT_NONE;
    float resumed[4 * 64];
    render = render_of(scene, &more);
    TEST_OK(cohort_render_resume(render, path, 77, &err), &err);
    finish(render);
    assert_true(cohort_render_aov(render, COHORT_AOV_COLOR, resumed));
    cohort_render_destroy(render);
    float *whole = test_render(scene, &more, NULL, &err);
    assert_memory_equal(resumed, whole, sizeof resumed);
    free(whole);
    cohort_scene_destroy(scene);
    unlink(path);
}

static void libraries_have_versions(void **state)
{
    (void)state;
    CohortLibraryVersions v;
    cohort_library_versions(&v);
    const char *const versions[] = {v.opensubdiv, v.openimageio, v.opencolorio, v.openexr};
    for (int i = 0; i < 4; i++)
        assert_true(versions[i] && versions[i][0] >= '0' && versions[i][0] <= '9');
    assert_non_null(v.isa);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(components_of_every_aov), cmocka_unit_test(aovs_that_were_asked_for),
        cmocka_unit_test(statistics_add_up),       cmocka_unit_test(films_belong_to_one_image),
        cmocka_unit_test(libraries_have_versions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
