// Texture nodes of a network as lookups: UsdUVTexture and the Ptex nodes with what feeds them.

#include "prims/material_network.h"

#include "base/error.h"
#include "prims/sync.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

// Stands for a scale of zero, which the renderer reads as one.
#define NOTHING 1e-30f

bool co_network_is_texture(const CohortMaterialNode *node)
{
    return strcmp(node->id, "UsdUVTexture") == 0 || strcmp(node->id, "HwPtexTexture_1") == 0 ||
           strcmp(node->id, "PxrPtexture") == 0;
}

static const char *string_of(const CohortNodeInput *input)
{
    return input && input->components == 0 && input->string ? input->string : "";
}

static void numbers_of(const CohortNodeInput *input, float *out, uint32_t count)
{
    for (uint32_t i = 0; input && i < input->components && i < count; i++)
        out[i] = input->value[i];
}

// ---- File, color space, wrap -------------------------------------------------------------------

// The attribute's colorSpace metadata beats the node's sourceColorSpace (OpenUSD since 23.11).
static void set_color_space(CoNetwork *net, const CohortMaterialNode *node,
                            const CohortNodeInput *file, const char *authored,
                            CohortTextureDesc *desc)
{
    const char *metadata = file->color_space;
    if (metadata && metadata[0] && strcmp(metadata, "auto") != 0)
        authored = metadata;
    if (!authored[0] || strcmp(authored, "auto") == 0) {
        desc->color_space = COHORT_COLOR_AUTO;
    } else if (strcmp(authored, "raw") == 0 || strcmp(authored, "data") == 0 ||
               strcmp(authored, "Raw") == 0) {
        desc->color_space = COHORT_COLOR_RAW;
    } else if (strcmp(authored, "sRGB") == 0) {
        desc->color_space = COHORT_COLOR_SRGB;
    } else if (authored == metadata) {
        desc->color_space = COHORT_COLOR_NAMED;
        desc->color_space_name = authored;
    } else {
        co_network_report(net, node, "inputs:sourceColorSpace", authored, "treated as auto");
    }
}

static CohortWrap wrap_of(CoNetwork *net, const CohortMaterialNode *node, const char *name)
{
    static const struct {
        const char *name;
        CohortWrap wrap;
    } wraps[] = {{"", COHORT_WRAP_USE_METADATA},  {"useMetadata", COHORT_WRAP_USE_METADATA},
                 {"black", COHORT_WRAP_BLACK},    {"clamp", COHORT_WRAP_CLAMP},
                 {"repeat", COHORT_WRAP_REPEAT},  {"mirror", COHORT_WRAP_MIRROR},
                 {"periodic", COHORT_WRAP_REPEAT}};
    const char *authored = string_of(co_network_input(node, name));
    for (size_t i = 0; i < sizeof wraps / sizeof wraps[0]; i++)
        if (strcmp(authored, wraps[i].name) == 0)
            return wraps[i].wrap;
    co_network_report(net, node, name, authored, "treated as useMetadata");
    return COHORT_WRAP_USE_METADATA;
}

static bool ends_with(const char *path, const char *end)
{
    size_t length = strlen(path), end_length = strlen(end);
    return length >= end_length && strcasecmp(path + length - end_length, end) == 0;
}

// Where st is one point of the image for the whole surface, the texture is a color: a filter that
// reached over the border, as at the default (0, 0), would take three quarters of it away.
static void keep_point_inside(const CoNetwork *net, const CohortMaterialNode *node,
                              CohortTextureDesc *desc)
{
    const CohortNodeInput *st = co_network_input(node, "st");
    float point[2] = {0.0f, 0.0f};
    if (co_network_source(net, st))
        return;
    numbers_of(st, point, 2);
    CohortWrap *wraps[2] = {&desc->wrap_s, &desc->wrap_t};
    for (int k = 0; k < 2; k++)
        if ((*wraps[k] == COHORT_WRAP_USE_METADATA || *wraps[k] == COHORT_WRAP_BLACK) &&
            point[k] >= 0.0f && point[k] <= 1.0f)
            *wraps[k] = COHORT_WRAP_CLAMP;
}

static void read_uv_node(CoNetwork *net, const CohortMaterialNode *node,
                         const CohortNodeInput *file, CohortTextureDesc *desc)
{
    desc->is_ptex = ends_with(desc->path, ".ptx");
    desc->wrap_s = wrap_of(net, node, "wrapS");
    desc->wrap_t = wrap_of(net, node, "wrapT");
    keep_point_inside(net, node, desc);
    set_color_space(net, node, file, string_of(co_network_input(node, "sourceColorSpace")), desc);
    numbers_of(co_network_input(node, "fallback"), desc->fallback, 4);
}

static void read_ptex_node(CoNetwork *net, const CohortMaterialNode *node,
                           const CohortNodeInput *file, CohortTextureDesc *desc)
{
    desc->is_ptex = true;
    const float missing[4] = {1.0f, 0.0f, 1.0f, 1.0f};
    memcpy(desc->fallback, missing, sizeof missing);
    numbers_of(co_network_input(node, "missingColor"), desc->fallback, 3);
    numbers_of(co_network_input(node, "missingAlpha"), &desc->fallback[3], 1);
    const CohortNodeInput *linearize = co_network_input(node, "linearize");
    bool is_pxr = strcmp(node->id, "PxrPtexture") == 0;
    const char *space = string_of(co_network_input(node, "sourceColorSpace"));
    if (is_pxr && !space[0])
        space = linearize && linearize->value[0] != 0.0f ? "sRGB" : "raw";
    set_color_space(net, node, file, space, desc);
    const char *const ignored[] = {"faceIndexOffset", "invertWindingOrder", "firstChannel", "blur"};
    for (size_t i = 0; i < sizeof ignored / sizeof ignored[0]; i++) {
        const CohortNodeInput *input = co_network_input(node, ignored[i]);
        if (input && input->components && input->value[0] != 0.0f)
            co_network_report(net, node, ignored[i], "", "treated as 0");
    }
}

static bool is_readable(const char *path)
{
    return strstr(path, "<UDIM>") || access(path, R_OK) == 0;
}

bool co_network_has_file(const CohortMaterialNode *node)
{
    const CohortNodeInput *file = co_network_input(node, "file");
    if (!file)
        file = co_network_input(node, "filename");
    const char *path = file && file->resolved ? file->resolved : string_of(file);
    return file && (file->source_node >= 0 || is_readable(path));
}

bool co_network_is_lost_relief(const CohortMaterialNode *node)
{
    if (co_network_has_file(node))
        return false;
    float color[4] = {0, 0, 0, 1}, scale[4] = {1, 1, 1, 1}, bias[4] = {0, 0, 0, 0};
    numbers_of(co_network_input(node, "fallback"), color, 4);
    numbers_of(co_network_input(node, "scale"), scale, 4);
    numbers_of(co_network_input(node, "bias"), bias, 4);
    return !(color[2] * scale[2] + bias[2] > 0.0f);
}

void co_network_check_normals(CoNetwork *net, const CohortMaterialNode *node)
{
    static const char *const formats[] = {".png", ".jpg", ".jpeg", ".tga", ".bmp"};
    const CohortNodeInput *file = co_network_input(node, "file");
    bool is_unsigned = false;
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++)
        is_unsigned = is_unsigned || ends_with(string_of(file), formats[i]);
    if (!is_unsigned || strcmp(node->id, "UsdUVTexture") != 0)
        return;
    if (!co_network_input(node, "bias"))
        co_network_report(net, node, "inputs:bias", "",
                          "normals in this format want scale 2, bias -1: taken as they are");
    const char *space = string_of(co_network_input(node, "sourceColorSpace"));
    if (file->color_space && file->color_space[0])
        space = file->color_space;
    if (!space[0] || strcmp(space, "auto") == 0 || strcasecmp(space, "sRGB") == 0)
        co_network_report(net, node, "inputs:sourceColorSpace", space,
                          "normals want raw: decoded as a color if they are 8-bit or say sRGB");
}

static uint32_t make_texture(CoNetwork *net, const CohortMaterialNode *node)
{
    const CohortNodeInput *file = co_network_input(node, "file");
    if (!file)
        file = co_network_input(node, "filename");
    bool is_named = file && (file->string ? file->string[0] != '\0' : file->resolved != NULL);
    if (!is_named || co_network_source(net, file)) {
        co_network_report(net, node, "inputs:file", "", "no file: the fallback color");
        return COHORT_INVALID_ID;
    }
    CohortTextureDesc desc = {.asset = file->string ? file->string : file->resolved,
                              .path = file->resolved ? file->resolved : file->string,
                              .fallback = {0.0f, 0.0f, 0.0f, 1.0f}};
    if (strcmp(node->id, "UsdUVTexture") == 0)
        read_uv_node(net, node, file, &desc);
    else
        read_ptex_node(net, node, file, &desc);
    if (!is_readable(desc.path))
        co_network_report(net, node, "inputs:file", desc.asset,
                          "no such file can be read: the fallback color");
    return co_sync_texture(net->index, &desc, net->err);
}

static void report_varying(CoNetwork *net, const CohortMaterialNode *node, const char *name)
{
    if (co_network_source(net, co_network_input(node, name)))
        co_network_report(net, node, name, "connection", "cannot vary: its default");
}

// ---- Texture coordinates -----------------------------------------------------------------------

static void read_transform(CoNetwork *net, const CohortMaterialNode *node, CohortLookupDesc *lookup)
{
    lookup->st_scale[0] = lookup->st_scale[1] = 1.0f;
    numbers_of(co_network_input(node, "scale"), lookup->st_scale, 2);
    numbers_of(co_network_input(node, "rotation"), &lookup->st_rotation_degrees, 1);
    numbers_of(co_network_input(node, "translation"), lookup->st_translation, 2);
    report_varying(net, node, "scale");
    report_varying(net, node, "rotation");
    report_varying(net, node, "translation");
    // The renderer reads an all-zero scale as one; coordinates scaled to nothing are one point.
    if (lookup->st_scale[0] == 0.0f && lookup->st_scale[1] == 0.0f)
        lookup->st_scale[0] = lookup->st_scale[1] = NOTHING;
}

static void read_reader(CoNetwork *net, const CohortMaterialNode *node, CohortLookupDesc *lookup)
{
    const char *varname = string_of(co_network_input(node, "varname"));
    if (varname[0])
        lookup->st_primvar = varname;
    else
        co_network_report(net, node, "inputs:varname", "", "no primvar named: st");
    numbers_of(co_network_input(node, "fallback"), lookup->st_fallback, 2);
}

static void read_coordinates(CoNetwork *net, const CohortMaterialNode *node,
                             CohortLookupDesc *lookup)
{
    const CohortNodeInput *st = co_network_input(node, "st");
    const CohortMaterialNode *source = co_network_source(net, st);
    if (source && strcmp(source->id, "UsdTransform2d") == 0) {
        read_transform(net, source, lookup);
        st = co_network_input(source, "in");
        source = co_network_source(net, st);
    }
    if (!source)
        numbers_of(st, lookup->st_fallback, 2);
    else if (strncmp(source->id, "UsdPrimvarReader_", 17) == 0)
        read_reader(net, source, lookup);
    else
        co_network_report(net, source, source->id, "", "not supported as st: primvar st");
}

// ---- Lookup ------------------------------------------------------------------------------------

static bool all_zero(const float v[4])
{
    return v[0] == 0.0f && v[1] == 0.0f && v[2] == 0.0f && v[3] == 0.0f;
}

uint32_t co_network_lookup(CoNetwork *net, int32_t node_index)
{
    size_t count = net->desc.lookup_count;
    for (size_t i = 0; i < count; i++)
        if (net->lookup_nodes[i] == node_index)
            return (uint32_t)i;
    const CohortMaterialNode *node = &net->source->nodes[node_index];
    if (count == CO_MATERIAL_LOOKUPS) {
        co_network_report(net, node, node->id, "", "more than 16 textures in a material: left out");
        return COHORT_INVALID_ID;
    }
    CohortLookupDesc *lookup = &net->lookups[count];
    *lookup = (CohortLookupDesc){.scale = {1, 1, 1, 1}, .st_scale = {1, 1}};
    lookup->texture = make_texture(net, node);
    if (lookup->texture == COHORT_INVALID_ID)
        return COHORT_INVALID_ID;
    read_coordinates(net, node, lookup);
    numbers_of(co_network_input(node, "scale"), lookup->scale, 4);
    numbers_of(co_network_input(node, "bias"), lookup->bias, 4);
    report_varying(net, node, "scale");
    report_varying(net, node, "bias");
    // The renderer reads an all-zero scale as one; a texture scaled to nothing is its bias.
    if (all_zero(lookup->scale))
        lookup->scale[0] = lookup->scale[1] = lookup->scale[2] = lookup->scale[3] = NOTHING;
    net->lookup_nodes[count] = node_index;
    net->desc.lookup_count = count + 1;
    return (uint32_t)count;
}
