// Value clips: samples of attributes kept in layers of their own, a run of time each.
//
// A clip set hangs at the prim that authors it and speaks for everything below. It is weaker than
// the layer that names its files and stronger than all that is weaker than that layer. The samples
// of an attribute over all clips of a set are merged into one ordinary list in stage time.
//
// Source: the reference's value clip rules (UsdClipsAPI), checked against what it answers.

#ifndef CO_STAGE_CLIPS_H
#define CO_STAGE_CLIPS_H

#include "stage/stage_data.h"

// Stage time to clip time; linear between entries, held outside. Ascending in `stage`.
typedef struct CoClipTime {
    double stage, clip;
    bool jumps; // to the next entry: nothing is sampled between them
} CoClipTime;

typedef struct CoClip {
    const CoLayerFile *file; // NULL when it could not be read: it has no samples then
    double start;            // stage time from which on it is used
} CoClip;

typedef struct CoClipSet {
    const char *prim_path;       // in the clips: what the prim is there
    const CoLayerFile *manifest; // NULL: whatever has samples in any clip
    const CoSource *anchor;      // the layer that names the files
    CoSource source;             // of the merged samples: stage time
    CoClip *clips;               // ascending in start; may be the same file more than once
    CoClipTime *times;           // none: clip time is stage time
    size_t clip_count, time_count;
    bool interpolates_missing;
} CoClipSet;

struct CoClips {
    const CohortPrim *prim;
    const CoClips *outer; // of an ancestor, weaker
    CoClipSet *sets;      // strongest first
    size_t count;
};

// Reads what the opinions on a prim say of clips and opens the layers; the parent's clips if they
// say nothing. While composing.
const CoClips *co_clips_compose(CohortStage *stage, const CohortPrim *prim);

// The merged samples of an attribute from a set that stands, in order of strength, between two
// opinions on the prim: before opinion `last` and not before opinion `first`. Takes the lock.
CoValueSource co_clips_value_source(const CohortPrim *prim, const char *name, uint32_t first,
                                    uint32_t last);

#endif
