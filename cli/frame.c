// One frame of a render: from the first ray to the files.

#include "render_command.h"

#include "cli.h"
#include "names.h"
#include "stats_file.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

// The film is kept on disk at most this often: rounds of a quick render are not worth a write each.
#define FILM_SECONDS 5.0

static volatile int stop_requested; // loading looks at it, on any thread
static volatile sig_atomic_t is_loading, snapshot_requested, first_stop; // seconds

void render_say_interrupted(void)
{
    static const char text[] =
        "cohort: interrupted before a round of the frame was complete: nothing is written of it\n";
    (void)!write(STDERR_FILENO, text, sizeof text - 1);
}

// Loading stops between meshes and textures, and may have a huge one in hand: nothing is lost when
// it is left there.
static void on_alarm(int signal_number)
{
    (void)signal_number;
    if (!is_loading)
        return;
    render_say_interrupted();
    _exit(EXIT_INTERRUPTED);
}

// Who asks again more than a second later, while a disk does not answer, is not kept waiting.
// Sooner it is the same wish: timeout(1) signals the process and its group.
static void on_signal(int signal_number)
{
    if (signal_number == SIGUSR1) {
        snapshot_requested = 1;
        return;
    }
    if (is_loading && !stop_requested)
        alarm(1);
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    if (!stop_requested) {
        first_stop = (sig_atomic_t)now.tv_sec;
    } else if ((sig_atomic_t)now.tv_sec - first_stop > 1) {
        signal(signal_number, SIG_DFL);
        raise(signal_number); // when this handler returns
    }
    stop_requested = 1;
}

void render_catch_signals(void)
{
    is_loading = 1;
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGUSR1, &action, NULL);
    action.sa_handler = on_alarm;
    sigaction(SIGALRM, &action, NULL);
    // A file that grows too large, or a reader that has gone, is an error of that write alone.
    struct sigaction ignore = {.sa_handler = SIG_IGN};
    sigemptyset(&ignore.sa_mask);
    sigaction(SIGXFSZ, &ignore, NULL);
    sigaction(SIGPIPE, &ignore, NULL);
}

const volatile int *render_stop_flag(void)
{
    return &stop_requested;
}

double render_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// ---- Files -------------------------------------------------------------------------------------

static void fill_stamp(const RenderRun *run, const char *status, OutputStamp *stamp)
{
    CohortSettingValue filter = {0}, space = {0};
    cohort_delegate_get(run->delegate, "cohort:filter", &filter);
    cohort_delegate_get(run->delegate, "cohort:renderingColorSpace", &space);
    *stamp = (OutputStamp){.stage = run->stage_path,
                           .camera = run->resolved.camera,
                           .filter = filter.string,
                           .status = status,
                           .time = run->resolved.time,
                           .pixel_aspect = run->resolved.pixel_aspect_ratio,
                           .frames_per_second = run->resolved.frames_per_second,
                           .seed = (uint32_t)run->options.seed,
                           .stage_hash = run->resolved.stage_hash,
                           .ocio_config = run->options.ocio,
                           .rendering_space = space.string,
                           .view = run->view};
    stamp->has_lens = cohort_render_pass_camera(run->pass, &stamp->lens);
    cohort_delegate_render_stats(run->delegate, &stamp->stats);
}

static bool write_outputs(RenderRun *run, size_t frame, const char *status, CohortError *err)
{
    const RenderOptions *o = &run->options;
    OutputStamp stamp;
    fill_stamp(run, status, &stamp);
    for (size_t i = 0; i < o->outputs.count; i++) {
        char path[4096];
        if (!names_frame(run, o->outputs.items[i], frame, path, sizeof path, err) ||
            !output_write(path, &run->buffers, &stamp, err))
            return false;
        if (!o->is_quiet)
            fprintf(stderr, "cohort: wrote %s (%ux%u, %llu spp)\n", path, run->resolved.width,
                    run->resolved.height, (unsigned long long)stamp.stats.samples_per_pixel);
    }
    return true;
}

static bool write_stats(RenderRun *run, size_t frame, const char *status, CohortError *err)
{
    const char *pattern = run->options.stats;
    if (!pattern)
        return true;
    char path[4096];
    if (!names_frame(run, pattern, frame, path, sizeof path, err))
        return false;
    StatsContext context = {.stage = run->stage_path,
                            .status = status,
                            .delegate = run->delegate,
                            .index = run->index,
                            .load_seconds = run->load_seconds,
                            .total_seconds = render_now() - run->start};
    cohort_delegate_render_stats(run->delegate, &context.render);
    return stats_write(path, &context, err);
}

static bool save_film(RenderRun *run, CohortError *err)
{
    if (!run->film[0])
        return true;
    run->has_film = cohort_render_pass_save(run->pass, run->film, run->resolved.stage_hash, err);
    return run->has_film;
}

// ---- While it renders --------------------------------------------------------------------------

typedef struct FilmKeeper {
    RenderRun *run;
    double last;
    bool failed;
} FilmKeeper;

// On the render thread, after each complete round.
static void keep_film(void *cookie, const CohortRoundInfo *info)
{
    FilmKeeper *keeper = cookie;
    if (info->is_done || keeper->failed || render_now() - keeper->last < FILM_SECONDS)
        return;
    CohortError err = {0};
    keeper->failed = !save_film(keeper->run, &err);
    keeper->last = render_now();
    if (keeper->failed)
        print_failure("warning", &err);
}

static double fraction_done(const CohortDelegate *delegate)
{
    CohortStat stats[32];
    size_t count = cohort_delegate_stats(delegate, stats, 32);
    for (size_t i = 0; i < count && i < 32; i++)
        if (!strcmp(stats[i].key, "fractionDone"))
            return stats[i].value.number;
    return 0.0;
}

static void watch(RenderRun *run, size_t frame)
{
    double start = render_now();
    while (!cohort_render_pass_wait(run->pass, 0.1)) {
        if (stop_requested) {
            cohort_delegate_stop(run->delegate, true);
            break;
        }
        CohortRenderStats stats = {0};
        cohort_delegate_render_stats(run->delegate, &stats);
        progress_update(&run->progress, fraction_done(run->delegate), render_now() - start, &stats);
        if (snapshot_requested && stats.samples_per_pixel) {
            CohortError err = {0};
            snapshot_requested = 0;
            if (!save_film(run, &err) || !write_outputs(run, frame, "snapshot", &err))
                print_failure("warning", &err);
        }
    }
    progress_end(&run->progress);
    run->was_interrupted = !cohort_render_pass_is_converged(run->pass);
}

// ---- Begin and end -----------------------------------------------------------------------------

static bool check_files(RenderRun *run, size_t frame, CohortError *err)
{
    run->film[0] = 0;
    run->has_film = false;
    for (size_t i = 0; i < run->options.outputs.count; i++) {
        char path[4000];
        if (!names_frame(run, run->options.outputs.items[i], frame, path, sizeof path, err) ||
            !names_check_writable(path, err))
            return false;
        if (i == 0)
            snprintf(run->film, sizeof run->film, "%s.film", path);
    }
    return true;
}

// An image of the stage's that cannot be read is a warning; one that was asked for by name is not.
static bool check_env(const RenderRun *run, CohortError *err)
{
    const CohortDiagnostic *warnings;
    size_t count = cohort_render_index_warnings(run->index, &warnings);
    for (size_t i = 0; i < count; i++)
        if (!strcmp(warnings[i].place, COHORT_ENV_PATH))
            return fail(err, COHORT_ERROR_TEXTURE, "--env %.80s: %.150s", run->options.env,
                        warnings[i].text);
    return true;
}

// What else than the film itself to do about one that does not fit.
static void say_how_to_begin_anew(const CohortRenderPassState *state, CohortError *err)
{
    size_t length = strlen(err->message);
    if (state->resume_file && !strcmp(err->file, state->resume_file))
        snprintf(err->message + length, sizeof err->message - length,
                 "; without --resume the render begins anew");
}

// A goal that another limit came before.
static void say_what_noise_is_left(const RenderRun *run, const CohortRenderStats *stats)
{
    const RenderOptions *o = &run->options;
    CohortSettingValue spp = {0};
    cohort_delegate_get(run->delegate, "cohort:spp", &spp);
    if (!o->is_quiet && o->noise > 0.0 && stats->mean_error > o->noise)
        fprintf(stderr, "cohort: %s ended it at a mean error of %.3g, above --noise %g\n",
                stats->samples_per_pixel >= (uint64_t)spp.integer ? "--spp" : "--time-limit",
                stats->mean_error, o->noise);
}

// NULL: none, which --resume allows, so that one command line begins and goes on.
static const char *film_to_resume(const RenderRun *run)
{
    if (!run->options.resume || !run->film[0])
        return NULL;
    if (access(run->film, F_OK) == 0)
        return run->film;
    if (!run->options.is_quiet)
        fprintf(stderr, "cohort: there is no %s to resume: the render begins anew\n", run->film);
    return NULL;
}

static bool begin(RenderRun *run, size_t frame, FilmKeeper *keeper, CohortError *err)
{
    double start = render_now();
    is_loading = 1;
    if (!check_files(run, frame, err) ||
        (frame > 0 && !cohort_adapter_set_time(run->adapter, run->frames.times[frame], err)))
        return false;
    cohort_adapter_settings(run->adapter, &run->resolved);
    CohortRenderPassState state = cohort_adapter_pass_state(run->adapter);
    state.bindings = run->buffers.bindings;
    state.binding_count = run->buffers.count;
    state.resume_file = film_to_resume(run);
    cohort_delegate_set_round_callback(run->delegate, keep_film, keeper);
    bool ok = cohort_render_pass_execute(run->pass, &state, err);
    is_loading = 0;
    if (!ok)
        say_how_to_begin_anew(&state, err);
    ok = ok && check_env(run, err);
    run->load_seconds = (frame == 0 ? start - run->start : 0.0) + render_now() - start;
    return ok;
}

// Writes what the last complete round holds. The film comes first when the render is not complete,
// and whenever a picture cannot be written: nothing rendered is lost.
static bool write_all(RenderRun *run, size_t frame, bool is_complete, CohortError *err)
{
    const char *status = is_complete ? "complete" : "interrupted";
    bool ok = is_complete || save_film(run, err);
    ok = write_outputs(run, frame, status, err) && ok;
    ok = write_stats(run, frame, status, err) && ok;
    if (is_complete && ok && run->film[0])
        unlink(run->film);
    else if (is_complete)
        save_film(run, NULL);
    return ok;
}

int render_frame(RenderRun *run, size_t frame, CohortError *err)
{
    FilmKeeper keeper = {.run = run, .last = render_now()};
    // A limit met here is one of the options': --memory or --size.
    if (!begin(run, frame, &keeper, err))
        return err->code == COHORT_ERROR_LIMIT ? EXIT_USAGE : render_exit_code(err);
    watch(run, frame);
    CohortError failure = {0}, unwritten = {0};
    bool has_failed = cohort_render_pass_error(run->pass, &failure);
    CohortRenderStats stats = {0};
    cohort_delegate_render_stats(run->delegate, &stats);
    bool is_written = stats.samples_per_pixel == 0 ||
                      write_all(run, frame, !has_failed && !run->was_interrupted, &unwritten);
    *err = has_failed ? failure : unwritten;
    if (has_failed && !is_written)
        print_failure("warning", &unwritten);
    if (has_failed || !is_written)
        return render_exit_code(err);
    if (!run->was_interrupted)
        say_what_noise_is_left(run, &stats);
    return run->was_interrupted ? EXIT_INTERRUPTED : EXIT_WRITTEN;
}
