// cohort check: what is broken in a stage, and what Cohort will not honor.

#include "check.h"
#include "cli.h"
#include "options.h"
#include "stage_options.h"

#include "cohort/stage_adapter.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

// ---- Findings ----------------------------------------------------------------------------------

static void add_at(Check *check, FindingCode code, CohortSeverity severity, const CohortPrim *prim,
                   const char *property, const char *text)
{
    Finding finding = {.code = code,
                       .severity = severity,
                       .layer = "",
                       .prim = cohort_prim_path(prim),
                       .property = property ? property : "",
                       .text = text};
    CohortOpinion opinion;
    bool has_origin = property && cohort_prim_origin(prim, property, &finding.layer, &finding.line);
    if (!has_origin && cohort_prim_opinion(prim, 0, &opinion)) {
        finding.layer = opinion.layer;
        finding.line = opinion.line;
    }
    findings_add(&check->findings, &finding);
}

void check_found(Check *check, FindingCode code, CohortSeverity severity, const CohortPrim *prim,
                 const char *property, const char *format, ...)
{
    char text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    add_at(check, code, severity, prim, property, text);
}

// ---- What the loader reports -------------------------------------------------------------------

// What composition goes on without is broken, what it merely ignores is not.
static const struct {
    FindingCode code;
    CohortSeverity severity;
} problem_findings[COHORT_PROBLEM_KIND_COUNT] = {
    [COHORT_PROBLEM_ARC_CYCLE] = {FINDING_COMPOSITION, COHORT_SEVERITY_ERROR},
    [COHORT_PROBLEM_ARC_CAPACITY] = {FINDING_COMPOSITION, COHORT_SEVERITY_ERROR},
    [COHORT_PROBLEM_ARC_TO_MOVED_PRIM] = {FINDING_COMPOSITION, COHORT_SEVERITY_ERROR},
    [COHORT_PROBLEM_INVALID_PRIM_PATH] = {FINDING_COMPOSITION, COHORT_SEVERITY_ERROR},
    [COHORT_PROBLEM_UNRESOLVED_PRIM_PATH] = {FINDING_COMPOSITION, COHORT_SEVERITY_ERROR},
    [COHORT_PROBLEM_INVALID_ASSET_PATH] = {FINDING_MISSING_LAYER, COHORT_SEVERITY_ERROR},
    [COHORT_PROBLEM_MUTED_ASSET_PATH] = {FINDING_COMPOSITION, COHORT_SEVERITY_WARNING},
    [COHORT_PROBLEM_INVALID_REFERENCE_OFFSET] = {FINDING_COMPOSITION, COHORT_SEVERITY_WARNING},
    [COHORT_PROBLEM_INVALID_SUBLAYER_OFFSET] = {FINDING_COMPOSITION, COHORT_SEVERITY_WARNING},
    [COHORT_PROBLEM_INVALID_SUBLAYER_PATH] = {FINDING_MISSING_LAYER, COHORT_SEVERITY_ERROR},
    [COHORT_PROBLEM_SUBLAYER_CYCLE] = {FINDING_COMPOSITION, COHORT_SEVERITY_ERROR},
    [COHORT_PROBLEM_INVALID_RELOCATE] = {FINDING_COMPOSITION, COHORT_SEVERITY_WARNING},
    [COHORT_PROBLEM_CONFLICTING_RELOCATE] = {FINDING_COMPOSITION, COHORT_SEVERITY_WARNING},
    [COHORT_PROBLEM_SAME_TARGET_RELOCATES] = {FINDING_COMPOSITION, COHORT_SEVERITY_WARNING},
    [COHORT_PROBLEM_OPINION_AT_RELOCATION_SOURCE] = {FINDING_COMPOSITION, COHORT_SEVERITY_WARNING},
    [COHORT_PROBLEM_VARIABLE_EXPRESSION] = {FINDING_COMPOSITION, COHORT_SEVERITY_ERROR},
    [COHORT_PROBLEM_CLIPS] = {FINDING_COMPOSITION, COHORT_SEVERITY_ERROR},
};

static void add_problems(Check *check)
{
    CohortProblem problem;
    for (size_t i = 0; cohort_stage_problem(check->stage, i, &problem); i++) {
        Finding finding = {.code = problem_findings[problem.kind].code,
                           .severity = problem_findings[problem.kind].severity,
                           .layer = problem.layer,
                           .line = problem.line,
                           .prim = problem.prim,
                           .text = problem.text};
        // Of a layer that is there the text itself is at fault, or its format.
        if (finding.code == FINDING_MISSING_LAYER && strstr(problem.text, "not supported")) {
            finding.code = FINDING_UNSUPPORTED_LAYER;
            finding.severity = COHORT_SEVERITY_WARNING;
        } else if (finding.code == FINDING_MISSING_LAYER && !strstr(problem.text, "cannot open")) {
            finding.code = FINDING_COMPOSITION;
        }
        findings_add(&check->findings, &finding);
    }
}

// Mistakes in the text of layers. Problems of composition are read as data when the stage is open;
// among them is the arc to each layer that could not be read at all.
static void report(void *cookie, CohortSeverity severity, const char *file, uint32_t line,
                   uint32_t column, const char *prim_path, const char *text)
{
    Check *check = cookie;
    char flags[1024];
    bool is_limit = strstr(text, "; raise max_") != NULL;
    if (severity == COHORT_SEVERITY_ERROR && line)
        findings_add(&check->findings,
                     &(Finding){.code = is_limit ? FINDING_LIMIT : FINDING_SYNTAX,
                                .severity = severity,
                                .layer = file,
                                .line = line,
                                .column = column,
                                .prim = prim_path,
                                .text = stage_options_in_flags(text, flags, sizeof flags)});
}

// ---- What the renderer would not honor ---------------------------------------------------------

static bool is_known(const Check *check, const CohortReportEntry *entry, bool is_property)
{
    const Findings *f = &check->findings;
    for (size_t i = 0; i < f->count; i++)
        if (!strcmp(f->items[i].prim, entry->prim_path) &&
            (is_property ? !strcmp(f->items[i].property, entry->name)
                         : f->items[i].severity == COHORT_SEVERITY_ERROR))
            return true;
    return false;
}

static void add_not_honored(Check *check, CohortDelegate *delegate)
{
    const CohortReportEntry *entries;
    size_t count = cohort_delegate_report(delegate, &entries);
    for (size_t i = 0; i < count; i++) {
        const CohortReportEntry *e = &entries[i];
        const CohortPrim *prim = *e->prim_path ? cohort_stage_prim(check->stage, e->prim_path)
                                               : cohort_stage_root(check->stage);
        bool is_property = prim && (cohort_prim_has_attribute(prim, e->name) ||
                                    cohort_prim_has_relationship(prim, e->name));
        // Composition has been reported, and what is broken is not also unhonored.
        if (!strcmp(e->name, "composition") || is_known(check, e, is_property))
            continue;
        char text[1024];
        snprintf(text, sizeof text, "%s%s%s: %s", e->name, *e->value ? " = " : "", e->value,
                 e->action);
        if (prim)
            add_at(check, FINDING_NOT_HONORED, COHORT_SEVERITY_WARNING, prim,
                   is_property ? e->name : NULL, text);
        else
            findings_add(&check->findings, &(Finding){.code = FINDING_NOT_HONORED,
                                                      .severity = COHORT_SEVERITY_WARNING,
                                                      .prim = e->prim_path,
                                                      .text = text});
    }
}

// ---- The stage ---------------------------------------------------------------------------------

static void check_below(Check *check, const CohortPrim *prim)
{
    const CohortPrim *prototype = cohort_prim_prototype(prim);
    if (cohort_prim_parent(prim))
        check_prim(check, prim);
    // What instances share is looked at once.
    for (size_t i = 0; (!prototype || prototype == prim) && i < cohort_prim_child_count(prim); i++)
        check_below(check, cohort_prim_child(prim, i));
}

static void check_units(Check *check, const CohortPrim *root, double meters_per_unit)
{
    CohortValue value;
    bool has_units = cohort_prim_metadata(root, "metersPerUnit", &value);
    if (!has_units)
        check_found(check, FINDING_UNITS, COHORT_SEVERITY_WARNING, root, NULL,
                    "no metersPerUnit: one unit is taken to be a centimeter");
    else if (!(meters_per_unit >= 1e-6 && meters_per_unit <= 1e6))
        check_found(check, FINDING_UNITS, COHORT_SEVERITY_WARNING, root, NULL,
                    "metersPerUnit is %g: expected 0.01 for centimeters, 1 for meters",
                    meters_per_unit);
    if (!cohort_prim_metadata(root, "upAxis", &value))
        check_found(check, FINDING_UNITS, COHORT_SEVERITY_WARNING, root, NULL,
                    "no upAxis: it is taken to be \"Y\"");
    double size = 0;
    for (int i = 0; i < 3; i++)
        size = fmax(size, check->box[i + 3] - check->box[i]);
    size *= meters_per_unit;
    if (size > 0 && !(size >= 1e-4 && size <= 1e6))
        check_found(check, FINDING_EXTENT, COHORT_SEVERITY_WARNING, root, NULL,
                    "the stage is %g m across with metersPerUnit = %g%s", size, meters_per_unit,
                    has_units ? "" : " (not authored)");
}

static void check_stage(Check *check)
{
    const CohortPrim *root = cohort_stage_root(check->stage);
    CohortStageInfo info;
    cohort_stage_info(check->stage, &info);
    for (int i = 0; i < 6; i++)
        check->box[i] = i < 3 ? (double)INFINITY : -(double)INFINITY;
    check_below(check, root);
    check_units(check, root, info.meters_per_unit);
    if (*info.default_prim) {
        char path[4096];
        snprintf(path, sizeof path, "%s%s", *info.default_prim == '/' ? "" : "/",
                 info.default_prim);
        if (!cohort_stage_prim(check->stage, path))
            check_found(check, FINDING_DEFAULT_PRIM, COHORT_SEVERITY_ERROR, root, NULL,
                        "there is no default prim \"%s\"", info.default_prim);
    }
    if (check->cameras && !check->lights)
        check_found(check, FINDING_NO_LIGHT, COHORT_SEVERITY_WARNING, root, NULL,
                    "there are cameras but no light: the picture will be black");
}

static bool check_path(Check *check, const char *path, StageOptions *which, CohortError *err)
{
    Messages messages = {0};
    CohortAdapterOptions options = {.inspect = true};
    stage_options_apply(which, &options.stage);
    options.stage.report = report;
    options.stage.cookie = check;
    CohortDelegate *delegate = cohort_delegate_create(err);
    CohortRenderIndex *index = delegate ? cohort_render_index_create(delegate, err) : NULL;
    CohortAdapter *adapter = index ? cohort_adapter_open(delegate, path, &options, err) : NULL;
    bool is_read = adapter && stage_options_check(which, &options.stage,
                                                  cohort_adapter_stage(adapter), &messages, err);
    if (is_read) {
        // The stage may be sound and yet nothing that can be rendered.
        CohortError why = {0};
        bool is_pulled =
            cohort_adapter_populate(adapter, &why) && cohort_render_index_pull(index, &why);
        check->stage = cohort_adapter_stage(adapter);
        add_problems(check);
        check_stage(check);
        add_not_honored(check, delegate);
        if (!is_pulled)
            check_found(check, FINDING_NOT_HONORED, COHORT_SEVERITY_ERROR,
                        cohort_stage_root(check->stage), NULL, "it cannot be rendered: %s",
                        why.message);
        // What could not be asked for want of memory is no finding.
        if (why.code == COHORT_ERROR_OUT_OF_MEMORY || cohort_stage_ran_short(check->stage))
            is_read = fail(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    }
    cohort_adapter_destroy(adapter);
    cohort_delegate_destroy(delegate);
    return is_read;
}

typedef struct CheckOptions {
    bool is_json, is_strict;
    StageOptions which;
} CheckOptions;

static int run(const char *path, CheckOptions *options)
{
    Check check = {0};
    CohortError err = {0};
    char text[2 * sizeof err.message];
    bool is_read = check_path(&check, path, &options->which, &err),
         is_limit = err.code == COHORT_ERROR_LIMIT;
    if (err.code == COHORT_ERROR_ARGUMENT || err.code == COHORT_ERROR_OUT_OF_MEMORY) {
        print_failure("error", &err);
        findings_clear(&check.findings);
        return err.code == COHORT_ERROR_ARGUMENT ? EXIT_USAGE : EXIT_LOAD;
    }
    if (!is_read && !check.findings.count)
        findings_add(&check.findings,
                     &(Finding){.code = is_limit ? FINDING_LIMIT : FINDING_MISSING_LAYER,
                                .severity = COHORT_SEVERITY_ERROR,
                                .layer = err.file,
                                .line = err.line,
                                .column = err.column,
                                .prim = err.prim_path,
                                .text = stage_options_in_flags(err.message, text, sizeof text)});
    findings_finish(&check.findings);
    if (options->is_json)
        findings_print_json(&check.findings, path, stdout);
    else
        findings_print(&check.findings, stdout);
    bool is_bad = check.findings.errors || (options->is_strict && check.findings.warnings);
    bool is_whole = !check.findings.is_out_of_memory && fflush(stdout) == 0;
    findings_clear(&check.findings);
    if (!is_whole)
        fprintf(stderr, "cohort check: error: not all findings could be printed\n");
    return !is_read ? EXIT_LOAD : !is_whole ? EXIT_WRITE : is_bad ? EXIT_DIFFERENT : EXIT_WRITTEN;
}

int command_check(int argc, char **argv)
{
    CheckOptions options = {0};
    bool wants_help = false;
    const Option table[] = {
        {"json", 0, OPTION_FLAG, &options.is_json, 0, 0, NULL, NULL, "print one JSON object"},
        {"strict", 0, OPTION_FLAG, &options.is_strict, 0, 0, NULL, NULL,
         "exit with 1 for warnings too"},
        STAGE_OPTION_ROWS(options.which),
        {"help", 'h', OPTION_FLAG, &wants_help, 0, 0, NULL, NULL, "show this"},
    };
    static const CommandHead head = {
        "check",
        "cohort check STAGE [options]\n\n"
        "Says what is broken in a stage and what will not be honored.\n\n",
        "\nExit codes: 0 sound (warnings at most), 1 errors, 2 usage, 3 the stage cannot be\n"
        "loaded, 4 standard output cannot be written.\n",
        1, "one stage"};
    int first, code = options_begin(&head, table, sizeof table / sizeof table[0], &wants_help, argc,
                                    argv, &first);
    return code >= 0 ? code : run(argv[first], &options);
}
