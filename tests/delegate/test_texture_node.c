// Texture nodes of a material: files, color spaces, wrapping and coordinates.

#include "material_fixture.h"

static void test_uv_texture(void **state)
{
    (void)state;
    const CohortNodeInput inputs[] = {text_input("file", "a.png"), text_input("wrapS", "periodic"),
                                      text_input("wrapT", "sideways"),
                                      text_input("sourceColorSpace", "raw")};
    sync_with_node("UsdUVTexture", inputs, 4);
    assert_int_equal(fake.materials[0].diffuse_color.kind, COHORT_INPUT_TEXTURE);
    assert_int_equal(fake.materials[0].diffuse_color.channel, 1);
    assert_int_equal(fake.textures[0].wrap_s, COHORT_WRAP_REPEAT);
    assert_int_equal(fake.textures[0].wrap_t, COHORT_WRAP_CLAMP); // one point: no border
    assert_int_equal(fake.textures[0].color_space, COHORT_COLOR_RAW);
    assert_non_null(report_of("wrapT"));
    assert_true(fake.lookups[0][0].scale[2] == 1.0f);
    assert_null(fake.lookups[0][0].st_primvar);
    // The same texture again is the same texture.
    sync_with_node("UsdUVTexture", inputs, 4);
    assert_int_equal(fake.texture_count, 1);
}

// A constant st outside the image still meets the border.
static void test_point_outside_keeps_its_wrap(void **state)
{
    (void)state;
    CohortNodeInput inputs[] = {text_input("file", "a.png"),
                                {.name = "st", .source_node = -1, .components = 2},
                                text_input("wrapS", "black")};
    inputs[1].value[0] = 1.5f;
    inputs[1].value[1] = 0.5f;
    sync_with_node("UsdUVTexture", inputs, 3);
    assert_int_equal(fake.textures[0].wrap_s, COHORT_WRAP_BLACK);
    assert_int_equal(fake.textures[0].wrap_t, COHORT_WRAP_CLAMP);
    assert_true(fake.lookups[0][0].st_fallback[0] == 1.5f);
}

static void test_missing_file_gives_the_fallback(void **state)
{
    (void)state;
    const CohortNodeInput inputs[] = {{.name = "fallback",
                                       .source_node = -1,
                                       .components = 4,
                                       .value = {0.25f, 0.5f, 0.75f, 1.0f}}};
    sync_with_node("UsdUVTexture", inputs, 1);
    assert_int_equal(fake.materials[0].diffuse_color.kind, COHORT_INPUT_CONSTANT);
    assert_true(fake.materials[0].diffuse_color.value[0] == 0.5f); // output g
    assert_non_null(report_of("inputs:file"));
}

// What is left of a lost normal map: 0 * 2 - 1, a normal into the surface, unless its fallback is
// one.
static void test_lost_relief_is_flat(void **state)
{
    (void)state;
    CohortNodeInput inputs[] = {text_input("file", "/nowhere/bumps.png"),
                                {.name = "scale", .source_node = -1, .components = 4},
                                {.name = "bias", .source_node = -1, .components = 4},
                                {.name = "fallback", .source_node = -1, .components = 4}};
    for (int i = 0; i < 3; i++) {
        inputs[1].value[i] = 2.0f;
        inputs[2].value[i] = -1.0f;
    }
    const CohortNodeInput surface[] = {connection("normal", 1, "rgb")};
    const CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 1},
        {.path = "/m/t", .id = "UsdUVTexture", .inputs = inputs, .input_count = 4}};
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 2};
    host.network = &network;
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    sync_index();
    assert_int_equal(fake.materials[0].normal.kind, COHORT_INPUT_CONSTANT);
    assert_non_null(report_of("inputs:file"));
    inputs[3].value[2] = 1.0f;
    cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_RESOURCE);
    sync_index();
    assert_int_equal(fake.materials[0].normal.kind, COHORT_INPUT_TEXTURE);
}

static void test_ptex_nodes(void **state)
{
    (void)state;
    const CohortNodeInput inputs[] = {text_input("filename", "a.ptx"),
                                      number_input("linearize", 1.0f),
                                      number_input("faceIndexOffset", 3.0f)};
    sync_with_node("PxrPtexture", inputs, 3);
    assert_true(fake.textures[0].is_ptex);
    assert_int_equal(fake.textures[0].color_space, COHORT_COLOR_SRGB);
    assert_true(fake.textures[0].fallback[0] == 1.0f && fake.textures[0].fallback[1] == 0.0f);
    assert_non_null(report_of("faceIndexOffset"));
    const CohortNodeInput uv[] = {text_input("file", "b.ptx")};
    sync_with_node("UsdUVTexture", uv, 1);
    assert_true(fake.textures[1].is_ptex);
}

static void test_unused_textures_cost_nothing(void **state)
{
    (void)state;
    static const char *const names[] = {"diffuseColor", "emissiveColor", "metallic"};
    static CohortNodeInput surface[3], file[20];
    CohortMaterialNode nodes[21] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 3}};
    static const char letters[] = "abcdefghijklmnopqrst";
    static char paths[20][2];
    for (int i = 0; i < 20; i++) {
        paths[i][0] = letters[i];
        file[i] = text_input("file", paths[i]);
        nodes[i + 1] = (CohortMaterialNode){
            .path = "/m/t", .id = "UsdUVTexture", .inputs = &file[i], .input_count = 1};
    }
    // Twenty nodes, three of them used: the rest must cost nothing.
    for (int i = 0; i < 3; i++)
        surface[i] = connection(names[i], 18 - i, "r");
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 21};
    host.network = &network;
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    sync_index();
    assert_int_equal(fake.texture_count, 3);
    assert_int_equal(fake.materials[0].lookup_count, 3);
}

// The file's colorSpace metadata beats the node's word; of both only what is known counts.
static void test_color_spaces(void **state)
{
    (void)state;
    static const struct {
        const char *metadata, *authored;
        CohortColorSpace want;
        bool is_named;
    } cases[] = {{NULL, "", COHORT_COLOR_AUTO, false},
                 {NULL, "auto", COHORT_COLOR_AUTO, false},
                 {NULL, "sRGB", COHORT_COLOR_SRGB, false},
                 {NULL, "raw", COHORT_COLOR_RAW, false},
                 {"auto", "raw", COHORT_COLOR_RAW, false},
                 {"sRGB", "raw", COHORT_COLOR_SRGB, false},
                 {"data", "sRGB", COHORT_COLOR_RAW, false},
                 {"lin_ap1_scene", "sRGB", COHORT_COLOR_NAMED, false},
                 {NULL, "lin_ap1_scene", COHORT_COLOR_AUTO, true}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char file[] = "0.png";
        file[0] = (char)('0' + i); // another texture each
        CohortNodeInput inputs[] = {text_input("file", file),
                                    text_input("sourceColorSpace", cases[i].authored)};
        inputs[0].color_space = cases[i].metadata;
        sync_with_node("UsdUVTexture", inputs, 2);
        assert_int_equal(fake.texture_count, i + 1);
        assert_int_equal(fake.textures[i].color_space, cases[i].want);
        assert_int_equal(report_of("inputs:sourceColorSpace") != NULL, cases[i].is_named);
    }
}

// A transform of 2d coordinates, and coordinates that nothing here can make.
static void test_coordinates(void **state)
{
    (void)state;
    const CohortNodeInput surface[] = {connection("diffuseColor", 1, "rgb"),
                                       connection("emissiveColor", 4, "rgb")};
    const CohortNodeInput texture[] = {text_input("file", "a.png"), connection("st", 2, "result")};
    const CohortNodeInput turn[] = {connection("in", 3, "result"), number_input("rotation", 90.0f),
                                    connection("scale", 3, "result")};
    const CohortNodeInput reader[] = {text_input("varname", "uv2")};
    const CohortNodeInput odd[] = {text_input("file", "b.png"), connection("st", 5, "out")};
    const CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 2},
        {.path = "/m/t", .id = "UsdUVTexture", .inputs = texture, .input_count = 2},
        {.path = "/m/x", .id = "UsdTransform2d", .inputs = turn, .input_count = 3},
        {.path = "/m/r", .id = "UsdPrimvarReader_float2", .inputs = reader, .input_count = 1},
        {.path = "/m/o", .id = "UsdUVTexture", .inputs = odd, .input_count = 2},
        {.path = "/m/n", .id = "ND_swirl"}};
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 6, .displacement = -1};
    host.network = &network;
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    sync_index();
    const CohortLookupDesc *l = &fake.lookups[0][0];
    assert_true(l->st_rotation_degrees == 90.0f && l->st_scale[0] == 1.0f);
    assert_non_null(report_of("scale")); // it cannot vary
    assert_non_null(report_of("ND_swirl"));
    assert_null(fake.lookups[0][1].st_primvar);
}

// A texture scaled to nothing is its bias; the renderer takes zeros for ones.
static void test_a_scale_of_nothing(void **state)
{
    (void)state;
    const CohortNodeInput inputs[] = {
        text_input("file", "a.png"),
        {.name = "scale", .source_node = -1, .components = 4},
        {.name = "bias", .source_node = -1, .components = 4, .value = {0.5f, 0.5f, 0.5f, 1.0f}}};
    sync_with_node("UsdUVTexture", inputs, 3);
    const CohortLookupDesc *l = &fake.lookups[0][0];
    assert_true(l->scale[0] > 0.0f && l->scale[0] < 1e-20f && l->bias[0] == 0.5f);
}

// Ten nodes of one file: a lookup each, of one texture.
static void test_equal_textures_are_one(void **state)
{
    (void)state;
    static const char *const names[] = {
        "diffuseColor", "emissiveColor", "specularColor", "metallic",           "roughness",
        "clearcoat",    "opacity",       "ior",           "clearcoatRoughness", "normal"};
    const CohortNodeInput file = text_input("file", "/bin/sh");
    CohortNodeInput surface[10];
    CohortMaterialNode nodes[11] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 10}};
    for (int i = 0; i < 10; i++) {
        surface[i] = connection(names[i], i + 1, "r");
        nodes[i + 1] = (CohortMaterialNode){
            .path = "/m/t", .id = "UsdUVTexture", .inputs = &file, .input_count = 1};
    }
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 11, .displacement = -1};
    host.network = &network;
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    sync_index();
    assert_int_equal(fake.materials[0].lookup_count, 10);
    assert_int_equal(fake.texture_count, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_uv_texture, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_point_outside_keeps_its_wrap, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_missing_file_gives_the_fallback, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_lost_relief_is_flat, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_ptex_nodes, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_unused_textures_cost_nothing, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_color_spaces, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_coordinates, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_a_scale_of_nothing, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_equal_textures_are_one, setup_index, teardown_index),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
