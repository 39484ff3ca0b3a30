// Material networks from a stage: connections through node graphs and interfaces, terminals, and
// what leads nowhere.

#include "stage_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static const char network[] =
    "def Material 'M' {"
    "  float inputs:rough = 0.7;"
    "  asset inputs:map = @tex.png@ (colorSpace = 'lin_ap1_scene');"
    "  token outputs:surface.connect = </M/G.outputs:out>;"
    "  token outputs:displacement.connect = </M/G/S.outputs:displacement>;"
    "  def NodeGraph 'G' {"
    "    token outputs:out.connect = </M/G/S.outputs:surface>;"
    "    float inputs:r.connect = </M.inputs:rough>;"
    "    def Shader 'S' { uniform token info:id = 'UsdPreviewSurface';"
    "      color3f inputs:diffuseColor.connect = </M/G/T.outputs:rgb>;"
    "      float inputs:roughness.connect = </M/G.inputs:r>;"
    "      float inputs:opacity.connect = </M/G/T.outputs:a>;"
    "      color3f inputs:emissiveColor.connect = </M/G/P.outputs:result>;"
    "      float inputs:metallic.connect = </M/G/X.outputs:out>;"
    "      float inputs:displacement = 1; int inputs:useSpecularWorkflow = 1;"
    "      token outputs:surface }"
    "    def Shader 'T' { uniform token info:id = 'UsdUVTexture';"
    "      asset inputs:file.connect = </M.inputs:map>;"
    "      float2 inputs:st.connect = </M/G/X2.outputs:result>;"
    "      token inputs:wrapS = 'mirror'; token inputs:sourceColorSpace = 'sRGB';"
    "      float4 inputs:scale = (2,2,2,1); float4 inputs:bias = (-1,-1,-1,0);"
    "      float4 inputs:fallback = (1,0,1,1); float3 outputs:rgb; float outputs:a }"
    "    def Shader 'X2' { uniform token info:id = 'UsdTransform2d';"
    "      float2 inputs:in.connect = </M/G/U.outputs:result>; float inputs:rotation = 30;"
    "      float2 inputs:scale = (2, 3); float2 inputs:translation = (0.5, 0);"
    "      float2 outputs:result }"
    "    def Shader 'U' { uniform token info:id = 'UsdPrimvarReader_float2';"
    "      string inputs:varname = 'map1'; float2 outputs:result }"
    "    def Shader 'P' { uniform token info:id = 'UsdPrimvarReader_float3';"
    "      string inputs:varname = 'glow'; float3 inputs:fallback = (0,1,0);"
    "      float3 outputs:result }"
    "    def Shader 'X' { uniform token info:id = 'ND_noise3d_float'; float outputs:out }"
    "  }"
    "}"
    "def Mesh 'A' { $triangle rel material:binding = </M>;"
    "  float2[] primvars:map1 = [(0,0)]; float3[] primvars:glow = [(0,0,1)];"
    "  float2[] primvars:other = [(0,0)] }";

static void test_inputs_through_a_node_graph(void **state)
{
    (void)state;
    open_stage(network);
    const CohortMaterialDesc *m = &fake.materials[0];
    assert_int_equal(m->lookup_count, 1); // one node, two uses
    assert_int_equal(m->diffuse_color.kind, COHORT_INPUT_TEXTURE);
    assert_int_equal(m->opacity.kind, COHORT_INPUT_TEXTURE);
    assert_int_equal(m->opacity.channel, 3);
    assert_true(m->roughness.kind == COHORT_INPUT_CONSTANT && m->roughness.value[0] == 0.7f);
    assert_int_equal(m->emissive_color.kind, COHORT_INPUT_PRIMVAR);
    assert_true(m->emissive_color.value[1] == 1.0f);
    assert_true(m->use_specular_workflow);
    assert_int_equal(fake_mesh("/A")->primvar_count, 2); // what the material reads, no other
    assert_true(is_reported("/M/G/X", "ND_noise3d_float"));
    assert_true(m->displacement.kind == COHORT_INPUT_CONSTANT && m->displacement.value[0] == 1.0f);
    assert_false(is_reported("/M/G/S", "inputs:displacement"));
}

static void test_textures_through_a_node_graph(void **state)
{
    (void)state;
    open_stage(network);
    const CohortLookupDesc *l = &fake.lookups[0][0];
    assert_true(l->st_scale[1] == 3.0f && l->st_rotation_degrees == 30.0f);
    assert_true(l->st_translation[0] == 0.5f && l->scale[0] == 2.0f && l->bias[2] == -1.0f);
    assert_int_equal(fake.texture_count, 1);
    assert_int_equal(fake.textures[0].color_space, COHORT_COLOR_NAMED); // metadata beats the input
    assert_int_equal(fake.textures[0].wrap_s, COHORT_WRAP_MIRROR);
    assert_int_equal(fake.textures[0].wrap_t, COHORT_WRAP_USE_METADATA);
    assert_true(fake.textures[0].fallback[0] == 1.0f);
    assert_non_null(strstr(fake.texture_paths[0], "tex.png"));
}

// A displacement input counts where the material's displacement comes from, as with Hydra's
// terminals.
static void test_displacement_is_what_is_connected(void **state)
{
    (void)state;
    open_stage("def Material 'A' { token outputs:surface.connect = </A/S.outputs:surface>;"
               "  def Shader 'S' { uniform token info:id = 'UsdPreviewSurface';"
               "    float inputs:displacement = 1; token outputs:surface } }"
               "def Material 'B' { token outputs:surface.connect = </A/S.outputs:surface>;"
               "  token outputs:displacement.connect = </B/D.outputs:displacement>;"
               "  def Shader 'D' { uniform token info:id = 'UsdPreviewSurface';"
               "    float inputs:displacement = 2; token outputs:displacement } }"
               "def Material 'C' { token outputs:surface.connect = </A/S.outputs:surface>;"
               "  token outputs:displacement.connect = </C/D.outputs:out>;"
               "  def Shader 'D' { uniform token info:id = 'PxrDisplace';"
               "    float inputs:displacement = 3 } }"
               "def Material 'D' { token outputs:surface.connect = </A/S.outputs:surface>;"
               "  token outputs:volume.connect = </C/D.outputs:out> }"
               "def Mesh 'MA' { $triangle rel material:binding = </A> }"
               "def Mesh 'MB' { $triangle rel material:binding = </B> }"
               "def Mesh 'MC' { $triangle rel material:binding = </C> }"
               "def Mesh 'MD' { $triangle rel material:binding = </D> }");
    for (int k = 0; k < 4; k++)
        assert_true(fake.materials[k].displacement.value[0] == (k == 1 ? 2.0f : 0.0f));
    assert_true(is_reported("/C/D", "info:id"));
    assert_true(is_reported("/D", "outputs:volume"));
    assert_false(is_reported("/A/S", "inputs:displacement"));
}

// The surface of another render context is refused by its shader's name, unless it is universal.
static void test_other_surfaces(void **state)
{
    (void)state;
    open_stage("def Material 'D' { token outputs:ri:surface.connect = </D/S.outputs:surface>;"
               "  def Shader 'S' { uniform token info:id = 'PxrDisneyBsdf' } }"
               "def Material 'Both' { token outputs:ri:surface.connect = </D/S.outputs:surface>;"
               "  token outputs:surface.connect = </Both/S.outputs:surface>;"
               "  def Shader 'S' { uniform token info:id = 'UsdPreviewSurface' } }"
               "def Material 'E' {}"
               "def Mesh 'A' { $triangle rel material:binding = </D> }"
               "def Mesh 'B' { $triangle rel material:binding = </Both> }"
               "def Mesh 'C' { $triangle rel material:binding = </E> }");
    assert_int_equal(fake_mesh("/A")->material, COHORT_INVALID_ID);
    assert_true(is_reported("/D/S", "info:id"));
    assert_int_not_equal(fake_mesh("/B")->material, COHORT_INVALID_ID);
    assert_true(is_reported("/E", "outputs:surface"));
}

static void test_ptex(void **state)
{
    (void)state;
    open_stage("def Material 'P' { token outputs:surface.connect = </P/S.outputs:surface>;"
               "  def Shader 'S' { uniform token info:id = 'UsdPreviewSurface';"
               "    color3f inputs:diffuseColor.connect = </P/T.outputs:rgb> }"
               "  def Shader 'T' { uniform token info:id = 'HwPtexTexture_1';"
               "    asset inputs:file = @a.ptx@ } }"
               "def Mesh 'A' { $triangle rel material:binding = </P> }");
    assert_true(fake.textures[0].is_ptex);
}

// Connections in a circle, to nothing, and shaders that read each other: all end, with a word.
static void test_connections_that_lead_nowhere(void **state)
{
    (void)state;
    open_stage("def Material 'Loop' { token outputs:surface.connect = </Loop.outputs:surface> }"
               "def Material 'M' { token outputs:surface.connect = </M/S.outputs:surface>;"
               "  float inputs:a.connect = </M.inputs:b>; float inputs:b.connect = </M.inputs:a>;"
               "  def Shader 'S' { uniform token info:id = 'UsdPreviewSurface';"
               "    float inputs:roughness = 0.25;"
               "    float inputs:roughness.connect = </Nowhere.outputs:x>;"
               "    float inputs:metallic.connect = </M.inputs:a>;"
               "    color3f inputs:diffuseColor.connect = </M/X.outputs:result> }"
               "  def Shader 'X' { uniform token info:id = 'UsdTransform2d';"
               "    float2 inputs:in.connect = </M/Y.outputs:result> }"
               "  def Shader 'Y' { uniform token info:id = 'UsdTransform2d';"
               "    float2 inputs:in.connect = </M/X.outputs:result> } }"
               "def Mesh 'L' { $triangle rel material:binding = </Loop> }"
               "def Mesh 'A' { $triangle rel material:binding = </M> }");
    assert_true(is_reported("/Loop", "outputs:surface"));
    assert_int_equal(fake_mesh("/L")->material, COHORT_INVALID_ID);
    const CohortMaterialDesc *m = &fake.materials[fake_mesh("/A")->material];
    assert_true(m->roughness.value[0] == 0.25f); // its own value
    assert_true(is_reported("/M/S", "inputs:roughness"));
    assert_true(m->metallic.kind == COHORT_INPUT_CONSTANT);
}

// More than 256 nodes: the rest is left out, with a word.
static void test_many_nodes(void **state)
{
    (void)state;
    static char body[64 * 1024];
    size_t used = (size_t)snprintf(body, sizeof body,
                                   "def Mesh 'A' { $triangle rel material:binding = </M> }"
                                   "def Material 'M' {"
                                   "  token outputs:surface.connect = </M/N0.outputs:surface>;");
    for (int i = 0; i < 300; i++)
        used += (size_t)snprintf(body + used, sizeof body - used,
                                 "def Shader 'N%d' { uniform token info:id = '%s';"
                                 "  float2 inputs:%s.connect = </M/N%d.outputs:result> }",
                                 i, i ? "UsdTransform2d" : "UsdPreviewSurface",
                                 i ? "in" : "diffuseColor", i + 1);
    snprintf(body + used, sizeof body - used, "}");
    open_stage(body);
    assert_true(is_reported("/M/N256", "Shader"));
    assert_int_not_equal(fake_mesh("/A")->material, COHORT_INVALID_ID);
}

// ---- Textures that are not what they should be -------------------------------------------------

static void open_textured(const char *surface, const char *texture)
{
    char body[2048];
    snprintf(body, sizeof body,
             "def Material 'M' { token outputs:surface.connect = </M/S.outputs:surface>;"
             "  def Shader 'S' { uniform token info:id = 'UsdPreviewSurface'; %s;"
             "    token outputs:surface }"
             "  def Shader 'T' { uniform token info:id = 'UsdUVTexture';"
             "    %s; float3 outputs:rgb; float outputs:a }"
             "  def Shader 'X' { uniform token info:id = 'UsdTransform2d';"
             "    float2 inputs:scale = (0,0); float2 outputs:result } }"
             "def Mesh 'A' { $triangle rel material:binding = </M> }",
             surface, texture);
    open_stage(body);
}

#define FLAT "float4 inputs:fallback = (0,0,1,1); " // else the map's loss is told instead

// In formats without negative numbers normals must be scaled and biased, and they are no colors.
static void test_normals_read_as_colors(void **state)
{
    (void)state;
    static const struct {
        const char *texture;
        bool bias, space;
    } cases[] = {
        {FLAT "asset inputs:file = @n.png@", true, true},
        {FLAT "asset inputs:file = @n.PNG@; float4 inputs:bias = (0,0,0,0)", false, true},
        {FLAT "asset inputs:file = @n.jpg@; token inputs:sourceColorSpace = 'raw'", true, false},
        {FLAT "asset inputs:file = @n.tga@ (colorSpace = 'raw')", true, false},
        {FLAT "asset inputs:file = @n.exr@", false, false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        open_textured("normal3f inputs:normal.connect = </M/T.outputs:rgb>", cases[i].texture);
        assert_int_equal(is_reported("/M/T", "inputs:bias"), cases[i].bias);
        assert_int_equal(is_reported("/M/T", "inputs:sourceColorSpace"), cases[i].space);
        close_stage(NULL);
    }
}

static void test_constant_normals(void **state)
{
    (void)state;
    open_textured("normal3f inputs:normal = (0.5,0,0.8)", "");
    assert_true(is_reported("/M/S", "inputs:normal"));
    close_stage(NULL);
    open_textured("normal3f inputs:normal = (0,0,1)", "");
    assert_false(is_reported("/M/S", "inputs:normal"));
    close_stage(NULL);
}

static void test_scales(void **state)
{
    (void)state;
    open_textured("color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>",
                  "asset inputs:file = @c.png@; float4 inputs:scale.connect = </M/T.outputs:rgb>;"
                  "float2 inputs:st.connect = </M/X.outputs:result>");
    assert_true(is_reported("/M/T", "scale")); // cannot vary
    // To the renderer all zero is one, but coordinates scaled to nothing are one point.
    for (int i = 0; i < 2; i++) {
        float scale = fake.lookups[0][0].st_scale[i];
        assert_true(scale != 0.0f && scale < 1e-20f);
    }
}

// An empty name is no file: nothing is opened, each output gives its part of the fallback.
static void test_files_without_a_name(void **state)
{
    (void)state;
    open_textured("color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>;"
                  "float inputs:opacity.connect = </M/T.outputs:a>",
                  "asset inputs:file = @@; float4 inputs:fallback = (0.25,0.5,0.75,0.125)");
    assert_true(is_reported("/M/T", "inputs:file"));
    assert_int_equal(fake.texture_count, 0);
    const CohortMaterialDesc *m = &fake.materials[0];
    assert_true(m->diffuse_color.value[0] == 0.25f && m->diffuse_color.value[2] == 0.75f);
    assert_true(m->opacity.value[0] == 0.125f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_inputs_through_a_node_graph, close_stage),
        cmocka_unit_test_teardown(test_textures_through_a_node_graph, close_stage),
        cmocka_unit_test_teardown(test_displacement_is_what_is_connected, close_stage),
        cmocka_unit_test_teardown(test_other_surfaces, close_stage),
        cmocka_unit_test_teardown(test_ptex, close_stage),
        cmocka_unit_test_teardown(test_connections_that_lead_nowhere, close_stage),
        cmocka_unit_test_teardown(test_many_nodes, close_stage),
        cmocka_unit_test(test_normals_read_as_colors),
        cmocka_unit_test(test_constant_normals),
        cmocka_unit_test_teardown(test_scales, close_stage),
        cmocka_unit_test_teardown(test_files_without_a_name, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
