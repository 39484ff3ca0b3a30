// PointInstancers and native instances, as the index pulls them.

#include "stage_adapter/adapter.h"

#include "base/error.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- Native instances --------------------------------------------------------------------------

static bool set_samples(CohortPull *pull, double (*transforms)[4][4], CohortInstancerSource *out,
                        CohortError *err)
{
    CohortInstancesSample *sample = cohort_pull_array(pull, 1, sizeof *sample);
    CO_CHECK_MEMORY(sample, err);
    sample->transforms = (const double(*)[4][4])transforms;
    out->samples = sample;
    out->sample_count = 1;
    return true;
}

// The colors that placements hand down, each to the meshes that have none.
static bool set_placement_colors(const CohortAdapter *a, const CoPlacement *placements,
                                 size_t count, CohortPull *pull, CohortInstancerSource *out,
                                 CohortError *err)
{
    float *colors = cohort_pull_array(pull, count, 3 * sizeof *colors);
    uint8_t *colored = cohort_pull_array(pull, count, 1);
    CO_CHECK(colors && colored, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    bool any = false;
    for (size_t i = 0; i < count; i++) {
        CoPlace place = {placements[i].prim, placements[i].within};
        colored[i] = co_inherited_color(a, place, pull, colors + 3 * i);
        any = any || colored[i];
    }
    if (!any)
        return true;
    out->display_colors = colors;
    out->colors_yield = true;
    out->colored = colored;
    return true;
}

static bool pull_native(CohortAdapter *a, const CoRecord *record, CohortPull *pull,
                        CohortInstancerSource *out, CohortError *err)
{
    size_t begin = 0, end;
    while (begin < a->placement_count && a->placements[begin].within != record->prototype)
        begin++;
    for (end = begin; end < a->placement_count; end++)
        if (a->placements[end].within != record->prototype)
            break;
    const CoPlacement *placements = a->placements + begin;
    size_t count = end - begin;
    double(*transforms)[4][4] = cohort_pull_array(pull, count, sizeof *transforms);
    uint32_t *prototypes = cohort_pull_array(pull, count, sizeof *prototypes);
    uint8_t *hidden = cohort_pull_array(pull, count, 1);
    CO_CHECK(transforms && prototypes && hidden, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    for (size_t i = 0; i < count; i++) {
        CoPlace place = {placements[i].prim, placements[i].within};
        CoMat4d m = co_place_transform(a, place);
        memcpy(transforms[i], m.m, sizeof m.m);
        prototypes[i] = placements[i].prototype;
        hidden[i] = !co_place_is_visible(a, place);
    }
    out->instance_count = count;
    out->prototypes = prototypes;
    out->hidden = hidden;
    return set_placement_colors(a, placements, count, pull, out, err) &&
           set_samples(pull, transforms, out, err);
}

// ---- PointInstancers ---------------------------------------------------------------------------

typedef struct Points {
    const int32_t *indices;
    CoFloats positions, orientations, scales, colors;
    const int32_t *color_indices;
    const int64_t *ids, *inactive, *invisible;
    size_t count, inactive_count, invisible_count;
} Points;

// Reads an array that must have one element for each instance; others are reported and ignored.
static void read_per_instance(const CohortAdapter *a, const CohortPrim *prim, const char *name,
                              uint32_t components, size_t count, CohortPull *pull, CoFloats *out)
{
    if (!co_values_read(a, prim, name, pull, out) || out->count == 0) {
        *out = (CoFloats){0};
        return;
    }
    if (out->count == count && out->components == components)
        return;
    char value[64];
    snprintf(value, sizeof value, "%zu elements for %zu instances", out->count, count);
    co_adapter_report(a, prim, name, value, "ignored");
    *out = (CoFloats){0};
}

static const int64_t *read_ids(const CohortValue *value, size_t *count)
{
    *count = value->type == COHORT_TYPE_INT64 ? value->count : 0;
    return *count ? value->data : NULL;
}

static int compare_ids(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return x < y ? -1 : x > y;
}

// A sorted copy, to search in.
static const int64_t *sorted_ids(const CohortValue *value, CohortPull *pull, size_t *count)
{
    const int64_t *ids = read_ids(value, count);
    int64_t *copy = ids ? cohort_pull_array(pull, *count, sizeof *copy) : NULL;
    if (!copy) {
        *count = 0;
        return NULL;
    }
    memcpy(copy, ids, *count * sizeof *copy);
    qsort(copy, *count, sizeof *copy, compare_ids);
    return copy;
}

// Per-instance displayColor; a constant one is inherited by the prototypes' meshes.
static void read_colors(const CohortAdapter *a, const CohortPrim *prim, CohortPull *pull,
                        Points *points)
{
    static const char name[] = "primvars:displayColor";
    CohortValue value;
    if (!cohort_prim_attribute_metadata(prim, name, "interpolation", &value) ||
        strcmp(co_values_text(&value), "constant") == 0 ||
        strcmp(co_values_text(&value), "uniform") == 0)
        return;
    size_t index_count;
    points->color_indices = co_values_ints(a, prim, "primvars:displayColor:indices", &index_count);
    if (!points->color_indices) {
        read_per_instance(a, prim, name, 3, points->count, pull, &points->colors);
        return;
    }
    bool ok = index_count == points->count &&
              co_values_read(a, prim, name, pull, &points->colors) &&
              points->colors.components == 3;
    for (size_t i = 0; ok && i < index_count; i++)
        ok = points->color_indices[i] >= 0 &&
             (size_t)points->color_indices[i] < points->colors.count;
    if (!ok) {
        co_adapter_report(a, prim, name, "indices", "do not fit the instances: ignored");
        points->colors = (CoFloats){0};
    }
}

static void report_ignored(const CohortAdapter *a, const CohortPrim *prim)
{
    size_t count = cohort_prim_property_count(prim);
    for (size_t i = 0; i < count; i++) {
        const char *name = cohort_prim_property_name(prim, i);
        CohortValue value;
        bool is_motion = strcmp(name, "velocities") == 0 || strcmp(name, "accelerations") == 0 ||
                         strcmp(name, "angularVelocities") == 0;
        if (is_motion && cohort_prim_value(prim, name, a->time, &value) && value.count)
            co_adapter_report(a, prim, name, "", "no motion blur");
        if (co_starts_with(name, "primvars:") && !co_starts_with(name, "primvars:displayColor") &&
            cohort_prim_attribute_metadata(prim, name, "interpolation", &value) &&
            strcmp(co_values_text(&value), "constant") != 0)
            co_adapter_report(a, prim, name, co_values_text(&value),
                              "no primvars per instance but displayColor");
    }
}

static bool read_points(const CohortAdapter *a, const CohortPrim *prim, CohortPull *pull,
                        Points *points, CohortError *err)
{
    points->indices = co_values_ints(a, prim, "protoIndices", &points->count);
    if (points->count == 0)
        return true;
    read_per_instance(a, prim, "positions", 3, points->count, pull, &points->positions);
    CO_CHECK(points->positions.count, err, COHORT_ERROR_SCENE,
             "positions and protoIndices differ in length");
    read_per_instance(a, prim, "orientationsf", 4, points->count, pull, &points->orientations);
    if (!points->orientations.count)
        read_per_instance(a, prim, "orientations", 4, points->count, pull, &points->orientations);
    read_per_instance(a, prim, "scales", 3, points->count, pull, &points->scales);
    CohortValue value;
    size_t id_count = 0;
    if (cohort_prim_value(prim, "ids", a->time, &value))
        points->ids = read_ids(&value, &id_count);
    if (id_count && id_count != points->count) {
        co_adapter_report(a, prim, "ids", "", "another length than protoIndices: ignored");
        points->ids = NULL;
    }
    if (cohort_prim_metadata(prim, "inactiveIds", &value))
        points->inactive = sorted_ids(&value, pull, &points->inactive_count);
    if (cohort_prim_value(prim, "invisibleIds", a->time, &value))
        points->invisible = sorted_ids(&value, pull, &points->invisible_count);
    read_colors(a, prim, pull, points);
    report_ignored(a, prim);
    return true;
}

static bool holds(const int64_t *ids, size_t count, int64_t id)
{
    return count && bsearch(&id, ids, count, sizeof id, compare_ids);
}

// Scale, then orientation (x, y, z, w), then position, as row vectors.
static void instance_matrix(const Points *points, size_t i, double m[4][4])
{
    double x = 0.0, y = 0.0, z = 0.0, w = 1.0;
    if (points->orientations.count) {
        const float *q = points->orientations.values + 4 * i;
        double length = sqrt((double)q[0] * (double)q[0] + (double)q[1] * (double)q[1] +
                             (double)q[2] * (double)q[2] + (double)q[3] * (double)q[3]);
        if (length > 0.0 && isfinite(length)) {
            x = (double)q[0] / length;
            y = (double)q[1] / length;
            z = (double)q[2] / length;
            w = (double)q[3] / length;
        }
    }
    const double rotation[3][3] = {
        {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (z * x - y * w)},
        {2.0 * (x * y - z * w), 1.0 - 2.0 * (z * z + x * x), 2.0 * (y * z + x * w)},
        {2.0 * (z * x + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (y * y + x * x)}};
    for (int r = 0; r < 3; r++) {
        double scale =
            points->scales.count ? (double)points->scales.values[3 * i + (size_t)r] : 1.0;
        for (int c = 0; c < 3; c++)
            m[r][c] = scale * rotation[r][c];
        m[3][r] = (double)points->positions.values[3 * i + (size_t)r];
    }
    m[3][3] = 1.0;
}

static bool is_finite_matrix(const double m[4][4])
{
    for (int i = 0; i < 16; i++)
        if (!isfinite(m[i / 4][i % 4]))
            return false;
    return true;
}

// The prototype entry of instance i, INVALID where there is none or the instance is inactive.
static uint32_t entry_of(const CohortAdapter *a, const CoRecord *record, const Points *points,
                         size_t i)
{
    int64_t id = points->ids ? points->ids[i] : (int64_t)i;
    int32_t index = points->indices[i];
    if (index < 0 || (size_t)index >= record->placed_count) {
        char value[32];
        snprintf(value, sizeof value, "%d", (int)index);
        co_adapter_report(a, record->prim, "protoIndices", value, "no such prototype: left out");
        return COHORT_INVALID_ID;
    }
    if (holds(points->inactive, points->inactive_count, id))
        return COHORT_INVALID_ID;
    return record->placed[index];
}

static bool pull_points(CohortAdapter *a, const CoRecord *record, CohortPull *pull,
                        CohortInstancerSource *out, CohortError *err)
{
    Points points = {0};
    if (!read_points(a, record->prim, pull, &points, err))
        return false;
    double(*transforms)[4][4] = cohort_pull_array(pull, points.count, sizeof *transforms);
    uint32_t *prototypes = cohort_pull_array(pull, points.count, sizeof *prototypes);
    uint8_t *hidden = cohort_pull_array(pull, points.count, 1);
    float *colors = cohort_pull_array(pull, points.count, 3 * sizeof *colors);
    CO_CHECK(transforms && prototypes && hidden && colors, err, COHORT_ERROR_OUT_OF_MEMORY,
             "out of memory");
    size_t used = 0;
    for (size_t i = 0; i < points.count; i++) {
        prototypes[used] = entry_of(a, record, &points, i);
        if (prototypes[used] == COHORT_INVALID_ID)
            continue;
        instance_matrix(&points, i, transforms[used]);
        if (!is_finite_matrix((const double(*)[4])transforms[used])) {
            co_adapter_report(a, record->prim, "positions", "not finite", "instance left out");
            memset(transforms[used], 0, sizeof transforms[used]);
            continue;
        }
        hidden[used] = holds(points.invisible, points.invisible_count,
                             points.ids ? points.ids[i] : (int64_t)i);
        if (points.colors.count) {
            size_t c = points.color_indices ? (size_t)points.color_indices[i] : i;
            memcpy(colors + 3 * used, points.colors.values + 3 * c, 3 * sizeof *colors);
        }
        used++;
    }
    out->instance_count = used;
    out->prototypes = prototypes;
    out->hidden = hidden;
    out->display_colors = points.colors.count ? colors : NULL;
    return set_samples(pull, transforms, out, err);
}

bool co_pull_instancer(void *cookie, CohortPull *pull, const char *path, CohortInstancerSource *out,
                       CohortError *err)
{
    CohortAdapter *a = cookie;
    const CoRecord *record = co_record_find(a, path);
    CO_CHECK(record, err, COHORT_ERROR_INTERNAL, "the adapter knows no instancer at %.180s", path);
    out->prototype_owner = CO_PROTOTYPES_PATH;
    return record->kind == CO_RECORD_NATIVE_INSTANCES ? pull_native(a, record, pull, out, err)
                                                      : pull_points(a, record, pull, out, err);
}
