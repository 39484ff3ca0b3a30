// Options of cohort render: the table, what they mean together, and their way into the delegate.

#include "render_command.h"

#include "cli.h"

#include <stdio.h>
#include <string.h>

static const char usage[] =
    "cohort render STAGE [-o OUT.exr] [-o OUT.png ...] [options]\n\n"
    "Renders a USD text stage. Outputs are written by their ending: .exr scene-linear with every\n"
    "AOV, .png through an OCIO display and view. Without -o the stage's RenderProduct names the\n"
    "file. Flags beat what the stage authors.\n\n";

static const char exit_codes[] =
    "\nWhile a render lasts, its film is kept beside the first output, every five seconds or so, under\n"
    "that name with .film behind it: OUT.exr.film. --resume goes on from there and gives the same\n"
    "pixels as a render that never stopped. SIGINT and SIGTERM write the last complete round, marked\n"
    "interrupted, or end a stage's loading; SIGUSR1 writes it and goes on.\n"
    "Exit codes: 0 written, 2 usage, 3 the stage cannot be loaded, 4 a file cannot be written,\n"
    "5 interrupted.\n";

static int parse_size(RenderOptions *o)
{
    unsigned w, h;
    char rest;
    if (!o->size)
        return 0;
    if (sscanf(o->size, "%ux%u%c", &w, &h, &rest) != 2 || w == 0 || h == 0 || w > 65536 || h > 65536)
        return usage_error("render", "--size %s: expected WIDTHxHEIGHT, such as 1280x720", o->size);
    o->width = w;
    o->height = h;
    return 0;
}

// "/Prim{set=selection}"
static int parse_variants(RenderOptions *o)
{
    for (size_t i = 0; i < o->variants.count; i++) {
        char *text = o->variant_text[i];
        snprintf(text, sizeof o->variant_text[0], "%s", o->variants.items[i]);
        char *open = strchr(text, '{'), *equals = open ? strchr(open, '=') : NULL;
        char *close = equals ? strchr(equals, '}') : NULL;
        if (text[0] != '/' || !close || close[1])
            return usage_error("render", "--variant %s: expected /Prim{set=selection}",
                               o->variants.items[i]);
        *open = *equals = *close = 0;
        CohortVariantChoice choice = {text, open + 1, equals + 1};
        o->variant_list[i] = choice;
    }
    return 0;
}

static int check(RenderOptions *o)
{
    if (o->preset) {
        o->first_hit_samples = o->first_hit_samples ? o->first_hit_samples : 4;
        o->light_samples = o->light_samples ? o->light_samples : 1;
    }
    if (o->default_time && o->frames)
        return usage_error("render", "--default-time and --frames exclude each other");
    if (o->level >= 0 && o->edge_length > 0.0)
        return usage_error("render", "--level and --edge-length exclude each other");
    int code = parse_size(o);
    return code ? code : parse_variants(o);
}

int render_options_parse(int argc, char **argv, RenderOptions *o, const char **stage)
{
    bool wants_help = false;
    const Option table[] = {
        {"output", 'o', OPTION_LIST, &o->outputs, 0, 0, "FILE", NULL, "an .exr or .png; #### stands for the frame"},
        {"camera", 0, OPTION_TEXT, &o->camera, 0, 0, "PATH", NULL, "path or name of a camera (default: the stage's choice)"},
        {"list-cameras", 0, OPTION_FLAG, &o->list_cameras, 0, 0, NULL, NULL, "print the stage's cameras and render nothing"},
        {"frames", 0, OPTION_TEXT, &o->frames, 0, 0, "SPEC", NULL, "7, 1:5, 5:1, 1:9x2, joined by commas (default: the earliest)"},
        {"default-time", 0, OPTION_FLAG, &o->default_time, 0, 0, NULL, NULL, "default values only, no time samples"},
        {"size", 0, OPTION_TEXT, &o->size, 0, 0, "WxH", NULL, "pixels (default: the stage's, else 1280 wide)"},
        {"render-settings", 0, OPTION_TEXT, &o->settings_prim, 0, 0, "PATH", NULL, "RenderSettings prim (default: the stage's)"},
        {"variant", 0, OPTION_LIST, &o->variants, 0, 0, "/PRIM{SET=SELECTION}", NULL, "select a variant; may be given again"},
        STAGE_OPTION_ROWS(o->part),
        {"level", 0, OPTION_INT, &o->level, 0, 8, "N", NULL, "subdivision level (default 2)"},
        {"edge-length", 0, OPTION_NUMBER, &o->edge_length, 0, 1e6, "PX", NULL, "in place of --level, by size on screen: no edge longer than this many pixels"},
        {"env", 0, OPTION_TEXT, &o->env, 0, 0, "FILE|sky", NULL, "add a dome light: an image, or a built-in sky"},
        {"headlight", 0, OPTION_FLAG, &o->headlight, 0, 0, NULL, NULL, "add a light at the camera"},
        {"hide-lights", 0, OPTION_FLAG, &o->hide_lights, 0, 0, NULL, NULL, "lights and domes do not show in the camera's own rays"},
        {"spp", 0, OPTION_INT, &o->spp, 1, 2147483648.0, "N", NULL, "samples per pixel at most (default 64)"},
        {"time-limit", 0, OPTION_NUMBER, &o->time_limit, 0, 1e9, "SECONDS", NULL, "stop before --spp, at the round that reaches it"},
        {"noise", 0, OPTION_NUMBER, &o->noise, 0, 1, "X", NULL, "stop before --spp, when the mean relative error is below this"},
        {"max-depth", 0, OPTION_INT, &o->max_depth, 1, 1023, "SEGMENTS", NULL, "longest path, the camera's segment is 1 (default 6)"},
        {"first-hit-samples", 0, OPTION_INT, &o->first_hit_samples, 1, 255, "N", NULL, "reflection rays at the first surface (default 1)"},
        {"light-samples", 0, OPTION_INT, &o->light_samples, 1, 255, "N", NULL, "light samples at the first surface (default 1)"},
        {"preset", 0, OPTION_TEXT, &o->preset, 0, 0, NULL, "paper", "4 reflection rays and 1 light sample at the first surface, then 1 and none"},
        {"filter", 0, OPTION_TEXT, &o->filter, 0, 0, NULL, "box|gaussian|blackman-harris", "pixel filter (default blackman-harris)"},
        {"seed", 0, OPTION_INT, &o->seed, 0, 4294967295.0, "N", NULL, "changes all random numbers (default 0)"},
        {"aov", 0, OPTION_LIST, &o->aovs, 0, 0, "NAME", NULL, "depth, cameraDepth, normal, albedo, primId, elementId, sampleCount, error"},
        {"sort", 0, OPTION_TEXT, &o->sort, 0, 0, NULL, "none|rays|hits|both", "which of the two sorts run (default: by the scene)"},
        {"sorter", 0, OPTION_TEXT, &o->sorter, 0, 0, NULL, "exact|fast", "how rays are sorted (default fast)"},
        {"batch", 0, OPTION_INT, &o->batch, 256, 67108864.0, "RAYS", NULL, "rays per batch (default 4194304)"},
        {"scratch", 0, OPTION_TEXT, &o->scratch, 0, 0, "DIR", NULL, "where rays are streamed to (default $TMPDIR or /tmp)"},
        {"memory", 0, OPTION_BYTES, &o->memory, 0, 0, "BYTES", NULL, "most that is resident, with K, M, G or T (default: no limit)"},
        {"threads", 0, OPTION_INT, &o->threads, 1, 4096, "N", NULL, "default: all"},
        {"isa", 0, OPTION_TEXT, &o->isa, 0, 0, NULL, "scalar|sse42|avx2|avx512", "instruction set (default: the machine's best)"},
        {"ptex-reductions", 0, OPTION_TEXT, &o->ptex_reductions, 0, 0, NULL, "linear|authored", "coarse Ptex levels: rebuilt in linear, or the file's"},
        {"converted", 0, OPTION_TEXT, &o->converted, 0, 0, "DIR", NULL, "where converted textures are kept (default $XDG_CACHE_HOME/cohort or ~/.cache/cohort)"},
        {"texture-level0", 0, OPTION_FLAG, &o->texture_level0, 0, 0, NULL, NULL, "full-resolution lookups, for references"},
        {"ocio", 0, OPTION_TEXT, &o->ocio, 0, 0, "CONFIG", NULL, "OCIO config (default $OCIO, else a built-in one)"},
        {"display", 0, OPTION_TEXT, &o->display, 0, 0, "NAME", NULL, "display of PNG outputs (default: the config's)"},
        {"view", 0, OPTION_TEXT, &o->view, 0, 0, "NAME", NULL, "view of PNG outputs (default: the display's)"},
        {"stats", 0, OPTION_TEXT, &o->stats, 0, 0, "FILE.json", NULL, "write every counter, and what was not honored; #### as in -o"},
        {"resume", 0, OPTION_FLAG, &o->resume, 0, 0, NULL, NULL, "go on from the film beside the first output, if it is there"},
        {"progress", 0, OPTION_TEXT, &o->progress, 0, 0, NULL, "alf", "ALF_PROGRESS lines on standard output"},
        {"quiet", 'q', OPTION_FLAG, &o->is_quiet, 0, 0, NULL, NULL, "errors only"},
        {"verbose", 'v', OPTION_FLAG, &o->is_verbose, 0, 0, NULL, NULL, "name everything that is not honored, prim by prim"},
        {"help", 'h', OPTION_FLAG, &wants_help, 0, 0, NULL, NULL, "show this"},
    };
    static const CommandHead head = {"render", usage, exit_codes, 1, "one stage"};
    int first, code = options_begin(&head, table, sizeof table / sizeof table[0], &wants_help, argc,
                                    argv, &first);
    if (code >= 0)
        return code;
    *stage = argv[first];
    code = check(o);
    return code ? code : -1;
}

typedef struct Setter {
    CohortDelegate *delegate;
    CohortError *err;
    bool ok;
} Setter;

static void set_int(Setter *s, const char *key, int64_t value)
{
    if (value && s->ok)
        s->ok = cohort_delegate_set_int(s->delegate, key, value, s->err);
}

static void set_double(Setter *s, const char *key, double value)
{
    if (value > 0.0 && s->ok)
        s->ok = cohort_delegate_set_double(s->delegate, key, value, s->err);
}

static void set_text(Setter *s, const char *key, const char *value)
{
    if (value && s->ok)
        s->ok = cohort_delegate_set_string(s->delegate, key, value, s->err);
}

static void set_bool(Setter *s, const char *key, bool value)
{
    if (value && s->ok)
        s->ok = cohort_delegate_set_bool(s->delegate, key, true, s->err);
}

bool render_options_apply(const RenderOptions *o, CohortDelegate *delegate, CohortError *err)
{
    Setter s = {delegate, err, true};
    set_int(&s, "cohort:spp", o->spp);
    set_int(&s, "cohort:maxDepth", o->max_depth);
    set_int(&s, "cohort:firstHitSamples", o->first_hit_samples);
    set_int(&s, "cohort:lightSamples", o->light_samples);
    set_bool(&s, "cohort:noLightSamplesAfterSplit", o->preset != NULL);
    set_text(&s, "cohort:filter", o->filter);
    set_bool(&s, "cohort:hideLights", o->hide_lights);
    set_int(&s, "cohort:seed", o->seed);
    set_double(&s, "cohort:noise", o->noise);
    set_bool(&s, "cohort:textureLevel0", o->texture_level0);
    set_text(&s, "cohort:ocioConfig", o->ocio);
    set_bool(&s, "cohort:ptexReductionsAuthored",
             o->ptex_reductions && !strcmp(o->ptex_reductions, "authored"));
    set_double(&s, "cohort:timeLimit", o->time_limit);
    set_int(&s, "cohort:batch", o->batch);
    set_int(&s, "cohort:memory", o->memory);
    set_int(&s, "cohort:threads", o->threads);
    set_text(&s, "cohort:sort", o->sort);
    set_text(&s, "cohort:sorter", o->sorter);
    set_text(&s, "cohort:isa", o->isa);
    set_text(&s, "cohort:scratchFolder", o->scratch);
    set_text(&s, "cohort:convertedFolder", o->converted);
    set_double(&s, "cohort:edgeLength", o->edge_length);
    if (s.ok && o->level >= 0)
        s.ok = cohort_delegate_set_int(delegate, "cohort:complexity", o->level, err);
    return s.ok;
}
