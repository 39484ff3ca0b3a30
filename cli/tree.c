// cohort tree: the prims of a stage, and where the opinions on one come from.

#include "cli.h"
#include "messages.h"
#include "options.h"
#include "source_line.h"
#include "stage_options.h"

#include "cohort/usda.h"

#include <stdio.h>
#include <string.h>

static void print_variants(const CohortPrim *prim)
{
    for (size_t i = 0; i < cohort_prim_variant_set_count(prim); i++) {
        const char *set = cohort_prim_variant_set(prim, i);
        printf(" {%s=%s}", set, cohort_prim_variant_selection(prim, set));
    }
}

// Arcs of this very prim, each kind and layer once.
static void print_arcs(const CohortPrim *prim)
{
    CohortOpinion last = {.layer = "", .arc = ""}, opinion;
    for (size_t i = 0; cohort_prim_opinion(prim, i, &opinion); i++) {
        bool is_repeated = !strcmp(opinion.arc, last.arc) && !strcmp(opinion.layer, last.layer);
        last = opinion;
        if (is_repeated || !opinion.is_introduced || !strcmp(opinion.arc, "local") ||
            !strcmp(opinion.arc, "variant"))
            continue;
        const char *name = strrchr(opinion.layer, '/');
        printf(" <- %s %s", opinion.arc, name ? name + 1 : opinion.layer);
    }
}

static void print_prim(const CohortPrim *prim, int depth)
{
    const char *type = cohort_prim_type(prim), *kind = cohort_prim_kind(prim);
    printf("%*s%s%s%s", 2 * depth, "", cohort_prim_name(prim), *type ? " " : "", type);
    if (kind && *kind)
        printf(" [%s]", kind);
    print_variants(prim);
    if (cohort_prim_is_instance(prim))
        printf(" (instance of %s)", cohort_prim_path(cohort_prim_prototype(prim)));
    print_arcs(prim);
    putchar('\n');
    for (size_t i = 0; i < cohort_prim_child_count(prim); i++)
        print_prim(cohort_prim_child(prim, i), depth + 1);
}

static void print_opinion(const char *indent, const CohortOpinion *opinion)
{
    bool is_above = !opinion->is_introduced && strcmp(opinion->arc, "local") != 0;
    printf("%s%-10s %s:%u%s\n", indent, opinion->arc, path_from_here(opinion->layer), opinion->line,
           is_above ? " (by an ancestor)" : "");
}

static int print_composition(const CohortStage *stage, const char *path)
{
    const CohortPrim *prim = cohort_stage_prim(stage, path);
    if (!prim) {
        fprintf(stderr, "cohort tree: error: the stage has no prim %s\n", path);
        return EXIT_LOAD;
    }
    CohortOpinion opinion;
    printf("%s %s, strongest first:\n", cohort_prim_path(prim), cohort_prim_type(prim));
    for (size_t i = 0; cohort_prim_opinion(prim, i, &opinion); i++)
        print_opinion("  ", &opinion);
    for (size_t i = 0; i < cohort_prim_property_count(prim); i++) {
        const char *name = cohort_prim_property_name(prim, i);
        printf("  .%s\n", name);
        for (size_t k = 0; cohort_prim_property_opinion(prim, name, k, &opinion); k++)
            print_opinion(k ? "    hidden: " : "    ", &opinion);
    }
    return EXIT_WRITTEN;
}

int command_tree(int argc, char **argv)
{
    const char *path = NULL;
    bool wants_help = false;
    StageOptions which = {0};
    const Option table[] = {
        {"composition", 0, OPTION_TEXT, &path, 0, 0, "PRIM", NULL,
         "show which layer and arc each opinion on a prim comes from"},
        STAGE_OPTION_ROWS(which),
        {"help", 'h', OPTION_FLAG, &wants_help, 0, 0, NULL, NULL, "show this"},
    };
    static const CommandHead head = {
        "tree",
        "cohort tree STAGE [options]\n\nPrints prims with types, kinds, variants and arcs.\n\n",
        "\nExit codes: 0 written, 2 usage, 3 the stage cannot be loaded, 4 standard output\n"
        "cannot be written.\n",
        1, "one stage"};
    int first, code = options_begin(&head, table, sizeof table / sizeof table[0], &wants_help, argc,
                                    argv, &first);
    if (code >= 0)
        return code;
    CohortError err = {0};
    Messages messages = {0};
    CohortStageOptions options = {.report = messages_report, .cookie = &messages};
    stage_options_apply(&which, &options);
    CohortStage *stage = cohort_stage_open(argv[first], &options, &err);
    bool ok = stage && stage_options_check(&which, &options, stage, &messages, &err);
    messages_end(&messages, &err);
    if (!ok) {
        cohort_stage_destroy(stage);
        return err.code == COHORT_ERROR_ARGUMENT ? EXIT_USAGE : EXIT_LOAD;
    }
    const CohortPrim *root = cohort_stage_root(stage);
    code = EXIT_WRITTEN;
    if (path)
        code = print_composition(stage, path);
    for (size_t i = 0; !path && i < cohort_prim_child_count(root); i++)
        print_prim(cohort_prim_child(root, i), 0);
    if (cohort_stage_ran_short(stage)) {
        fail(&err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory: not all that is there is printed");
        print_failure("error", &err);
        code = EXIT_LOAD;
    }
    cohort_stage_destroy(stage);
    return code;
}
