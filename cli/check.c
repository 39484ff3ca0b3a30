// cohort check: what is broken in a stage, and what Cohort will not honour.

#include "check.h"
#include "cli.h"
#include "options.h"
#include "stage_options.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void print_json_text(const char *text)
{
    putchar('"');
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        if (*c == '"' || *c == '\\')
            printf("\\%c", *c);
        else if (*c < 0x20)
            printf("\\u%04x", *c);
        else
            putchar(*c);
    }
    putchar('"');
}

static void print_finding(Check *check, CohortSeverity severity, const char *layer, uint32_t line,
                          const char *prim, const char *text)
{
    const char *name = severity == COHORT_SEVERITY_ERROR ? "error" : "warning";
    if (!check->is_json) {
        printf("%s:%u: %s: %s%s%s\n", layer, line, name, text, *prim ? " at " : "", prim);
    } else {
        printf("%s\n  {\"severity\": \"%s\", \"layer\": ",
               check->errors + check->warnings ? "," : "", name);
        print_json_text(layer);
        printf(", \"line\": %u, \"prim\": ", line);
        print_json_text(prim);
        printf(", \"text\": ");
        print_json_text(text);
        putchar('}');
    }
    if (severity == COHORT_SEVERITY_ERROR)
        check->errors++;
    else
        check->warnings++;
}

void check_found(Check *check, CohortSeverity severity, const CohortPrim *prim,
                 const char *property, const char *format, ...)
{
    char text[1024], path[4096];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    snprintf(path, sizeof path, "%s%s%s", cohort_prim_path(prim), property ? "." : "",
             property ? property : "");
    const char *layer = "";
    uint32_t line = 0;
    CohortOpinion opinion;
    if (!property || !cohort_prim_origin(prim, property, &layer, &line))
        if (cohort_prim_opinion(prim, 0, &opinion)) {
            layer = opinion.layer;
            line = opinion.line;
        }
    print_finding(check, severity, layer, line, path, text);
}

static void report(void *cookie, CohortSeverity severity, const char *file, uint32_t line,
                   uint32_t column, const char *prim_path, const char *text)
{
    (void)column;
    print_finding(cookie, severity, file ? file : "", line, prim_path ? prim_path : "", text);
}

static void check_below(Check *check, const CohortPrim *prim)
{
    const CohortPrim *prototype = cohort_prim_prototype(prim);
    if (cohort_prim_parent(prim))
        check_prim(check, prim);
    // What instances share is looked at once.
    for (size_t i = 0; (!prototype || prototype == prim) && i < cohort_prim_child_count(prim); i++)
        check_below(check, cohort_prim_child(prim, i));
}

static void check_stage(Check *check)
{
    const CohortPrim *root = cohort_stage_root(check->stage);
    CohortStageInfo info;
    CohortValue value;
    cohort_stage_info(check->stage, &info);
    if (!cohort_prim_metadata(root, "metersPerUnit", &value))
        check_found(check, COHORT_SEVERITY_WARNING, root, NULL,
                    "no metersPerUnit: the stage is taken to be in centimeters");
    else if (!(info.meters_per_unit > 1e-6 && info.meters_per_unit < 1e6))
        check_found(check, COHORT_SEVERITY_WARNING, root, NULL, "metersPerUnit is %g",
                    info.meters_per_unit);
    if (!cohort_prim_metadata(root, "upAxis", &value))
        check_found(check, COHORT_SEVERITY_WARNING, root, NULL, "no upAxis: it is taken to be Y");
    if (*info.default_prim) {
        char path[4096];
        snprintf(path, sizeof path, "%s%s", *info.default_prim == '/' ? "" : "/",
                 info.default_prim);
        if (!cohort_stage_prim(check->stage, path))
            check_found(check, COHORT_SEVERITY_ERROR, root, NULL, "there is no default prim \"%s\"",
                        info.default_prim);
    }
    check_below(check, root);
}

static int check_path(const char *path, bool is_json, StageOptions *which)
{
    Check check = {.is_json = is_json};
    CohortStageOptions options = {.report = report, .cookie = &check};
    stage_options_apply(which, &options);
    CohortError err = {0};
    if (is_json)
        printf("{\"findings\": [");
    CohortStage *stage = cohort_stage_open(path, &options, &err);
    check.stage = stage;
    if (stage)
        check_stage(&check);
    else if (!check.errors)
        print_finding(&check, COHORT_SEVERITY_ERROR, err.file[0] ? err.file : path, err.line,
                      err.prim_path, err.message);
    if (is_json)
        printf("\n], \"errors\": %zu, \"warnings\": %zu}\n", check.errors, check.warnings);
    cohort_stage_destroy(stage);
    return !stage ? EXIT_LOAD : check.errors ? EXIT_DIFFERENT : EXIT_WRITTEN;
}

int command_check(int argc, char **argv)
{
    bool is_json = false, wants_help = false;
    StageOptions which = {0};
    const Option table[] = {
        {"json", 0, OPTION_FLAG, &is_json, 0, 0, NULL, NULL, "print one JSON object"},
        STAGE_OPTION_ROWS(which),
        {"help", 'h', OPTION_FLAG, &wants_help, 0, 0, NULL, NULL, "show this"},
    };
    enum {
        COUNT = sizeof table / sizeof table[0]
    };
    int first, code = options_parse("check", table, COUNT, argc, argv, &first);
    if (code)
        return code;
    if (wants_help) {
        printf("cohort check STAGE [options]\n\nSays what is broken in a stage and what is not "
               "honoured.\nExit status: 0 sound (warnings at most), 1 errors, 3 cannot be "
               "read.\n\n");
        options_help(table, COUNT);
        return EXIT_WRITTEN;
    }
    if (argc - first != 1)
        return usage_error("check", "expected one stage, got %d", argc - first);
    return check_path(argv[first], is_json, &which);
}
