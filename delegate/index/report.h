// The list of what was asked for and not honored: repeats merged, kept as data.

#ifndef CO_DELEGATE_REPORT_H
#define CO_DELEGATE_REPORT_H

#include "cohort/delegate.h"
#include "index/string_map.h"

typedef struct CoReport {
    CohortReportEntry *entries;
    size_t count, capacity;
    bool is_sorted;
    CoStringMap places; // content -> index in entries; rebuilt after a sort
    CoArena text;
} CoReport;

// Adds an entry or counts a repeat. NULL strings count as empty. False when out of memory.
bool co_report_add(CoReport *report, const CohortReportEntry *entry);

// All entries, sorted by path, name, value and action; valid until the next add.
size_t co_report_entries(CoReport *report, const CohortReportEntry **out);

void co_report_clear(CoReport *report);

#endif
