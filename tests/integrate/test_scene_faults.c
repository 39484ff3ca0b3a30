// Scenes and renders that run out of memory: whichever allocation fails, it is said, nothing stays
// behind, and what comes next finds the scene in order (scene.c, material.c, scene_displace.c,
// scene_commit.c, scene_look.c, render.c).

#include "base/memory.h"
#include "base/parallel.h"
#include "integrate/scene_data.h"
#include "support/faults.h"
#include "support/files.h"
#include "support/scenes.h"

#include <math.h>

enum {
    SIDE = 8,
    ATTEMPTS = 2000
};

// A displaced square of two materials, far from its own origin, with a face that is no use.
static bool set_square(CohortScene *scene, uint32_t object, uint32_t material, CohortError *err)
{
    static const int32_t counts[] = {4, 2}, indices[] = {0, 1, 2, 3, 0, 1};
    static const float heights[] = {0.0f, 0.25f, 0.5f, -0.5f};
    static const int32_t faces[] = {0};
    float points[12];
    for (int i = 0; i < 12; i++)
        points[i] = test_square_points[i] + (i % 3 == 0 ? 100.0f : 0.0f);
    CohortPrimvarDesc primvar = {.name = "height",
                                 .interpolation = COHORT_INTERPOLATION_VERTEX,
                                 .components = 1,
                                 .values = heights,
                                 .value_count = 4};
    CohortSubsetDesc subset = {.faces = faces, .face_count = 1, .material = material};
    CohortMeshDesc desc = test_cage(points, 4, counts, 2, indices, 6);
    desc.scheme = COHORT_SCHEME_BILINEAR;
    desc.level = 1;
    desc.primvars = &primvar;
    desc.primvar_count = 1;
    desc.subsets = &subset;
    desc.subset_count = 1;
    return cohort_scene_set_mesh(scene, object, &desc, err);
}

static bool set_material(CohortScene *scene, uint32_t material, CohortError *err)
{
    CohortMaterialDesc desc = cohort_material_default();
    desc.displacement = (CohortInput){.kind = COHORT_INPUT_PRIMVAR, .primvar = "height"};
    return cohort_scene_set_material(scene, material, &desc, err);
}

static bool set_places(CohortScene *scene, uint32_t object, CohortError *err)
{
    static const float color[3] = {0.5f, 0.25f, 1.0f};
    CohortInstanceDesc place = test_place(object, -100, 0, 0, 1);
    place.display_color = color;
    return cohort_scene_set_group(scene, 0, &place, 1, err);
}

// All that a host does before the first round. NULL if anything fails.
static CohortScene *make_scene(CohortRender **render, CohortError *err)
{
    const CohortRenderSettings settings = {.width = SIDE,
                                           .height = SIDE,
                                           .spp = 1,
                                           .batch = 256,
                                           .threads = 2,
                                           .scratch_folder = "/tmp"};
    CohortScene *scene = cohort_scene_create(err);
    if (!scene)
        return NULL;
    test_camera(scene, 0, 0, 5, 0.1, err);
    uint32_t material = cohort_scene_new_material(scene, err);
    uint32_t object = material == 0 ? cohort_scene_new_object(scene, err) : COHORT_INVALID_ID;
    bool ok = object != COHORT_INVALID_ID && set_material(scene, material, err) &&
              set_square(scene, object, material, err) && set_places(scene, object, err) &&
              cohort_scene_commit(scene, NULL, err);
    *render = ok ? cohort_render_create(scene, &settings, err) : NULL;
    if (*render)
        return scene;
    cohort_scene_destroy(scene);
    return NULL;
}

static CohortScene *committed_scene(CohortError *err)
{
    CohortRender *render;
    CohortScene *scene = make_scene(&render, err);
    assert_non_null(scene);
    cohort_render_destroy(render);
    return scene;
}

static void nothing_stays_behind(void **state)
{
    (void)state;
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CohortError err = {0};
        CohortRender *render = NULL;
        test_faults_begin(&faults);
        CohortScene *scene = make_scene(&render, &err);
        test_faults_end(&faults, scene != NULL, &err);
        while (scene && !cohort_render_is_done(render))
            TEST_OK(cohort_render_round(render, &err), &err);
        cohort_render_destroy(render);
        cohort_scene_destroy(scene);
    }
}

// A commit that failed is made good by the next: points are displaced once, and counted once.
static void commits_are_made_good(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    test_camera(scene, 0, 0, 5, 0.1, &err);
    uint32_t material = cohort_scene_new_material(scene, &err);
    TEST_OK(set_material(scene, material, &err), &err);
    uint32_t object = cohort_scene_new_object(scene, &err);
    TEST_OK(set_square(scene, object, material, &err), &err);
    TEST_OK(set_places(scene, object, &err), &err);
    bool is_done = false;
    uint64_t n;
    for (n = 1; n < ATTEMPTS && !is_done; n++) {
        err = (CohortError){0};
        co_memory_fail_after(n);
        is_done = cohort_scene_commit(scene, NULL, &err);
        co_memory_fail_after(0);
        assert_true(is_done || err.code == COHORT_ERROR_OUT_OF_MEMORY);
    }
    assert_true(is_done && n > 10);
    CohortSceneCounts counts;
    cohort_scene_counts(scene, &counts);
    assert_int_equal(counts.displaced_meshes, 1);
    assert_int_equal(counts.displaced_points, 7); // two of nine have no height
    double box[6];
    assert_true(cohort_scene_bounds(scene, box));
    assert_float_equal(box[2], -0.5, 1e-5);
    assert_float_equal(box[5], 0.5, 1e-5);
    cohort_scene_destroy(scene);
}

// Names so long that each is an allocation of its own.
static void failed_materials_stay(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortTextureDesc texture = {.path = "/a.png"};
    assert_int_equal(cohort_scene_new_texture(scene, &texture, &err), 0);
    uint32_t material = cohort_scene_new_material(scene, &err);
    TEST_OK(set_material(scene, material, &err), &err);
    static char name[80000];
    memset(name, 'a', sizeof name - 1);
    CohortMaterialDesc desc = cohort_material_default();
    CohortLookupDesc lookup = {.st_primvar = name};
    desc.diffuse_color = (CohortInput){.kind = COHORT_INPUT_PRIMVAR, .primvar = name};
    desc.roughness = (CohortInput){.kind = COHORT_INPUT_TEXTURE};
    desc.lookups = &lookup;
    desc.lookup_count = 1;
    CoMaterial before = scene->materials[material];
    size_t live = test_live_bytes();
    bool is_set = false;
    uint64_t n;
    for (n = 1; n < ATTEMPTS && !is_set; n++) {
        err = (CohortError){0};
        co_memory_fail_after(n);
        is_set = cohort_scene_set_material(scene, material, &desc, &err);
        co_memory_fail_after(0);
        if (is_set)
            break;
        assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        assert_memory_equal(&scene->materials[material], &before, sizeof before);
        assert_string_equal(scene->materials[material].displacement.primvar, "height");
        assert_int_equal(test_live_bytes(), live);
    }
    assert_true(is_set && n == 3);
    assert_string_equal(scene->materials[material].lookups[0].st_primvar, name);
    cohort_scene_destroy(scene);
}

// A root that finds no memory for its instances is empty, but still the root.
static void a_failed_root_is_empty(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = committed_scene(&err);
    for (uint64_t n = 1; n <= 2; n++) {
        co_memory_fail_after(n);
        assert_false(set_places(scene, 1, NULL));
        co_memory_fail_after(0);
        double box[6];
        TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
        assert_false(cohort_scene_bounds(scene, box));
        const CohortRenderSettings settings = {.width = SIDE, .height = SIDE, .spp = 1};
        float *pixels = test_render(scene, &settings, NULL, &err);
        for (int i = 0; i < 4 * SIDE * SIDE; i++)
            assert_true(pixels[i] == 0.0f);
        free(pixels);
        TEST_OK(set_places(scene, 1, &err), &err);
        TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
        assert_true(cohort_scene_bounds(scene, box));
    }
    cohort_scene_destroy(scene);
}

// Diagnostics are those of the last commit, however many edits have said more since.
static void warnings_are_those_of_the_commit(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = committed_scene(&err);
    const CohortDiagnostic *said;
    size_t count = cohort_scene_warnings(scene, &said);
    assert_true(count > 0);
    float points[12];
    memcpy(points, test_square_points, sizeof points);
    points[4] = NAN;
    CohortMeshDesc desc = test_square(points);
    desc.path = "/other";
    TEST_OK(cohort_scene_set_mesh(scene, 1, &desc, &err), &err);
    assert_int_equal(cohort_scene_warnings(scene, &said), count);
    for (size_t i = 0; i < count; i++)
        assert_string_equal(said[i].place, "/mesh");
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    assert_int_equal(cohort_scene_warnings(scene, &said), count + 1);
    assert_string_equal(said[count].place, "/other");
    cohort_scene_destroy(scene);
}

// A wall that glows by an image, under a dome of the same.
static CohortScene *lit_scene(const char *image, CohortError *err)
{
    CohortScene *scene = test_scene(err);
    CohortTextureDesc texture = {.path = image, .color_space = COHORT_COLOR_SRGB};
    CohortLookupDesc lookup = {.texture = cohort_scene_new_texture(scene, &texture, err),
                               .st_fallback = {0.25f, 0.5f}};
    CohortMaterialDesc desc = cohort_material_default();
    desc.emissive_color.kind = COHORT_INPUT_TEXTURE;
    desc.lookups = &lookup;
    desc.lookup_count = 1;
    uint32_t material = cohort_scene_new_material(scene, err);
    TEST_OK(cohort_scene_set_material(scene, material, &desc, err), err);
    CohortInstanceDesc wall;
    test_wall(scene, &wall, 2.0, 0.0, material, err);
    TEST_OK(cohort_scene_set_group(scene, 0, &wall, 1, err), err);
    CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
    dome.path = "/dome";
    dome.texture_file = image;
    uint32_t light = cohort_scene_new_light(scene, err);
    TEST_OK(cohort_scene_set_light(scene, light, &dome, err), err);
    test_camera(scene, 0, 0, 5, 0.1, err);
    return scene;
}

static float *lit_picture(const CohortScene *scene)
{
    const CohortRenderSettings settings = {
        .width = SIDE, .height = SIDE, .spp = 4, .batch = 256, .threads = 1};
    CohortError err = {0};
    const CohortDiagnostic *said;
    assert_int_equal(cohort_scene_warnings(scene, &said), 0);
    return test_render(scene, &settings, NULL, &err);
}

// Images that find no memory are no images that cannot be read: neither goes dark or to a fallback.
static void images_are_made_good(void **state)
{
    (void)state;
    co_worker_count_set(1);
    const char *image = in_folder("colors.ppm");
    CohortError err = {0};
    test_write_text(image, "P3 4 2 255\n255 0 0 0 255 0 0 0 255 9 9 9 "
                           "80 80 0 0 80 80 80 0 80 255 255 255\n");
    const CohortSceneOptions options = {.converted_folder = test_folder};
    CohortScene *scene = lit_scene(image, &err);
    TEST_OK(cohort_scene_commit(scene, &options, &err), &err);
    float *want = lit_picture(scene);
    assert_true(want[0] > 0.0f || want[1] > 0.0f || want[2] > 0.0f);
    cohort_scene_destroy(scene);
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        err = (CohortError){0};
        scene = lit_scene(image, &err);
        test_faults_begin(&faults);
        bool ok = cohort_scene_commit(scene, &options, &err);
        test_faults_end(&faults, ok, &err);
        if (!ok)
            TEST_OK(cohort_scene_commit(scene, &options, &err), &err);
        float *got = lit_picture(scene);
        assert_memory_equal(got, want, 4 * SIDE * SIDE * sizeof *got);
        free(got);
        cohort_scene_destroy(scene);
    }
    assert_true(faults.count > 20);
    free(want);
    co_worker_count_set(0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_stays_behind),
        cmocka_unit_test(commits_are_made_good),
        cmocka_unit_test(failed_materials_stay),
        cmocka_unit_test(a_failed_root_is_empty),
        cmocka_unit_test(warnings_are_those_of_the_commit),
        cmocka_unit_test(images_are_made_good),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
