// The renderer's scene: objects, instances, materials, textures, lights and a camera, as arrays.
//
// A scene is edited between renders, then committed; a commit rebuilds only what was edited. Every
// array given to a call is copied before it returns. Ids are small integers, never reused while the
// scene lives. Space: scene units as authored, double transforms in USD's row-vector convention
// (p' = p * M, translation in the last row). Colors of lights are linear in the rendering color
// space; those of materials and displayColor are linear Rec.709 and are brought there, textures by
// their own color space.
//
// Threads: one thread edits at a time; nothing may be edited while a render of the scene runs.

#ifndef COHORT_SCENE_H
#define COHORT_SCENE_H

#include "cohort/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct CohortScene CohortScene;

// ---- Objects: meshes and groups -------------------------------------------------------------

typedef enum CohortScheme {
    COHORT_SCHEME_CATMULL_CLARK = 0,
    COHORT_SCHEME_LOOP,
    COHORT_SCHEME_BILINEAR,
    COHORT_SCHEME_NONE // polygons
} CohortScheme;

typedef enum CohortInterpolateBoundary {
    COHORT_BOUNDARY_EDGE_AND_CORNER = 0,
    COHORT_BOUNDARY_EDGE_ONLY,
    COHORT_BOUNDARY_NONE
} CohortInterpolateBoundary;

typedef enum CohortFvarLinear {
    COHORT_FVAR_CORNERS_PLUS1 = 0,
    COHORT_FVAR_NONE,
    COHORT_FVAR_CORNERS_ONLY,
    COHORT_FVAR_CORNERS_PLUS2,
    COHORT_FVAR_BOUNDARIES,
    COHORT_FVAR_ALL
} CohortFvarLinear;

typedef enum CohortInterpolation {
    COHORT_INTERPOLATION_CONSTANT = 0, // 1 value
    COHORT_INTERPOLATION_UNIFORM,      // 1 per face
    COHORT_INTERPOLATION_VARYING,      // 1 per point, always linear
    COHORT_INTERPOLATION_VERTEX,       // 1 per point, follows the scheme
    COHORT_INTERPOLATION_FACE_VARYING  // 1 per face-vertex, indexed topology kept
} CohortInterpolation;

// One primvar, without the "primvars:" prefix. "normals" (3 components) gives the shading normals
// of polygon meshes and is ignored on subdivision meshes.
typedef struct CohortPrimvarDesc {
    const char *name;
    CohortInterpolation interpolation;
    uint32_t components;    // 1 to 4
    const float *values;    // [value_count * components]
    size_t value_count;     // elements
    const int32_t *indices; // [index_count] into values, or NULL: values are in order
    size_t index_count;
} CohortPrimvarDesc;

// A GeomSubset of family materialBind: its faces take another material.
typedef struct CohortSubsetDesc {
    const int32_t *faces; // [face_count] face numbers of the whole mesh
    size_t face_count;
    uint32_t material;
} CohortSubsetDesc;

// A mesh as UsdGeomMesh has it. Zero is the default of every option.
typedef struct CohortMeshDesc {
    const char *path; // for messages; copied
    CohortScheme scheme;
    CohortInterpolateBoundary interpolate_boundary;
    CohortFvarLinear fvar_linear;
    bool triangle_rule_smooth; // triangleSubdivisionRule = smooth
    bool left_handed;
    uint32_t level; // subdivision level, 0 = the cage's faces at limit positions; most 10
    // Where an edge shall be finer than `level`: [face_vertex_index_count] for the edge from each
    // face-vertex to the next of its face. Of faces that disagree on an edge the finest counts.
    // NULL: all are the same. Inside, a face is as fine as its finest edge, or, if that is finer,
    // as `face_levels` says ([face_count] or NULL).
    const uint8_t *edge_levels, *face_levels;
    const float *points; // [point_count * 3], object space
    size_t point_count;
    const int32_t *face_vertex_counts; // [face_count]
    size_t face_count;
    const int32_t *face_vertex_indices; // [face_vertex_index_count]
    size_t face_vertex_index_count;
    const int32_t *hole_indices;
    size_t hole_count;
    const int32_t *crease_indices;
    size_t crease_index_count;
    const int32_t *crease_lengths;
    size_t crease_count;
    const float *crease_sharpnesses; // one per crease or one per edge; 10 or more is infinite
    size_t crease_sharpness_count;
    const int32_t *corner_indices;
    const float *corner_sharpnesses;
    size_t corner_count;
    const CohortPrimvarDesc *primvars;
    size_t primvar_count;
    const CohortSubsetDesc *subsets;
    size_t subset_count;
    uint32_t material;         // COHORT_INVALID_ID: Lambertian with the primvars displayColor
                               // and displayOpacity
    uint32_t ptex_face_offset; // added to the Ptex face id (ptexFaceOffset)
} CohortMeshDesc;

// Rays that do not meet what is hidden from them.
typedef enum CohortHidden {
    COHORT_HIDDEN_FROM_CAMERA = 2,
    COHORT_HIDDEN_FROM_SHADOW = 4,  // light samples
    COHORT_HIDDEN_FROM_INDIRECT = 8 // all others: reflection, refraction, diffuse bounces
} CohortHidden;

// One placement of an object inside a group.
typedef struct CohortInstanceDesc {
    uint32_t object;        // a mesh or a group
    double transform[4][4]; // object to group (to world for the root)
    int32_t prim_id;        // what the primId AOV shows; -1 inherits from the enclosing instance
    bool hidden;            // takes no part in anything
    uint32_t hidden_from;   // CohortHidden bits
    const float *display_color; // 3 floats replacing the mesh's displayColor, or NULL
    bool color_yields;          // display_color is for meshes without displayColor alone
} CohortInstanceDesc;

// An empty scene. NULL when out of memory.
CohortScene *cohort_scene_create(CohortError *err);

// Frees a scene and all that was made of it; no render may have it any more. NULL is allowed.
void cohort_scene_destroy(CohortScene *scene);

// A new object id, empty until set. COHORT_INVALID_ID when out of memory.
uint32_t cohort_scene_new_object(CohortScene *scene, CohortError *err);

// Makes the object this mesh. Structural faults (index out of range, counts that do not add up, no
// finite point) are errors naming desc->path; repairable ones are warnings (cohort_scene_warnings).
// On failure the object is empty and renders as nothing.
bool cohort_scene_set_mesh(CohortScene *scene, uint32_t object, const CohortMeshDesc *desc,
                           CohortError *err);

// Gives a mesh other materials and rebuilds nothing. `subset_materials` has one id for each subset
// that the mesh was set with, in their order.
bool cohort_scene_set_mesh_materials(CohortScene *scene, uint32_t object, uint32_t material,
                                     const uint32_t *subset_materials, size_t subset_count,
                                     CohortError *err);

// Makes the object a group: instances of other objects, which must not lead back to it. Object 0 is
// the root group and exists from the start.
bool cohort_scene_set_group(CohortScene *scene, uint32_t object,
                            const CohortInstanceDesc *instances, size_t count, CohortError *err);

// Tells every placement of every mesh that is not hidden, as the groups now stand: object to world.
typedef void CohortPlacementFn(void *cookie, uint32_t object, const double transform[4][4]);
void cohort_scene_placements(const CohortScene *scene, CohortPlacementFn *fn, void *cookie);

// Empties an object; its id stays taken.
void cohort_scene_clear_object(CohortScene *scene, uint32_t object);

// ---- Textures and materials ------------------------------------------------------------------

typedef enum CohortWrap {
    COHORT_WRAP_USE_METADATA = 0, // the file's own wrap modes, else black
    COHORT_WRAP_BLACK,
    COHORT_WRAP_CLAMP,
    COHORT_WRAP_REPEAT,
    COHORT_WRAP_MIRROR
} CohortWrap;

typedef enum CohortColorSpace {
    // The file's metadata, else the file rules of the OCIO config but for its Default rule, else
    // sRGB for 8-bit RGB(A), else raw. For an image of a light, chromaticities are metadata and it
    // is linear Rec.709 instead of raw.
    COHORT_COLOR_AUTO = 0,
    COHORT_COLOR_RAW,
    COHORT_COLOR_SRGB,
    COHORT_COLOR_NAMED // a color space of the OCIO config, or one of USD's built-in names
} CohortColorSpace;

typedef enum CohortPtexFilter {
    COHORT_PTEX_BILINEAR = 0,
    COHORT_PTEX_BOX
} CohortPtexFilter;

typedef struct CohortTextureDesc {
    const char *path;  // resolved file; <UDIM> stays in it; a name ending in .ptx is Ptex
    const char *asset; // as authored, for messages
    bool is_ptex;
    CohortColorSpace color_space;
    const char *color_space_name; // for COHORT_COLOR_NAMED
    CohortWrap wrap_s, wrap_t;
    CohortPtexFilter ptex_filter;
    float fallback[4]; // when the file cannot be read
} CohortTextureDesc;

// What feeds one input of a material. Zero: the constant in `value`.
typedef enum CohortInputKind {
    COHORT_INPUT_CONSTANT = 0,
    COHORT_INPUT_PRIMVAR, // `primvar`, `value` where the mesh has none
    COHORT_INPUT_TEXTURE  // `lookup`
} CohortInputKind;

typedef struct CohortInput {
    CohortInputKind kind;
    float value[4];
    const char *primvar;
    uint32_t lookup;  // index into the material's lookups
    uint32_t channel; // 0-3 first channel taken of the lookup's rgba
} CohortInput;

// One texture node: out = texel * scale + bias, at st = transform(primvar st) or at the Ptex face.
typedef struct CohortLookupDesc {
    uint32_t texture;       // id from cohort_scene_new_texture
    const char *st_primvar; // UV textures; NULL = "st"
    float st_fallback[2];
    float st_scale[2], st_rotation_degrees,
        st_translation[2];   // UsdTransform2d; scale (0,0) = (1,1)
    float scale[4], bias[4]; // scale all zero = all one
} CohortLookupDesc;

// UsdPreviewSurface; cohort_material_default() gives its registry defaults.
typedef struct CohortMaterialDesc {
    const char *path;
    CohortInput diffuse_color, emissive_color, specular_color, metallic, roughness, clearcoat,
        clearcoat_roughness, opacity, ior, normal;
    // Scene units of the mesh, along its normals outward, taken once: at the first commit after
    // the mesh was set. To displace it otherwise, set it again. A texture that nothing else reads
    // should be the last lookup: hits then do not make it.
    CohortInput displacement;
    bool lambert; // diffuse, emission and cut-outs alone: no specular lobe, no coat
    bool use_specular_workflow;
    bool opacity_presence; // opacityMode = presence
    float opacity_threshold;
    const CohortLookupDesc *lookups;
    size_t lookup_count; // at most 16
} CohortMaterialDesc;

CohortMaterialDesc cohort_material_default(void);

// A new texture, which the commit opens: a file that cannot be read is a warning then, and its
// texels are `fallback`. Textures cannot be changed, and equal ones are not merged.
// COHORT_INVALID_ID when out of memory.
uint32_t cohort_scene_new_texture(CohortScene *scene, const CohortTextureDesc *desc,
                                  CohortError *err);

// A new material id, as if none were bound until it is set. COHORT_INVALID_ID when out of memory.
uint32_t cohort_scene_new_material(CohortScene *scene, CohortError *err);

// Gives a material its values. It stays what it was when this fails: out of memory, an id that is
// not there, more than 16 lookups.
bool cohort_scene_set_material(CohortScene *scene, uint32_t material,
                               const CohortMaterialDesc *desc, CohortError *err);

// ---- Lights ----------------------------------------------------------------------------------

typedef enum CohortLightType {
    COHORT_LIGHT_RECT = 0, // width x height in the xy plane, emits along -Z
    COHORT_LIGHT_DISK,     // radius, emits along -Z
    COHORT_LIGHT_SPHERE,   // radius
    COHORT_LIGHT_DISTANT,  // angle, shines along -Z
    COHORT_LIGHT_DOME      // surrounds everything, lat-long texture
} CohortLightType;

// UsdLux attributes, defaults by cohort_light_default(type). `color` is in the rendering space.
typedef struct CohortLightDesc {
    const char *path;
    CohortLightType type;
    double transform[4][4]; // light to world
    float color[3];
    float intensity, exposure;
    bool enable_color_temperature;
    float color_temperature; // kelvin
    bool normalize;
    float diffuse, specular;     // multipliers
    float width, height, radius; // scene units
    float angle_degrees;
    const char *texture_file;  // rect, dome; NULL = none
    const char *texture_asset; // as authored
    CohortColorSpace texture_color_space;
    const char *texture_color_space_name;
    float shaping_focus; // 0 = none
    float shaping_focus_tint[3];
    float shaping_cone_angle_degrees; // 90 = none
    float shaping_cone_softness;
    bool hidden;    // invisible: contributes nothing
    bool no_shadow; // no surface keeps its light from another; the camera sees it as any light
} CohortLightDesc;

CohortLightDesc cohort_light_default(CohortLightType type);

// A new light id, hidden until it is set. COHORT_INVALID_ID when out of memory.
uint32_t cohort_scene_new_light(CohortScene *scene, CohortError *err);

// Gives a light its values. What cannot shine (sizes or a transform that are not finite, a texture
// that cannot be read) is a warning of the commit. The light stays what it was when this fails: out
// of memory, an id that is not there.
bool cohort_scene_set_light(CohortScene *scene, uint32_t light, const CohortLightDesc *desc,
                            CohortError *err);

// ---- Camera ----------------------------------------------------------------------------------

typedef struct CohortCameraDesc {
    double transform[4][4]; // camera to world; looks down -Z, +Y up
    bool orthographic;
    // Image-plane window at distance 1 (perspective) or in scene units (orthographic): left, right,
    // bottom, top, after the conform policy.
    double window[4];
    double clip_near, clip_far; // scene units
    double lens_radius;         // scene units, 0 = pinhole
    double focus_distance;      // scene units, used when lens_radius > 0
} CohortCameraDesc;

// Sets the one camera. COHORT_ERROR_SCENE when its transform or window is not finite, or the window
// has no width or height; the camera stays what it was.
bool cohort_scene_set_camera(CohortScene *scene, const CohortCameraDesc *desc, CohortError *err);

// ---- Commit ----------------------------------------------------------------------------------

typedef struct CohortSceneOptions {
    const char *rendering_color_space; // NULL or "": the config's scene_linear role, else Rec.709
    const char *ocio_config;           // NULL: $OCIO, else none (linear Rec.709)
    const char *converted_folder;      // converted textures; NULL: a folder of the user's cache
    bool ptex_reductions_authored;     // take the file's own reductions
    uint64_t texture_memory;           // bytes of decoded texels that may stay resident; 0 = 1 GiB
    const volatile int *stop; // an int that any thread, or a signal handler, makes other than 0 to
                              // end the commit; NULL = none
} CohortSceneOptions;

// What the commits of a scene have rebuilt so far; each commit adds to it.
typedef struct CohortSceneCounts {
    uint64_t mesh_builds;    // tessellations and bottom-level BVHs
    uint64_t mesh_refits;    // of these, BVHs that only took new points
    uint64_t group_builds;   // top-level BVHs
    uint64_t group_refits;   // top-level BVHs that only took new boxes
    uint64_t material_binds; // cohort_scene_set_mesh_materials
    uint64_t light_builds, material_builds, camera_builds, texture_opens;
    uint64_t displaced_meshes, displaced_points;
    uint64_t triangle_count, mesh_count, instance_count; // of the scene as it stands
    uint64_t geometry_bytes, accel_bytes;
    // Of geometry_bytes; the rest are primvars and tables of faces.
    uint64_t point_bytes, topology_bytes, normal_bytes;
    // Of accel_bytes; the rest are the trees over instances.
    uint64_t node_bytes, leaf_bytes;
} CohortSceneCounts;

// Makes the edits effective. Missing textures and the like are warnings. Stopped, it ends with
// COHORT_ERROR_CANCELLED before the next texture, mesh or group; another commit goes on from there.
//   options  NULL: all defaults; copied, but for `stop`
// Other errors: _SCENE without a camera, _OUT_OF_MEMORY, _COLOR for a config or space,
// _INSTALLATION where no image can be read, _FILE_WRITE of scratch files.
bool cohort_scene_commit(CohortScene *scene, const CohortSceneOptions *options, CohortError *err);
void cohort_scene_counts(const CohortScene *scene, CohortSceneCounts *out);

// World-space box of the committed scene: min xyz, max xyz; false when it holds nothing.
bool cohort_scene_bounds(const CohortScene *scene, double box[6]);

// Diagnostics up to the last commit as data, repeats merged. Returns how many. Pointers live until
// the next edit or commit.
typedef struct CohortDiagnostic {
    CohortSeverity severity;
    const char *place; // prim path or file
    const char *text;
    uint64_t count;
} CohortDiagnostic;
size_t cohort_scene_warnings(const CohortScene *scene, const CohortDiagnostic **out);

#ifdef __cplusplus
}
#endif

#endif
