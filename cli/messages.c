#include "messages.h"

#include "cli.h"

#include "cohort/stage_adapter.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    LINES_MAX = 12, // of what was not honored, unless --verbose
    EQUAL_MAX = 12  // warnings in the same words, likewise
};

static void release(Messages *m)
{
    if (m->held.code != COHORT_OK)
        print_failure("error", &m->held);
    if (m->first.code == COHORT_OK)
        m->first = m->held;
    memset(&m->held, 0, sizeof m->held);
}

// Fowler, Noll, Vo: FNV-1a.
static uint64_t hash_words(const char *text)
{
    uint64_t hash = 0xcbf29ce484222325u;
    for (; *text; text++)
        hash = (hash ^ (unsigned char)*text) * 0x100000001b3u;
    return hash;
}

// Whether these words were printed often enough. Words whose places in the table are the same are
// counted from the last that were others.
static bool is_worn(Messages *m, const char *text)
{
    uint64_t hash = hash_words(text);
    MessagesSaid *said = &m->said[hash % MESSAGES_SAID];
    if (said->hash != hash)
        *said = (MessagesSaid){.hash = hash};
    if (m->is_verbose || said->times++ < EQUAL_MAX)
        return false;
    m->unsaid++;
    return true;
}

void messages_report(void *cookie, CohortSeverity severity, const char *file, uint32_t line,
                     uint32_t column, const char *prim_path, const char *text)
{
    Messages *m = cookie;
    if (severity > COHORT_SEVERITY_WARNING)
        return;
    if (m->held.code != COHORT_OK && strstr(text, m->held.message))
        memset(&m->held, 0, sizeof m->held);
    release(m);
    CohortError said = {.code = COHORT_ERROR_COMPOSITION, .line = line, .column = column};
    snprintf(said.file, sizeof said.file, "%s", file ? file : "");
    snprintf(said.prim_path, sizeof said.prim_path, "%s", prim_path ? prim_path : "");
    snprintf(said.message, sizeof said.message, "%s", text);
    if (severity == COHORT_SEVERITY_ERROR)
        m->held = said;
    else if (!m->is_quiet && !is_worn(m, text))
        print_failure("warning", &said);
}

void messages_end(Messages *m, const CohortError *err)
{
    if (!strcmp(m->held.message, err->message))
        memset(&m->held, 0, sizeof m->held);
    release(m);
    if (m->unsaid)
        fprintf(stderr, "cohort: %zu more warnings in the same words; cohort check names all\n",
                m->unsaid);
    bool is_said = !strcmp(m->first.message, err->message) && m->first.line == err->line;
    if (err->code != COHORT_OK && !is_said)
        print_failure("error", err);
}

static int compare_groups(const void *a, const void *b)
{
    const CohortReportEntry *x = a, *y = b;
    int order = strcmp(x->name, y->name);
    order = order ? order : strcmp(x->action, y->action);
    return order ? order : strcmp(x->prim_path, y->prim_path);
}

static size_t group_end(const CohortReportEntry *entries, size_t count, size_t begin)
{
    size_t end = begin + 1;
    while (end < count && !strcmp(entries[end].name, entries[begin].name) &&
           !strcmp(entries[end].action, entries[begin].action))
        end++;
    return end;
}

// Entries of one name and action, in order of prims: one line. A prim has one for each value.
static void print_entries(const CohortReportEntry *e, size_t count)
{
    bool is_same_value = true;
    size_t prims = 1;
    for (size_t i = 1; i < count; i++) {
        is_same_value = is_same_value && !strcmp(e[i].value, e->value);
        prims += strcmp(e[i].prim_path, e[i - 1].prim_path) != 0;
    }
    fprintf(stderr, "cohort: ");
    if (e->prim_path[0])
        fprintf(stderr, "<%s> ", e->prim_path);
    if (prims > 1)
        fprintf(stderr, "and %zu more: ", prims - 1);
    fprintf(stderr, "%s", e->name);
    if (e->value[0] && is_same_value)
        fprintf(stderr, " = %s", e->value);
    fprintf(stderr, ": %s\n", e->action);
}

// A file that cannot be read is missed by each prim that names it, and by the renderer, once.
static bool is_missing(const CohortReportEntry *e, const CohortDiagnostic *w)
{
    return !strcmp(e->name, "inputs:file") && e->value[0] && !strcmp(e->value, w->place);
}

static bool is_warned_of(const CohortReportEntry *e, const CohortDiagnostic *warnings, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (is_missing(e, &warnings[i]))
            return true;
    return false;
}

static bool is_reported(const CohortDiagnostic *w, const CohortReportEntry *entries, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (is_missing(&entries[i], w))
            return true;
    return false;
}

static void print_report(const CohortReportEntry *entries, size_t count,
                         const CohortDiagnostic *warnings, size_t warning_count, bool is_verbose)
{
    CohortReportEntry *sorted = count ? malloc(count * sizeof *sorted) : NULL;
    if (!sorted)
        return;
    // What composition lost was said when it was met; files are named one by one below.
    size_t kept = 0, lines = 0, hidden = 0;
    for (size_t i = 0; i < count; i++)
        if (strcmp(entries[i].name, "composition") &&
            (is_verbose || !is_warned_of(&entries[i], warnings, warning_count)))
            sorted[kept++] = entries[i];
    qsort(sorted, kept, sizeof *sorted, compare_groups);
    for (size_t i = 0, end; i < kept; i = end) {
        end = is_verbose ? i + 1 : group_end(sorted, kept, i);
        if (lines++ < LINES_MAX || is_verbose)
            print_entries(&sorted[i], end - i);
        else
            hidden += end - i;
    }
    if (hidden)
        fprintf(stderr, "cohort: %zu more not honored; -v or --stats shows all\n", hidden);
    free(sorted);
}

void messages_not_honored(CohortDelegate *delegate, const CohortRenderIndex *index, bool is_verbose)
{
    const CohortReportEntry *entries;
    size_t entry_count = cohort_delegate_report(delegate, &entries);
    const CohortDiagnostic *warnings;
    size_t count = cohort_render_index_warnings(index, &warnings);
    print_report(entries, entry_count, warnings, count, is_verbose);
    for (size_t i = 0; i < count; i++) {
        const CohortDiagnostic *w = &warnings[i];
        // That of --env is the error which ends the render.
        if (!strcmp(w->place, COHORT_ENV_PATH) ||
            (is_verbose && is_reported(w, entries, entry_count)))
            continue;
        fprintf(stderr, "cohort: %s%swarning: %s", w->place, w->place[0] ? ": " : "", w->text);
        if (w->count > 1)
            fprintf(stderr, " (%llu times)", (unsigned long long)w->count);
        fputc('\n', stderr);
    }
}
