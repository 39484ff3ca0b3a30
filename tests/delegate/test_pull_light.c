// UsdLux lights from stage to scene: every input, old names, textures, and what is not honored.

#include "stage_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

// Without opinions a light is what the renderer calls the default of its type.
static void test_fallbacks(void **state)
{
    (void)state;
    open_stage("def RectLight 'R' {} def DiskLight 'D' {} def SphereLight 'S' {}"
               "def DistantLight 'H' {} def DomeLight 'O' {}");
    static const CohortLightType types[] = {COHORT_LIGHT_RECT, COHORT_LIGHT_DISK,
                                            COHORT_LIGHT_SPHERE, COHORT_LIGHT_DISTANT,
                                            COHORT_LIGHT_DOME};
    assert_int_equal(fake.light_count, 5);
    for (uint32_t i = 0; i < 5; i++) {
        const CohortLightDesc *light = &fake.lights[i];
        const CohortLightDesc fallback = cohort_light_default(types[i]);
        assert_int_equal(light->type, types[i]);
        assert_true(light->intensity == fallback.intensity && light->width == fallback.width);
        assert_true(light->exposure == fallback.exposure && light->radius == fallback.radius);
        assert_false(light->normalize || light->enable_color_temperature || light->no_shadow);
        assert_null(light->texture_file);
    }
}

static void test_every_input(void **state)
{
    (void)state;
    open_stage("def RectLight 'R' {"
               "  float inputs:width = 3; float inputs:height = 4; float inputs:intensity = 7;"
               "  float inputs:exposure = -1; color3f inputs:color = (1, 0.5, 0.25);"
               "  bool inputs:normalize = 1; float inputs:diffuse = 0.5;"
               "  float inputs:specular = 0.75; bool inputs:enableColorTemperature = 1;"
               "  float inputs:colorTemperature = 3000; bool inputs:shadow:enable = 0;"
               "  float inputs:shaping:cone:angle = 30; float inputs:shaping:cone:softness = 0.1;"
               "  float inputs:shaping:focus = 2; color3f inputs:shaping:focusTint = (0,0,1)"
               "}");
    const CohortLightDesc *r = &fake.lights[0];
    assert_true(r->width == 3.0f && r->height == 4.0f && r->intensity == 7.0f);
    assert_true(r->exposure == -1.0f && r->color[2] == 0.25f && r->normalize);
    assert_true(r->diffuse == 0.5f && r->specular == 0.75f && r->no_shadow);
    assert_true(r->enable_color_temperature && r->color_temperature == 3000.0f);
    assert_true(r->shaping_cone_angle_degrees == 30.0f && r->shaping_cone_softness == 0.1f);
    assert_true(r->shaping_focus == 2.0f && r->shaping_focus_tint[2] == 1.0f);
}

// What is no finite number is named once with its prim and attribute; the schema's value shines.
static void test_no_numbers(void **state)
{
    (void)state;
    static const struct {
        const char *type, *attribute, *value;
    } cases[] = {{"SphereLight", "float inputs:intensity", "nan"},
                 {"SphereLight", "float inputs:exposure", "inf"},
                 {"SphereLight", "float inputs:colorTemperature", "nan"},
                 {"SphereLight", "float inputs:radius", "-inf"},
                 {"SphereLight", "float radius", "nan"},
                 {"SphereLight", "float inputs:diffuse", "nan"},
                 {"SphereLight", "float inputs:specular", "inf"},
                 {"SphereLight", "color3f inputs:color", "(1, nan, 0.5)"},
                 {"SphereLight", "float inputs:shaping:focus", "nan"},
                 {"SphereLight", "color3f inputs:shaping:focusTint", "(inf, 0, 0)"},
                 {"SphereLight", "float inputs:shaping:cone:angle", "nan"},
                 {"SphereLight", "float inputs:shaping:cone:softness", "inf"},
                 {"RectLight", "float inputs:width", "nan"},
                 {"RectLight", "float inputs:height", "inf"},
                 {"DistantLight", "float inputs:angle", "nan"},
                 {"DomeLight", "float inputs:intensity", "1e39"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char body[256];
        snprintf(body, sizeof body, "def %s 'Odd' { %s = %s } def %s 'Plain' {}", cases[i].type,
                 cases[i].attribute, cases[i].value, cases[i].type);
        open_stage(body);
        const CohortReportEntry *entries;
        assert_int_equal(cohort_adapter_report(stage.adapter, &entries), 1);
        assert_string_equal(entries[0].prim_path, "/Odd");
        assert_string_equal(entries[0].name, strchr(cases[i].attribute, ' ') + 1);
        assert_int_equal(entries[0].count, 1);
        assert_non_null(strstr(entries[0].action, "not finite: treated as "));
        CohortLightDesc odd = fake.lights[0];
        odd.path = fake.lights[1].path;
        assert_memory_equal(&odd, &fake.lights[1], sizeof odd);
        close_stage(NULL);
    }
}

// Names without "inputs:" are read where the others are not authored.
static void test_old_names(void **state)
{
    (void)state;
    open_stage("def SphereLight 'Old' { float radius = 2; float exposure = 3 }"
               "def SphereLight 'Both' { float radius = 2; float inputs:radius = 4 }");
    assert_true(fake.lights[0].radius == 2.0f && fake.lights[0].exposure == 3.0f);
    assert_true(fake.lights[1].radius == 4.0f);
}

// DomeLight_1 turns its pole to the stage's up axis; the first DomeLight ignores that.
static void test_domes_and_the_up_axis(void **state)
{
    (void)state;
    open_stage("(upAxis = 'Z')\n def DomeLight_1 'D' {} def DomeLight 'D0' {}");
    assert_true(fake.lights[0].transform[1][2] == 1.0); // pole +Y to +Z
    assert_true(fake.lights[0].transform[2][1] == -1.0);
    assert_true(fake.lights[1].transform[1][1] == 1.0);
}

static void test_textures(void **state)
{
    (void)state;
    open_stage("def DomeLight 'Named' { asset inputs:texture:file = @a.exr@"
               "    (colorSpace = 'lin_ap1_scene');"
               "  token inputs:texture:format = 'angular' }"
               "def DomeLight 'Auto' { asset inputs:texture:file = @b.exr@ (colorSpace = 'auto') }"
               "def RectLight 'Empty' { asset inputs:texture:file = @@ }"
               "def DiskLight 'None' { asset inputs:texture:file = @c.exr@ }");
    assert_string_equal(fake.lights[0].texture_asset, "a.exr");
    assert_int_equal(fake.lights[0].texture_color_space, COHORT_COLOR_NAMED);
    assert_string_equal(fake.lights[0].texture_color_space_name, "lin_ap1_scene");
    assert_true(is_reported("/Named", "inputs:texture:format"));
    assert_non_null(strstr(fake.lights[1].texture_file, "b.exr"));
    assert_int_not_equal(fake.lights[1].texture_color_space, COHORT_COLOR_NAMED);
    assert_null(fake.lights[2].texture_file);
    assert_null(fake.lights[3].texture_file); // UsdLux gives disks none
}

static void test_what_is_not_honored_is_named(void **state)
{
    (void)state;
    open_stage("def RectLight 'R' { rel light:filters = </F>;"
               "  rel collection:lightLink:includes = </X>;"
               "  float inputs:shadow:distance = 5; float inputs:shadow:falloff = -1;"
               "  color3f inputs:shadow:color = (1,0,0);"
               "  asset inputs:shaping:ies:file = @lamp.ies@ }"
               "def DomeLight 'D' { rel portals = </P>;"
               "  bool collection:lightLink:includeRoot = 0 }"
               "def RectLight 'Plain' { float inputs:shadow:distance = -1;"
               "  color3f inputs:shadow:color = (0,0,0) }");
    static const char *const names[] = {"light:filters", "collection:lightLink:includes",
                                        "inputs:shadow:distance", "inputs:shadow:color",
                                        "inputs:shaping:ies:file"};
    for (int i = 0; i < 5; i++)
        assert_true(is_reported("/R", names[i]));
    assert_false(is_reported("/R", "inputs:shadow:falloff"));
    assert_true(is_reported("/D", "portals"));
    assert_true(is_reported("/D", "collection:lightLink:includeRoot"));
    assert_false(is_reported("/Plain", "inputs:shadow:distance"));
    assert_false(is_reported("/Plain", "inputs:shadow:color"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_fallbacks, close_stage),
        cmocka_unit_test_teardown(test_every_input, close_stage),
        cmocka_unit_test(test_no_numbers),
        cmocka_unit_test_teardown(test_old_names, close_stage),
        cmocka_unit_test_teardown(test_domes_and_the_up_axis, close_stage),
        cmocka_unit_test_teardown(test_textures, close_stage),
        cmocka_unit_test_teardown(test_what_is_not_honored_is_named, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
