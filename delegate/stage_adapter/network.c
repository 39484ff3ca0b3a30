// Material networks: from a Material's surface output through connections, node graphs and
// interface inputs to a flat list of shading nodes.

#include "stage_adapter/adapter.h"

#include "base/error.h"

#include <stdio.h>
#include <string.h>

enum {
    MAX_NODES = 256,
    MAX_HOPS = 64,
    PATH_SIZE = 2048
};

typedef struct Network {
    CohortAdapter *adapter;
    CohortPull *pull;
    CohortMaterialNode *nodes; // [MAX_NODES]
    const CohortPrim **prims;  // [MAX_NODES]
    size_t count;
    CohortError *err;
} Network;

// An attribute that holds a value, or the output of a shader.
typedef struct Source {
    const CohortPrim *prim;
    const char *attribute;
    bool is_output; // of a shader
} Source;

// Splits "/Prim.attribute"; the prim must exist.
static bool find_property(const CohortAdapter *a, const char *path, Source *out)
{
    const char *dot = strchr(path, '.');
    char prim_path[PATH_SIZE];
    if (!dot || (size_t)(dot - path) >= sizeof prim_path)
        return false;
    memcpy(prim_path, path, (size_t)(dot - path));
    prim_path[dot - path] = '\0';
    out->prim = cohort_stage_prim(a->stage, prim_path);
    out->attribute = dot + 1;
    return out->prim != NULL;
}

// Follows connections from an attribute until a shader's output or an attribute without connection.
static Source follow(const CohortAdapter *a, Source source)
{
    for (int hop = 0; hop < MAX_HOPS; hop++) {
        source.is_output = strcmp(cohort_prim_type(source.prim), "Shader") == 0 &&
                           co_starts_with(source.attribute, "outputs:");
        const char *const *connections;
        if (source.is_output ||
            cohort_prim_connections(source.prim, source.attribute, &connections) == 0)
            return source;
        Source next = {0};
        if (!find_property(a, connections[0], &next)) {
            co_adapter_report(a, source.prim, source.attribute, connections[0],
                              "connected to nothing: its own value");
            return source;
        }
        source = next;
    }
    co_adapter_report(a, source.prim, source.attribute, "", "connections in a circle: ignored");
    source.is_output = false;
    return source;
}

static int32_t add_node(Network *net, const CohortPrim *prim);

// ---- Inputs ------------------------------------------------------------------------------------

static void read_asset(Network *net, const Source *source, CohortNodeInput *out)
{
    const CohortAsset *assets;
    if (!cohort_prim_assets(source->prim, source->attribute, net->adapter->time, &assets))
        return;
    out->string = assets[0].authored;
    out->resolved = assets[0].resolved[0] ? assets[0].resolved : assets[0].anchored;
}

static void read_constant(Network *net, const Source *source, CohortNodeInput *out)
{
    CohortValue value, space;
    if (cohort_prim_attribute_metadata(source->prim, source->attribute, "colorSpace", &space))
        out->color_space = co_values_text(&space);
    if (!cohort_prim_value(source->prim, source->attribute, net->adapter->time, &value) ||
        value.count == 0)
        return;
    CoFloats numbers;
    if (value.type == COHORT_TYPE_ASSET) {
        read_asset(net, source, out);
    } else if (co_values_floats(&value, net->pull, &numbers) && numbers.components <= 4) {
        out->components = numbers.components;
        memcpy(out->value, numbers.values, numbers.components * sizeof *numbers.values);
    } else {
        out->string = co_values_text(&value);
    }
}

// Remembers which primvars materials read: the others need not reach the renderer.
static void note_primvar(Network *net, const CohortMaterialNode *node, const CohortNodeInput *input)
{
    if (strcmp(input->name, "varname") == 0 && input->string &&
        co_starts_with(node->id, "UsdPrimvarReader") &&
        !co_string_map_set(&net->adapter->primvars, input->string, 1))
        CO_FAIL(net->err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
}

static void read_input(Network *net, const CohortPrim *prim, const char *attribute,
                       CohortNodeInput *out)
{
    out->name = attribute + strlen("inputs:");
    out->source_node = -1;
    Source source = follow(net->adapter, (Source){.prim = prim, .attribute = attribute});
    if (!source.is_output) {
        read_constant(net, &source, out);
        return;
    }
    out->source_node = add_node(net, source.prim);
    out->source_output = source.attribute + strlen("outputs:");
}

static void read_inputs(Network *net, const CohortPrim *prim, CohortMaterialNode *node)
{
    size_t count = cohort_prim_property_count(prim);
    CohortNodeInput *inputs = cohort_pull_array(net->pull, count, sizeof *inputs);
    if (!inputs) {
        CO_FAIL(net->err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        return;
    }
    for (size_t i = 0; i < count; i++) {
        const char *name = cohort_prim_property_name(prim, i);
        if (!co_starts_with(name, "inputs:"))
            continue;
        CohortNodeInput *input = &inputs[node->input_count];
        read_input(net, prim, name, input);
        note_primvar(net, node, input);
        if (input->source_node >= 0 || input->components || input->string)
            node->input_count++;
        else
            memset(input, 0, sizeof *input);
    }
    node->inputs = inputs;
}

static const char *shader_id(const CohortAdapter *a, const CohortPrim *prim)
{
    const char *id = cohort_prim_token(prim, "info:id", a->time, "");
    if (id[0])
        return id;
    const char *source = cohort_prim_token(prim, "info:implementationSource", a->time, "id");
    return strcmp(source, "id") == 0 ? "(no info:id)" : source;
}

// The node of a shader prim, made when it is new; -1 when there are too many.
static int32_t add_node(Network *net, const CohortPrim *prim)
{
    for (size_t i = 0; i < net->count; i++)
        if (net->prims[i] == prim)
            return (int32_t)i;
    if (net->count == MAX_NODES) {
        co_adapter_report(net->adapter, prim, "Shader", "", "more than 256 nodes: left out");
        return -1;
    }
    size_t place = net->count++;
    net->prims[place] = prim;
    CohortMaterialNode *node = &net->nodes[place];
    node->path = cohort_prim_path(prim);
    node->id = shader_id(net->adapter, prim);
    read_inputs(net, prim, node);
    return (int32_t)place;
}

// ---- Terminals ---------------------------------------------------------------------------------

// The universal surface, else any other context's, which is then refused by the name of its shader.
static const char *surface_output(const CohortPrim *material)
{
    size_t count = cohort_prim_property_count(material);
    const char *other = NULL;
    for (size_t i = 0; i < count; i++) {
        const char *name = cohort_prim_property_name(material, i);
        size_t length = strlen(name);
        if (strcmp(name, "outputs:surface") == 0)
            return name;
        if (co_starts_with(name, "outputs:") && length > 8 &&
            strcmp(name + length - 8, ":surface") == 0)
            other = name;
    }
    return other;
}

// The shader that a terminal of a material is connected to, as a node; -1: none.
static int32_t find_terminal(Network *net, const CohortPrim *material, const char *output)
{
    const char *const *connections;
    if (cohort_prim_connections(material, output, &connections) == 0)
        return -1;
    Source source = follow(net->adapter, (Source){.prim = material, .attribute = output});
    return source.is_output ? add_node(net, source.prim) : -1;
}

static const CohortNodeInput *find_input(const CohortMaterialNode *node, const char *name)
{
    for (size_t i = 0; i < node->input_count; i++)
        if (strcmp(node->inputs[i].name, name) == 0)
            return &node->inputs[i];
    return NULL;
}

// The primvar that a node cannot do without; NULL when it reads none or has a fallback for it.
static const char *needed_primvar(const CohortMaterialNode *node)
{
    const CohortNodeInput *varname = find_input(node, "varname");
    bool is_reader = co_starts_with(node->id, "UsdPrimvarReader") && varname && varname->string;
    return is_reader && !find_input(node, "fallback") ? varname->string : NULL;
}

// Lists them once, for the report on meshes that lack them: all, or another time.
static bool note_needs(const Network *net, CoRecord *record)
{
    CoArena *arena = &net->adapter->arena;
    if (record->needs)
        return true;
    const char **needs = co_arena_array(arena, net->count + 1, sizeof *needs);
    CO_CHECK_MEMORY(needs, net->err);
    size_t count = 0;
    for (size_t i = 0; i < net->count; i++) {
        const char *name = needed_primvar(&net->nodes[i]);
        if (!name)
            continue;
        needs[count] = co_arena_string(arena, name, strlen(name));
        CO_CHECK_MEMORY(needs[count++], net->err);
    }
    record->needs = needs;
    record->need_count = count;
    return true;
}

static void report_volume(const CohortAdapter *a, const CohortPrim *material)
{
    const char *const *connections;
    if (cohort_prim_connections(material, "outputs:volume", &connections))
        co_adapter_report(a, material, "outputs:volume", connections[0], "not supported: ignored");
}

bool co_pull_material(void *cookie, CohortPull *pull, const char *path, CohortMaterialNetwork *out,
                      CohortError *err)
{
    CohortAdapter *a = cookie;
    const CoRecord *record = co_record_find(a, path);
    CO_CHECK(record, err, COHORT_ERROR_INTERNAL, "the adapter knows no material at %.180s", path);
    CohortError own = {0};
    Network net = {.adapter = a,
                   .pull = pull,
                   .nodes = cohort_pull_array(pull, MAX_NODES, sizeof *net.nodes),
                   .prims = cohort_pull_array(pull, MAX_NODES, sizeof *net.prims),
                   .err = &own};
    CO_CHECK(net.nodes && net.prims, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    const char *output = surface_output(record->prim);
    out->surface = output ? find_terminal(&net, record->prim, output) : -1;
    out->displacement = find_terminal(&net, record->prim, "outputs:displacement");
    report_volume(a, record->prim);
    CO_CHECK(!cohort_stage_ran_short(a->stage), err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    // Nodes that lack inputs for want of memory do not say what they need.
    bool ok = own.code == COHORT_OK && note_needs(&net, &a->records[record - a->records]);
    out->nodes = net.nodes;
    out->node_count = net.count;
    if (!ok && err)
        *err = own;
    return ok;
}
