// Bindings, material networks, lights, cameras and settings, from stage to scene.

#include "stage_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static StageFixture f;

static void open_with(const char *body, const CohortAdapterOptions *options)
{
    CohortError err = {0};
    if (!stage_fixture_open(&f, body, options, &err))
        fail_msg("%s", err.message);
}

static int teardown(void **state)
{
    (void)state;
    stage_fixture_close(&f);
    return 0;
}

#define BIND "(prepend apiSchemas = [\"MaterialBindingAPI\"])"
#define MATERIAL(name, red) \
    "def Material \"" name "\" { token outputs:surface.connect = </" name ".outputs:surface_x>\n" \
    "token outputs:surface_x.connect = </" name "/S.outputs:surface>\n" \
    "def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\"\n" \
    "color3f inputs:diffuseColor = (" red ", 0, 0)\n token outputs:surface } }\n"

// Red of the material a mesh has, -1 without one.
static float red_of(uint32_t material)
{
    return material == COHORT_INVALID_ID ? -1.0f : fake.materials[material].diffuse_color.value[0];
}

static float mesh_red(const char *path)
{
    const FakeObject *mesh = fake_mesh(path);
    assert_non_null(mesh);
    return red_of(mesh->material);
}

static void test_binding_strength_and_purpose(void **state)
{
    (void)state;
    open_with(
        MATERIAL("M1", "0.1") MATERIAL("M2", "0.2") MATERIAL(
            "M3",
            "0.3") "def Xform \"Weak\" " BIND
                   " { rel material:binding = </M1>\n" TRIANGLE("Own",
                                                                "rel material:binding = </M2>")
                       TRIANGLE(
                           "None",
                           "") "}\n"
                               "def Xform \"Strong\" " BIND
                               " { rel material:binding = </M1> (bindMaterialAs = "
                               "\"strongerThanDescendants\")\n" TRIANGLE(
                                   "Own",
                                   "rel material:binding = </M2>") "}\n"
                                                                   "def Xform \"Full\" " BIND
                                                                   " { rel material:binding:full = "
                                                                   "</M3>\n" TRIANGLE(
                                                                       "Own",
                                                                       "rel material:binding = "
                                                                       "</M2>") "}\n" TRIANGLE("Unb"
                                                                                               "oun"
                                                                                               "d",
                                                                                               "")
                                                                       TRIANGLE(
                                                                           "Lost",
                                                                           "rel material:binding = "
                                                                           "</Nowhere>"),
        NULL);
    assert_true(mesh_red("/Weak/Own") == 0.2f);
    assert_true(mesh_red("/Weak/None") == 0.1f);
    assert_true(mesh_red("/Strong/Own") == 0.1f);
    assert_true(mesh_red("/Full/Own") == 0.3f);
    assert_true(mesh_red("/Unbound") == -1.0f);
    assert_true(mesh_red("/Lost") == -1.0f);
    assert_true(stage_fixture_reports(&f, "/Lost", "material:binding"));
}

static void test_collection_bindings(void **state)
{
    (void)state;
    open_with(
        MATERIAL("M1", "0.1") MATERIAL(
            "M2", "0.2") "def Xform \"C\" (prepend apiSchemas = [\"MaterialBindingAPI\", "
                         "\"CollectionAPI:some\"]) { rel material:binding = </M1>\n"
                         "rel material:binding:collection:some = [</C.collection:some>, </M2>]\n"
                         "rel collection:some:includes = [</C/In>]\n rel collection:some:excludes "
                         "= [</C/In/Not>]\n"
                         "def Xform \"In\" {\n" TRIANGLE("Yes", "") TRIANGLE("Not", "")
                             TRIANGLE("Direct", "rel material:binding = </M1>") "}\n" TRIANGLE(
                                 "Out", "") "}\n",
        NULL);
    assert_true(mesh_red("/C/In/Yes") == 0.2f);
    assert_true(mesh_red("/C/In/Not") == 0.1f);
    assert_true(mesh_red("/C/In/Direct") == 0.1f);
    assert_true(mesh_red("/C/Out") == 0.1f);
}

static void test_collections_of_collections(void **state)
{
    (void)state;
    open_with(
        MATERIAL("M1", "0.1") MATERIAL(
            "M2", "0.2") "def Xform \"C\" " BIND " { rel material:binding = </M1>\n"
                         "rel material:binding:collection:all = [</C.collection:all>, </M2>]\n"
                         "rel collection:all:includes = [</C.collection:a>, </C/Own>]\n"
                         "rel collection:all:excludes = [</C/A/Not>]\n"
                         "rel collection:a:includes = [</C/A>, </C.collection:b>]\n"
                         "rel collection:a:excludes = [</C/Own/Deep>]\n"
                         "rel collection:b:includes = [</C/B>, </C.collection:all>]\n" // a cycle
                         "def Xform \"A\" {\n" TRIANGLE("Yes", "")
                             TRIANGLE("Not", "") "}\n"
                                                 "def Xform \"Own\" {\n" TRIANGLE("Yes", "")
                                                     TRIANGLE("Deep", "") "}\n" TRIANGLE("B", "")
                                                         TRIANGLE("Out", "") "}\n",
        NULL);
    assert_true(mesh_red("/C/A/Yes") == 0.2f);
    assert_true(mesh_red("/C/A/Not") == 0.1f);
    assert_true(mesh_red("/C/B") == 0.2f);
    assert_true(mesh_red("/C/Own/Yes") == 0.2f);
    assert_true(mesh_red("/C/Own/Deep") == 0.1f); // the included collection leaves it out
    assert_true(mesh_red("/C/Out") == 0.1f);
}

static void test_subsets(void **state)
{
    (void)state;
    open_with(MATERIAL("M1", "0.1") MATERIAL("M2", "0.2")
                  TRIANGLE("A", "rel material:binding = </M1>\n"
                                "def GeomSubset \"S\" " BIND " { int[] indices = [0]\n"
                                "uniform token elementType = \"face\"\n"
                                "uniform token familyName = \"materialBind\"\n"
                                "rel material:binding = </M2> }\n"
                                "def GeomSubset \"E\" { int[] indices = [0]\n"
                                "uniform token elementType = \"edge\"\n"
                                "uniform token familyName = \"materialBind\" }"),
              NULL);
    assert_true(mesh_red("/A") == 0.1f);
    assert_true(red_of(fake_mesh("/A")->subset_material) == 0.2f);
    assert_true(stage_fixture_reports(&f, "/A/E", "elementType"));
}

static const char network[] =
    "def Material \"M\" {\n float inputs:rough = 0.7\n asset inputs:map = @tex.png@ (colorSpace = "
    "\"lin_ap1_scene\")\n"
    "token outputs:surface.connect = </M/G.outputs:out>\n"
    "token outputs:displacement.connect = </M/G/S.outputs:displacement>\n"
    "def NodeGraph \"G\" { token outputs:out.connect = </M/G/S.outputs:surface>\n"
    "float inputs:r.connect = </M.inputs:rough>\n"
    "def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\"\n"
    "color3f inputs:diffuseColor.connect = </M/G/T.outputs:rgb>\n"
    "float inputs:roughness.connect = </M/G.inputs:r>\n"
    "float inputs:opacity.connect = </M/G/T.outputs:a>\n"
    "color3f inputs:emissiveColor.connect = </M/G/P.outputs:result>\n"
    "float inputs:metallic.connect = </M/G/X.outputs:out>\n"
    "float inputs:displacement = 1\n int inputs:useSpecularWorkflow = 1\n token outputs:surface }\n"
    "def Shader \"T\" { uniform token info:id = \"UsdUVTexture\"\n"
    "asset inputs:file.connect = </M.inputs:map>\n float2 inputs:st.connect = "
    "</M/G/X2.outputs:result>\n"
    "token inputs:wrapS = \"mirror\"\n token inputs:sourceColorSpace = \"sRGB\"\n"
    "float4 inputs:scale = (2,2,2,1)\n float4 inputs:bias = (-1,-1,-1,0)\n float4 inputs:fallback "
    "= (1,0,1,1)\n"
    "float3 outputs:rgb\n float outputs:a }\n"
    "def Shader \"X2\" { uniform token info:id = \"UsdTransform2d\"\n"
    "float2 inputs:in.connect = </M/G/U.outputs:result>\n float inputs:rotation = 30\n"
    "float2 inputs:scale = (2, 3)\n float2 inputs:translation = (0.5, 0)\n float2 outputs:result "
    "}\n"
    "def Shader \"U\" { uniform token info:id = \"UsdPrimvarReader_float2\"\n"
    "string inputs:varname = \"map1\"\n float2 outputs:result }\n"
    "def Shader \"P\" { uniform token info:id = \"UsdPrimvarReader_float3\"\n"
    "string inputs:varname = \"glow\"\n float3 inputs:fallback = (0,1,0)\n float3 outputs:result "
    "}\n"
    "def Shader \"X\" { uniform token info:id = \"ND_noise3d_float\"\n float outputs:out }\n"
    "} }\n" TRIANGLE("A", "rel material:binding = </M>\n float2[] primvars:map1 = [(0,0)]\n"
                          "float3[] primvars:glow = [(0,0,1)]\n float2[] primvars:other = [(0,0)]");

static void test_network(void **state)
{
    (void)state;
    open_with(network, NULL);
    const CohortMaterialDesc *m = &fake.materials[0];
    assert_int_equal(m->lookup_count, 1); // one node, two uses
    assert_int_equal(m->diffuse_color.kind, COHORT_INPUT_TEXTURE);
    assert_int_equal(m->opacity.kind, COHORT_INPUT_TEXTURE);
    assert_int_equal(m->opacity.channel, 3);
    assert_true(m->roughness.kind == COHORT_INPUT_CONSTANT && m->roughness.value[0] == 0.7f);
    assert_int_equal(m->emissive_color.kind, COHORT_INPUT_PRIMVAR);
    assert_true(m->emissive_color.value[1] == 1.0f);
    assert_true(m->use_specular_workflow);
    const CohortLookupDesc *l = &fake.lookups[0][0];
    assert_true(l->st_scale[1] == 3.0f && l->st_rotation_degrees == 30.0f);
    assert_true(l->st_translation[0] == 0.5f && l->scale[0] == 2.0f && l->bias[2] == -1.0f);
    assert_int_equal(fake.texture_count, 1);
    assert_int_equal(fake.textures[0].color_space, COHORT_COLOR_NAMED); // metadata beats the input
    assert_int_equal(fake.textures[0].wrap_s, COHORT_WRAP_MIRROR);
    assert_int_equal(fake.textures[0].wrap_t, COHORT_WRAP_USE_METADATA);
    assert_true(fake.textures[0].fallback[0] == 1.0f);
    assert_non_null(strstr(fake.texture_paths[0], "tex.png"));
    assert_int_equal(fake_mesh("/A")->primvar_count, 2); // what the material reads, no other
    assert_true(stage_fixture_reports(&f, "/M/G/X", "ND_noise3d_float"));
    assert_true(m->displacement.kind == COHORT_INPUT_CONSTANT && m->displacement.value[0] == 1.0f);
    assert_false(stage_fixture_reports(&f, "/M/G/S", "inputs:displacement"));
}

// A displacement input counts where the material's displacement comes from, as with Hydra's
// terminals.
static void test_displacement_is_what_is_connected(void **state)
{
    (void)state;
    open_with("def Material \"A\" { token outputs:surface.connect = </A/S.outputs:surface>\n"
              "def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\"\n"
              "float inputs:displacement = 1\n token outputs:surface } }\n"
              "def Material \"B\" { token outputs:surface.connect = </A/S.outputs:surface>\n"
              "token outputs:displacement.connect = </B/D.outputs:displacement>\n"
              "def Shader \"D\" { uniform token info:id = \"UsdPreviewSurface\"\n"
              "float inputs:displacement = 2\n token outputs:displacement } }\n"
              "def Material \"C\" { token outputs:surface.connect = </A/S.outputs:surface>\n"
              "token outputs:displacement.connect = </C/D.outputs:out>\n"
              "def Shader \"D\" { uniform token info:id = \"PxrDisplace\"\n"
              "float inputs:displacement = 3 } }\n"
              "def Material \"D\" { token outputs:surface.connect = </A/S.outputs:surface>\n"
              "token outputs:volume.connect = </C/D.outputs:out> }\n" TRIANGLE(
                  "MA", "rel material:binding = </A>") TRIANGLE("MB", "rel material:binding = </B>")
                  TRIANGLE("MC", "rel material:binding = </C>")
                      TRIANGLE("MD", "rel material:binding = </D>"),
              NULL);
    for (int k = 0; k < 4; k++)
        assert_true(fake.materials[k].displacement.value[0] == (k == 1 ? 2.0f : 0.0f));
    assert_true(stage_fixture_reports(&f, "/C/D", "info:id"));
    assert_true(stage_fixture_reports(&f, "/D", "outputs:volume"));
    assert_false(stage_fixture_reports(&f, "/A/S", "inputs:displacement"));
}

static void test_ptex_and_foreign_surfaces(void **state)
{
    (void)state;
    open_with("def Material \"P\" { token outputs:surface.connect = </P/S.outputs:surface>\n"
              "def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\"\n"
              "color3f inputs:diffuseColor.connect = </P/T.outputs:rgb>\n token outputs:surface }\n"
              "def Shader \"T\" { uniform token info:id = \"HwPtexTexture_1\"\n asset inputs:file "
              "= @a.ptx@ } }\n"
              "def Material \"D\" { token outputs:ri:surface.connect = </D/S.outputs:surface>\n"
              "def Shader \"S\" { uniform token info:id = \"PxrDisneyBsdf\" } }\n"
              "def Material \"E\" {}\n"
              "def Material \"Loop\" { token outputs:surface.connect = </Loop.outputs:surface> "
              "}\n" TRIANGLE("A", "rel material:binding = </P>")
                  TRIANGLE("B", "rel material:binding = </D>")
                      TRIANGLE("C", "rel material:binding = </E>")
                          TRIANGLE("L", "rel material:binding = </Loop>"),
              NULL);
    assert_true(fake.textures[0].is_ptex);
    assert_true(mesh_red("/B") == -1.0f);
    assert_true(stage_fixture_reports(&f, "/D/S", "info:id"));
    assert_true(stage_fixture_reports(&f, "/E", "outputs:surface"));
    assert_true(stage_fixture_reports(&f, "/Loop", "outputs:surface"));
}

static void test_lights(void **state)
{
    (void)state;
    open_with("(\n upAxis = \"Z\"\n)\n"
              "def RectLight \"R\" { float inputs:width = 3\n float inputs:intensity = 7\n"
              "color3f inputs:color = (1, 0.5, 0.25)\n bool inputs:normalize = 1\n"
              "float inputs:shaping:cone:angle = 30\n rel light:filters = </F>\n"
              "rel collection:lightLink:includes = </X> }\n"
              "def SphereLight \"Old\" { float radius = 2\n float exposure = 3 }\n"
              "def DomeLight_1 \"D\" {}\n"
              "def DomeLight \"D0\" {}\n"
              "def CylinderLight \"C\" {}\n"
              "def DistantLight \"H\" { token visibility = \"invisible\" }\n",
              NULL);
    assert_int_equal(fake.light_count, 4);
    assert_true(fake.lights[0].width == 3.0f && fake.lights[0].intensity == 7.0f);
    assert_true(fake.lights[0].color[2] == 0.25f && fake.lights[0].normalize);
    assert_true(fake.lights[0].shaping_cone_angle_degrees == 30.0f);
    assert_true(fake.lights[1].radius == 2.0f && fake.lights[1].exposure == 3.0f);
    assert_true(fake.lights[2].transform[1][2] == 1.0); // pole +Y to +Z
    assert_true(fake.lights[2].transform[2][1] == -1.0);
    assert_true(fake.lights[3].transform[1][1] == 1.0); // the first DomeLight ignores the up axis
    assert_true(stage_fixture_reports(&f, "/C", "CylinderLight"));
    assert_true(stage_fixture_reports(&f, "/R", "light:filters"));
    assert_true(stage_fixture_reports(&f, "/R", "collection:lightLink:includes"));
    CohortResolvedSettings settings;
    cohort_adapter_settings(f.adapter, &settings);
    assert_int_equal(settings.light_count, 4);
}

static void test_lights_in_instances(void **state)
{
    (void)state;
    open_with("class Xform \"P\" { def SphereLight \"L\" { double3 xformOp:translate = (0,1,0)\n"
              "uniform token[] xformOpOrder = [\"xformOp:translate\"] } }\n"
              "def Xform \"I1\" (instanceable = true\n inherits = </P>) {}\n"
              "def Xform \"I2\" (instanceable = true\n inherits = </P>) {\n"
              "double3 xformOp:translate = (5,0,0)\n"
              "uniform token[] xformOpOrder = [\"xformOp:translate\"] }\n",
              NULL);
    assert_int_equal(fake.light_count, 2);
    assert_true(fake.lights[0].transform[3][0] == 0.0 && fake.lights[0].transform[3][1] == 1.0);
    assert_true(fake.lights[1].transform[3][0] == 5.0 && fake.lights[1].transform[3][1] == 1.0);
}

// Whatever else shows the same prototype, and wherever it is met first.
static void test_lights_of_point_instancers_are_named(void **state)
{
    (void)state;
    open_with("class Xform \"P\" { def SphereLight \"L\" {} }\n"
              "class Xform \"Q\" { def PointInstancer \"PI\" {\n"
              "rel prototypes = [</Q/PI/Lamp>]\n int[] protoIndices = [0]\n"
              "point3f[] positions = [(1,0,0)]\n"
              "def Xform \"Lamp\" { def DiskLight \"D\" {} } } }\n"
              "def Xform \"A\" (instanceable = true\n inherits = </P>) {}\n"
              "def Xform \"B\" (instanceable = true\n inherits = </Q>) {}\n"
              "def PointInstancer \"C\" {\n rel prototypes = [</C/Shared>, </C/Own>]\n"
              "int[] protoIndices = [0, 1]\n point3f[] positions = [(1,0,0), (2,0,0)]\n"
              "def Xform \"Shared\" (instanceable = true\n inherits = </P>) {}\n"
              "def Xform \"Own\" { def RectLight \"R\" {} } }\n",
              NULL);
    assert_int_equal(fake.light_count, 1); // of A
    assert_true(stage_fixture_reports(&f, "/C/Shared", "instance"));
    assert_true(stage_fixture_reports(&f, "/C/Own/R", "RectLight"));
    assert_true(stage_fixture_reports(&f, "/B/PI/Lamp/D", "DiskLight"));
}

static void test_settings_and_camera(void **state)
{
    (void)state;
    open_with(
        "(\n renderSettingsPrimPath = \"/Set\"\n)\n"
        "def Camera \"Other\" {}\n"
        "def Camera \"Cam\" { float horizontalAperture = 20\n float verticalAperture = 10\n"
        "float focalLength = 40\n float fStop = 2\n float focusDistance = 5\n"
        "float2 clippingRange = (0.5, 100)\n float horizontalApertureOffset = 2\n"
        "double shutter:close = 0.5 }\n"
        "def RenderSettings \"Set\" { rel camera = </Cam>\n uniform int2 resolution = (200, 100)\n"
        "uniform token renderingColorSpace = \"lin_rec709_scene\"\n"
        "uniform float4 dataWindowNDC = (0, 0, 0.5, 1)\n rel products = </Set/P>\n"
        "def RenderProduct \"P\" { token productName = \"out.exr\"\n"
        "rel orderedVars = [</Set/C>, </Set/L>, </Set/N>] }\n"
        "def RenderVar \"C\" { uniform string sourceName = \"color\" }\n"
        "def RenderVar \"L\" { uniform string sourceName = \"C<RD>[<L.>]\" } }\n" TRIANGLE("M", ""),
        NULL);
    CohortResolvedSettings settings;
    cohort_adapter_settings(f.adapter, &settings);
    assert_string_equal(settings.camera, "/Cam");
    assert_int_equal(settings.width, 200);
    assert_int_equal(settings.height, 100);
    assert_string_equal(settings.product_name, "out.exr");
    assert_true(stage_fixture_reports(&f, "/Set", "dataWindowNDC"));
    assert_true(stage_fixture_reports(&f, "/Set/L", "sourceName"));
    assert_false(stage_fixture_reports(&f, "/Set/C", "sourceName"));
    assert_true(stage_fixture_reports(&f, "/Set/P", "orderedVars"));
    CohortSettingValue space;
    assert_true(cohort_delegate_get(f.delegate, "cohort:renderingColorSpace", &space));
    assert_string_equal(space.string, "lin_rec709_scene");
    stage_fixture_render(&f, 200, 100);
    assert_true(stage_fixture_reports(&f, "/Cam", "shutter:close"));
    assert_true(fabs(fake.camera.window[0] - (2.0 - 10.0) / 40.0) < 1e-7);
    assert_true(fabs(fake.camera.window[1] - (2.0 + 10.0) / 40.0) < 1e-7);
    assert_true(fabs(fake.camera.window[3] - 5.0 / 40.0) < 1e-7);
    assert_true(fabs(fake.camera.lens_radius - 1.0) < 1e-7); // 0.1 * 40 / (2 * 2)
    assert_true(fake.camera.focus_distance == 5.0 && fake.camera.clip_near == 0.5);
    stage_fixture_render(&f, 100, 100); // square: expandAperture grows the height
    assert_true(fabs(fake.camera.window[3] - 10.0 / 40.0) < 1e-7);
}

static void test_asked_camera_and_size(void **state)
{
    (void)state;
    CohortAdapterOptions options = {.camera = "B", .height = 50};
    open_with(
        "def Camera \"A\" {}\n def Xform \"X\" { def Camera \"B\" { float horizontalAperture = 20\n"
        "float verticalAperture = 10 } }\n",
        &options);
    CohortResolvedSettings settings;
    cohort_adapter_settings(f.adapter, &settings);
    assert_string_equal(settings.camera, "/X/B");
    assert_int_equal(settings.width, 100);
    assert_string_equal(cohort_adapter_camera(f.adapter, 0), "/A");
    assert_null(cohort_adapter_camera(f.adapter, 2));
}

static void test_unknown_camera_is_an_error(void **state)
{
    (void)state;
    CohortAdapterOptions options = {.camera = "C"};
    CohortError err = {0};
    assert_false(stage_fixture_open(&f, "def Camera \"A\" {}\n", &options, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_non_null(strstr(err.message, "\"C\""));
}

// The recording renderer's box is (-1,-2,-3) to (1,2,3).
static void test_framing_env_and_headlight(void **state)
{
    (void)state;
    CohortAdapterOptions options = {.env = "sky", .headlight = true, .width = 100};
    open_with(TRIANGLE("M", ""), &options);
    CohortResolvedSettings settings;
    cohort_adapter_settings(f.adapter, &settings);
    assert_true(settings.camera_frames);
    assert_int_equal(settings.height, 73); // of the default aperture
    stage_fixture_render(&f, 100, 73);
    assert_true(fabs(fake.camera.transform[3][2] - (2.0 * 100.0 / 15.2908 + 3.0)) < 1e-5);
    assert_int_equal(fake.light_count, 2);
    assert_int_equal(fake.lights[0].type, COHORT_LIGHT_DOME);
    assert_int_equal(fake.lights[1].type, COHORT_LIGHT_DISTANT);
    assert_true(fake.lights[1].transform[3][2] == fake.camera.transform[3][2]);
    assert_int_equal(access(fake.lights[0].texture_file, R_OK), 0);
}

static bool has_entry(const char *prim_path, const char *name, const char *text)
{
    const CohortReportEntry *entries;
    size_t count = cohort_adapter_report(f.adapter, &entries);
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
    open_with("def \"R\" (references = @nowhere.usda@) {}\n"
              "def Material \"T\" { token outputs:surface.connect = </T/S.outputs:surface>\n"
              "def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\"\n"
              "color3f inputs:diffuseColor.connect = </T/I.outputs:rgb>\n token outputs:surface }\n"
              "def Shader \"I\" { uniform token info:id = \"UsdUVTexture\"\n"
              "asset inputs:file = @nowhere.png@\n float3 outputs:rgb } }\n"
              "def Xform \"X\" " BIND " { rel material:binding = </T>\n" TRIANGLE("M", "") "}\n",
              &options);
    assert_true(has_entry("/R", "composition", "nowhere.usda"));
    assert_true(has_entry("/T/I", "inputs:file", "nowhere.png"));
    assert_true(calls > 0);
}

static void test_z_up_framing(void **state)
{
    (void)state;
    open_with("(\n upAxis = \"Z\"\n)\n" TRIANGLE("M", ""), NULL);
    stage_fixture_render(&f, 10, 10);
    assert_true(fabs(fake.camera.transform[3][1] + (3.0 * 100.0 / 15.2908 + 2.0)) < 1e-5);
    assert_true(fake.camera.transform[1][2] == 1.0);  // up is +Z
    assert_true(fake.camera.transform[2][1] == -1.0); // it looks along +Y
}

static void test_missing_stage(void **state)
{
    (void)state;
    CohortError err = {0};
    memset(&f, 0, sizeof f);
    f.delegate = cohort_delegate_create(NULL);
    f.index = cohort_render_index_create(f.delegate, NULL);
    assert_null(cohort_adapter_open(f.delegate, "/nowhere/x.usda", NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_NOT_FOUND);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_binding_strength_and_purpose, teardown),
        cmocka_unit_test_teardown(test_collection_bindings, teardown),
        cmocka_unit_test_teardown(test_collections_of_collections, teardown),
        cmocka_unit_test_teardown(test_subsets, teardown),
        cmocka_unit_test_teardown(test_network, teardown),
        cmocka_unit_test_teardown(test_displacement_is_what_is_connected, teardown),
        cmocka_unit_test_teardown(test_ptex_and_foreign_surfaces, teardown),
        cmocka_unit_test_teardown(test_lights, teardown),
        cmocka_unit_test_teardown(test_lights_of_point_instancers_are_named, teardown),
        cmocka_unit_test_teardown(test_lights_in_instances, teardown),
        cmocka_unit_test_teardown(test_settings_and_camera, teardown),
        cmocka_unit_test_teardown(test_asked_camera_and_size, teardown),
        cmocka_unit_test_teardown(test_unknown_camera_is_an_error, teardown),
        cmocka_unit_test_teardown(test_framing_env_and_headlight, teardown),
        cmocka_unit_test_teardown(test_missing_files_are_in_the_report, teardown),
        cmocka_unit_test_teardown(test_z_up_framing, teardown),
        cmocka_unit_test_teardown(test_missing_stage, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
