// Meshes and implicits, as the index pulls them.

#include "stage_adapter/adapter.h"

#include "base/error.h"
#include "geometry/implicit.h"
#include "index/index.h"

#include <stdio.h>
#include <string.h>

typedef struct Names {
    const char *name;
    int value;
} Names;

// The value of a token attribute by table; unknown tokens are reported and give the first value.
static int token_of(const CohortAdapter *a, const CohortPrim *prim, const char *attribute,
                    const Names *names)
{
    const char *authored = cohort_prim_token(prim, attribute, a->time, names[0].name);
    for (const Names *n = names; n->name; n++)
        if (strcmp(n->name, authored) == 0)
            return n->value;
    char action[80];
    snprintf(action, sizeof action, "treated as %s", names[0].name);
    co_adapter_report(a, prim, attribute, authored, action);
    return names[0].value;
}

static const Names schemes[] = {{"catmullClark", COHORT_SCHEME_CATMULL_CLARK},
                                {"loop", COHORT_SCHEME_LOOP},
                                {"bilinear", COHORT_SCHEME_BILINEAR},
                                {"none", COHORT_SCHEME_NONE},
                                {NULL, 0}};
static const Names boundaries[] = {{"edgeAndCorner", COHORT_BOUNDARY_EDGE_AND_CORNER},
                                   {"edgeOnly", COHORT_BOUNDARY_EDGE_ONLY},
                                   {"none", COHORT_BOUNDARY_NONE},
                                   {NULL, 0}};
static const Names fvar_rules[] = {{"cornersPlus1", COHORT_FVAR_CORNERS_PLUS1},
                                   {"", COHORT_FVAR_CORNERS_PLUS1},
                                   {"none", COHORT_FVAR_NONE},
                                   {"cornersOnly", COHORT_FVAR_CORNERS_ONLY},
                                   {"cornersPlus2", COHORT_FVAR_CORNERS_PLUS2},
                                   {"boundaries", COHORT_FVAR_BOUNDARIES},
                                   {"all", COHORT_FVAR_ALL},
                                   {NULL, 0}};
static const Names triangle_rules[] = {{"catmullClark", 0}, {"smooth", 1}, {NULL, 0}};
static const Names orientations[] = {{"rightHanded", 0}, {"leftHanded", 1}, {NULL, 0}};

// ---- Creases and corners -----------------------------------------------------------------------

static void read_corners(const CohortAdapter *a, const CohortPrim *prim, CohortPull *pull,
                         CohortMeshDesc *desc)
{
    CoFloats sharpness;
    size_t count;
    const int32_t *indices = co_values_ints(a, prim, "cornerIndices", &count);
    if (!count)
        return;
    if (!co_values_read(a, prim, "cornerSharpnesses", pull, &sharpness) ||
        sharpness.count != count) {
        co_adapter_report(a, prim, "cornerSharpnesses", "",
                          "another length than cornerIndices: no corners");
        return;
    }
    desc->corner_indices = indices;
    desc->corner_sharpnesses = sharpness.values;
    desc->corner_count = count;
}

static void read_creases(const CohortAdapter *a, const CohortPrim *prim, CohortPull *pull,
                         CohortMeshDesc *desc)
{
    size_t index_count, crease_count, total = 0, edges = 0;
    const int32_t *indices = co_values_ints(a, prim, "creaseIndices", &index_count);
    const int32_t *lengths = co_values_ints(a, prim, "creaseLengths", &crease_count);
    if (!index_count && !crease_count)
        return;
    bool ok = true;
    for (size_t i = 0; i < crease_count && ok; i++) {
        ok = lengths[i] >= 2 && (size_t)lengths[i] <= index_count;
        total += ok ? (size_t)lengths[i] : 0;
        edges += ok ? (size_t)lengths[i] - 1 : 0;
    }
    CoFloats sharpness = {0};
    ok = ok && total == index_count &&
         co_values_read(a, prim, "creaseSharpnesses", pull, &sharpness) &&
         (sharpness.count == crease_count || sharpness.count == edges);
    if (!ok) {
        co_adapter_report(a, prim, "creaseLengths", "", "creases do not add up: no creases");
        return;
    }
    desc->crease_indices = indices;
    desc->crease_index_count = index_count;
    desc->crease_lengths = lengths;
    desc->crease_count = crease_count;
    desc->crease_sharpnesses = sharpness.values;
    desc->crease_sharpness_count = sharpness.count;
}

// ---- Subsets -----------------------------------------------------------------------------------

static bool is_material_subset(const CohortAdapter *a, const CohortPrim *prim)
{
    if (strcmp(cohort_prim_type(prim), "GeomSubset") != 0 ||
        strcmp(cohort_prim_token(prim, "familyName", a->time, ""), "materialBind") != 0)
        return false;
    const char *elements = cohort_prim_token(prim, "elementType", a->time, "face");
    if (strcmp(elements, "face") == 0)
        return true;
    co_adapter_report(a, prim, "elementType", elements, "subset left out");
    return false;
}

static bool read_subsets(const CohortAdapter *a, const CoRecord *record, CohortPull *pull,
                         CohortMeshSource *out, CohortError *err)
{
    size_t children = cohort_prim_child_count(record->prim);
    if (children == 0)
        return true;
    CohortSubsetDesc *subsets = cohort_pull_array(pull, children, sizeof *subsets);
    const char **materials = cohort_pull_array(pull, children, sizeof *materials);
    CO_CHECK(subsets && materials, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    size_t count = 0;
    for (size_t i = 0; i < children; i++) {
        CoPlace place = {cohort_prim_child(record->prim, i), record->prototype};
        if (!is_material_subset(a, place.prim))
            continue;
        const char *material = co_binding_resolve(a, place);
        const CoRecord *known = material ? co_record_find(a, material) : NULL;
        subsets[count].faces = co_values_ints(a, place.prim, "indices", &subsets[count].face_count);
        materials[count] = known ? known->path : NULL;
        if (subsets[count].face_count)
            count++;
    }
    out->mesh.subsets = subsets;
    out->mesh.subset_count = count;
    out->subset_materials = materials;
    return true;
}

// ---- Mesh --------------------------------------------------------------------------------------

static void report_motion(const CohortAdapter *a, const CohortPrim *prim)
{
    static const char *const names[] = {"velocities", "accelerations", "angularVelocities"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        CohortValue value;
        if (cohort_prim_value(prim, names[i], a->time, &value) && value.count)
            co_adapter_report(a, prim, names[i], "", "no motion blur");
    }
}

// Loop subdivides triangles only; Hydra draws other meshes of that scheme as they are.
static void check_loop(const CohortAdapter *a, const CohortPrim *prim, CohortMeshDesc *desc)
{
    for (size_t i = 0; desc->scheme == COHORT_SCHEME_LOOP && i < desc->face_count; i++) {
        if (desc->face_vertex_counts[i] == 3)
            continue;
        desc->scheme = COHORT_SCHEME_NONE;
        co_adapter_report(a, prim, "subdivisionScheme", "loop",
                          "not only triangles: not subdivided");
    }
}

static void read_topology(const CohortAdapter *a, const CohortPrim *prim, CohortPull *pull,
                          CohortMeshDesc *desc)
{
    desc->scheme = (CohortScheme)token_of(a, prim, "subdivisionScheme", schemes);
    desc->interpolate_boundary =
        (CohortInterpolateBoundary)token_of(a, prim, "interpolateBoundary", boundaries);
    desc->fvar_linear =
        (CohortFvarLinear)token_of(a, prim, "faceVaryingLinearInterpolation", fvar_rules);
    desc->triangle_rule_smooth = token_of(a, prim, "triangleSubdivisionRule", triangle_rules) != 0;
    desc->face_vertex_counts = co_values_ints(a, prim, "faceVertexCounts", &desc->face_count);
    desc->face_vertex_indices =
        co_values_ints(a, prim, "faceVertexIndices", &desc->face_vertex_index_count);
    desc->hole_indices = co_values_ints(a, prim, "holeIndices", &desc->hole_count);
    check_loop(a, prim, desc);
    read_creases(a, prim, pull, desc);
    read_corners(a, prim, pull, desc);
}

static bool set_points(CohortPull *pull, const float *points, CohortMeshSource *out,
                       CohortError *err)
{
    CohortPointsSample *sample = cohort_pull_array(pull, 1, sizeof *sample);
    CO_CHECK_MEMORY(sample, err);
    sample->points = points;
    out->points = sample;
    out->points_sample_count = 1;
    return true;
}

// ptexFaceOffset is a constant primvar, so it may stand above the mesh.
static uint32_t ptex_offset(const CohortAdapter *a, const CoRecord *record)
{
    CoPlace place = {record->prim, record->prototype};
    do {
        double offset = cohort_prim_double(place.prim, "primvars:ptexFaceOffset", a->time, -1.0);
        if (offset >= 0.0 && offset < 4294967296.0)
            return (uint32_t)offset;
    } while (co_place_up(a, &place));
    return 0;
}

// RenderMan's, Arnold's and our own names for the rays that meet a prim. Constant primvars: the
// nearest above counts.
static uint32_t hidden_from(const CohortAdapter *a, const CoRecord *record)
{
    static const struct {
        const char *name;
        uint32_t bit;
    } names[] = {{"primvars:cohort:visibility:camera", COHORT_HIDDEN_FROM_CAMERA},
                 {"primvars:cohort:visibility:shadow", COHORT_HIDDEN_FROM_SHADOW},
                 {"primvars:cohort:visibility:indirect", COHORT_HIDDEN_FROM_INDIRECT},
                 {"primvars:ri:attributes:visibility:camera", COHORT_HIDDEN_FROM_CAMERA},
                 {"primvars:ri:attributes:visibility:transmission", COHORT_HIDDEN_FROM_SHADOW},
                 {"primvars:ri:attributes:visibility:indirect", COHORT_HIDDEN_FROM_INDIRECT},
                 {"primvars:ri:visibility:camera", COHORT_HIDDEN_FROM_CAMERA},
                 {"primvars:ri:visibility:transmission", COHORT_HIDDEN_FROM_SHADOW},
                 {"primvars:ri:visibility:indirect", COHORT_HIDDEN_FROM_INDIRECT},
                 {"primvars:arnold:visibility:camera", COHORT_HIDDEN_FROM_CAMERA},
                 {"primvars:arnold:visibility:shadow", COHORT_HIDDEN_FROM_SHADOW}};
    uint32_t hidden = 0, known = 0;
    CoPlace place = {record->prim, record->prototype};
    do {
        for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
            double value = cohort_prim_double(place.prim, names[i].name, a->time, -1.0);
            if (value < 0.0 || known & names[i].bit)
                continue;
            known |= names[i].bit;
            hidden |= value == 0.0 ? names[i].bit : 0u;
        }
    } while (co_place_up(a, &place));
    return hidden;
}

static bool pull_polygons(CohortAdapter *a, const CoRecord *record, CohortPull *pull,
                          CohortMeshSource *out, CohortError *err)
{
    CoFloats points = {0};
    read_topology(a, record->prim, pull, &out->mesh);
    if (co_values_read(a, record->prim, "points", pull, &points)) {
        CO_CHECK(points.components == 3, err, COHORT_ERROR_SCENE, "points are no 3-vectors");
        out->mesh.point_count = points.count;
    }
    CO_CHECK(points.count, err, COHORT_ERROR_SCENE, "the mesh has no points");
    report_motion(a, record->prim);
    return set_points(pull, points.values, out, err) && read_subsets(a, record, pull, out, err);
}

bool co_pull_mesh(void *cookie, CohortPull *pull, const char *path, CohortMeshSource *out,
                  CohortError *err)
{
    CohortAdapter *a = cookie;
    const CoRecord *record = co_record_find(a, path);
    CO_CHECK(record && record->kind == CO_RECORD_MESH, err, COHORT_ERROR_INTERNAL,
             "the adapter knows no mesh at %.180s", path);
    bool is_implicit = co_is_implicit_type(cohort_prim_type(record->prim));
    bool ok = is_implicit ? co_pull_implicit(a, record, pull, out, err)
                          : pull_polygons(a, record, pull, out, err);
    out->mesh.left_handed = token_of(a, record->prim, "orientation", orientations) != 0;
    out->mesh.ptex_face_offset = ptex_offset(a, record);
    out->hidden_from = hidden_from(a, record);
    out->material = record->material;
    return ok && co_pull_primvars(a, record, pull, out, err);
}

// ---- Implicits ---------------------------------------------------------------------------------

static const struct {
    const char *type;
    CoImplicit kind;
    double height, radius; // UsdGeom's fallbacks
} implicits[] = {
    {"Sphere", CO_IMPLICIT_SPHERE, 0.0, 1.0},       {"Cube", CO_IMPLICIT_CUBE, 0.0, 0.0},
    {"Cone", CO_IMPLICIT_CONE, 2.0, 1.0},           {"Cylinder", CO_IMPLICIT_CYLINDER, 2.0, 1.0},
    {"Cylinder_1", CO_IMPLICIT_CYLINDER, 2.0, 1.0}, {"Capsule", CO_IMPLICIT_CAPSULE, 1.0, 0.5},
    {"Capsule_1", CO_IMPLICIT_CAPSULE, 1.0, 0.5},   {"Plane", CO_IMPLICIT_PLANE, 0.0, 0.0}};

static size_t implicit_of(const char *type)
{
    size_t count = sizeof implicits / sizeof implicits[0];
    for (size_t i = 0; i < count; i++)
        if (strcmp(implicits[i].type, type) == 0)
            return i;
    return count;
}

bool co_is_implicit_type(const char *type)
{
    return implicit_of(type) < sizeof implicits / sizeof implicits[0];
}

bool co_pull_implicit(CohortAdapter *a, const CoRecord *record, CohortPull *pull,
                      CohortMeshSource *out, CohortError *err)
{
    const CohortPrim *prim = record->prim;
    size_t i = implicit_of(cohort_prim_type(prim));
    static const Names axes[] = {{"Z", 2}, {"X", 0}, {"Y", 1}, {NULL, 0}};
    double radius = cohort_prim_double(prim, "radius", a->time, implicits[i].radius);
    CoImplicitDesc desc = {
        .kind = implicits[i].kind,
        .axis = token_of(a, prim, "axis", axes),
        .radius_bottom = cohort_prim_double(prim, "radiusBottom", a->time, radius),
        .radius_top = cohort_prim_double(prim, "radiusTop", a->time, radius),
        .height = cohort_prim_double(prim, "height", a->time, implicits[i].height),
        .size = cohort_prim_double(prim, "size", a->time, 2.0),
        .width = cohort_prim_double(prim, "width", a->time, 2.0),
        .length = cohort_prim_double(prim, "length", a->time, 2.0)};
    return co_implicit_mesh(&desc, record->path, &pull->arena, &out->mesh, err) &&
           set_points(pull, out->mesh.points, out, err);
}
