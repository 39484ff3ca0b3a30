#include "stage_options.h"

#include "cli.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static CohortPaths paths_of(const OptionList *list)
{
    return (CohortPaths){list->items, list->count};
}

static void add_environment(StageOptions *o)
{
    const char *text = getenv("PXR_AR_DEFAULT_SEARCH_PATH");
    if (!text || strlen(text) >= sizeof o->environment)
        return;
    snprintf(o->environment, sizeof o->environment, "%s", text);
    char *at = o->environment;
    while (*at && o->search_paths.count < OPTION_LIST_MAX) {
        char *end = at + strcspn(at, ":");
        bool is_last = !*end;
        *end = 0;
        if (end > at)
            o->search_paths.items[o->search_paths.count++] = at;
        at = is_last ? end : end + 1;
    }
}

void stage_options_apply(StageOptions *o, CohortStageOptions *out)
{
    o->search_path_flags = o->search_paths.count;
    add_environment(o);
    out->mask = paths_of(&o->masks);
    out->muted = paths_of(&o->mutes);
    out->loads = paths_of(&o->loads);
    out->unloads = paths_of(&o->unloads);
    out->search_paths = paths_of(&o->search_paths);
    out->session = o->session;
    out->max_prims = (uint64_t)o->max_prims;
    // To ask for some payloads is to leave out the others.
    out->no_payloads = o->no_payloads || o->loads.count;
}

bool stage_options_compose(const StageOptions *o)
{
    return o->masks.count || o->mutes.count || o->loads.count || o->unloads.count ||
           o->search_paths.count || o->session || o->no_payloads;
}

static bool is_repeated(const OptionList *list, size_t i)
{
    for (size_t k = 0; k < i; k++)
        if (!strcmp(list->items[k], list->items[i]))
            return true;
    return false;
}

static void warn(Messages *messages, const char *option, const char *value, const char *text)
{
    char line[512];
    snprintf(line, sizeof line, "%s %.300s: %s", option, value, text);
    messages_report(messages, COHORT_SEVERITY_WARNING, "", 0, 0, "", line);
}

static void warn_of_slips(const StageOptions *o, const CohortStage *stage, Messages *messages)
{
    for (size_t i = 0; i < o->mutes.count; i++)
        if (!cohort_stage_met_muted(stage, i) && !is_repeated(&o->mutes, i))
            warn(messages, "--mute", o->mutes.items[i],
                 "the stage leads to no such layer (relative paths begin at the stage's folder "
                 "or at the current one)");
    for (size_t i = 0; i < o->search_path_flags; i++) {
        struct stat info;
        const char *path = o->search_paths.items[i];
        if ((stat(path, &info) || !S_ISDIR(info.st_mode)) && !is_repeated(&o->search_paths, i))
            warn(messages, "--search-path", path, "there is no such folder");
    }
}

bool stage_options_check(const StageOptions *o, const CohortStageOptions *options,
                         const CohortStage *stage, Messages *messages, CohortError *err)
{
    const struct {
        const char *option;
        const CohortPaths *prims;
    } lists[] = {
        {"--mask", &options->mask}, {"--load", &options->loads}, {"--unload", &options->unloads}};
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++)
        for (size_t k = 0; k < lists[i].prims->count; k++)
            if (!cohort_stage_prim(stage, lists[i].prims->items[k]))
                return fail(err, COHORT_ERROR_ARGUMENT, "%s %.150s: there is no such prim",
                            lists[i].option, lists[i].prims->items[k]);
    warn_of_slips(o, stage, messages);
    return true;
}

const char *stage_options_in_flags(const char *text, char *out, size_t size)
{
    static const char member[] = "raise max_prims", flag[] = "raise --max-prims";
    const char *at = strstr(text, member);
    if (!at)
        return text;
    snprintf(out, size, "%.*s%s%s", (int)(at - text), text, flag, at + sizeof member - 1);
    return out;
}
