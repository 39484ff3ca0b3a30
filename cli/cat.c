// cohort cat: layers and composed stages as text.

#include "cli.h"
#include "messages.h"
#include "options.h"
#include "stage_options.h"

#include "cohort/usda.h"

static bool flatten(const char *in, const char *out, const StageOptions *which,
                    const CohortStageOptions *options, Messages *messages, CohortError *err)
{
    CohortStage *stage = cohort_stage_open(in, options, err);
    bool ok = stage && stage_options_check(which, options, stage, messages, err) &&
              cohort_stage_flatten(stage, out, err);
    cohort_stage_destroy(stage);
    return ok;
}

int command_cat(int argc, char **argv)
{
    const char *out = NULL;
    bool is_flat = false, wants_help = false;
    StageOptions which = {0};
    const Option table[] = {
        {"output", 'o', OPTION_TEXT, &out, 0, 0, "FILE", NULL,
         "write there, not to standard output"},
        {"flatten", 0, OPTION_FLAG, &is_flat, 0, 0, NULL, NULL,
         "compose the stage first; the next seven are of use with it alone"},
        STAGE_OPTION_ROWS(which),
        {"help", 'h', OPTION_FLAG, &wants_help, 0, 0, NULL, NULL, "show this"},
    };
    static const CommandHead head = {
        "cat", "cohort cat LAYER [options]\n\nWrites a USD text layer back as USDA.\n\n",
        "\nExit codes: 0 written, 2 usage, 3 the layer cannot be loaded, 4 a file or\n"
        "standard output cannot be written.\n",
        1, "one layer"};
    int first, code = options_begin(&head, table, sizeof table / sizeof table[0], &wants_help, argc,
                                    argv, &first);
    if (code >= 0)
        return code;
    if (!is_flat && stage_options_compose(&which))
        return usage_error("cat", "what a stage is composed of is asked for without --flatten");
    CohortError err = {0};
    Messages messages = {0};
    CohortStageOptions options = {.report = messages_report, .cookie = &messages};
    stage_options_apply(&which, &options);
    bool ok = is_flat ? flatten(argv[first], out, &which, &options, &messages, &err)
                      : cohort_layer_cat(argv[first], out, &options, &err);
    messages_end(&messages, &err);
    if (ok)
        return EXIT_WRITTEN;
    return err.code == COHORT_ERROR_FILE_WRITE ? EXIT_WRITE
           : err.code == COHORT_ERROR_ARGUMENT ? EXIT_USAGE
                                               : EXIT_LOAD;
}
