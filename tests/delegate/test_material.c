// Material networks given by a host: what becomes of each node, and what an edit touches.

#include "index_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static const CohortReportEntry *report_of(const char *name)
{
    const CohortReportEntry *entries;
    size_t count = cohort_delegate_report(delegate, &entries);
    for (size_t i = 0; i < count; i++)
        if (strcmp(entries[i].name, name) == 0)
            return &entries[i];
    return NULL;
}

static CohortNodeInput text_input(const char *name, const char *text)
{
    return (CohortNodeInput){.name = name, .source_node = -1, .string = text, .resolved = text};
}

static CohortNodeInput number_input(const char *name, float value)
{
    return (CohortNodeInput){.name = name, .source_node = -1, .components = 1, .value = {value}};
}

static CohortNodeInput connection(const char *name, int32_t node, const char *output)
{
    return (CohortNodeInput){.name = name, .source_node = node, .source_output = output};
}

// A surface whose diffuseColor is connected to one node.
static void sync_with_node(const char *id, const CohortNodeInput *inputs, size_t count)
{
    const CohortNodeInput surface[] = {connection("diffuseColor", 1, "g")};
    const CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 1},
        {.path = "/m/t", .id = id, .inputs = inputs, .input_count = count}};
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 2};
    host.network = &network;
    if (cohort_render_index_prim_count(render_index, COHORT_PRIM_MATERIAL) == 0)
        insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_RESOURCE);
    sync_index();
    host.network = NULL;
}

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

static void test_numbers_that_are_none(void **state)
{
    (void)state;
    const CohortNodeInput inputs[] = {number_input("roughness", NAN), number_input("ior", INFINITY),
                                      number_input("opacityThreshold", -INFINITY),
                                      number_input("metallic", 0.25f),
                                      {.name = "diffuseColor",
                                       .source_node = -1,
                                       .components = 3,
                                       .value = {0.5f, NAN, 0.5f}}};
    const CohortMaterialNode node = {
        .path = "/m/s", .id = "UsdPreviewSurface", .inputs = inputs, .input_count = 5};
    const CohortMaterialNetwork network = {.nodes = &node, .node_count = 1, .displacement = -1};
    host.network = &network;
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    sync_index();
    host.network = NULL;
    const CohortMaterialDesc plain = cohort_material_default(), *got = &fake.materials[0];
    assert_true(got->roughness.value[0] == plain.roughness.value[0]);
    assert_true(got->ior.value[0] == plain.ior.value[0]);
    assert_true(got->opacity_threshold == 0.0f && got->metallic.value[0] == 0.25f);
    assert_memory_equal(got->diffuse_color.value, plain.diffuse_color.value, 3 * sizeof(float));
    const char *const named[] = {"roughness", "ior", "opacityThreshold", "diffuseColor"};
    for (size_t i = 0; i < sizeof named / sizeof named[0]; i++) {
        char name[32];
        snprintf(name, sizeof name, "inputs:%s", named[i]);
        assert_non_null(report_of(name));
        assert_string_equal(report_of(name)->prim_path, "/m/s");
        assert_int_equal(report_of(name)->count, 1);
    }
    assert_string_equal(report_of("inputs:diffuseColor")->value, "0.5, nan, 0.5");
    assert_null(report_of("inputs:metallic"));
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
    assert_true(fake.materials[0].diffuse_color.value[2] == 0.75f);
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

static void test_unknown_node_is_named(void **state)
{
    (void)state;
    sync_with_node("ND_fractal3d_float", NULL, 0);
    assert_int_equal(fake.materials[0].diffuse_color.kind, COHORT_INPUT_CONSTANT);
    assert_true(fake.materials[0].diffuse_color.value[0] == 0.18f);
    assert_non_null(report_of("ND_fractal3d_float"));
}

static void test_connections_out_of_range(void **state)
{
    (void)state;
    const CohortNodeInput surface[] = {connection("diffuseColor", 99, "rgb"),
                                       number_input("roughness", 0.25f)};
    const CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 2}};
    CohortMaterialNetwork network = {.nodes = nodes, .node_count = 1};
    host.network = &network;
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    sync_index();
    assert_true(fake.materials[0].roughness.value[0] == 0.25f);
    network.surface = 7;
    cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_RESOURCE);
    sync_index();
    assert_non_null(report_of("outputs:surface"));
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

// A material edit is no geometry edit, unless the material turns into none.
static void test_edits_of_a_bound_material(void **state)
{
    (void)state;
    CohortNodeInput surface[] = {number_input("roughness", 0.25f)};
    CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 1}};
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 1};
    host.network = &network;
    host.material = "/m";
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    sync_index();
    const FakeObject *mesh = &fake.objects[fake.objects[0].instances[0].object];
    assert_int_equal(mesh->material, 0);
    surface[0].value[0] = 0.5f;
    cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_PARAMS);
    sync_index();
    assert_true(fake.materials[0].roughness.value[0] == 0.5f);
    assert_int_equal(fake.set_mesh_calls, 1);
    nodes[0].id = "PxrDisneyBsdf";
    cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_RESOURCE);
    sync_index();
    assert_int_equal(mesh->material, COHORT_INVALID_ID);
    assert_non_null(report_of("info:id"));
    nodes[0].id = "UsdPreviewSurface";
    cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_RESOURCE);
    sync_index();
    assert_int_equal(mesh->material, 0);
    assert_true(cohort_delegate_set_bool(delegate, "enableSceneMaterials", false, NULL));
    sync_index();
    assert_int_equal(mesh->material, COHORT_INVALID_ID);
}

// Meshes are displaced when they are set: another displacement sets those that have it anew.
static void test_displacement_sets_meshes_anew(void **state)
{
    (void)state;
    CohortNodeInput surface[] = {number_input("displacement", 0.0f),
                                 number_input("roughness", 0.5f)};
    CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 2}};
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 1};
    host.network = &network;
    host.material = "/m";
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    insert_prim(COHORT_PRIM_MATERIAL, "/other", NULL, 0);
    sync_index();
    assert_int_equal(fake.set_mesh_calls, 1);
    const struct {
        float displacement, roughness;
        uint64_t sets;
    } edits[] = {{0.25f, 0.5f, 2}, {0.25f, 0.3f, 2}, {0.5f, 0.3f, 3}, {0.0f, 0.3f, 4}};
    for (size_t i = 0; i < sizeof edits / sizeof edits[0]; i++) {
        surface[0].value[0] = edits[i].displacement;
        surface[1].value[0] = edits[i].roughness;
        cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_PARAMS);
        sync_index();
        assert_int_equal(fake.set_mesh_calls, edits[i].sets);
        assert_true(fake.materials[0].displacement.value[0] == edits[i].displacement);
    }
    // Bound to another material that displaces otherwise.
    surface[0].value[0] = 1.0f;
    cohort_render_index_mark_dirty(render_index, "/other", COHORT_DIRTY_PARAMS);
    sync_index();
    assert_int_equal(fake.set_mesh_calls, 4);
    host.material = "/other";
    cohort_render_index_mark_dirty(render_index, "/mesh", COHORT_DIRTY_MATERIAL_ID);
    sync_index();
    assert_int_equal(fake.set_mesh_calls, 5);
}

// Heights that cannot be read are none; those that can are the last lookup, behind the colors'.
static void test_lost_heights_are_none(void **state)
{
    (void)state;
    const CohortNodeInput surface[] = {connection("displacement", 1, "r"),
                                       connection("diffuseColor", 2, "rgb")};
    CohortNodeInput heights[] = {text_input("file", "/nowhere/heights.ptx")};
    const CohortNodeInput colors[] = {text_input("file", "/bin/sh")};
    const CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 2},
        {.path = "/m/h", .id = "UsdUVTexture", .inputs = heights, .input_count = 1},
        {.path = "/m/c", .id = "UsdUVTexture", .inputs = colors, .input_count = 1}};
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 3};
    host.network = &network;
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    sync_index();
    assert_int_equal(fake.materials[0].displacement.kind, COHORT_INPUT_CONSTANT);
    assert_string_equal(report_of("inputs:file")->action, "no such file can be read: no relief");
    heights[0] = text_input("file", "/bin/ls");
    cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_RESOURCE);
    sync_index();
    assert_int_equal(fake.materials[0].displacement.kind, COHORT_INPUT_TEXTURE);
    assert_int_equal(fake.materials[0].displacement.lookup, 1);
    assert_int_equal(fake.materials[0].diffuse_color.lookup, 0);
}

static void test_material_without_network(void **state)
{
    (void)state;
    host.material = "/m";
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    sync_index();
    assert_int_equal(fake.objects[fake.objects[0].instances[0].object].material, COHORT_INVALID_ID);
    assert_non_null(report_of("Material"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_uv_texture, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_numbers_that_are_none, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_point_outside_keeps_its_wrap, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_missing_file_gives_the_fallback, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_lost_relief_is_flat, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_ptex_nodes, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_unknown_node_is_named, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_connections_out_of_range, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_unused_textures_cost_nothing, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_edits_of_a_bound_material, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_displacement_sets_meshes_anew, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_lost_heights_are_none, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_material_without_network, setup_index, teardown_index),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
