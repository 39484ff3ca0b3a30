#include "index/report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *text_or_empty(const char *text)
{
    return text ? text : "";
}

// One string that equal entries share. \x1f cannot stand in a path or a name.
static bool make_key(const CohortReportEntry *e, char **key, size_t *size)
{
    *size = strlen(e->prim_path) + strlen(e->name) + strlen(e->value) + strlen(e->action) + 8;
    *key = co_alloc(CO_MEMORY_DELEGATE, *size);
    if (!*key)
        return false;
    snprintf(*key, *size, "%u\x1f%s\x1f%s\x1f%s\x1f%s", (unsigned)e->severity % 10, e->prim_path,
             e->name, e->value, e->action);
    return true;
}

static bool reserve(CoReport *report)
{
    void *entries = report->entries;
    bool is_done = co_grow(CO_MEMORY_DELEGATE, &entries, report->count, &report->capacity,
                           sizeof *report->entries);
    report->entries = entries;
    return is_done;
}

static const char *copy_text(CoReport *report, const char *text)
{
    return co_arena_string(&report->text, text, strlen(text));
}

static bool append(CoReport *report, const CohortReportEntry *entry, const char *key)
{
    report->text.tag = CO_MEMORY_DELEGATE;
    CohortReportEntry copy = *entry;
    copy.prim_path = copy_text(report, entry->prim_path);
    copy.name = copy_text(report, entry->name);
    copy.value = copy_text(report, entry->value);
    copy.action = copy_text(report, entry->action);
    if (!copy.prim_path || !copy.name || !copy.value || !copy.action || !reserve(report) ||
        !co_string_map_set(&report->places, key, (uint32_t)report->count))
        return false;
    report->entries[report->count++] = copy;
    report->is_sorted = false;
    return true;
}

static int compare_entries(const void *a, const void *b)
{
    const CohortReportEntry *x = a, *y = b;
    int order = strcmp(x->prim_path, y->prim_path);
    if (order == 0)
        order = strcmp(x->name, y->name);
    if (order == 0)
        order = strcmp(x->value, y->value);
    if (order == 0)
        order = strcmp(x->action, y->action);
    return order != 0 ? order : (int)x->severity - (int)y->severity;
}

// The entry of this content; NULL when there is none, or when it was dropped.
static CohortReportEntry *find(const CoReport *report, const CohortReportEntry *e, const char *key)
{
    uint32_t place = co_string_map_find(&report->places, key);
    if (place >= report->count || compare_entries(&report->entries[place], e) != 0)
        return NULL;
    return &report->entries[place];
}

static bool repeat(CoReport *report, CohortReportEntry *entry, uint64_t count)
{
    if (report->is_begun) {
        void *repeats = report->repeats;
        bool has_room = co_grow(CO_MEMORY_DELEGATE, &repeats, report->repeat_count,
                                &report->repeat_capacity, sizeof *report->repeats);
        report->repeats = repeats;
        if (!has_room)
            return false;
        uint32_t place = (uint32_t)(entry - report->entries);
        report->repeats[report->repeat_count++] = (CoReportRepeat){place, count};
    }
    entry->count += count;
    return true;
}

bool co_report_add(CoReport *report, const CohortReportEntry *entry)
{
    CohortReportEntry e = *entry;
    e.prim_path = text_or_empty(e.prim_path);
    e.name = text_or_empty(e.name);
    e.value = text_or_empty(e.value);
    e.action = text_or_empty(e.action);
    e.count = entry->count ? entry->count : 1;
    char *key;
    size_t size;
    if (!make_key(&e, &key, &size))
        return false;
    CohortReportEntry *known = find(report, &e, key);
    bool ok = known ? repeat(report, known, e.count) : append(report, &e, key);
    co_free(CO_MEMORY_DELEGATE, key, size);
    return ok;
}

void co_report_begin(CoReport *report)
{
    report->is_begun = true;
    report->first = report->count;
    report->mark = co_arena_mark(&report->text);
    report->repeat_count = 0;
}

void co_report_end(CoReport *report, bool is_kept)
{
    if (report->is_begun && !is_kept) {
        for (size_t i = 0; i < report->repeat_count; i++)
            report->entries[report->repeats[i].place].count -= report->repeats[i].count;
        report->count = report->first;
        co_arena_rewind(&report->text, report->mark);
    }
    report->is_begun = false;
}

// After a sort the places are stale; the keys are already in the map, so setting them again only
// fails when make_key runs out of memory: later repeats of such an entry are then new entries.
static void rebuild_places(CoReport *report)
{
    for (size_t i = 0; i < report->count; i++) {
        char *key;
        size_t size;
        if (!make_key(&report->entries[i], &key, &size)) {
            co_string_map_clear(&report->places);
            return;
        }
        if (!co_string_map_set(&report->places, key, (uint32_t)i)) {
            co_free(CO_MEMORY_DELEGATE, key, size);
            co_string_map_clear(&report->places);
            return;
        }
        co_free(CO_MEMORY_DELEGATE, key, size);
    }
}

size_t co_report_entries(CoReport *report, const CohortReportEntry **out)
{
    report->is_begun = false;
    if (!report->is_sorted && report->count > 1) {
        qsort(report->entries, report->count, sizeof *report->entries, compare_entries);
        rebuild_places(report);
    }
    report->is_sorted = true;
    *out = report->entries;
    return report->count;
}

void co_report_clear(CoReport *report)
{
    co_free(CO_MEMORY_DELEGATE, report->entries, report->capacity * sizeof *report->entries);
    co_free(CO_MEMORY_DELEGATE, report->repeats, report->repeat_capacity * sizeof *report->repeats);
    co_string_map_clear(&report->places);
    co_arena_clear(&report->text);
    memset(report, 0, sizeof *report);
}
