// Texture lookups of a batch: as many as hits ask for, made once, and none where memory gives out.

#include "support/faults.h"
#include "support/scenes.h"

#include <math.h>

static const float points[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
static const int32_t indices[] = {0, 1, 2, 3};
static const float fallback[] = {0.25f, 0.5f, 0.75f, 1.0f};

// A quad that fills the image and glows by a texture without a file: by its fallback.
static CohortScene *textured_quad(uint32_t lookups)
{
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortTextureDesc texture = {.path = "/nowhere.png", .color_space = COHORT_COLOR_RAW};
    memcpy(texture.fallback, fallback, sizeof fallback);
    CohortLookupDesc lookup[2];
    for (uint32_t i = 0; i < 2; i++)
        lookup[i] = (CohortLookupDesc){.texture = cohort_scene_new_texture(scene, &texture, &err)};
    CohortMaterialDesc glow = cohort_material_default();
    glow.lambert = true;
    glow.emissive_color.kind = COHORT_INPUT_TEXTURE;
    glow.diffuse_color = (CohortInput){.kind = COHORT_INPUT_CONSTANT};
    glow.lookups = lookup;
    glow.lookup_count = lookups;
    if (lookups == 0)
        glow.emissive_color = (CohortInput){.value = {0.25f, 0.5f, 0.75f}};
    if (lookups == 2)
        glow.roughness = (CohortInput){.kind = COHORT_INPUT_TEXTURE, .lookup = 1};
    uint32_t material = cohort_scene_new_material(scene, &err);
    TEST_OK(cohort_scene_set_material(scene, material, &glow, &err), &err);
    uint32_t quad = test_quads(scene, points, 4, indices, 1, NULL, material, &err);
    CohortInstanceDesc place = test_place(quad, 0, 0, 0, 1);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, &err), &err);
    test_camera(scene, 0, 0, 1, 0.5, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    return scene;
}

static const CohortRenderSettings settings = {
    .width = 8, .height = 8, .spp = 4, .threads = 2, .batch = 256};

static void assert_is_fallback(const float *pixels)
{
    for (int i = 0; i < 64; i++)
        for (int c = 0; c < 3; c++)
            assert_true(fabsf(pixels[4 * i + c] - fallback[c]) < 1e-5f);
}

// Every hit asks for what its material has, whether hits are sorted or not.
static void every_hit_asks_once(void **state)
{
    (void)state;
    for (uint32_t lookups = 0; lookups <= 2; lookups++) {
        CohortScene *scene = textured_quad(lookups);
        for (int sort = COHORT_SORT_NONE; sort <= COHORT_SORT_BOTH; sort++) {
            CohortError err = {0};
            CohortRenderSettings sorted = settings;
            CohortRenderStats stats;
            sorted.sort = (CohortSort)sort;
            float *pixels = test_render(scene, &sorted, &stats, &err);
            assert_is_fallback(pixels);
            assert_true(stats.ends_hit >= 8 * 8 * 4);
            assert_int_equal(stats.texture_lookups, lookups * stats.ends_hit);
            free(pixels);
        }
        cohort_scene_destroy(scene);
    }
}

// What is left of a render, and what it comes to; the render is gone then.
static void finish(CohortRender *render)
{
    CohortError err = {0};
    float pixels[4 * 64];
    while (!cohort_render_is_done(render))
        TEST_OK(cohort_render_round(render, &err), &err);
    assert_true(cohort_render_aov(render, COHORT_AOV_COLOR, pixels));
    assert_is_fallback(pixels);
    cohort_render_destroy(render);
}

// A round that finds no memory says so, and the next one is whole: whatever it was that failed.
static void rounds_go_on_after_failures(void **state)
{
    (void)state;
    CohortScene *scene = textured_quad(1);
    int failures = 0;
    bool is_done = false;
    for (uint64_t n = 1; n < 1000 && !is_done; n++) {
        CohortError err = {0};
        CohortRender *render = cohort_render_create(scene, &settings, &err);
        assert_non_null(render);
        co_memory_fail_after(n);
        bool ok = cohort_render_round(render, &err);
        is_done = ok;
        // The next one fails too, but later or not at all.
        co_memory_fail_after(ok ? 0 : n + 1);
        if (!ok) {
            assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
            failures++;
            cohort_render_round(render, NULL);
        }
        co_memory_fail_after(0);
        finish(render);
    }
    assert_true(is_done && failures > 2);
    cohort_scene_destroy(scene);
}

// The same of each allocation alone, whether the round can do without or not.
static void one_refusal_changes_nothing(void **state)
{
    (void)state;
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CohortError err = {0};
        CohortScene *scene = textured_quad(2);
        CohortRenderSettings alone = settings;
        alone.threads = 1;
        CohortRender *render = cohort_render_create(scene, &alone, &err);
        assert_non_null(render);
        test_faults_begin(&faults);
        bool ok = cohort_render_round(render, &err);
        test_faults_end(&faults, ok, &err);
        finish(render);
        cohort_scene_destroy(scene);
    }
    assert_true(faults.count > 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_hit_asks_once),
        cmocka_unit_test(rounds_go_on_after_failures),
        cmocka_unit_test(one_refusal_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
