// What can be wrong with a prim by itself.

#include "check.h"

#include <math.h>
#include <string.h>

// ---- Paths
// ----------------------------------------------------------------------------------------
static void check_targets(Check *check, const CohortPrim *prim, const char *name)
{
    const char *const *paths = NULL;
    size_t count = cohort_prim_targets(prim, name, &paths);
    if (!count)
        count = cohort_prim_connections(prim, name, &paths);
    for (size_t i = 0; i < count; i++) {
        char path[4096];
        size_t length = strcspn(paths[i], ".");
        if (length >= sizeof path)
            continue;
        memcpy(path, paths[i], length);
        path[length] = 0;
        if (!cohort_stage_prim(check->stage, path))
            check_found(check, COHORT_SEVERITY_WARNING, prim, name, "there is no target <%s>",
                        paths[i]);
    }
}

static void check_assets(Check *check, const CohortPrim *prim, const char *name)
{
    const CohortAsset *assets;
    size_t count = cohort_prim_assets(prim, name, COHORT_TIME_DEFAULT, &assets);
    for (size_t i = 0; i < count; i++)
        if (*assets[i].authored && !*assets[i].resolved)
            check_found(check, COHORT_SEVERITY_ERROR, prim, name,
                        "@%s@ does not exist (looked for %s)", assets[i].authored,
                        assets[i].anchored);
}

// ---- Meshes
// ---------------------------------------------------------------------------------------
typedef struct MeshSizes {
    size_t points, faces, corners;
} MeshSizes;

static bool find_array(const CohortPrim *prim, const char *name, CohortValue *out)
{
    double earliest = 0;
    return cohort_prim_value(prim, name, COHORT_TIME_DEFAULT, out) ||
           cohort_prim_value(prim, name, earliest, out);
}

static void check_topology(Check *check, const CohortPrim *prim, MeshSizes *sizes)
{
    CohortValue points = {0}, counts = {0}, indices = {0};
    find_array(prim, "points", &points);
    if (!find_array(prim, "faceVertexCounts", &counts) || counts.type != COHORT_TYPE_INT ||
        !find_array(prim, "faceVertexIndices", &indices) || indices.type != COHORT_TYPE_INT) {
        check_found(check, COHORT_SEVERITY_WARNING, prim, NULL, "the mesh has no topology");
        return;
    }
    const int32_t *count = counts.data, *index = indices.data;
    int64_t total = 0;
    for (size_t i = 0; i < counts.count; i++) {
        if (count[i] < 3)
            check_found(check, COHORT_SEVERITY_ERROR, prim, "faceVertexCounts",
                        "face %zu has %d corners", i, count[i]);
        total += count[i];
        if (count[i] < 3)
            break; // one such face is enough to say so
    }
    *sizes = (MeshSizes){points.count, counts.count, indices.count};
    if (total >= 0 && (uint64_t)total != indices.count)
        check_found(check, COHORT_SEVERITY_ERROR, prim, "faceVertexIndices",
                    "%zu indices for faces with %lld corners", indices.count, (long long)total);
    for (size_t i = 0; i < indices.count; i++)
        if (index[i] < 0 || (size_t)index[i] >= points.count) {
            check_found(check, COHORT_SEVERITY_ERROR, prim, "faceVertexIndices",
                        "index %d at %zu is outside the %zu points", index[i], i, points.count);
            break;
        }
}

// How many elements an interpolation asks for; SIZE_MAX: any.
static size_t expected_count(const CohortString *interpolation, const MeshSizes *sizes)
{
    if (!strcmp(interpolation->text, "constant"))
        return 1;
    if (!strcmp(interpolation->text, "uniform"))
        return sizes->faces;
    if (!strcmp(interpolation->text, "faceVarying"))
        return sizes->corners;
    return sizes->points;
}

static void check_primvar(Check *check, const CohortPrim *prim, const char *name,
                          const MeshSizes *sizes)
{
    CohortValue value, interpolation, size;
    char indexed[1024];
    if (!find_array(prim, name, &value) || !value.is_array ||
        !cohort_prim_attribute_metadata(prim, name, "interpolation", &interpolation) ||
        interpolation.type != COHORT_TYPE_TOKEN || strlen(name) + 9 > sizeof indexed)
        return;
    size_t per_element = 1, expected = expected_count(interpolation.data, sizes);
    if (cohort_prim_attribute_metadata(prim, name, "elementSize", &size) &&
        size.type == COHORT_TYPE_INT && *(const int32_t *)size.data > 0)
        per_element = (size_t) * (const int32_t *)size.data;
    strcpy(indexed, name);
    strcat(indexed, ":indices");
    const char *counted = find_array(prim, indexed, &value) ? indexed : name;
    if (counted == indexed)
        per_element = 1;
    if (expected != 1 && value.count != expected * per_element)
        check_found(check, COHORT_SEVERITY_ERROR, prim, counted,
                    "%zu elements where %s interpolation asks for %zu", value.count,
                    ((const CohortString *)interpolation.data)->text, expected * per_element);
}

static void check_mesh(Check *check, const CohortPrim *prim)
{
    MeshSizes sizes = {0};
    check_topology(check, prim, &sizes);
    for (size_t i = 0; sizes.faces && i < cohort_prim_property_count(prim); i++) {
        const char *name = cohort_prim_property_name(prim, i), *end = strrchr(name, ':');
        bool is_indices = end && !strcmp(end, ":indices");
        if (!strcmp(name, "normals") || (!strncmp(name, "primvars:", 9) && !is_indices))
            check_primvar(check, prim, name, &sizes);
    }
}

// ---- Any prim
// -------------------------------------------------------------------------------------
static bool is_not_rendered(const char *type)
{
    static const char *const types[] = {
        "BasisCurves", "HermiteCurves", "NurbsCurves",   "NurbsPatch",  "Points",
        "TetMesh",     "Volume",        "ParticleField", "PointCloud",  "CylinderLight",
        "PortalLight", "GeometryLight", "PluginLight",   "LightFilter", "PluginLightFilter"};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (!strcmp(types[i], type))
            return true;
    return false;
}

void check_prim(Check *check, const CohortPrim *prim)
{
    const char *type = cohort_prim_type(prim);
    if (is_not_rendered(type))
        check_found(check, COHORT_SEVERITY_WARNING, prim, NULL, "a %s is not rendered", type);
    if (!strcmp(type, "Mesh"))
        check_mesh(check, prim);
    double matrix[4][4];
    bool resets;
    if (cohort_prim_local_transform(prim, 0, matrix, &resets))
        for (int i = 0; i < 16; i++)
            if (!isfinite(matrix[i / 4][i % 4])) {
                check_found(check, COHORT_SEVERITY_ERROR, prim, "xformOpOrder",
                            "the transform is not finite");
                break;
            }
    for (size_t i = 0; i < cohort_prim_property_count(prim); i++) {
        const char *name = cohort_prim_property_name(prim, i);
        check_targets(check, prim, name);
        check_assets(check, prim, name);
    }
}
