// cohort render: from the command line to a render pass, frame by frame.

#include "render_command.h"

#include "cli.h"
#include "names.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char null_product[] = "husk:null_raster"; // render, and write nothing

int render_exit_code(const CohortError *err)
{
    if (err->code == COHORT_ERROR_ARGUMENT)
        return EXIT_USAGE;
    if (err->code == COHORT_ERROR_CANCELLED)
        return EXIT_INTERRUPTED;
    return err->code == COHORT_ERROR_FILE_WRITE ? EXIT_WRITE : EXIT_LOAD;
}

// ---- Names -------------------------------------------------------------------------------------

// Without -o the stage's first RenderProduct names the output.
static bool choose_product(RenderRun *run, CohortError *err)
{
    const char *name = run->resolved.product_name;
    if (run->options.outputs.count || !strcmp(name, null_product))
        return true;
    if (!name[0])
        return fail(err, COHORT_ERROR_ARGUMENT,
                    "name at least one output with -o: the stage's render settings name none");
    snprintf(run->product, sizeof run->product, "%s", name);
    run->options.outputs.items[run->options.outputs.count++] = run->product;
    return names_check(run, err);
}

// ---- Stage -------------------------------------------------------------------------------------

// "/Prim{set=selection}" that selects nothing is a slip of the user's.
static bool check_variants(const RenderRun *run, CohortError *err)
{
    const CohortStage *stage = cohort_adapter_stage(run->adapter);
    for (size_t i = 0; i < run->options.variants.count; i++) {
        const CohortVariantChoice *choice = &run->options.variant_list[i];
        const CohortPrim *prim = cohort_stage_prim(stage, choice->prim);
        size_t count = prim ? cohort_prim_variant_count(prim, choice->set) : 0;
        bool is_there = false;
        for (size_t k = 0; k < count; k++)
            is_there =
                is_there || !strcmp(cohort_prim_variant(prim, choice->set, k), choice->selection);
        if (!is_there)
            return fail(err, COHORT_ERROR_ARGUMENT, "--variant %.150s: %s",
                        run->options.variants.items[i],
                        !prim    ? "there is no such prim"
                        : !count ? "the prim has no such variant set"
                                 : "the set has no such variant");
    }
    return true;
}

static bool open_stage(RenderRun *run, CohortError *err)
{
    RenderOptions *o = &run->options;
    CohortAdapterOptions options = {.camera = o->camera,
                                    .render_settings = o->settings_prim,
                                    .width = o->width,
                                    .height = o->height,
                                    .env = o->env,
                                    .headlight = o->headlight};
    stage_options_apply(&o->part, &options.stage);
    options.stage.threads = (uint32_t)o->threads;
    options.stage.variants = o->variant_list;
    options.stage.variant_count = o->variants.count;
    options.stage.stop = render_stop_flag();
    options.stage.report = messages_report;
    options.stage.cookie = &run->messages;
    if (o->default_time)
        options.time_choice = COHORT_TIME_DEFAULTS;
    if (run->frames.count) {
        options.time_choice = COHORT_TIME_AT;
        options.time = run->frames.times[0];
    }
    run->adapter = cohort_adapter_open(run->delegate, run->stage_path, &options, err);
    if (!run->adapter ||
        !stage_options_check(&o->part, &options.stage, cohort_adapter_stage(run->adapter),
                             &run->messages, err) ||
        !check_variants(run, err) || !cohort_adapter_populate(run->adapter, err))
        return false;
    cohort_adapter_settings(run->adapter, &run->resolved);
    return true;
}

static bool check_env(const RenderOptions *o, CohortError *err)
{
    if (!o->env || !strcmp(o->env, "sky") || access(o->env, R_OK) == 0)
        return true;
    return fail(err, COHORT_ERROR_FILE_NOT_FOUND, "--env %.150s: %s; name an image, or \"sky\"",
                o->env, strerror(errno));
}

static bool load(RenderRun *run, CohortError *err)
{
    run->delegate = cohort_delegate_create(err);
    if (!run->delegate || !check_env(&run->options, err) ||
        !render_options_apply(&run->options, run->delegate, err))
        return false;
    cohort_delegate_set_stop_flag(run->delegate, render_stop_flag());
    run->index = cohort_render_index_create(run->delegate, err);
    return run->index && open_stage(run, err);
}

// Options that no output heeds.
static bool check_outputs_heed(const RenderOptions *o, CohortError *err)
{
    bool has_exr = false, has_png = false;
    for (size_t i = 0; i < o->outputs.count; i++) {
        bool is_png = output_is_png(o->outputs.items[i]);
        has_png = has_png || is_png;
        has_exr = has_exr || !is_png;
    }
    for (size_t i = 0; i < o->aovs.count && has_png && !has_exr; i++)
        if (strcmp(o->aovs.items[i], "color"))
            return fail(err, COHORT_ERROR_ARGUMENT,
                        "--aov %.80s: only .exr outputs hold it, and there is none",
                        o->aovs.items[i]);
    if ((o->display || o->view) && has_exr && !has_png && !o->is_quiet)
        fprintf(stderr,
                "cohort: warning: --display and --view change .png outputs alone; there is none\n");
    return true;
}

static bool open_view(RenderRun *run, CohortError *err)
{
    const RenderOptions *o = &run->options;
    bool wants_view = o->display || o->view;
    for (size_t i = 0; i < o->outputs.count; i++)
        wants_view = wants_view || output_is_png(o->outputs.items[i]);
    if (!wants_view)
        return true;
    CohortSettingValue space = {0};
    cohort_delegate_get(run->delegate, "cohort:renderingColorSpace", &space);
    run->view = cohort_view_create(o->ocio, space.string, o->display, o->view, err);
    return run->view != NULL;
}

static bool prepare(RenderRun *run, CohortError *err)
{
    const RenderOptions *o = &run->options;
    if (!choose_product(run, err) || !open_view(run, err) || !check_outputs_heed(o, err))
        return false;
    run->pass = cohort_render_pass_create(run->index, err);
    return run->pass &&
           output_buffers_create(run->delegate, run->resolved.width, run->resolved.height,
                                 o->aovs.items, o->aovs.count, &run->buffers, err);
}

// ---- Run ---------------------------------------------------------------------------------------

static int render_frames(RenderRun *run, CohortError *err)
{
    const RenderOptions *o = &run->options;
    size_t count = run->frames.count ? run->frames.count : 1;
    progress_begin(&run->progress, o->progress != NULL, o->is_quiet, count);
    if (run->resolved.light_count == 0 && !o->env && !o->headlight && !o->is_quiet)
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

static int list_cameras(const RenderRun *run)
{
    const char *camera;
    for (size_t i = 0; (camera = cohort_adapter_camera(run->adapter, i)) != NULL; i++)
        printf("%s%s\n", camera, strcmp(camera, run->resolved.camera) ? "" : " (default)");
    return EXIT_WRITTEN;
}

static int run_render(RenderRun *run, CohortError *err)
{
    if ((!run->options.list_cameras && !names_check(run, err)) || !load(run, err))
        return render_exit_code(err);
    if (run->options.list_cameras)
        return list_cameras(run);
    if (!prepare(run, err))
        return render_exit_code(err);
    return render_frames(run, err);
}

static void end(RenderRun *run, int code, const CohortError *err)
{
    if (err->code == COHORT_ERROR_CANCELLED) { // who stops the loading wants to hear no more of it
        render_say_interrupted();
        return;
    }
    if (run->adapter && !run->options.is_quiet && !run->options.list_cameras)
        messages_not_honored(run->delegate, run->index, run->options.is_verbose);
    messages_end(&run->messages, err);
    if (run->has_film && code != EXIT_WRITTEN)
        fprintf(stderr, "cohort: %s; --resume goes on from %s\n",
                code == EXIT_INTERRUPTED ? "interrupted" : "the complete rounds are kept",
                run->film);
    else if (code == EXIT_INTERRUPTED)
        render_say_interrupted();
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
    RenderRun run = {.start = render_now(), .options.level = -1};
    int code = render_options_parse(argc, argv, &run.options, &run.stage_path);
    if (code >= 0)
        return code;
    char why[512];
    if (run.options.frames && !frames_parse(run.options.frames, &run.frames, why, sizeof why))
        return usage_error("render", "%s", why);
    run.messages.is_quiet = run.options.is_quiet;
    run.messages.is_verbose = run.options.is_verbose;
    render_catch_signals();
    CohortError err = {0};
    code = run_render(&run, &err);
    end(&run, code, &err);
    clear(&run);
    return code;
}
