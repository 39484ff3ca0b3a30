// The renderer's side of a CohortScene: what edits leave behind and what a commit makes of it.

#ifndef CO_INTEGRATE_SCENE_DATA_H
#define CO_INTEGRATE_SCENE_DATA_H

#include "accel/accel.h"
#include "base/arena.h"
#include "color/color.h"
#include "light/light.h"
#include "texture/texture.h"

enum {
    CO_MATERIAL_LOOKUPS_MAX = 16
};

typedef enum CoObjectKind {
    CO_OBJECT_EMPTY = 0,
    CO_OBJECT_MESH,
    CO_OBJECT_GROUP
} CoObjectKind;

typedef enum CoVisit {
    CO_VISIT_NEW = 0,
    CO_VISIT_OPEN, // on the way down: meeting it again is a cycle
    CO_VISIT_DONE
} CoVisit;

// A placement of a group that holds those of groups within it, see co_scene_nest.
typedef struct CoPart {
    CohortInstanceDesc desc;
    const float *firm_color; // as display_color, for meshes that have one of their own
} CoPart;

// One object as edited, and its structures once committed.
typedef struct CoSceneObject {
    CoObjectKind kind;
    bool is_dirty;    // edited since the last commit
    CoVisit visit;    // state of the walk for cycles and build order
    double origin[3]; // mesh: subtracted from its points, so that far-away points keep their bits
    CoMesh mesh;      // its materials are slots: 0 for faces in no subset, then the subsets
    uint32_t *materials; // mesh: [material_slots] material of each slot, COHORT_INVALID_ID = none
    uint32_t material_slots;
    CoBvh *bvh;
    bool is_deformed;          // mesh: bvh is of the points before the edit, and can be refitted
    bool is_settled;           // mesh: displaced, if its materials ask for that
    CohortInstanceDesc *edits; // group: as given; display_color points into edit_colors
    float *edit_colors;        // [edit_count][3]
    uint32_t edit_count;
    uint32_t height;     // group: above the highest object in it; 0: not in the scene
    bool is_merged;      // group: what it places stands in the groups that place it
    CoPart *parts;       // group with merged ones in it: all that stands in it; else NULL
    uint64_t part_count; // of a merged group, what `parts` would be
    CoTop *top;
    CoInstance *instances; // group: those that show
    uint32_t *edit_of;     // group: index into what is placed in it, per shown instance
    uint32_t instance_count, instance_capacity;
    CoVec3 box_min, box_max; // object space
} CoSceneObject;

// Where one input of a material comes from.
typedef struct CoInputSource {
    CohortInputKind kind;
    uint32_t lookup, channel; // texture
    const char *primvar;      // primvar
    float value[4];
} CoInputSource;

// One texture node of a material, compiled.
typedef struct CoLookupSource {
    uint32_t texture; // scene's texture id
    bool is_ptex;
    const char *st_primvar;
    float st_fallback[2];
    float m[2][3]; // st' = m * (s, t, 1)
    float scale[4], bias[4];
} CoLookupSource;

typedef enum CoMaterialInput {
    CO_INPUT_DIFFUSE = 0,
    CO_INPUT_EMISSIVE,
    CO_INPUT_SPECULAR,
    CO_INPUT_METALLIC,
    CO_INPUT_ROUGHNESS,
    CO_INPUT_CLEARCOAT,
    CO_INPUT_CLEARCOAT_ROUGHNESS,
    CO_INPUT_OPACITY,
    CO_INPUT_IOR,
    CO_INPUT_NORMAL,
    CO_INPUT_COUNT
} CoMaterialInput;

typedef struct CoMaterial {
    CoArena arena;       // names
    const float *rec709; // 3x3 into the rendering space, set by the commit; NULL: the same
    bool is_set;
    CoInputSource inputs[CO_INPUT_COUNT];
    CoInputSource displacement;
    CoLookupSource lookups[CO_MATERIAL_LOOKUPS_MAX];
    uint32_t lookup_count; // those that hits need; displacement's alone lies behind them
    float opacity_threshold;
    bool is_lambert, use_specular_workflow, opacity_presence;
    bool may_pass;   // opacity below one is possible: rays may go straight through
    bool has_normal; // the normal input is connected
    bool displaces;
    bool reads_ptex; // some lookup is of a Ptex texture
} CoMaterial;

// A camera in the render frame.
typedef struct CoCamera {
    CoVec3 origin, right, up, back; // unit axes; looks along -back
    double window[4];               // left, right, bottom, top
    bool is_orthographic;
    float clip_near, clip_far, lens_radius, focus_distance;
} CoCamera;

typedef struct CoWarning {
    char *place, *text; // in the scene's `names` arena
    uint64_t count;
    CohortSeverity severity;
} CoWarning;

struct CohortScene {
    CoSceneObject *objects;
    uint32_t object_count, object_capacity;
    CohortTextureDesc *texture_descs; // strings in `names`
    uint32_t texture_count, texture_capacity;
    CoMaterial *materials;
    uint32_t material_count, material_capacity;
    CohortLightDesc *light_descs; // strings in `names`
    uint32_t light_count, light_capacity;
    CohortCameraDesc camera_desc;
    bool has_camera;
    CoArena names;
    CoWarning *warnings;
    uint32_t warning_count, warning_capacity;
    CohortDiagnostic *diagnostics; // the caller's view of `warnings`
    uint32_t diagnostic_capacity;
    bool lights_dirty, camera_dirty;

    // Committed.
    CoColor *color;
    CoTextures *textures;
    uint32_t *texture_ids; // scene texture id -> CoTextures id
    uint32_t texture_id_capacity;
    uint32_t textures_added; // how many of them are valid
    CoLights *lights;
    double lights_frame[3]; // the frame they were built in
    CoLightImage *light_images;
    uint32_t light_image_count;
    CoObject *accel_objects;
    uint32_t accel_object_count;
    CoAccelScene accel;
    CoCamera camera;
    double frame[3]; // render = world - frame
    double box[6];   // world: min, max
    bool has_box, is_committed;
    float rec709[9];  // linear Rec.709 -> rendering space, row-major
    bool converts;    // and whether that changes anything
    bool has_cutouts; // some material or unbound mesh may pass rays
    bool has_lookups; // some material looks textures up
    uint64_t path_count;
    CohortSceneCounts counts;
};

// What is placed in a group.
static inline uint32_t co_scene_placed_count(const CoSceneObject *group)
{
    return group->parts ? (uint32_t)group->part_count : group->edit_count;
}

static inline const CohortInstanceDesc *co_scene_placed(const CoSceneObject *group, uint32_t i)
{
    return group->parts ? &group->parts[i].desc : &group->edits[i];
}

// Adds a warning, merging repeats. A warning lost for lack of memory is only that.
void co_scene_warn(CohortScene *scene, CohortSeverity severity, const char *place,
                   const char *text);

// Copies a string into the scene; NULL and failure give NULL.
const char *co_scene_string(CohortScene *scene, const char *text);

// Frees what a commit made of an object; the edit stays.
void co_scene_object_release(CoSceneObject *object);

// Makes room for one more element in an array that grows by doubling. False when out of memory.
bool co_scene_grow(void **array, uint32_t *capacity, uint32_t count, size_t element_size);

// The material in a slot of a mesh; NULL where none is bound or it was never set.
static inline const CoMaterial *co_scene_material(const CohortScene *scene, uint32_t object,
                                                  uint32_t slot)
{
    uint32_t id = scene->objects[object].materials[slot];
    return id < scene->material_count && scene->materials[id].is_set ? &scene->materials[id] : NULL;
}

// Steps of cohort_scene_commit, in the files of their names.
// Measures how deep groups nest and chooses those to be merged, so that no more stand within each
// other than can be traced; where the choice is another than before, all are dirty. False for
// circles.
bool co_scene_nest(CohortScene *scene, CohortError *err);
// Fills the parts of a group, whose old ones are released; those that it places are done.
bool co_scene_list_parts(CohortScene *scene, CoSceneObject *group, CohortError *err);
// Needs textures, before objects.
bool co_scene_displace(CohortScene *scene, const volatile int *stop, CohortError *err);
bool co_scene_commit_objects(CohortScene *scene, const volatile int *stop, CohortError *err);
bool co_scene_commit_textures(CohortScene *scene, const CohortSceneOptions *options,
                              CohortError *err);
bool co_scene_commit_lights(CohortScene *scene, CohortError *err);
bool co_scene_commit_camera(CohortScene *scene, CohortError *err);

#endif
