#include "prims/material_network.h"

#include "base/error.h"
#include "base/hash.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static bool is_finite(const CohortNodeInput *input)
{
    for (uint32_t i = 0; input->source_node < 0 && i < input->components && i < 4; i++)
        if (!isfinite(input->value[i]))
            return false;
    return true;
}

const CohortNodeInput *co_network_input(const CohortMaterialNode *node, const char *name)
{
    for (size_t i = 0; i < node->input_count; i++)
        if (strcmp(node->inputs[i].name, name) == 0)
            return is_finite(&node->inputs[i]) ? &node->inputs[i] : NULL;
    return NULL;
}

static void report_not_finite(CoNetwork *net, const CohortMaterialNode *node)
{
    for (size_t i = 0; i < node->input_count; i++) {
        const CohortNodeInput *input = &node->inputs[i];
        if (is_finite(input))
            continue;
        char name[128], value[64] = "";
        size_t used = 0;
        for (uint32_t k = 0; k < input->components && k < 4; k++)
            used += (size_t)snprintf(value + used, sizeof value - used, k ? ", %g" : "%g",
                                     (double)input->value[k]);
        snprintf(name, sizeof name, "inputs:%s", input->name);
        co_network_report(net, node, name, value, "not finite: its default");
    }
}

const CohortMaterialNode *co_network_source(const CoNetwork *net, const CohortNodeInput *input)
{
    if (!input || input->source_node < 0 || (size_t)input->source_node >= net->source->node_count)
        return NULL;
    return &net->source->nodes[input->source_node];
}

void co_network_report(CoNetwork *net, const CohortMaterialNode *node, const char *name,
                       const char *value, const char *action)
{
    if (!cohort_delegate_report_add(net->index->delegate, COHORT_SEVERITY_WARNING, node->path, name,
                                    value, action))
        CO_FAIL(net->err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
}

// ---- One input ---------------------------------------------------------------------------------

// First of the four channels that an output of a texture node stands for.
static uint32_t channel_of(const char *output)
{
    if (!output)
        return 0;
    if (strcmp(output, "g") == 0 || strcmp(output, "resultG") == 0)
        return 1;
    if (strcmp(output, "b") == 0 || strcmp(output, "resultB") == 0)
        return 2;
    return strcmp(output, "a") == 0 || strcmp(output, "resultA") == 0 ? 3 : 0;
}

static bool starts_with(const char *text, const char *prefix)
{
    return strncmp(text, prefix, strlen(prefix)) == 0;
}

static void copy_constant(const CohortNodeInput *input, float out[4])
{
    for (uint32_t i = 0; i < input->components && i < 4; i++)
        out[i] = input->value[i];
}

// What a texture node without a texture gives from a channel on.
static void copy_fallback(const CohortMaterialNode *node, uint32_t channel, float out[4])
{
    const CohortNodeInput *fallback = co_network_input(node, "fallback");
    float color[4] = {0.0f, 0.0f, 0.0f, 1.0f};
    if (fallback)
        copy_constant(fallback, color);
    for (uint32_t i = 0; i < 4; i++)
        out[i] = color[channel + i < 4 ? channel + i : 3];
}

static void connect_primvar(CoNetwork *net, const CohortMaterialNode *reader, CohortInput *out)
{
    const CohortNodeInput *varname = co_network_input(reader, "varname");
    const CohortNodeInput *fallback = co_network_input(reader, "fallback");
    if (fallback && fallback->components)
        copy_constant(fallback, out->value);
    if (!varname || !varname->string || !varname->string[0]) {
        co_network_report(net, reader, "inputs:varname", "", "no primvar named: its fallback");
        return;
    }
    out->kind = COHORT_INPUT_PRIMVAR;
    out->primvar = varname->string;
}

// A map of heights or normals whose fallback color would be another surface.
static bool is_lost(const CohortNodeInput *input, const CohortMaterialNode *source)
{
    if (strcmp(input->name, "displacement") == 0)
        return !co_network_has_file(source);
    return strcmp(input->name, "normal") == 0 && co_network_is_lost_relief(source);
}

static void connect(CoNetwork *net, const CohortMaterialNode *surface, const CohortNodeInput *input,
                    CohortInput *out)
{
    const CohortMaterialNode *source = co_network_source(net, input);
    bool is_texture = co_network_is_texture(source);
    if (is_texture && is_lost(input, source)) {
        const CohortNodeInput *file = co_network_input(source, "file");
        co_network_report(net, source, "inputs:file", file && file->string ? file->string : "",
                          "no such file can be read: no relief");
        return;
    }
    if (is_texture) {
        uint32_t lookup = co_network_lookup(net, input->source_node);
        if (lookup == COHORT_INVALID_ID) {
            copy_fallback(source, channel_of(input->source_output), out->value);
            return;
        }
        out->kind = COHORT_INPUT_TEXTURE;
        out->lookup = lookup;
        out->channel = channel_of(input->source_output);
        if (strcmp(input->name, "normal") == 0)
            co_network_check_normals(net, source);
        return;
    }
    if (starts_with(source->id, "UsdPrimvarReader_")) {
        connect_primvar(net, source, out);
        return;
    }
    char action[160];
    snprintf(action, sizeof action, "node not supported: default of inputs:%.80s", input->name);
    co_network_report(net, source, source->id, surface->id, action);
}

static void read_input(CoNetwork *net, const CohortMaterialNode *surface, const char *name,
                       CohortInput *out)
{
    const CohortNodeInput *input = co_network_input(surface, name);
    if (!input)
        return;
    if (co_network_source(net, input))
        connect(net, surface, input, out);
    else if (input->components)
        copy_constant(input, out->value);
}

// ---- The surface -------------------------------------------------------------------------------

static float constant_number(CoNetwork *net, const CohortMaterialNode *surface, const char *name,
                             float fallback)
{
    const CohortNodeInput *input = co_network_input(surface, name);
    if (!input)
        return fallback;
    if (co_network_source(net, input)) {
        co_network_report(net, surface, name, "connection", "cannot vary: its default");
        return fallback;
    }
    return input->components ? input->value[0] : fallback;
}

static void report_flat_normal(CoNetwork *net, const CohortMaterialNode *surface)
{
    const CohortNodeInput *normal = co_network_input(surface, "normal");
    char value[64];
    if (!normal || co_network_source(net, normal) || normal->components != 3 ||
        (normal->value[0] == 0.0f && normal->value[1] == 0.0f && normal->value[2] > 0.0f))
        return;
    snprintf(value, sizeof value, "%g, %g, %g", (double)normal->value[0], (double)normal->value[1],
             (double)normal->value[2]);
    co_network_report(net, surface, "inputs:normal", value, "only maps bend normals: ignored");
}

static void read_preview_surface(CoNetwork *net, const CohortMaterialNode *surface)
{
    CohortMaterialDesc *desc = &net->desc;
    struct {
        const char *name;
        CohortInput *input;
    } inputs[] = {{"diffuseColor", &desc->diffuse_color},
                  {"emissiveColor", &desc->emissive_color},
                  {"specularColor", &desc->specular_color},
                  {"metallic", &desc->metallic},
                  {"roughness", &desc->roughness},
                  {"clearcoat", &desc->clearcoat},
                  {"clearcoatRoughness", &desc->clearcoat_roughness},
                  {"opacity", &desc->opacity},
                  {"ior", &desc->ior},
                  {"normal", &desc->normal}};
    for (size_t i = 0; i < sizeof inputs / sizeof inputs[0]; i++)
        read_input(net, surface, inputs[i].name, inputs[i].input);
    report_flat_normal(net, surface);
    desc->use_specular_workflow =
        constant_number(net, surface, "useSpecularWorkflow", 0.0f) != 0.0f;
    desc->opacity_threshold = constant_number(net, surface, "opacityThreshold", 0.0f);
    const CohortNodeInput *mode = co_network_input(surface, "opacityMode");
    desc->opacity_presence = mode && mode->string && strcmp(mode->string, "presence") == 0;
}

// Of the shader that the material's displacement comes from, which need not be its surface.
static void read_displacement(CoNetwork *net)
{
    int32_t terminal = net->source->displacement;
    if (terminal < 0 || (size_t)terminal >= net->source->node_count)
        return;
    const CohortMaterialNode *node = &net->source->nodes[terminal];
    if (strcmp(node->id, "UsdPreviewSurface") == 0)
        read_input(net, node, "displacement", &net->desc.displacement);
    else
        co_network_report(net, node, "info:id", node->id, "displacement not supported: ignored");
}

static uint64_t hash_text(const char *text, uint64_t seed)
{
    return co_hash_bytes(text ? text : "", text ? strlen(text) : 0, seed);
}

uint64_t co_network_displacement(const CohortMaterialDesc *desc)
{
    const CohortInput *input = &desc->displacement;
    if (input->kind == COHORT_INPUT_CONSTANT && input->value[0] == 0.0f)
        return 0;
    uint64_t hash = co_hash_bytes(input->value, sizeof input->value, input->kind);
    hash = hash_text(input->primvar, co_hash_combine(hash, input->channel));
    if (input->kind == COHORT_INPUT_TEXTURE) {
        const CohortLookupDesc *l = &desc->lookups[input->lookup];
        const float numbers[] = {
            l->st_fallback[0],    l->st_fallback[1],        l->st_scale[0],
            l->st_scale[1],       l->st_rotation_degrees,   l->st_translation[0],
            l->st_translation[1], l->scale[input->channel], l->bias[input->channel]};
        hash = co_hash_bytes(numbers, sizeof numbers, hash);
        hash = hash_text(l->st_primvar, co_hash_combine(hash, l->texture));
    }
    return hash ? hash : 1;
}

bool co_network_translate(CoNetwork *net)
{
    net->desc = cohort_material_default();
    net->desc.path = net->prim->path;
    int32_t terminal = net->source->surface;
    if (terminal < 0 || (size_t)terminal >= net->source->node_count) {
        CohortMaterialNode self = {.path = net->prim->path, .id = ""};
        co_network_report(net, &self, "outputs:surface", "",
                          "no surface: Lambertian with displayColor");
        return false;
    }
    const CohortMaterialNode *surface = &net->source->nodes[terminal];
    if (strcmp(surface->id, "UsdPreviewSurface") != 0) {
        co_network_report(net, surface, "info:id", surface->id,
                          "surface not supported: Lambertian with displayColor");
        return false;
    }
    for (size_t i = 0; i < net->source->node_count; i++)
        report_not_finite(net, &net->source->nodes[i]);
    read_preview_surface(net, surface);
    read_displacement(net); // last, so that its lookup is
    return true;
}
