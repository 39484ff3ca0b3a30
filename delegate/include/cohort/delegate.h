// The door to the engine: a C API after Hydra's render delegate.
//
// A host creates a delegate, inserts prims into its render index, binds render buffers to AOVs and
// executes a render pass. The index pulls what is dirty from the host's CohortSceneDelegate, the
// pass renders in the background, and the buffers fill round by round until the pass has converged.
//
//   delegate (settings, statistics, report) - index (prims, dirty bits) - pass (camera, AOVs)
//
// What a CohortSceneDelegate gives is in scene_delegate.h.
//
// Threads: one thread, the host's, makes all calls, except those marked "any thread". Scene
// delegate callbacks run on the thread that calls cohort_render_index_sync or
// cohort_render_pass_execute, one at a time. A render pass has one thread of its own; it touches no
// prim and calls only the round callback.

#ifndef COHORT_DELEGATE_H
#define COHORT_DELEGATE_H

#include "cohort/render.h"
#include "cohort/scene_delegate.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct CohortDelegate CohortDelegate;
typedef struct CohortRenderIndex CohortRenderIndex;
typedef struct CohortRenderPass CohortRenderPass;
typedef struct CohortRenderBuffer CohortRenderBuffer;

// ---- Delegate and settings -------------------------------------------------------------------

typedef enum CohortSettingType {
    COHORT_SETTING_BOOL = 0,
    COHORT_SETTING_INT,
    COHORT_SETTING_DOUBLE,
    COHORT_SETTING_STRING
} CohortSettingType;

// A typed value; only the member of its type means anything.
typedef struct CohortSettingValue {
    CohortSettingType type;
    bool boolean;
    int64_t integer;
    double number;
    const char *string; // never NULL in what Cohort returns
} CohortSettingValue;

// One row of the settings table. Static.
typedef struct CohortSettingDescriptor {
    const char *key;   // "cohort:spp"; generic Hydra settings keep Hydra's name
    const char *alias; // a generic Hydra key that means the same setting, or NULL
    CohortSettingType type;
    CohortSettingValue fallback;
    double least, most;      // range of numbers
    const char *choices;     // strings: "a|b|c", or NULL for free text
    const char *description; // one sentence
    bool affects_image;      // a change restarts the render; others wait for the next start
} CohortSettingDescriptor;

// The settings table, in a fixed order. Returns its length. Any thread.
size_t cohort_setting_descriptors(const CohortSettingDescriptor **out);

// Creates a delegate with every setting at its default. NULL when out of memory.
CohortDelegate *cohort_delegate_create(CohortError *err);

// Stops the render and frees everything the delegate has: index, passes and buffers too.
void cohort_delegate_destroy(CohortDelegate *delegate);

// Sets a setting by key or alias. Setting the value it has is a no-op and returns true. Numbers are
// converted between bool, int and double where nothing is lost. COHORT_ERROR_ARGUMENT names the
// setting when the key is unknown, or the value of the wrong type or out of range.
bool cohort_delegate_set(CohortDelegate *delegate, const char *key, const CohortSettingValue *value,
                         CohortError *err);
bool cohort_delegate_set_bool(CohortDelegate *delegate, const char *key, bool value,
                              CohortError *err);
bool cohort_delegate_set_int(CohortDelegate *delegate, const char *key, int64_t value,
                             CohortError *err);
bool cohort_delegate_set_double(CohortDelegate *delegate, const char *key, double value,
                                CohortError *err);
bool cohort_delegate_set_string(CohortDelegate *delegate, const char *key, const char *value,
                                CohortError *err);

// Reads a setting; false when the key is unknown. Strings live until that setting changes.
bool cohort_delegate_get(const CohortDelegate *delegate, const char *key, CohortSettingValue *out);

// Rises by one whenever a set changed a value: equal versions, equal settings.
uint64_t cohort_delegate_settings_version(const CohortDelegate *delegate);

// The render settings that the delegate's settings amount to: what the next render starts with,
// size and AOVs aside. Strings as in cohort_delegate_get.
void cohort_delegate_render_settings(const CohortDelegate *delegate, CohortRenderSettings *out);

// ---- AOVs and render buffers -----------------------------------------------------------------

typedef enum CohortFormat {
    COHORT_FORMAT_NONE = 0,
    COHORT_FORMAT_FLOAT32,
    COHORT_FORMAT_FLOAT32_VEC3,
    COHORT_FORMAT_FLOAT32_VEC4,
    COHORT_FORMAT_INT32
} CohortFormat;

size_t cohort_format_size(CohortFormat format); // bytes per pixel

// What the delegate would render for an AOV name. format NONE: not supported.
typedef struct CohortAovDescriptor {
    const char *name;
    CohortAov aov;
    CohortFormat format;
    float clear[4]; // ids: clear[0] converted to int32
    bool filtered;  // by the pixel filter; others keep one sample's value
    const char *description;
} CohortAovDescriptor;

// `color depth cameraDepth normal albedo primId elementId sampleCount error`; anything else gives
// an empty descriptor. Any thread.
CohortAovDescriptor cohort_aov_descriptor(const char *name);
// All supported AOVs. Returns how many. Any thread.
size_t cohort_aov_descriptors(const CohortAovDescriptor **out);

// A buffer of width x height pixels, cleared to zero. The format must be that of the AOV it will be
// bound to. Sizes are checked: at most 65536 a side.
CohortRenderBuffer *cohort_render_buffer_create(CohortDelegate *delegate, uint32_t width,
                                                uint32_t height, CohortFormat format,
                                                CohortError *err);
void cohort_render_buffer_destroy(CohortRenderBuffer *buffer); // stops a render that is bound to it
uint32_t cohort_render_buffer_width(const CohortRenderBuffer *buffer);
uint32_t cohort_render_buffer_height(const CohortRenderBuffer *buffer);
CohortFormat cohort_render_buffer_format(const CohortRenderBuffer *buffer);

// Gives the pixels of the newest complete round, ROW 0 AT THE BOTTOM as in Hydra, without padding.
// They stay as they are until the matching unmap, whatever the render does meanwhile; maps nest.
// Any thread.
const void *cohort_render_buffer_map(CohortRenderBuffer *buffer);
void cohort_render_buffer_unmap(CohortRenderBuffer *buffer);

// True while a map is open. Any thread.
bool cohort_render_buffer_is_mapped(CohortRenderBuffer *buffer);

// True when the last write came from a render that has converged. Any thread.
bool cohort_render_buffer_is_converged(CohortRenderBuffer *buffer);

// Makes the newest round the one that map returns, unless a map is open. map does it too. Any
// thread.
void cohort_render_buffer_resolve(CohortRenderBuffer *buffer);

// ---- Render index ----------------------------------------------------------------------------

typedef enum CohortPrimType {
    COHORT_PRIM_MESH = 0,
    COHORT_PRIM_INSTANCER,
    COHORT_PRIM_CAMERA,
    COHORT_PRIM_LIGHT,
    COHORT_PRIM_MATERIAL,
    COHORT_PRIM_TYPE_COUNT
} CohortPrimType;

// What changed in a prim. Each is counted by itself (CohortSyncCounts).
typedef enum CohortDirty {
    COHORT_DIRTY_TRANSFORM = 1 << 0,
    COHORT_DIRTY_VISIBILITY = 1 << 1,
    COHORT_DIRTY_MATERIAL_ID = 1 << 2, // binding, not the material's own values
    COHORT_DIRTY_PRIMVAR = 1 << 3,     // normals included
    COHORT_DIRTY_POINTS = 1 << 4,
    COHORT_DIRTY_TOPOLOGY = 1 << 5, // subsets and holes included
    COHORT_DIRTY_SUBDIV_TAGS = 1 << 6,
    COHORT_DIRTY_DISPLAY_STYLE = 1 << 7,  // refinement level
    COHORT_DIRTY_INSTANCER = 1 << 8,      // placements
    COHORT_DIRTY_INSTANCE_INDEX = 1 << 9, // which prototype, which are hidden
    COHORT_DIRTY_PARAMS = 1 << 10,        // of a camera, light or material
    COHORT_DIRTY_RESOURCE = 1 << 11       // a material's network, a light's texture
} CohortDirty;
#define COHORT_DIRTY_BIT_COUNT 12
#define COHORT_DIRTY_ALL ((1u << COHORT_DIRTY_BIT_COUNT) - 1u)

// What syncs have done since the index was created.
typedef struct CohortSyncCounts {
    uint64_t by_bit[COHORT_PRIM_TYPE_COUNT]
                   [COHORT_DIRTY_BIT_COUNT]; // prims synced with that bit set
    // Edits of the scene; bindings_set counts meshes that got other materials and nothing else.
    uint64_t meshes_set, bindings_set, groups_set, lights_set, materials_set, cameras_set;
    uint64_t commits, render_starts;
    CohortSceneCounts scene; // what the edits made the renderer rebuild
} CohortSyncCounts;

// Creates the delegate's index; a delegate has one. It owns the scene.
CohortRenderIndex *cohort_render_index_create(CohortDelegate *delegate, CohortError *err);

// Inserts a prim, all dirty. `scene` is borrowed and must outlive the prim; the strings are copied.
//   instancer  for meshes and instancers: the owner of the prototype it stands in, which is an
//              instancer (that may be inserted later) or any name that instancers give as their
//              prototype_owner; NULL = drawn by itself
//   prototype  which of them, below 2^24
// Fails when the path is taken. primId of a mesh is its position in the order of insertion.
bool cohort_render_index_insert(CohortRenderIndex *index, CohortPrimType type, const char *path,
                                const CohortSceneDelegate *scene, const char *instancer,
                                uint32_t prototype, CohortError *err);

// Takes a prim out of the scene, and the render down; unknown paths are ignored.
void cohort_render_index_remove(CohortRenderIndex *index, const char *path);

// Marks bits (CohortDirty) of a prim; unknown paths are ignored.
void cohort_render_index_mark_dirty(CohortRenderIndex *index, const char *path, uint32_t bits);
void cohort_render_index_mark_all_dirty(CohortRenderIndex *index, CohortPrimType type,
                                        uint32_t bits);

// The bits a prim has now; 0 also for unknown paths.
uint32_t cohort_render_index_dirty_bits(const CohortRenderIndex *index, const char *path);
size_t cohort_render_index_prim_count(const CohortRenderIndex *index, CohortPrimType type);

// Path of the mesh with that primId, or NULL.
const char *cohort_render_index_prim_path(const CohortRenderIndex *index, int32_t prim_id);

// Pulls and applies all that is dirty, and commits the scene. Stops a running render first, but
// only when there is something to do; the next execute restarts it. A prim that cannot be synced is
// reported and left out; false only when the scene as a whole cannot be made.
bool cohort_render_index_sync(CohortRenderIndex *index, CohortError *err);

// The first half of a sync: pulls all that is dirty, so that the report is complete, but makes no
// scene of it yet. For who only wants to know what would not be honored.
bool cohort_render_index_pull(CohortRenderIndex *index, CohortError *err);

// World-space box (min xyz, max xyz) of the synced scene; false when it holds nothing.
bool cohort_render_index_bounds(const CohortRenderIndex *index, double box[6]);

void cohort_render_index_counts(const CohortRenderIndex *index, CohortSyncCounts *out);

// ---- Render pass -----------------------------------------------------------------------------

typedef struct CohortAovBinding {
    const char *name;
    CohortRenderBuffer *buffer;
} CohortAovBinding;

typedef struct CohortRenderPassState {
    const char *camera;               // path in the index
    const CohortAovBinding *bindings; // all buffers of one size, which is the image's
    size_t binding_count;             // at least one
    CohortConformPolicy conform;
    double pixel_aspect_ratio; // width / height of a pixel, 0 = 1
    bool disable_depth_of_field;
    const char *resume_file; // a film to go on from at the next start, NULL = from nothing
    uint64_t stage_hash;     // identifies the scene in saved films; the pass adds its own settings
} CohortRenderPassState;

// A pass of the index. Passes of one delegate render one at a time: executing another one stops the
// one before.
CohortRenderPass *cohort_render_pass_create(CohortRenderIndex *index, CohortError *err);
void cohort_render_pass_destroy(CohortRenderPass *pass);

// Syncs what is dirty and starts the background render, or restarts it where a prim, an image
// setting or the state changed; otherwise does nothing and returns at once. The render runs to its
// end by itself: it never needs another call.
bool cohort_render_pass_execute(CohortRenderPass *pass, const CohortRenderPassState *state,
                                CohortError *err);

// True when the render has reached its target, or has ended with an error. Any thread.
bool cohort_render_pass_is_converged(const CohortRenderPass *pass);

// Blocks until the pass has converged or was stopped or paused, at most `seconds` (negative: no
// limit). Returns whether it has converged. Any thread.
bool cohort_render_pass_wait(CohortRenderPass *pass, double seconds);

// The error that ended the render: true and *out set when there is one. Any thread.
bool cohort_render_pass_error(const CohortRenderPass *pass, CohortError *out);

// The camera as the pass renders it, its window conformed to the image. False before the first
// execute.
bool cohort_render_pass_camera(const CohortRenderPass *pass, CohortCameraDesc *out);

// Saves the film of the last complete round. Only a pass with the same scene, view and settings,
// but for those that say when to stop, goes on from it. From the round callback: at once. While
// rendering: at the end of the open round, waiting for it.
bool cohort_render_pass_save(CohortRenderPass *pass, const char *path, uint64_t stage_hash,
                             CohortError *err);

// Pause drops the open round and keeps the complete ones; resume goes on from there with the same
// pixels as if it had never stopped. Without a render both do nothing. Any thread but the render's.
// Resume is false when there is no memory or thread to go on with.
bool cohort_delegate_pause(CohortDelegate *delegate);
bool cohort_delegate_resume(CohortDelegate *delegate);

// Ends the render: the open round is dropped, the film of the last complete one stays readable. Not
// blocking, it only starts the abort. Resume goes on from there. Any thread.
void cohort_delegate_stop(CohortDelegate *delegate, bool blocking);

// Has loading look at an int that any thread, or a signal handler, makes other than 0: a sync or
// execute ends then before its next prim, texture or mesh, with COHORT_ERROR_CANCELLED, and another
// goes on from there. Borrowed; NULL = none. A render that has started is ended by
// cohort_delegate_stop.
void cohort_delegate_set_stop_flag(CohortDelegate *delegate, const volatile int *stop);

// Starts over from the first sample. False when no pass has been executed, or when it cannot start:
// the next execute says why.
bool cohort_delegate_restart(CohortDelegate *delegate);

// Called on the render thread after each complete round, when the buffers hold it. It may map
// buffers, read statistics, save the film and stop without blocking; nothing else.
typedef struct CohortRoundInfo {
    uint64_t round;             // 1-based
    uint64_t samples_per_pixel; // so far
    double seconds;             // since the render started
    bool is_done;
} CohortRoundInfo;
typedef void CohortRoundFn(void *cookie, const CohortRoundInfo *info);
void cohort_delegate_set_round_callback(CohortDelegate *delegate, CohortRoundFn *fn, void *cookie);

// ---- Statistics and report -------------------------------------------------------------------

typedef struct CohortStat {
    const char *key; // static
    CohortSettingValue value;
} CohortStat;

// Fills at most `capacity` entries and returns how many there are. Keys: percentDone (0-100, never
// falls during a render), fractionDone, numCompletedSamples (per pixel), totalClockTime (seconds
// since the render started), loadClockTime (seconds of sync and commit), totalMemory, peakMemory
// (bytes), renderProgressAnnotation, rendererName, rendererVersion, huskErrorStatus (0 = no error).
// Any thread; the strings are static.
size_t cohort_delegate_stats(const CohortDelegate *delegate, CohortStat *out, size_t capacity);

// The renderer's own statistics, as of the last complete round. False without a render. Any thread.
bool cohort_delegate_render_stats(const CohortDelegate *delegate, CohortRenderStats *out);

// One thing that was asked for and not honored.
typedef struct CohortReportEntry {
    CohortSeverity severity;
    const char *prim_path;
    const char *name;   // attribute, node or schema
    const char *value;  // as authored, "" if there is none
    const char *action; // what was done instead
    uint64_t count;     // equal entries
} CohortReportEntry;

// All entries, sorted by path and name, repeats merged. What a prim says whose sync fails, for want
// of memory or stopped, is not among them: it is pulled, and speaks, again. Pointers live until the
// next call that adds an entry (sync, execute, adapter calls).
size_t cohort_delegate_report(CohortDelegate *delegate, const CohortReportEntry **out);

// Adds an entry; for scene delegates. Strings are copied. False when out of memory.
bool cohort_delegate_report_add(CohortDelegate *delegate, CohortSeverity severity,
                                const char *prim_path, const char *name, const char *value,
                                const char *action);
void cohort_delegate_report_clear(CohortDelegate *delegate);

// The renderer's own diagnostics (missing textures, repaired meshes), as cohort_scene_warnings.
size_t cohort_render_index_warnings(const CohortRenderIndex *index, const CohortDiagnostic **out);

#ifdef __cplusplus
}
#endif

#endif
