// cohort render: options and one frame.

#ifndef COHORT_CLI_RENDER_COMMAND_H
#define COHORT_CLI_RENDER_COMMAND_H

#include "frames.h"
#include "messages.h"
#include "options.h"
#include "output.h"
#include "progress.h"
#include "stage_options.h"

#include "cohort/stage_adapter.h"

typedef struct RenderOptions {
    OptionList outputs, aovs, variants;
    const char *camera, *frames, *size, *filter, *preset, *env, *scratch, *sort, *sorter, *isa,
        *converted, *ptex_reductions, *ocio, *display, *view, *stats, *progress, *settings_prim;
    int64_t spp, max_depth, first_hit_samples, light_samples, batch, threads, level, seed;
    int64_t memory;
    double time_limit, noise, edge_length;
    bool headlight, hide_lights, resume, is_quiet, is_verbose, default_time, texture_level0,
        list_cameras;
    StageOptions part;
    CohortVariantChoice variant_list[OPTION_LIST_MAX];
    char variant_text[OPTION_LIST_MAX][512];
    uint32_t width, height;
} RenderOptions;

// A run over all frames of a stage.
typedef struct RenderRun {
    RenderOptions options;
    const char *stage_path;
    FrameList frames;
    Messages messages;
    CohortDelegate *delegate;
    CohortRenderIndex *index;
    CohortAdapter *adapter;
    CohortRenderPass *pass;
    CohortView *view;
    CohortResolvedSettings resolved;
    OutputBuffers buffers;
    Progress progress;
    char product[4096]; // the stage's own name for the image, when none was given
    char film[4096];    // beside the first output; "" when nothing is written
    bool has_film;      // the last complete round is there
    double load_seconds, start;
    bool was_interrupted;
} RenderRun;

// render_options.c: fills *options; returns an exit code, or -1 to go on.
int render_options_parse(int argc, char **argv, RenderOptions *options, const char **stage);
bool render_options_apply(const RenderOptions *options, CohortDelegate *delegate, CohortError *err);

// frame.c: renders and writes one frame, and returns an exit code. SIGINT and SIGTERM end it with
// the last complete round; SIGUSR1 writes that round and goes on. Until a render has begun, the
// first two put up the stop flag, and end the process a second later if it is still loading.
void render_catch_signals(void);
const volatile int *render_stop_flag(void);
void render_say_interrupted(void); // that nothing is written; safe in a signal handler
int render_frame(RenderRun *run, size_t frame, CohortError *err);

// Seconds of a steady clock.
double render_now(void);

// The exit code of a failure: what the user asked for, what could not be written, or the stage.
int render_exit_code(const CohortError *err);

#endif
