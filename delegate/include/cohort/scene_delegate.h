// What a host gives the render index: meshes, instancers, cameras, lights and material networks, by
// callbacks (Hydra's HdSceneDelegate).
//
// The index asks for what is dirty, while it syncs, and copies what it is told before it goes on to
// the next prim.
//
// Threads: callbacks run on the thread that calls cohort_render_index_sync or
// cohort_render_pass_execute, one at a time.

#ifndef COHORT_SCENE_DELEGATE_H
#define COHORT_SCENE_DELEGATE_H

#include "cohort/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

// Scratch memory of one pull. Everything a callback returns may be put here; it is freed when the
// prim has been synced. Zeroed, aligned to 16. NULL when out of memory or when the product
// overflows; the sync then fails, whatever the callback makes of it.
typedef struct CohortPull CohortPull;
void *cohort_pull_array(CohortPull *pull, size_t count, size_t size);

// A transform at a time. `time` is in frames relative to the frame rendered: 0 is the frame.
typedef struct CohortTransformSample {
    double time;
    double matrix[4][4]; // row vectors, translation in the last row
} CohortTransformSample;

typedef struct CohortPointsSample {
    double time;
    const float *points; // [mesh.point_count * 3], object space
} CohortPointsSample;

// A mesh. `mesh.points` and all material ids in `mesh` are ignored: points come as samples in
// ascending time, of which the one at time 0, else the nearest, is rendered; materials come as
// paths.
typedef struct CohortMeshSource {
    CohortMeshDesc mesh;
    const CohortPointsSample *points;
    size_t points_sample_count;
    const char *material;                // path in the index, NULL or "" = none
    const char *const *subset_materials; // [mesh.subset_count] paths
    uint32_t hidden_from;                // CohortHidden bits; a primvar's change brings others
} CohortMeshSource;

typedef struct CohortInstancesSample {
    double time;
    const double (*transforms)[4][4]; // [instance_count], prototype root to instancer
} CohortInstancesSample;

// Placements of an instancer's prototypes.
typedef struct CohortInstancerSource {
    size_t instance_count;
    const char *prototype_owner; // whose prototypes these are; NULL = the instancer's own
    const uint32_t *prototypes;  // [instance_count] prototype numbers, NULL = all 0
    const CohortInstancesSample *samples;
    size_t sample_count;
    const uint8_t *hidden;       // [instance_count], 1 = not drawn; NULL = all drawn
    const float *display_colors; // [instance_count * 3] or NULL
    const uint8_t *colored;      // [instance_count], 0 = its color is not to be used; NULL = all 1
    bool colors_yield;           // they are for meshes without a displayColor of their own
} CohortInstancerSource;

typedef enum CohortConformPolicy {
    COHORT_CONFORM_EXPAND_APERTURE = 0, // grow the aperture until it has the image's aspect
    COHORT_CONFORM_CROP_APERTURE,
    COHORT_CONFORM_ADJUST_WIDTH,
    COHORT_CONFORM_ADJUST_HEIGHT,
    COHORT_CONFORM_ADJUST_PIXEL_ASPECT // keep the aperture: stretches
} CohortConformPolicy;

// UsdGeomCamera's attributes, in its units; cohort_camera_source_default() gives its defaults. The
// delegate conforms the window to the image it renders.
typedef struct CohortCameraSource {
    bool orthographic;
    double horizontal_aperture, vertical_aperture; // tenths of a scene unit
    double horizontal_offset, vertical_offset;     // tenths of a scene unit
    double focal_length;                           // tenths of a scene unit
    double clip_near, clip_far;                    // scene units
    double f_stop;                                 // 0 = pinhole
    double focus_distance;                         // scene units
} CohortCameraSource;

CohortCameraSource cohort_camera_source_default(void);

// One input of a shading node: a constant, or a connection to another node's output.
typedef struct CohortNodeInput {
    const char *name;          // "diffuseColor", without "inputs:"
    int32_t source_node;       // index of the connected node, -1 = the constant below
    const char *source_output; // "rgb"
    uint32_t components;       // 1 to 4 numbers in `value`, 0 = a string
    float value[4];
    const char *string;      // tokens, strings, asset paths as authored
    const char *resolved;    // assets: the file to open (where it should be when it is missing)
    const char *color_space; // `colorSpace` metadata of the attribute, or NULL
} CohortNodeInput;

typedef struct CohortMaterialNode {
    const char *path; // for messages
    const char *id;   // info:id, "UsdPreviewSurface"
    const CohortNodeInput *inputs;
    size_t input_count;
} CohortMaterialNode;

// A material network whose interface inputs and node graphs have been followed. Supported nodes:
// UsdPreviewSurface, UsdUVTexture, UsdPrimvarReader_*, UsdTransform2d, HwPtexTexture_1,
// PxrPtexture. Others are reported by name and replaced by what can be done.
typedef struct CohortMaterialNetwork {
    const CohortMaterialNode *nodes;
    size_t node_count;
    int32_t surface;      // node of the surface terminal, -1 = none: Lambertian with displayColor
    int32_t displacement; // of the displacement terminal, -1 = none: nothing is displaced
} CohortMaterialNetwork;

// What the index pulls from a host. Every function gets `cookie`; a NULL function means the
// default. A function that returns false has put the reason into *err: the prim is reported and
// draws nothing. Paths and arrays returned must live until the prim has been synced (see
// CohortPull).
typedef struct CohortSceneDelegate {
    void *cookie;
    bool (*get_mesh)(void *cookie, CohortPull *pull, const char *path, CohortMeshSource *out,
                     CohortError *err);
    bool (*get_instancer)(void *cookie, CohortPull *pull, const char *path,
                          CohortInstancerSource *out, CohortError *err);
    // Prim to world; under an instancer: prim to the root of its prototype. Samples in ascending
    // time; the one at time 0, else the nearest, is rendered. NULL or no sample: identity.
    bool (*get_transform)(void *cookie, CohortPull *pull, const char *path,
                          const CohortTransformSample **out, size_t *count, CohortError *err);
    bool (*get_visible)(void *cookie, const char *path); // NULL: visible
    // The transform and `hidden` in *out are ignored: they have callbacks and dirty bits of their
    // own.
    bool (*get_light)(void *cookie, CohortPull *pull, const char *path, CohortLightDesc *out,
                      CohortError *err);
    bool (*get_camera)(void *cookie, const char *path, CohortCameraSource *out, CohortError *err);
    bool (*get_material)(void *cookie, CohortPull *pull, const char *path,
                         CohortMaterialNetwork *out, CohortError *err);
    // Whether a callback has found no memory for something since this was asked last, for hosts
    // that cannot say so where it happens. Asked before and after each prim: the sync fails with
    // COHORT_ERROR_OUT_OF_MEMORY if it is true after, and the prim stays dirty. NULL: never.
    bool (*ran_short)(void *cookie);
} CohortSceneDelegate;

#ifdef __cplusplus
}
#endif

#endif
