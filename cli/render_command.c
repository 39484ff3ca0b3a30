#include "render_command.h"

#include "cli.h"
#include "stats_file.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

// The film is kept on disk at most this often: rounds of a quick render are not worth a write each.
#define FILM_SECONDS 5.0

static volatile sig_atomic_t stop_requested, snapshot_requested;

static void on_signal(int signal_number)
{
    if (signal_number == SIGUSR1)
        snapshot_requested = 1;
    else
        stop_requested = 1;
}

static void catch_signals(void)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGUSR1, &action, NULL);
    struct sigaction ignore = {.sa_handler = SIG_IGN};
    sigemptyset(&ignore.sa_mask);
    sigaction(SIGXFSZ, &ignore, NULL);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool open_stage(RenderRun *run, CohortError *err)
{
    const RenderOptions *o = &run->options;
    CohortAdapterOptions options = {.camera = o->camera,
                                    .render_settings = o->settings_prim,
                                    .width = o->width,
                                    .height = o->height,
                                    .env = o->env,
                                    .headlight = o->headlight};
    options.stage.variants = o->variant_list;
    options.stage.variant_count = o->variants.count;
    if (o->default_time)
        options.time_choice = COHORT_TIME_DEFAULTS;
    if (run->frames.count) {
        options.time_choice = COHORT_TIME_AT;
        options.time = run->frames.times[0];
    }
    run->adapter = cohort_adapter_open(run->delegate, run->stage_path, &options, err);
    if (!run->adapter || !cohort_adapter_populate(run->adapter, err))
        return false;
    cohort_adapter_settings(run->adapter, &run->resolved);
    return true;
}

static bool wants_png(const RenderOptions *o)
{
    for (size_t i = 0; i < o->outputs.count; i++)
        if (strstr(o->outputs.items[i], ".png") || strstr(o->outputs.items[i], ".PNG"))
            return true;
    return false;
}

static bool prepare(RenderRun *run, CohortError *err)
{
    const RenderOptions *o = &run->options;
    run->delegate = cohort_delegate_create(err);
    if (!run->delegate || !render_options_apply(o, run->delegate, err))
        return false;
    run->index = cohort_render_index_create(run->delegate, err);
    if (!run->index || !open_stage(run, err))
        return false;
    CohortSettingValue space = {0};
    cohort_delegate_get(run->delegate, "cohort:renderingColorSpace", &space);
    if (wants_png(o)) {
        run->view = cohort_view_create(o->ocio, space.string, o->display, o->view, err);
        if (!run->view)
            return false;
    }
    run->pass = cohort_render_pass_create(run->index, err);
    return run->pass && output_buffers_create(run->delegate, run->resolved.width,
                                              run->resolved.height, o->aovs.items, o->aovs.count,
                                              &run->buffers, err);
}

// Wrong settings are the user's; everything else met before the first ray is the stage's.
static int load_exit_code(const CohortError *err)
{
    return err->code == COHORT_ERROR_ARGUMENT ? EXIT_USAGE : EXIT_LOAD;
}

typedef struct Snapshot {
    RenderRun *run;
    double last;
    bool failed;
} Snapshot;

// On the render thread, after each complete round.
static void keep_film(void *cookie, const CohortRoundInfo *info)
{
    Snapshot *s = cookie;
    if (info->is_done || s->failed || (now() - s->last < FILM_SECONDS && !snapshot_requested))
        return;
    CohortError err = {0};
    s->last = now();
    if (cohort_render_pass_save(s->run->pass, s->run->film, s->run->resolved.stage_hash, &err))
        return;
    s->failed = true;
    print_error("warning", &err);
}

static bool write_outputs(RenderRun *run, size_t frame, const char *status, CohortError *err)
{
    const RenderOptions *o = &run->options;
    OutputStamp stamp = {.stage = run->stage_path,
                         .camera = run->resolved.camera,
                         .status = status,
                         .time = run->resolved.time,
                         .pixel_aspect = run->resolved.pixel_aspect_ratio,
                         .frames_per_second = run->resolved.frames_per_second,
                         .seed = (uint32_t)o->seed,
                         .stage_hash = run->resolved.stage_hash,
                         .ocio_config = o->ocio,
                         .view = run->view};
    CohortSettingValue filter = {0}, space = {0};
    cohort_delegate_get(run->delegate, "cohort:filter", &filter);
    cohort_delegate_get(run->delegate, "cohort:renderingColorSpace", &space);
    stamp.filter = filter.string;
    stamp.rendering_space = space.string;
    cohort_delegate_render_stats(run->delegate, &stamp.stats);
    for (size_t i = 0; i < o->outputs.count; i++) {
        char path[4096], why[512];
        if (!frames_path(o->outputs.items[i], run->frames.count ? &run->frames : NULL, frame, path,
                         sizeof path, why, sizeof why))
            return fail(err, COHORT_ERROR_ARGUMENT, "%s", why);
        if (!output_write(path, &run->buffers, &stamp, err))
            return false;
        if (!o->is_quiet)
            fprintf(stderr, "cohort: wrote %s (%ux%u, %llu spp)\n", path, run->resolved.width,
                    run->resolved.height, (unsigned long long)stamp.stats.samples_per_pixel);
    }
    return true;
}

static bool write_stats(RenderRun *run, const char *status, CohortError *err)
{
    StatsContext context = {.stage = run->stage_path,
                            .status = status,
                            .delegate = run->delegate,
                            .index = run->index,
                            .adapter = run->adapter,
                            .load_seconds = run->load_seconds,
                            .total_seconds = now() - run->start};
    cohort_delegate_render_stats(run->delegate, &context.render);
    return !run->options.stats || stats_write(run->options.stats, &context, err);
}

static void print_report(const RenderRun *run)
{
    const CohortReportEntry *entries;
    size_t n = cohort_delegate_report(run->delegate, &entries);
    size_t limit = run->options.is_verbose ? n : 12;
    for (size_t i = 0; i < n && i < limit && !run->options.is_quiet; i++)
        fprintf(stderr, "cohort: <%s> %s%s%s: %s%s\n", entries[i].prim_path, entries[i].name,
                entries[i].value[0] ? " = " : "", entries[i].value, entries[i].action,
                entries[i].count > 1 ? " (repeated)" : "");
    if (n > limit && !run->options.is_quiet)
        fprintf(stderr, "cohort: %zu more not honored; -v or --stats shows all\n", n - limit);
    const CohortDiagnostic *warnings;
    n = cohort_render_index_warnings(run->index, &warnings);
    for (size_t i = 0; i < n && !run->options.is_quiet; i++)
        fprintf(stderr, "cohort: %s: warning: %s (%llu times)\n", warnings[i].place,
                warnings[i].text, (unsigned long long)warnings[i].count);
}

static void watch(RenderRun *run, size_t frame)
{
    double start = now();
    bool is_stopping = false;
    while (!cohort_render_pass_wait(run->pass, 0.1)) {
        CohortStat stats[32];
        CohortRenderStats render = {0};
        size_t n = cohort_delegate_stats(run->delegate, stats, 32);
        double fraction = 0.0;
        for (size_t i = 0; i < n && i < 32; i++)
            if (!strcmp(stats[i].key, "fractionDone"))
                fraction = stats[i].value.number;
        cohort_delegate_render_stats(run->delegate, &render);
        progress_update(&run->progress, fraction, now() - start, &render);
        if (snapshot_requested && render.rounds) {
            CohortError err = {0};
            snapshot_requested = 0;
            if (!write_outputs(run, frame, "snapshot", &err))
                print_error("warning", &err);
        }
        if (stop_requested && !is_stopping) {
            is_stopping = true;
            cohort_delegate_stop(run->delegate, true);
            break;
        }
    }
    progress_end(&run->progress);
    run->was_interrupted = is_stopping;
}

// Renders and writes one frame; returns an exit code.
static int render_frame(RenderRun *run, size_t frame, CohortError *err)
{
    char first[4000], why[512];
    if (!frames_path(run->options.outputs.items[0], run->frames.count ? &run->frames : NULL, frame,
                     first, sizeof first, why, sizeof why))
        return usage_error("render", "%s", why);
    snprintf(run->film, sizeof run->film, "%s.film", first);
    if (frame > 0 && !cohort_adapter_set_time(run->adapter, run->frames.times[frame], err))
        return EXIT_LOAD;
    cohort_adapter_settings(run->adapter, &run->resolved);
    CohortRenderPassState state = cohort_adapter_pass_state(run->adapter);
    state.bindings = run->buffers.bindings;
    state.binding_count = run->buffers.count;
    state.stage_hash = run->resolved.stage_hash;
    if (run->options.resume && access(run->film, R_OK) == 0)
        state.resume_file = run->film;
    Snapshot snapshot = {.run = run, .last = now()};
    cohort_delegate_set_round_callback(run->delegate, keep_film, &snapshot);
    double start = now();
    if (!cohort_render_pass_execute(run->pass, &state, err))
        return load_exit_code(err);
    run->load_seconds = (frame == 0 ? start - run->start : 0.0) + now() - start;
    watch(run, frame);
    if (cohort_render_pass_error(run->pass, err) && err->code != COHORT_ERROR_CANCELLED)
        return err->code == COHORT_ERROR_FILE_WRITE ? EXIT_WRITE : EXIT_LOAD;
    memset(err, 0, sizeof *err);
    CohortRenderStats stats = {0};
    cohort_delegate_render_stats(run->delegate, &stats);
    if (run->was_interrupted && stats.rounds == 0 && !state.resume_file)
        return EXIT_INTERRUPTED;
    if (run->was_interrupted &&
        !cohort_render_pass_save(run->pass, run->film, run->resolved.stage_hash, err))
        return EXIT_WRITE;
    const char *status = run->was_interrupted ? "interrupted" : "complete";
    if (!write_outputs(run, frame, status, err) || !write_stats(run, status, err))
        return EXIT_WRITE;
    if (!run->was_interrupted)
        unlink(run->film);
    return run->was_interrupted ? EXIT_INTERRUPTED : EXIT_WRITTEN;
}

static int render_frames(RenderRun *run, CohortError *err)
{
    size_t count = run->frames.count ? run->frames.count : 1;
    progress_begin(&run->progress, run->options.progress != NULL, run->options.is_quiet, count);
    if (run->resolved.light_count == 0 && !run->options.env && !run->options.headlight &&
        !run->options.is_quiet)
        fprintf(stderr, "cohort: warning: the stage has no lights and will be dark; "
                        "--env sky or --headlight adds one\n");
    for (size_t i = 0; i < count; i++) {
        run->progress.frame = i;
        int code = render_frame(run, i, err);
        if (code != EXIT_WRITTEN)
            return code;
        CohortRenderStats stats = {0};
        cohort_delegate_render_stats(run->delegate, &stats);
        progress_update(&run->progress, 1.0, 0.0, &stats);
    }
    progress_end(&run->progress);
    return EXIT_WRITTEN;
}

static void clear(RenderRun *run)
{
    if (run->delegate)
        cohort_delegate_stop(run->delegate, true);
    cohort_render_pass_destroy(run->pass);
    output_buffers_destroy(&run->buffers);
    cohort_adapter_destroy(run->adapter);
    cohort_delegate_destroy(run->delegate);
    cohort_view_destroy(run->view);
    frames_clear(&run->frames);
}

int command_render(int argc, char **argv)
{
    static RenderRun run;
    run.start = now();
    run.options.level = -1;
    int code = render_options_parse(argc, argv, &run.options, &run.stage_path);
    if (code >= 0)
        return code;
    char why[512];
    if (run.options.frames && !frames_parse(run.options.frames, &run.frames, why, sizeof why))
        return usage_error("render", "%s", why);
    catch_signals();
    CohortError err = {0};
    if (!prepare(&run, &err))
        code = load_exit_code(&err);
    else
        code = render_frames(&run, &err);
    if (run.adapter)
        print_report(&run);
    if (err.code != COHORT_OK)
        print_error("error", &err);
    if (code == EXIT_INTERRUPTED)
        fprintf(stderr, "cohort: interrupted; --resume goes on from %s\n", run.film);
    clear(&run);
    return code;
}
