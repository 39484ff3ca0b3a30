// Which part of a stage is opened, and with what on top: the same flags for every sub-command.

#ifndef COHORT_CLI_STAGE_OPTIONS_H
#define COHORT_CLI_STAGE_OPTIONS_H

#include "cohort/usda.h"
#include "messages.h"
#include "options.h"

typedef struct StageOptions {
    OptionList masks, mutes, loads, unloads, search_paths;
    const char *session;
    bool no_payloads;
    int64_t max_prims; // 0: the default
    size_t search_path_flags; // of search_paths, those that were given as flags
    char environment[4096];   // the search paths of PXR_AR_DEFAULT_SEARCH_PATH, cut apart
} StageOptions;

// Rows for an options table; `o` is a StageOptions.
#define STAGE_OPTION_ROWS(o) \
    {"mask", 0, OPTION_LIST, &(o).masks, 0, 0, "PRIM", NULL, \
     "only this prim, what is above and what is below; may be given again"}, \
    {"session", 0, OPTION_TEXT, &(o).session, 0, 0, "LAYER", NULL, \
     "a layer stronger than the stage's own"}, \
    {"mute", 0, OPTION_LIST, &(o).mutes, 0, 0, "LAYER", NULL, \
     "take this layer as empty; may be given again"}, \
    {"no-payloads", 0, OPTION_FLAG, &(o).no_payloads, 0, 0, NULL, NULL, "leave payloads out"}, \
    {"load", 0, OPTION_LIST, &(o).loads, 0, 0, "PRIM", NULL, \
     "but not those at, above and below this prim; may be given again"}, \
    {"unload", 0, OPTION_LIST, &(o).unloads, 0, 0, "PRIM", NULL, \
     "leave out the payloads at and below this prim; may be given again"}, \
    {"search-path", 0, OPTION_LIST, &(o).search_paths, 0, 0, "FOLDER", NULL, \
     "where assets are looked for that lie not beside their layer, before the " \
     "folders of $PXR_AR_DEFAULT_SEARCH_PATH; may be given again"}, \
    {"max-prims", 0, OPTION_INT, &(o).max_prims, 1, 1e12, "N", NULL, \
     "refuse a stage with more prims (5000000)"}

// Puts them into the options of a stage, which point into `o` from then on.
void stage_options_apply(StageOptions *o, CohortStageOptions *out);

// Whether any but --max-prims is given: the others speak of composed stages.
bool stage_options_compose(const StageOptions *o);

// Refuses prims that are named in them and are not in the stage that was opened with them: a slip, by which
// all or nothing would be left out without a word. Layers to mute that the stage does not have, and search
// paths that are no folders, are warnings: they may be right for other stages.
bool stage_options_check(const StageOptions *o, const CohortStageOptions *options,
                         const CohortStage *stage, Messages *messages, CohortError *err);

// An error's text as the user knows its options: by their flags, not as members of a struct.
const char *stage_options_in_flags(const char *text, char *out, size_t size);

#endif
