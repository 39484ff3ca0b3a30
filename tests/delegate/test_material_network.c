// From a material network to a surface: constants, primvars, textures, and what is none.

#include "material_fixture.h"
#include "prims/material_network.h"

#include <math.h>
#include <stdio.h>

static void test_numbers_that_are_none(void **state)
{
    (void)state;
    const CohortNodeInput inputs[] = {
        number_input("roughness", NAN),
        number_input("ior", INFINITY),
        number_input("opacityThreshold", -INFINITY),
        number_input("metallic", 0.25f),
        {.name = "diffuseColor", .source_node = -1, .components = 3, .value = {0.5f, NAN, 0.5f}}};
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

// A reader of a primvar: by name, with its fallback; without a name the fallback alone.
static void test_primvar_readers(void **state)
{
    (void)state;
    const CohortNodeInput fallback = {
        .name = "fallback", .source_node = -1, .components = 3, .value = {0.25f, 0.5f, 0.75f}};
    const CohortNodeInput named[] = {text_input("varname", "tint"), fallback};
    sync_with_node("UsdPrimvarReader_float3", named, 2);
    const CohortInput *diffuse = &fake.materials[0].diffuse_color;
    assert_int_equal(diffuse->kind, COHORT_INPUT_PRIMVAR);
    assert_true(diffuse->value[2] == 0.75f);
    sync_with_node("UsdPrimvarReader_float3", &fallback, 1);
    assert_int_equal(diffuse->kind, COHORT_INPUT_CONSTANT);
    assert_true(diffuse->value[1] == 0.5f);
    assert_non_null(report_of("inputs:varname"));
}

// What decides the kind of a surface cannot vary over it.
static void test_switches_cannot_vary(void **state)
{
    (void)state;
    const CohortNodeInput surface[] = {connection("useSpecularWorkflow", 1, "r"),
                                       number_input("opacityThreshold", 0.5f),
                                       text_input("opacityMode", "presence")};
    const CohortNodeInput file = text_input("file", "a.png");
    const CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 3},
        {.path = "/m/t", .id = "UsdUVTexture", .inputs = &file, .input_count = 1}};
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 2, .displacement = -1};
    host.network = &network;
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    sync_index();
    assert_false(fake.materials[0].use_specular_workflow);
    assert_non_null(report_of("useSpecularWorkflow"));
    assert_true(fake.materials[0].opacity_threshold == 0.5f);
    assert_true(fake.materials[0].opacity_presence);
    assert_int_equal(fake.texture_count, 0);
}

// Materials that displace alike have equal hashes; nothing has none.
static void test_displacement_hashes(void **state)
{
    (void)state;
    CohortLookupDesc lookup = {.texture = 3, .scale = {1, 1, 1, 1}};
    CohortMaterialDesc desc = {.lookups = &lookup, .lookup_count = 1};
    assert_int_equal(co_network_displacement(&desc), 0);
    uint64_t hashes[7];
    for (int i = 0; i < 7; i++) {
        desc.displacement =
            (CohortInput){.kind = i < 2 ? COHORT_INPUT_CONSTANT : COHORT_INPUT_TEXTURE,
                          .value = {i < 2 ? 0.5f * (float)(i + 1) : 0.0f}};
        desc.displacement.channel = i == 3;
        lookup.scale[0] = i == 4 ? 2.0f : 1.0f;
        lookup.bias[0] = i == 5 ? 0.5f : 0.0f;
        lookup.st_primvar = i == 6 ? "uv2" : NULL;
        hashes[i] = co_network_displacement(&desc);
        assert_int_not_equal(hashes[i], 0);
        assert_int_equal(co_network_displacement(&desc), hashes[i]);
        for (int k = 0; k < i; k++)
            assert_true(hashes[k] != hashes[i]);
    }
    lookup.scale[3] = 7.0f; // of a channel that is not taken
    assert_int_equal(co_network_displacement(&desc), hashes[6]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_numbers_that_are_none, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_unknown_node_is_named, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_connections_out_of_range, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_lost_heights_are_none, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_primvar_readers, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_switches_cannot_vary, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_displacement_hashes, setup_index, teardown_index),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
