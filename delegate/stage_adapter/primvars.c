// Primvars: a mesh's own, and the constant ones it inherits; only those that something reads.

#include "stage_adapter/adapter.h"

#include "base/error.h"

#include <stdio.h>
#include <string.h>

enum {
    MAX_PRIMVARS = 64,
    NAME_SIZE = 256
};
static const char prefix[] = "primvars:";

typedef struct Gather {
    const CohortAdapter *adapter;
    CohortPull *pull;
    const CohortMeshDesc *mesh;
    CohortPrimvarDesc *list; // [MAX_PRIMVARS]
    size_t count;
} Gather;

static bool has_name(const Gather *g, const char *name)
{
    for (size_t i = 0; i < g->count; i++)
        if (strcmp(g->list[i].name, name) == 0)
            return true;
    return false;
}

static bool is_wanted(const Gather *g, const char *name)
{
    if (strcmp(name, "normals") == 0)
        return g->mesh->scheme == COHORT_SCHEME_NONE; // subdivision makes its own
    return strcmp(name, "displayColor") == 0 || strcmp(name, "displayOpacity") == 0 ||
           strcmp(name, "st") == 0 ||
           co_string_map_find(&g->adapter->primvars, name) != COHORT_INVALID_ID;
}

static CohortInterpolation interpolation_of(const CohortPrim *prim, const char *attribute,
                                            CohortInterpolation fallback)
{
    static const char *const names[] = {"constant", "uniform", "varying", "vertex", "faceVarying"};
    CohortValue value;
    if (cohort_prim_attribute_metadata(prim, attribute, "interpolation", &value))
        for (int i = 0; i < 5; i++)
            if (strcmp(co_values_text(&value), names[i]) == 0)
                return (CohortInterpolation)i;
    return fallback;
}

static size_t expected_count(const CohortMeshDesc *mesh, CohortInterpolation interpolation)
{
    switch (interpolation) {
    case COHORT_INTERPOLATION_CONSTANT:
        return 1;
    case COHORT_INTERPOLATION_UNIFORM:
        return mesh->face_count;
    case COHORT_INTERPOLATION_VARYING:
    case COHORT_INTERPOLATION_VERTEX:
        return mesh->point_count;
    case COHORT_INTERPOLATION_FACE_VARYING:
        return mesh->face_vertex_index_count;
    }
    return 0;
}

// Cuts what is too long and refuses what is too short, saying so.
static bool check_length(const Gather *g, const CohortPrim *prim, const char *attribute,
                         CohortPrimvarDesc *d)
{
    size_t expected = expected_count(g->mesh, d->interpolation);
    size_t *length = d->indices ? &d->index_count : &d->value_count;
    if (*length == expected)
        return true;
    char value[64], action[96];
    snprintf(value, sizeof value, "%zu elements", *length);
    bool is_long = *length > expected;
    snprintf(action, sizeof action, "%zu expected: %s", expected,
             is_long ? "the rest is not used" : "left out");
    co_adapter_report(g->adapter, prim, attribute, value, action);
    *length = expected;
    return is_long;
}

static bool has_element_size(const CohortPrim *prim, const char *attribute)
{
    CohortValue value;
    return cohort_prim_attribute_metadata(prim, attribute, "elementSize", &value) &&
           value.type == COHORT_TYPE_INT && value.count && *(const int32_t *)value.data != 1;
}

// What most exporters write: it would only make rays ask.
static bool is_opaque(const CohortPrimvarDesc *d)
{
    bool found = strcmp(d->name, "displayOpacity") == 0;
    for (size_t i = 0; i < d->value_count && found; i++)
        found = d->values[i * d->components] >= 1.0f;
    return found;
}

// Adds one attribute of a prim as the primvar `name`, if it holds numbers that fit the mesh.
static void add_primvar(Gather *g, const CohortPrim *prim, const char *attribute, const char *name,
                        CohortInterpolation fallback)
{
    CoFloats values;
    if (!co_values_read(g->adapter, prim, attribute, g->pull, &values) || values.count == 0 ||
        values.components > 4)
        return;
    CohortPrimvarDesc d = {.name = name,
                           .interpolation = interpolation_of(prim, attribute, fallback),
                           .components = values.components,
                           .values = values.values,
                           .value_count = values.count};
    char indices[NAME_SIZE];
    int n = snprintf(indices, sizeof indices, "%s:indices", attribute);
    if (n > 0 && (size_t)n < sizeof indices)
        d.indices = co_values_ints(g->adapter, prim, indices, &d.index_count);
    if (has_element_size(prim, attribute)) {
        co_adapter_report(g->adapter, prim, attribute, "elementSize", "left out");
        return;
    }
    if (check_length(g, prim, attribute, &d) && !is_opaque(&d))
        g->list[g->count++] = d;
}

static void gather_prim(Gather *g, const CohortPrim *prim, bool is_own, bool with_color)
{
    size_t count = cohort_prim_property_count(prim);
    for (size_t i = 0; i < count && g->count < MAX_PRIMVARS; i++) {
        const char *attribute = cohort_prim_property_name(prim, i);
        if (!co_starts_with(attribute, prefix))
            continue;
        const char *name = attribute + sizeof prefix - 1;
        if (!is_wanted(g, name) || has_name(g, name) ||
            (!with_color && strcmp(name, "displayColor") == 0))
            continue;
        if (is_own || interpolation_of(prim, attribute, COHORT_INTERPOLATION_CONSTANT) ==
                          COHORT_INTERPOLATION_CONSTANT)
            add_primvar(g, prim, attribute, name, COHORT_INTERPOLATION_CONSTANT);
    }
}

// A lookup without its coordinates shows one texel: that is seldom what was meant.
static void report_missing(const Gather *g, const CoRecord *mesh, const char *material)
{
    const CoRecord *record = material ? co_record_find(g->adapter, material) : NULL;
    for (size_t i = 0; record && i < record->need_count; i++) {
        char name[NAME_SIZE];
        if (has_name(g, record->needs[i]))
            continue;
        snprintf(name, sizeof name, "%s%s", prefix, record->needs[i]);
        co_adapter_report(g->adapter, mesh->prim, name, "",
                          "the material reads it, but it is not here: a default");
    }
}

bool co_pull_primvars(CohortAdapter *adapter, const CoRecord *record, CohortPull *pull,
                      CohortMeshSource *out, CohortError *err)
{
    Gather g = {.adapter = adapter,
                .pull = pull,
                .mesh = &out->mesh,
                .list = cohort_pull_array(pull, MAX_PRIMVARS + 1, sizeof *g.list)};
    CO_CHECK_MEMORY(g.list, err);
    for (size_t i = 0; i < out->mesh.primvar_count && i < MAX_PRIMVARS; i++)
        g.list[g.count++] = out->mesh.primvars[i]; // an implicit's own
    CoPlace place = {record->prim, record->prototype};
    gather_prim(&g, place.prim, true, true);
    if (!has_name(&g, "normals") && is_wanted(&g, "normals"))
        add_primvar(&g, record->prim, "normals", "normals", COHORT_INTERPOLATION_VERTEX);
    // A color from beyond a native instance differs by placement and comes with it; what stands
    // above the target of a PointInstancer is the same for all its places.
    bool is_shared = true;
    while (g.count < MAX_PRIMVARS) {
        uint32_t inside = place.prototype;
        if (!co_place_up(adapter, &place))
            break;
        is_shared = is_shared && !co_place_left_native(adapter, inside, place);
        gather_prim(&g, place.prim, false, is_shared);
    }
    report_missing(&g, record, record->material);
    for (size_t i = 0; i < out->mesh.subset_count && out->subset_materials; i++)
        report_missing(&g, record, out->subset_materials[i]);
    out->mesh.primvars = g.list;
    out->mesh.primvar_count = g.count;
    return true;
}

// A constant color of any precision that a prim authors, the one that its index chooses.
static bool constant_color(const CohortAdapter *adapter, const CohortPrim *prim, CohortPull *pull,
                           float color[3])
{
    static const char attribute[] = "primvars:displayColor";
    CoFloats values;
    if (interpolation_of(prim, attribute, COHORT_INTERPOLATION_CONSTANT) !=
            COHORT_INTERPOLATION_CONSTANT ||
        !co_values_read(adapter, prim, attribute, pull, &values) || values.components != 3)
        return false;
    size_t index_count;
    const int32_t *indices =
        co_values_ints(adapter, prim, "primvars:displayColor:indices", &index_count);
    size_t chosen = index_count ? (size_t)indices[0] : 0; // a negative one is beyond all
    if (chosen >= values.count)
        return false;
    memcpy(color, values.values + 3 * chosen, 3 * sizeof *color);
    return true;
}

bool co_inherited_color(const CohortAdapter *adapter, CoPlace place, CohortPull *pull,
                        float color[3])
{
    uint32_t inside;
    do {
        inside = place.prototype;
        if (constant_color(adapter, place.prim, pull, color))
            return true;
    } while (co_place_up(adapter, &place) && !co_place_left_native(adapter, inside, place));
    return false;
}
