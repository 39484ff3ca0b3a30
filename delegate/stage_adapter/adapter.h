// The stage adapter's own picture of a stage: which prim stands where in the index, and why.
//
// Terms: record = one prim given to the index. Prototype = a subtree drawn wherever it is placed:
// the children of a native instance, or a target of a PointInstancer. Prims below a prototype are
// shared by all its placements; one prototype may need several entries when what it inherits from
// the places differs (bindings, purpose, constant primvars).

#ifndef CO_ADAPTER_H
#define CO_ADAPTER_H

#include "cohort/stage_adapter.h"
#include "index/string_map.h"
#include "math/vec.h"

#define CO_WORLD COHORT_INVALID_ID // the prototype number of what is drawn by itself

// The owner of all prototypes in the index.
#define CO_PROTOTYPES_PATH "/__cohort/prototypes"
#define CO_CAMERA_PATH "/__cohort/camera"
#define CO_HEADLIGHT_PATH "/__cohort/headlight"
#define CO_ENV_PATH COHORT_ENV_PATH

typedef enum CoRecordKind {
    CO_RECORD_MESH = 0, // and implicits
    CO_RECORD_POINT_INSTANCER,
    CO_RECORD_NATIVE_INSTANCES, // all native instances that stand in one prototype or in the world
    CO_RECORD_LIGHT,
    CO_RECORD_CAMERA,
    CO_RECORD_MATERIAL,
    CO_RECORD_FRAMING_CAMERA,
    CO_RECORD_HEADLIGHT,
    CO_RECORD_ENV
} CoRecordKind;

typedef struct CoRecord {
    CoRecordKind kind;
    const char *path;       // in the index
    const CohortPrim *prim; // NULL for what the adapter makes up and for native instances
    uint32_t prototype;     // it stands in
    const char *material;   // meshes: path in the index, NULL = none
    uint32_t *placed;       // point instancers: entry of each prototype target
    size_t placed_count;
    const char **needs; // materials: primvars whose readers have no fallback
    size_t need_count;
} CoRecord;

// One native instance to be placed.
typedef struct CoPlacement {
    const CohortPrim *prim; // the instance
    uint32_t within;        // prototype it stands in
    uint32_t prototype;     // it shows
} CoPlacement;

typedef struct CoPrototype {
    bool is_native;
    const CohortPrim *root;   // native: the instance whose children are shared; else the target
    const CohortPrim *anchor; // native: the instance from which its children inherit here
    uint32_t outer;           // prototype in which the anchor, or the target, stands
} CoPrototype;

struct CohortAdapter {
    CohortDelegate *delegate;
    CohortRenderIndex *index;
    CohortStage *stage;
    CohortStageInfo info;
    CohortSceneDelegate scene; // handed to the index
    CoArena arena;             // strings and lists, until destroy
    CohortAdapterOptions options;
    double time; // NAN = default values
    uint32_t purposes;
    CoRecord *records;
    size_t record_count, record_capacity;
    CoStringMap paths; // path in the index -> record
    CoPrototype *prototypes;
    size_t prototype_count, prototype_capacity;
    CoStringMap prototype_keys;
    CoPlacement *placements;
    size_t placement_count, placement_capacity;
    CoStringMap lights_below; // native prototype's path -> whether it holds lights
    CoStringMap primvars;     // names that materials read
    const char **cameras;
    size_t camera_count, camera_capacity;
    size_t light_count;
    const CohortPrim *settings_prim, *product_prim; // NULL = none
    CohortResolvedSettings resolved;
    double frame_box[6]; // what the framing camera shows
    const char *env_file;
    bool env_is_made; // the file is the adapter's own: a name of this descriptor
    int env_descriptor;
};

// ---- Ancestry (ancestry.c) ---------------------------------------------------------------------

// A prim as seen from one of its places: going up leaves a prototype through its anchor.
typedef struct CoPlace {
    const CohortPrim *prim;
    uint32_t prototype;
} CoPlace;

// The next place up; false at the top.
bool co_place_up(const CohortAdapter *adapter, CoPlace *place);

// Whether that step up from a place in prototype `inside` left a native instance.
bool co_place_left_native(const CohortAdapter *adapter, uint32_t inside, CoPlace place);

// Prim to world, or to the root of its prototype.
CoMat4d co_place_transform(const CohortAdapter *adapter, CoPlace place);
// Prim to world, through all prototypes.
CoMat4d co_place_world_transform(const CohortAdapter *adapter, CoPlace place);

// UsdGeomImageable: a prim without a type has neither visibility nor purpose, whatever it authors.
bool co_is_imageable(const CohortPrim *prim);

// Inherited visibility, up to the root of its prototype.
bool co_place_is_visible(const CohortAdapter *adapter, CoPlace place);

// The same through all prototypes up to the world: for lights.
bool co_place_is_visible_in_world(const CohortAdapter *adapter, CoPlace place);

// Whether an attribute whose name begins so has time samples at the place or above it.
bool co_place_varies(const CohortAdapter *adapter, CoPlace place, const char *prefix);

// ---- Bindings (binding.c) ----------------------------------------------------------------------

// Path of the material bound to a place: purpose full, then all-purpose; NULL = none.
const char *co_binding_resolve(const CohortAdapter *adapter, CoPlace place);

// A text that is equal for places whose descendants inherit equal bindings; false when it is too
// long.
bool co_binding_key(const CohortAdapter *adapter, CoPlace place, char *out, size_t size);

// ---- Values (values.c) -------------------------------------------------------------------------

typedef struct CoFloats {
    const float *values; // [count * components]
    size_t count;        // elements
    uint32_t components;
} CoFloats;

// Reads numbers of any precision as floats. False when there is no value or it is no number.
bool co_values_floats(const CohortValue *value, CohortPull *pull, CoFloats *out);
bool co_values_read(const CohortAdapter *adapter, const CohortPrim *prim, const char *name,
                    CohortPull *pull, CoFloats *out);
// Reads an int array; count 0 when there is none.
const int32_t *co_values_ints(const CohortAdapter *adapter, const CohortPrim *prim,
                              const char *name, size_t *count);
// The text of a token, string or asset value, "" for others.
const char *co_values_text(const CohortValue *value);
// Writes a short form of an authored value for the report.
void co_values_describe(const CohortValue *value, char *out, size_t size);

bool co_starts_with(const char *text, const char *prefix);

// ---- Walk (walk.c), records (records.c) --------------------------------------------------------

bool co_walk_stage(CohortAdapter *adapter, CohortError *err);

// Inserts a record; the path gets a suffix when it is taken by another place of the same prim.
// Pointers to records move. NULL when out of memory.
CoRecord *co_record_add(CohortAdapter *adapter, const CoRecord *record, CohortPrimType type,
                        CohortError *err);
const CoRecord *co_record_find(const CohortAdapter *adapter, const char *path);

// The material at a path, inserted when it is new: its path, or NULL when it is none (reported).
const char *co_record_material(CohortAdapter *adapter, CoPlace from, const char *path,
                               CohortError *err);

void co_adapter_report(const CohortAdapter *adapter, const CohortPrim *prim, const char *name,
                       const char *value, const char *action);

bool co_is_light_type(const char *type);

// ---- What the index pulls ----------------------------------------------------------------------

bool co_pull_mesh(void *cookie, CohortPull *pull, const char *path, CohortMeshSource *out,
                  CohortError *err);
bool co_pull_instancer(void *cookie, CohortPull *pull, const char *path, CohortInstancerSource *out,
                       CohortError *err);
bool co_pull_light(void *cookie, CohortPull *pull, const char *path, CohortLightDesc *out,
                   CohortError *err);
bool co_pull_camera(void *cookie, const char *path, CohortCameraSource *out, CohortError *err);
bool co_pull_material(void *cookie, CohortPull *pull, const char *path, CohortMaterialNetwork *out,
                      CohortError *err);

// Primvars of a mesh that something reads, its own and the constant ones it inherits.
bool co_pull_primvars(CohortAdapter *adapter, const CoRecord *record, CohortPull *pull,
                      CohortMeshSource *out, CohortError *err);

// A constant displayColor of the place or above it.
bool co_inherited_color(const CohortAdapter *adapter, CoPlace place, CohortPull *pull,
                        float color[3]);

// UsdGeom's implicits as meshes; false when the type is none.
bool co_is_implicit_type(const char *type);
bool co_pull_implicit(CohortAdapter *adapter, const CoRecord *record, CohortPull *pull,
                      CohortMeshSource *out, CohortError *err);

// ---- Settings, framing, sky --------------------------------------------------------------------

bool co_resolve_settings(CohortAdapter *adapter, CohortError *err); // before the walk
bool co_resolve_camera(CohortAdapter *adapter, CohortError *err);   // after it
void co_resolve_size(CohortAdapter *adapter);

// The framing camera's transform and lens (usdrecord's way: 50 mm, in front of the box).
CoMat4d co_frame_transform(const CohortAdapter *adapter);
void co_frame_camera(const CohortAdapter *adapter, CohortCameraSource *out);

// Writes the built-in sky as a Radiance file, horizon at the middle row, zenith on top.
bool co_sky_write(const char *path, CohortError *err);

#endif
