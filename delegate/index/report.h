// The list of what was asked for and not honored: repeats merged, kept as data.

#ifndef CO_DELEGATE_REPORT_H
#define CO_DELEGATE_REPORT_H

#include "cohort/delegate.h"
#include "index/string_map.h"

// So many more of an entry that was there already.
typedef struct CoReportRepeat {
    uint32_t place;
    uint64_t count;
} CoReportRepeat;

typedef struct CoReport {
    CohortReportEntry *entries;
    size_t count, capacity;
    bool is_sorted;
    CoStringMap places; // content -> index in entries, or of one that was dropped; rebuilt by sorts
    CoArena text;
    // Since co_report_begin.
    bool is_begun;
    size_t first; // entry
    CoArenaMark mark;
    CoReportRepeat *repeats;
    size_t repeat_count, repeat_capacity;
} CoReport;

// Adds an entry or counts a repeat. NULL strings count as empty. False when out of memory.
bool co_report_add(CoReport *report, const CohortReportEntry *entry);

// What is added between these two may turn out untrue: it is kept, or as if it had never been said.
// Needs no memory. Whoever reads the entries in between has them for good.
void co_report_begin(CoReport *report);
void co_report_end(CoReport *report, bool is_kept);

// All entries, sorted by path, name, value and action; valid until the next add.
size_t co_report_entries(CoReport *report, const CohortReportEntry **out);

void co_report_clear(CoReport *report);

#endif
