// The render index and the delegate as the rooms index, prims and pass see them.
//
// Terms: container = what prims stand in: the world (container 0), or one prototype of an
// instancer. A container is one group of the scene, so a prototype exists once however often it is
// placed.

#ifndef CO_DELEGATE_INDEX_H
#define CO_DELEGATE_INDEX_H

#include "cohort/delegate.h"
#include "index/report.h"
#include "index/settings.h"
#include "index/string_map.h"

struct CohortPull {
    CoArena arena;
    bool is_short; // an array was refused: whatever is made of the pull is not whole
};

enum {
    CO_DICING_PLACES = 8
};

// How large a mesh is seen. Zero: not placed anywhere.
typedef struct CoDicingView {
    double center[3], radius; // of its cage
    uint64_t placements;
    // Those where a unit of its own length may be most pixels, in no order, and how many these are.
    double to_world[CO_DICING_PLACES][4][4], densities[CO_DICING_PLACES];
    double density; // at most, in all others
} CoDicingView;

static inline uint32_t co_dicing_places(const CoDicingView *view)
{
    return view->placements < CO_DICING_PLACES ? (uint32_t)view->placements : CO_DICING_PLACES;
}

// The camera as prims/dicing.h needs it.
typedef struct CoDicing {
    double eye[3], clip_near;
    double axes[3][3], window[4]; // unit axes; what it sees, as CohortCameraDesc has it
    double pixels; // that a unit of length is at distance 1, or anywhere if orthographic
    double edge_length;
    bool is_orthographic;
    CoDicingView *views; // by object
    size_t view_count;
} CoDicing;

typedef struct CoPrim {
    CohortPrimType type;
    char *path;
    const CohortSceneDelegate *scene;
    uint32_t container; // it stands in; meshes and instancers
    uint32_t dirty;     // CohortDirty bits
    uint32_t id;     // of the object, light or material in the scene; INVALID before the first sync
    int32_t prim_id; // meshes
    bool is_visible;
    bool is_nowhere;                    // its transform cannot be used: it is left out
    uint32_t hidden_from;               // meshes: CohortHidden bits
    double cage_center[3], cage_radius; // meshes
    uint64_t view;         // meshes: hash of the CoDicingView they were set with, 0 = none
    bool has_geometry;     // meshes: the scene's object is set
    size_t subset_count;   // meshes: with that many subsets
    bool is_plain;         // materials: no surface that can be rendered, meshes show displayColor
    uint64_t displacement; // materials: what displaces, see material_network.h; meshes: what the
                           // materials had that they were set with. 0 = nothing
    double transform[4][4];
    CohortCameraSource camera;
} CoPrim;

typedef struct CoContainer {
    uint32_t object;           // group in the scene
    uint32_t owner, prototype; // whose prototype it is (a value of owners), and which
    bool is_dirty;
    size_t member_begin, member_count; // in the sync's list of members
} CoContainer;

struct CohortRenderIndex {
    CohortDelegate *delegate;
    CohortScene *scene;
    CoPrim **prims; // in order of insertion; NULL = removed
    size_t prim_count, prim_capacity;
    size_t live_count[COHORT_PRIM_TYPE_COUNT];
    CoStringMap paths; // path -> place in prims
    CoContainer *containers;
    size_t container_count, container_capacity;
    CoStringMap container_names; // "instancer\x1fprototype" -> container
    CoStringMap owners;          // instancer -> number
    CoStringMap textures;        // content -> texture of the scene
    CoStringMap missing;         // paths that meshes name as materials, and that were none
    uint32_t *mesh_places;       // primId -> place in prims
    size_t mesh_count, mesh_capacity;
    bool needs_commit;
    bool materials_changed;      // one that meshes name came or went: they must look again
    CohortCameraDesc camera_set; // what the scene's camera was last set to
    bool has_camera_set;
    CoDicing dicing;
    double load_seconds; // of syncs and commits
    CohortSyncCounts counts;
};

typedef struct CoRenderThread CoRenderThread;

struct CohortDelegate {
    CoSettings settings;
    CoReport report;
    CohortRenderIndex *index;
    CoRenderThread *thread; // the one render, and the thread that drives it
    CohortRenderPass *passes;
    CohortRenderPass *current; // whose render the thread has
    CohortRenderBuffer *buffers;
    CohortRoundFn *round_fn;
    void *round_cookie;
    const volatile int *stop; // the host's, for loading
    bool has_lost;            // see co_delegate_note
};

// Adds a warning to the report for those who cannot fail themselves: one that finds no memory is
// remembered.
void co_delegate_note(CohortDelegate *delegate, CohortSeverity severity, const char *prim_path,
                      const char *name, const char *value, const char *action);

// Whether any was lost since this was asked last: asked first and last by all that may fail.
bool co_delegate_has_lost(CohortDelegate *delegate);

// The prim at a path, NULL if there is none.
CoPrim *co_index_find(const CohortRenderIndex *index, const char *path);

// The container of prototype `prototype` of an instancer (NULL: the world), made when it is not
// there. COHORT_INVALID_ID when out of memory.
uint32_t co_index_container(CohortRenderIndex *index, const char *instancer, uint32_t prototype);

void co_index_destroy(CohortRenderIndex *index);

// Marks what must be pulled or committed again after a setting changed.
void co_index_setting_changed(CohortRenderIndex *index, CoSetting setting);

// True when a sync would do something.
bool co_index_is_dirty(const CohortRenderIndex *index);

// Commits pending edits with the delegate's settings. The render must be down.
bool co_index_commit(CohortRenderIndex *index, CohortError *err);

#endif
