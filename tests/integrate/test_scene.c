// Edits of a scene: what is refused, what a failed edit leaves behind, and UsdLux's fallbacks.
// Also tests material.c.

#include "support/scenes.h"

#include "base/memory.h"
#include "integrate/scene_data.h"

#include <math.h>

static void ids_out_of_range_are_refused(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortMeshDesc quad = test_square(NULL);
    CohortLightDesc light = cohort_light_default(COHORT_LIGHT_DISK);
    CohortInstanceDesc place = test_place(7, 0, 0, 0, 1);
    const uint32_t material = 0;
    uint32_t object = cohort_scene_new_object(scene, &err);
    const bool accepted[] = {cohort_scene_set_mesh(scene, 0, &quad, &err), // the root group
                             cohort_scene_set_mesh(scene, 7, &quad, &err),
                             cohort_scene_set_group(scene, object, &place, 1, &err),
                             cohort_scene_set_light(scene, 0, &light, &err),
                             cohort_scene_set_mesh_materials(scene, object, 0, &material, 1, &err)};
    for (size_t i = 0; i < sizeof accepted / sizeof *accepted; i++)
        assert_false(accepted[i]);
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    cohort_scene_clear_object(scene, 7); // nothing to empty
    cohort_scene_destroy(scene);
}

static void cameras_that_show_nothing_are_refused(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    const CohortCameraDesc good = {.transform = {{1}, {0, 1}, {0, 0, 1}, {0, 0, 0, 1}},
                                   .window = {-1, 1, -1, 1}};
    for (int i = 0; i < 4; i++) {
        CohortCameraDesc bad = good;
        if (i == 0)
            bad.transform[3][1] = (double)NAN;
        if (i == 1)
            bad.window[2] = -HUGE_VAL;
        if (i == 2)
            bad.window[0] = bad.window[1];
        if (i == 3)
            bad.window[3] = bad.window[2];
        err = (CohortError){0};
        assert_false(cohort_scene_set_camera(scene, &bad, &err));
        assert_int_equal(err.code, COHORT_ERROR_SCENE);
        assert_false(scene->has_camera);
    }
    TEST_OK(cohort_scene_set_camera(scene, &good, &err), &err);
    assert_true(scene->has_camera);
    cohort_scene_destroy(scene);
}

// Points far from their origin are stored near it, moved by a multiple of a power of two which the
// placements take back; near ones, and single points, stay what they are.
static void far_points_keep_their_bits(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    float far[12];
    for (int i = 0; i < 12; i++)
        far[i] = test_square_points[i] + (i % 3 == 0 ? 1e5f : 0.0f);
    const float one[12] = {5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5};
    const float *const sets[] = {test_square_points, far, one};
    for (int k = 0; k < 3; k++) {
        CohortMeshDesc desc = test_square(sets[k]);
        uint32_t object = cohort_scene_new_object(scene, &err);
        TEST_OK(cohort_scene_set_mesh(scene, object, &desc, &err), &err);
        const CoSceneObject *o = &scene->objects[object];
        assert_true(k == 1 ? o->origin[0] == 1e5 : o->origin[0] == 0.0);
        assert_true(o->origin[1] == 0.0 && o->origin[2] == 0.0);
        for (int i = 0; k == 1 && i < 12; i++)
            assert_true(o->mesh.points[i] == test_square_points[i]);
    }
    cohort_scene_destroy(scene);
}

// On failure the object is empty.
static void a_failed_mesh_is_empty(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortMeshDesc desc = test_square(NULL);
    uint32_t object = cohort_scene_new_object(scene, &err);
    TEST_OK(cohort_scene_set_mesh(scene, object, &desc, &err), &err);
    const int32_t odd[] = {0, 1, 2, 9};
    desc.face_vertex_indices = odd;
    assert_false(cohort_scene_set_mesh(scene, object, &desc, &err));
    assert_int_equal(scene->objects[object].kind, CO_OBJECT_EMPTY);
    assert_non_null(strstr(err.prim_path[0] ? err.prim_path : err.message, "/mesh"));
    desc = test_square(NULL);
    desc.subset_count = 1; // whose array is missing
    err = (CohortError){0};
    assert_false(cohort_scene_set_mesh(scene, object, &desc, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    cohort_scene_destroy(scene);
}

// A light that finds no memory stays what it was.
static void failed_lights_stay(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t light = cohort_scene_new_light(scene, &err);
    char file[8192];
    memset(file, 'a', sizeof file - 1);
    file[sizeof file - 1] = '\0';
    CohortLightDesc desc = cohort_light_default(COHORT_LIGHT_DOME);
    desc.path = "/dome";
    desc.texture_file = file;
    desc.texture_asset = file;
    desc.texture_color_space_name = file;
    bool is_set = false;
    int failures = 0;
    for (uint64_t n = 1; n < 100 && !is_set; n++) {
        err = (CohortError){0};
        co_memory_fail_after(n);
        is_set = cohort_scene_set_light(scene, light, &desc, &err);
        co_memory_fail_after(0);
        const CohortLightDesc *kept = &scene->light_descs[light];
        if (!is_set) {
            assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
            assert_int_equal(kept->type, COHORT_LIGHT_RECT);
            assert_true(kept->hidden && !kept->texture_file);
            failures++;
        } else {
            assert_string_equal(kept->texture_file, file);
            assert_string_equal(kept->texture_color_space_name, file);
            assert_ptr_not_equal(kept->texture_file, file);
        }
    }
    assert_true(is_set && failures > 0);
    cohort_scene_destroy(scene);
}

// The 17th texture needs a longer list: whatever fails then, the next one finds room for all.
static void failed_textures_leave_no_gap(void **state)
{
    (void)state;
    size_t before = co_memory_live(CO_MEMORY_SCENE);
    int failures = 0;
    bool has_ended = false;
    for (uint64_t n = 1; n < 100 && !has_ended; n++) {
        CohortError err = {0};
        CohortScene *scene = test_scene(&err);
        CohortTextureDesc desc = {.path = "/a.png"};
        for (uint32_t i = 0; i < 16; i++)
            assert_int_equal(cohort_scene_new_texture(scene, &desc, &err), i);
        co_memory_fail_after(n);
        uint32_t id = cohort_scene_new_texture(scene, &desc, &err);
        co_memory_fail_after(0);
        has_ended = id == 16;
        failures += !has_ended;
        if (!has_ended) {
            assert_int_equal(id, COHORT_INVALID_ID);
            assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
            assert_int_equal(cohort_scene_new_texture(scene, &desc, NULL), 16);
        }
        assert_true(scene->texture_capacity > 16 && scene->texture_id_capacity > 16);
        cohort_scene_destroy(scene);
        assert_int_equal(co_memory_live(CO_MEMORY_SCENE), before);
    }
    assert_true(has_ended && failures >= 2);
}

// Repeats are one warning with a count.
static void warnings_are_merged(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    for (int i = 0; i < 5; i++) {
        co_scene_warn(scene, COHORT_SEVERITY_WARNING, i % 2 ? "/a" : NULL, "odd");
        co_scene_warn(scene, COHORT_SEVERITY_WARNING, "/a", "even");
    }
    assert_int_equal(scene->warning_count, 3);
    assert_string_equal(scene->warnings[0].place, "");
    assert_int_equal(scene->warnings[0].count, 3);
    assert_int_equal(scene->warnings[1].count, 5);
    assert_int_equal(scene->warnings[2].count, 2);
    cohort_scene_destroy(scene);
}

static void lights_begin_as_usdlux_has_them(void **state)
{
    (void)state;
    for (int type = COHORT_LIGHT_RECT; type <= COHORT_LIGHT_DOME; type++) {
        CohortLightDesc light = cohort_light_default((CohortLightType)type);
        assert_int_equal(light.type, type);
        assert_true(light.intensity == (type == COHORT_LIGHT_DISTANT ? 50000.0f : 1.0f));
        assert_true(light.exposure == 0.0f && light.diffuse == 1.0f && light.specular == 1.0f);
        assert_true(light.color[0] == 1.0f && light.color_temperature == 6500.0f);
        assert_false(light.normalize || light.enable_color_temperature || light.no_shadow);
        assert_true(light.width == 1.0f && light.height == 1.0f && light.radius == 0.5f);
        assert_true(light.angle_degrees == 0.53f && light.shaping_cone_angle_degrees == 90.0f);
        assert_true(light.shaping_focus == 0.0f && light.shaping_focus_tint[0] == 0.0f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ids_out_of_range_are_refused),
        cmocka_unit_test(cameras_that_show_nothing_are_refused),
        cmocka_unit_test(far_points_keep_their_bits),
        cmocka_unit_test(a_failed_mesh_is_empty),
        cmocka_unit_test(failed_lights_stay),
        cmocka_unit_test(failed_textures_leave_no_gap),
        cmocka_unit_test(warnings_are_merged),
        cmocka_unit_test(lights_begin_as_usdlux_has_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
