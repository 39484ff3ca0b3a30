// Schedule-free images: every bit of every AOV is the same whatever the threads, batch, sort,
// instruction set, or where the render stopped and went on.

#include "support/scenes.h"

#include "base/hash.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

enum {
    WIDTH = 40,
    HEIGHT = 30,
    AOVS = COHORT_AOV_COLOR | COHORT_AOV_DEPTH | COHORT_AOV_CAMERA_DEPTH | COHORT_AOV_NORMAL |
           COHORT_AOV_ALBEDO | COHORT_AOV_PRIM_ID | COHORT_AOV_ELEMENT_ID |
           COHORT_AOV_SAMPLE_COUNT | COHORT_AOV_ERROR
};

static uint32_t glossy(CohortScene *scene, float roughness, float opacity, bool presence,
                       CohortError *err)
{
    CohortMaterialDesc desc = cohort_material_default();
    desc.diffuse_color.value[0] = 0.7f;
    desc.roughness.value[0] = roughness;
    desc.opacity.value[0] = opacity;
    desc.opacity_presence = presence;
    uint32_t id = cohort_scene_new_material(scene, err);
    TEST_OK(cohort_scene_set_material(scene, id, &desc, err), err);
    return id;
}

static void add_light(CohortScene *scene, CohortLightType type, double y, CohortError *err)
{
    CohortLightDesc desc = cohort_light_default(type);
    static const double down[4][4] = {{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}, {0, 0, 0, 1}};
    memcpy(desc.transform, down, sizeof down);
    desc.transform[3][1] = y;
    desc.intensity = type == COHORT_LIGHT_DOME ? 0.2f : 4.0f;
    desc.width = desc.height = 1.5f;
    uint32_t id = cohort_scene_new_light(scene, err);
    TEST_OK(cohort_scene_set_light(scene, id, &desc, err), err);
}

// Cut-outs, a mirror, nested instances, coincident boxes, slivers, lens, four kinds of light.
static CohortScene *build(CohortError *err)
{
    CohortScene *scene = test_scene(err);
    static const float slivers[] = {-3, 0, 0, 3, 1e-6f, 0, 3, 2e-6f, 0.1f, -3, 1e-6f, 0.1f};
    static const int32_t sliver_indices[] = {0, 1, 2, 3};
    uint32_t shiny = glossy(scene, 0.2f, 1.0f, false, err);
    uint32_t mirror = glossy(scene, 0.0f, 1.0f, false, err);
    uint32_t glass = glossy(scene, 0.4f, 0.4f, false, err);
    uint32_t gauze = glossy(scene, 0.6f, 0.5f, true, err);
    uint32_t materials[4] = {shiny, mirror, glass, gauze}, boxes[4];
    for (int i = 0; i < 4; i++)
        boxes[i] =
            test_quads(scene, test_box_points, 8, test_box_indices, 6, NULL, materials[i], err);
    uint32_t sliver = test_quads(scene, slivers, 4, sliver_indices, 1, NULL, shiny, err);
    uint32_t pair = cohort_scene_new_object(scene, err), ring = cohort_scene_new_object(scene, err);
    CohortInstanceDesc two[2] = {test_place(boxes[0], 0, 0, 0, 0.3),
                                 test_place(boxes[3], 0.5, 0.4, 0.2, 0.2)};
    TEST_OK(cohort_scene_set_group(scene, pair, two, 2, err), err);
    CohortInstanceDesc many[12];
    for (int i = 0; i < 12; i++)
        many[i] = test_place(pair, 2.0 * cos(i * 0.52), 0.1 * i, 2.0 * sin(i * 0.52), 0.8);
    TEST_OK(cohort_scene_set_group(scene, ring, many, 12, err), err);
    CohortInstanceDesc root[7] = {
        test_place(ring, 0, -0.5, 0, 1.0),      test_place(boxes[1], -0.8, -0.3, 0, 0.5),
        test_place(boxes[2], 0.9, 0, 1, 0.6),   test_place(boxes[0], 0, -2, 0, 1.2),
        test_place(boxes[0], 0, -2, 0, 1.2),    test_place(sliver, 0, 0.3, 0.5, 1.0),
        test_place(boxes[3], 0, -100.8, 0, 100)};
    TEST_OK(cohort_scene_set_group(scene, 0, root, 7, err), err);
    add_light(scene, COHORT_LIGHT_RECT, 4, err);
    add_light(scene, COHORT_LIGHT_SPHERE, 3, err);
    add_light(scene, COHORT_LIGHT_DISTANT, 0, err);
    add_light(scene, COHORT_LIGHT_DOME, 0, err);
    test_camera(scene, 0, 0.3, 6, 0.5, err);
    CohortCameraDesc camera = {.window = {-0.5, 0.5, -0.4, 0.4},
                               .clip_near = 0.1,
                               .clip_far = 1e4,
                               .lens_radius = 0.1,
                               .focus_distance = 6};
    test_identity(camera.transform);
    camera.transform[3][2] = 6;
    TEST_OK(cohort_scene_set_camera(scene, &camera, err), err);
    TEST_OK(cohort_scene_commit(scene, NULL, err), err);
    return scene;
}

static uint64_t hash_aovs(const CohortRender *render)
{
    static float pixels[WIDTH * HEIGHT * 4];
    uint64_t hash = 0;
    for (uint32_t bit = 1; bit <= COHORT_AOV_ERROR; bit <<= 1) {
        assert_true(cohort_render_aov(render, (CohortAov)bit, pixels));
        size_t n = WIDTH * HEIGHT * cohort_aov_components((CohortAov)bit);
        hash = co_hash_bytes(pixels, n * sizeof(float), hash);
    }
    return hash;
}

static const CohortRenderSettings base = {.width = WIDTH,
                                          .height = HEIGHT,
                                          .spp = 12,
                                          .max_depth = 8,
                                          .first_hit_samples = 3,
                                          .light_samples = 2,
                                          .aovs = AOVS,
                                          .batch = 4096};

static uint64_t hash_of(const CohortScene *scene, const CohortRenderSettings *settings,
                        CohortRenderStats *stats)
{
    CohortError err = {0};
    CohortRender *render = cohort_render_create(scene, settings, &err);
    if (!render && err.code == COHORT_ERROR_ARGUMENT)
        return 0; // an instruction set that this machine lacks
    assert_non_null(render);
    while (!cohort_render_is_done(render))
        TEST_OK(cohort_render_round(render, &err), &err);
    uint64_t hash = hash_aovs(render);
    if (stats)
        cohort_render_stats(render, stats);
    cohort_render_destroy(render);
    return hash;
}

static void image_does_not_depend_on_the_schedule(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = build(&err);
    CohortRenderStats stats;
    uint64_t expected = hash_of(scene, &base, &stats);
    assert_true(stats.batches[0] + stats.batches[1] + stats.batches[2] > 3);
    assert_int_equal(stats.rays_made, stats.rays_traced);
    assert_int_equal(stats.ray_bytes, 40);
    static const uint32_t threads[] = {1, 2, 4}, batches[] = {1u << 10, 1u << 14, 1u << 20};
    static const CohortSort sorts[] = {COHORT_SORT_NONE, COHORT_SORT_RAYS, COHORT_SORT_HITS,
                                       COHORT_SORT_BOTH};
    static const char *const isas[] = {"scalar", "sse42", "avx2", "avx512"};
    for (int i = 0; i < 3; i++) {
        CohortRenderSettings s = base;
        s.threads = threads[i];
        s.batch = batches[i];
        assert_int_equal(hash_of(scene, &s, NULL), expected);
    }
    for (int i = 0; i < 4; i++) {
        CohortRenderSettings s = base;
        s.sort = sorts[i];
        s.sorter = i & 1 ? COHORT_SORTER_EXACT : COHORT_SORTER_FAST;
        assert_int_equal(hash_of(scene, &s, NULL), expected);
    }
    for (int i = 0; i < 4; i++) {
        CohortRenderSettings s = base;
        s.isa = isas[i];
        s.sort = COHORT_SORT_BOTH;
        uint64_t hash = hash_of(scene, &s, NULL);
        assert_true(hash == expected || (i > 0 && hash == 0));
    }
    cohort_scene_destroy(scene);
}

static void stopping_and_going_on_changes_nothing(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = build(&err);
    uint64_t expected = hash_of(scene, &base, NULL);
    char path[] = "/tmp/cohort-test-film-XXXXXX";
    int fd = mkstemp(path);
    close(fd);
    unlink(path);
    uint64_t hash = 0;
    for (int part = 0; part < 3; part++) {
        CohortRender *render = cohort_render_create(scene, &base, &err);
        assert_non_null(render);
        if (part > 0)
            TEST_OK(cohort_render_resume(render, path, 7, &err), &err);
        for (int round = 0; !cohort_render_is_done(render) && (round < 2 || part == 2); round++)
            TEST_OK(cohort_render_round(render, &err), &err);
        TEST_OK(cohort_render_save(render, path, 7, &err), &err);
        hash = hash_aovs(render);
        cohort_render_destroy(render);
    }
    assert_int_equal(hash, expected);
    CohortRenderSettings other = base;
    other.seed = 5;
    CohortRender *render = cohort_render_create(scene, &other, &err);
    assert_false(cohort_render_resume(render, path, 7, &err));
    cohort_render_destroy(render);
    unlink(path);
    cohort_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(image_does_not_depend_on_the_schedule),
        cmocka_unit_test(stopping_and_going_on_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
