#include "findings.h"

#include "json_text.h"
#include "source_line.h"

#include <stdlib.h>
#include <string.h>

static const char *const codes[FINDING_CODE_COUNT] = {
#define FINDING_CODE(name, text, hint) text,
    FINDING_CODES(FINDING_CODE)
#undef FINDING_CODE
};

static const char *const hints[FINDING_CODE_COUNT] = {
#define FINDING_HINT(name, text, hint) hint,
    FINDING_CODES(FINDING_HINT)
#undef FINDING_HINT
};

// ---- Collecting --------------------------------------------------------------------------------

static const char *copy_text(Findings *f, const char *text)
{
    char *copy = text && *text ? strdup(text) : NULL;
    f->is_out_of_memory |= text && *text && !copy;
    return copy ? copy : "";
}

static void free_text(const char *text)
{
    if (*text)
        free((void *)(uintptr_t)text);
}

void findings_add(Findings *f, const Finding *finding)
{
    if (f->count == f->capacity) {
        size_t capacity = f->capacity ? f->capacity * 2 : 64;
        Finding *items = realloc(f->items, capacity * sizeof *items);
        f->is_out_of_memory |= !items;
        if (!items)
            return;
        f->items = items;
        f->capacity = capacity;
    }
    Finding *own = &f->items[f->count++];
    *own = *finding;
    own->layer = copy_text(f, finding->layer);
    own->prim = copy_text(f, finding->prim);
    own->property = copy_text(f, finding->property);
    own->text = copy_text(f, finding->text);
    own->prim_count = 1;
}

// ---- Order -------------------------------------------------------------------------------------

static int compare_place(const Finding *a, const Finding *b)
{
    int order = strcmp(a->layer, b->layer);
    if (!order)
        order = (a->line > b->line) - (a->line < b->line);
    if (!order)
        order = (a->code > b->code) - (a->code < b->code);
    return order ? order : strcmp(a->property, b->property);
}

static int compare_findings(const void *a, const void *b)
{
    const Finding *x = a, *y = b;
    int order = compare_place(x, y);
    if (!order)
        order = strcmp(x->prim, y->prim);
    if (!order)
        order = (x->column > y->column) - (x->column < y->column);
    return order ? order : strcmp(x->text, y->text);
}

static void free_finding(const Finding *finding)
{
    free_text(finding->layer);
    free_text(finding->prim);
    free_text(finding->property);
    free_text(finding->text);
}

static size_t place_end(const Findings *f, size_t begin)
{
    size_t end = begin + 1;
    while (end < f->count && f->items[begin].line &&
           compare_place(&f->items[begin], &f->items[end]) == 0)
        end++;
    return end;
}

// Of one place, keeps what the first prim has and counts the prims; the others get a count of 0.
static void merge_place(Findings *f, size_t begin, size_t end)
{
    const Finding *first = &f->items[begin], *last = first;
    size_t prim_count = 1;
    for (size_t i = begin + 1; i < end; i++) {
        Finding *item = &f->items[i];
        prim_count += strcmp(item->prim, f->items[i - 1].prim) != 0;
        if (strcmp(item->prim, first->prim) != 0 || compare_findings(last, item) == 0)
            item->prim_count = 0;
        else
            last = item;
    }
    for (size_t i = begin; i < end; i++)
        if (f->items[i].prim_count)
            f->items[i].prim_count = prim_count;
}

void findings_finish(Findings *f)
{
    size_t kept = 0;
    if (f->count)
        qsort(f->items, f->count, sizeof *f->items, compare_findings);
    for (size_t i = 0, end; i < f->count; i = end) {
        end = place_end(f, i);
        merge_place(f, i, end);
    }
    f->errors = f->warnings = 0;
    for (size_t i = 0; i < f->count; i++) {
        const Finding item = f->items[i];
        if (!item.prim_count) {
            free_finding(&item);
            continue;
        }
        f->items[kept++] = item;
        f->errors += item.severity == COHORT_SEVERITY_ERROR;
        f->warnings += item.severity != COHORT_SEVERITY_ERROR;
    }
    f->count = kept;
}

void findings_clear(Findings *f)
{
    for (size_t i = 0; i < f->count; i++)
        free_finding(&f->items[i]);
    free(f->items);
    *f = (Findings){0};
}

// ---- Printing ----------------------------------------------------------------------------------

static const char *severity_name(const Finding *finding)
{
    return finding->severity == COHORT_SEVERITY_ERROR ? "error" : "warning";
}

static void print_place(const Finding *finding, FILE *out)
{
    if (*finding->layer)
        fprintf(out, "%s:", path_from_here(finding->layer));
    if (finding->line)
        fprintf(out, "%u:", finding->line);
    if (finding->line && finding->column)
        fprintf(out, "%u:", finding->column);
    if (*finding->layer)
        fputc(' ', out);
}

// The first run of findings of a kind ends with its hint.
void findings_print(const Findings *f, FILE *out)
{
    bool is_hinted[FINDING_CODE_COUNT] = {false};
    for (size_t i = 0; i < f->count; i++) {
        const Finding *item = &f->items[i];
        print_place(item, out);
        fprintf(out, "%s: %s [%s]\n", severity_name(item), item->text, codes[item->code]);
        source_line_print(out, item->layer, item->line, item->column);
        if (strcmp(item->prim, "/") != 0 && *item->prim) {
            fprintf(out, "    at %s%s%s", item->prim, *item->property ? "." : "", item->property);
            if (item->prim_count > 1)
                fprintf(out, " and %zu more", item->prim_count - 1);
            fputc('\n', out);
        }
        if (!is_hinted[item->code] && (i + 1 == f->count || item[1].code != item->code)) {
            fprintf(out, "    hint: %s\n", hints[item->code]);
            is_hinted[item->code] = true;
        }
    }
    if (f->count)
        fprintf(out, "%zu error%s, %zu warning%s\n", f->errors, f->errors == 1 ? "" : "s",
                f->warnings, f->warnings == 1 ? "" : "s");
    else
        fprintf(out, "nothing found\n");
}

static void print_json_member(const char *name, const char *text, FILE *out)
{
    fprintf(out, ", \"%s\": ", name);
    json_print_text(text, out);
}

void findings_print_json(const Findings *f, const char *stage, FILE *out)
{
    fprintf(out, "{\"format\": 1, \"stage\": ");
    json_print_text(stage, out);
    fprintf(out, ", \"errors\": %zu, \"warnings\": %zu, \"findings\": [", f->errors, f->warnings);
    for (size_t i = 0; i < f->count; i++) {
        const Finding *item = &f->items[i];
        fprintf(out, "%s\n  {\"severity\": \"%s\", \"code\": \"%s\"", i ? "," : "",
                severity_name(item), codes[item->code]);
        print_json_member("layer", item->layer, out);
        fprintf(out, ", \"line\": %u, \"column\": %u", item->line, item->column);
        print_json_member("prim", item->prim, out);
        print_json_member("property", item->property, out);
        fprintf(out, ", \"prims\": %zu", item->prim_count);
        print_json_member("text", item->text, out);
        print_json_member("hint", hints[item->code], out);
        fputc('}', out);
    }
    fprintf(out, "%s]}\n", f->count ? "\n" : "");
}
