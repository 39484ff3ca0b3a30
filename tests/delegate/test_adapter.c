// The adapter as a host uses it: times, what it adds to a stage by itself, and the report.

#include "stage_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

// ---- Time --------------------------------------------------------------------------------------

static const char sampled[] =
    "def Xform 'Parent' {"
    "  color3f[] primvars:displayColor.timeSamples = { 1: [(1,0,0)], 2: [(0,1,0)] };"
    "  def Mesh 'M' { $triangle }"
    "}"
    "def Mesh 'S' { $triangle"
    "  def GeomSubset 'G' { int[] indices.timeSamples = { 1: [], 2: [0] };"
    "    uniform token elementType = 'face'; uniform token familyName = 'materialBind' }"
    "}"
    "class Xform 'P' { def Mesh 'A' { $triangle } }"
    "def Xform 'I' (instanceable = true; inherits = </P>) {"
    "  color3f[] primvars:displayColor.timeSamples = { 1: [(1,0,0)], 2: [(0,0,1)] } }";

// What a frame of a range shows is what it shows alone, wherever the sampled attribute stands.
static void test_frame_of_a_range_is_that_frame(void **state)
{
    (void)state;
    FakeObject objects[8];
    for (int range = 0; range < 2; range++) {
        CohortAdapterOptions options = {.time_choice = COHORT_TIME_AT, .time = range ? 1.0 : 2.0};
        open_stage_with(sampled, &options);
        if (range) {
            assert_true(cohort_adapter_set_time(stage.adapter, 2.0, NULL));
            assert_true(cohort_render_index_sync(stage.index, NULL));
        }
        assert_true(fake_mesh("/Parent/M")->first_color[1] == 1.0f);
        assert_int_equal(fake_mesh("/S")->subset_faces, 1);
        const FakeObject *root = &fake.objects[0];
        bool found = false;
        for (size_t i = 0; i < root->instance_count; i++)
            found = found || (root->instances[i].prim_id < 0 && root->colors[i][2] == 1.0f);
        assert_true(found);
        assert_true(fake.object_count <= 8);
        for (uint32_t i = 0; range && i < fake.object_count; i++)
            assert_memory_equal(objects[i].colors, fake.objects[i].colors,
                                sizeof objects[i].colors);
        memcpy(objects, fake.objects, sizeof objects);
        if (!range)
            close_stage(NULL);
    }
}

// ---- What the adapter adds ---------------------------------------------------------------------

// The recording renderer's box is (-1,-2,-3) to (1,2,3).
static void test_framing_env_and_headlight(void **state)
{
    (void)state;
    char folder[] = "/tmp/cohort-adapter-XXXXXX";
    assert_non_null(mkdtemp(folder));
    setenv("TMPDIR", folder, 1);
    CohortAdapterOptions options = {.env = "sky", .headlight = true, .width = 100};
    open_stage_with("def Mesh 'M' { $triangle }", &options);
    CohortResolvedSettings settings;
    cohort_adapter_settings(stage.adapter, &settings);
    assert_true(settings.camera_frames);
    assert_int_equal(settings.height, 73); // of the default aperture
    render_stage(100, 73);
    assert_true(fabs(fake.camera.transform[3][2] - (2.0 * 100.0 / 15.2908 + 3.0)) < 1e-5);
    assert_int_equal(fake.light_count, 2);
    assert_int_equal(fake.lights[0].type, COHORT_LIGHT_DOME);
    assert_int_equal(fake.lights[1].type, COHORT_LIGHT_DISTANT);
    assert_true(fake.lights[1].transform[3][2] == fake.camera.transform[3][2]);
    assert_int_equal(access(fake.lights[0].texture_file, R_OK), 0);
    unsetenv("TMPDIR");
    assert_int_equal(rmdir(folder), 0); // the sky has left nothing there, while it is in use
}

static void test_z_up_framing(void **state)
{
    (void)state;
    open_stage("(upAxis = 'Z')\n def Mesh 'M' { $triangle }");
    render_stage(10, 10);
    assert_true(fabs(fake.camera.transform[3][1] + (3.0 * 100.0 / 15.2908 + 2.0)) < 1e-5);
    assert_true(fake.camera.transform[1][2] == 1.0);  // up is +Z
    assert_true(fake.camera.transform[2][1] == -1.0); // it looks along +Y
}

// ---- The report --------------------------------------------------------------------------------

static bool has_entry(const char *prim_path, const char *name, const char *text)
{
    const CohortReportEntry *entries;
    size_t count = cohort_adapter_report(stage.adapter, &entries);
    for (size_t i = 0; i < count; i++)
        if (!strcmp(entries[i].prim_path, prim_path) && !strcmp(entries[i].name, name) &&
            (strstr(entries[i].action, text) || strstr(entries[i].value, text)))
            return true;
    return false;
}

static void count_call(void *cookie, CohortSeverity severity, const char *file, uint32_t line,
                       uint32_t column, const char *prim_path, const char *text)
{
    (void)severity, (void)file, (void)line, (void)column, (void)prim_path, (void)text;
    ++*(int *)cookie;
}

static void test_missing_files_are_in_the_report(void **state)
{
    (void)state;
    int calls = 0;
    CohortAdapterOptions options = {.stage = {.report = count_call, .cookie = &calls}};
    open_stage_with("def 'R' (references = @nowhere.usda@) {}"
                    "def Material 'T' { token outputs:surface.connect = </T/S.outputs:surface>;"
                    "  def Shader 'S' { uniform token info:id = 'UsdPreviewSurface';"
                    "    color3f inputs:diffuseColor.connect = </T/I.outputs:rgb> }"
                    "  def Shader 'I' { uniform token info:id = 'UsdUVTexture';"
                    "    asset inputs:file = @nowhere.png@; float3 outputs:rgb } }"
                    "def Mesh 'M' { $triangle rel material:binding = </T> }",
                    &options);
    assert_true(has_entry("/R", "composition", "nowhere.usda"));
    assert_true(has_entry("/T/I", "inputs:file", "nowhere.png"));
    assert_true(calls > 0);
}

static void test_missing_stage(void **state)
{
    (void)state;
    CohortError err = {0};
    memset(&stage, 0, sizeof stage);
    stage.delegate = cohort_delegate_create(NULL);
    stage.index = cohort_render_index_create(stage.delegate, NULL);
    assert_null(cohort_adapter_open(stage.delegate, "/nowhere/x.usda", NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_NOT_FOUND);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_frame_of_a_range_is_that_frame, close_stage),
        cmocka_unit_test_teardown(test_framing_env_and_headlight, close_stage),
        cmocka_unit_test_teardown(test_z_up_framing, close_stage),
        cmocka_unit_test_teardown(test_missing_files_are_in_the_report, close_stage),
        cmocka_unit_test_teardown(test_missing_stage, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
