#include "parse/parser.h"

#include "base/error.h"
#include "base/hash.h"

#include <stdarg.h>
#include <string.h>

enum {
    FEW_FIELDS = 32,           // are searched in order
    MAX_FIELDS = (1 << 24) - 1 // what CoSpec.field_count can hold
};

static void report(CoParser *p, const char *at, CohortErrorCode code, const char *format,
                   va_list args) __attribute__((format(printf, 4, 0)));

static void report(CoParser *p, const char *at, CohortErrorCode code, const char *format,
                   va_list args)
{
    char text[256];
    uint32_t line, column;
    vsnprintf(text, sizeof text, format, args);
    co_scan_place(&p->scan, at, &line, &column);
    p->error_count++;
    if (p->report)
        p->report(p->cookie, COHORT_SEVERITY_ERROR, p->layer->path, line, column, p->prim_path,
                  text);
    if (p->err && p->err->code == COHORT_OK) {
        CO_FAIL(p->err, code, "%s", text);
        co_error_place(p->err, p->layer->path, line, column, p->prim_path);
    }
}

bool co_parse_fail(CoParser *p, const char *at, const char *format, ...)
{
    if (p->stopped)
        return false;
    va_list args;
    va_start(args, format);
    report(p, at, COHORT_ERROR_USDA_SYNTAX, format, args);
    va_end(args);
    if (p->error_count >= p->max_errors)
        p->stopped = true;
    return false;
}

bool co_parse_stop(CoParser *p, const char *at, CohortErrorCode code, const char *format, ...)
{
    if (p->stopped)
        return false;
    va_list args;
    va_start(args, format);
    report(p, at, code, format, args);
    va_end(args);
    p->stopped = true;
    return false;
}

bool co_parse_give_up(CoParser *p)
{
    p->stopped = true;
    return CO_FAIL(p->err, COHORT_ERROR_CANCELLED, "stopped");
}

// The text at the cursor in a form that can stand in a message.
static void describe(const CoParser *p, char *out, size_t size)
{
    const char *at = p->scan.at;
    size_t left = (size_t)(p->scan.end - at), length = 0;
    if (left == 0) {
        snprintf(out, size, "the end of the file");
        return;
    }
    if (*at == '\n' || *at == '\r') {
        snprintf(out, size, "the end of the line");
        return;
    }
    while (length < left && length < 24 && (unsigned char)at[length] >= 0x20)
        length++;
    while (length > 0 && length < left && ((unsigned char)at[length] & 0xc0) == 0x80)
        length--;
    if (length == 0)
        snprintf(out, size, "a byte of value %d", (unsigned char)*at);
    else
        snprintf(out, size, "'%.*s'", (int)length, at);
}

bool co_parse_expected(CoParser *p, const char *what)
{
    char found[64];
    describe(p, found, sizeof found);
    return co_parse_fail(p, p->scan.at, "found %s, expected %s", found, what);
}

bool co_parse_char(CoParser *p, char c)
{
    if (co_scan_char(&p->scan, c))
        return true;
    char what[4] = {'\'', c, '\'', '\0'};
    return co_parse_expected(p, what);
}

// ---- Fields ------------------------------------------------------------------------------------

// Field names are few and come from tables, so most are known by their address.
static const char *name_token(CoParser *p, const char *name)
{
    size_t slot = (size_t)co_hash64((uint64_t)(uintptr_t)name) % CO_NAME_CACHE;
    if (p->names[slot].name != name) {
        const char *token = co_parse_token(p, name, strlen(name));
        if (!token)
            return NULL;
        p->names[slot].name = name;
        p->names[slot].token = token;
    }
    return p->names[slot].token;
}

static void add_field_slot(CoParser *p, const char *name, uint32_t position)
{
    size_t slot = (size_t)co_hash64((uint64_t)(uintptr_t)name) & (p->field_capacity - 1);
    while (p->field_slots[slot])
        slot = (slot + 1) & (p->field_capacity - 1);
    p->field_slots[slot] = position + 1;
}

// Makes the table that of a spec, with room for one field more.
static bool index_fields(CoParser *p, const CoSpec *spec)
{
    size_t wanted = p->field_capacity ? p->field_capacity : 8 * FEW_FIELDS;
    while (wanted < 2 * ((size_t)spec->field_count + 1))
        wanted *= 2;
    if (p->field_spec == spec && wanted == p->field_capacity)
        return true;
    if (wanted > p->field_capacity) {
        uint32_t *slots = co_realloc(CO_MEMORY_USDA, p->field_slots,
                                     p->field_capacity * sizeof *slots, wanted * sizeof *slots);
        if (!slots)
            return co_parse_stop(p, p->scan.at, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        p->field_slots = slots;
        p->field_capacity = wanted;
    }
    memset(p->field_slots, 0, p->field_capacity * sizeof *p->field_slots);
    for (uint32_t i = 0; i < spec->field_count; i++)
        add_field_slot(p, spec->fields[i].name, i);
    p->field_spec = spec;
    return true;
}

// *found is NULL if there is none.
static bool find_field(CoParser *p, const CoSpec *spec, const char *token, CoField **found)
{
    *found = NULL;
    if (spec->field_count < FEW_FIELDS) {
        for (size_t i = 0; i < spec->field_count; i++)
            if (spec->fields[i].name == token)
                *found = &spec->fields[i];
        return true;
    }
    if (!index_fields(p, spec))
        return false;
    size_t slot = (size_t)co_hash64((uint64_t)(uintptr_t)token) & (p->field_capacity - 1);
    for (; p->field_slots[slot]; slot = (slot + 1) & (p->field_capacity - 1))
        if (spec->fields[p->field_slots[slot] - 1].name == token) {
            *found = &spec->fields[p->field_slots[slot] - 1];
            return true;
        }
    return true;
}

CoValue *co_parse_field(CoParser *p, CoSpec *spec, const char *name, const char *at)
{
    const char *token = name_token(p, name);
    if (!token)
        return NULL;
    CoField *field;
    if (!find_field(p, spec, token, &field))
        return NULL;
    if (!field) {
        if (spec->field_count >= MAX_FIELDS) {
            co_parse_stop(p, at, COHORT_ERROR_LIMIT, "more than %d fields in one place",
                          MAX_FIELDS);
            return NULL;
        }
        field = co_parse_push(p, &spec->fields, spec->field_count, sizeof *field);
        if (!field)
            return NULL;
        if (p->field_spec == spec)
            add_field_slot(p, token, spec->field_count);
        spec->field_count++;
    }
    field->name = token;
    field->line = co_parse_line(p, at);
    return &field->value;
}

bool co_parse_deeper(CoParser *p, const char *at)
{
    if (p->depth >= p->max_depth)
        return co_parse_stop(p, at, COHORT_ERROR_LIMIT,
                             "nested deeper than %llu levels; raise max_depth to read it",
                             (unsigned long long)p->max_depth);
    p->depth++;
    return true;
}

uint32_t co_parse_line(CoParser *p, const char *at)
{
    uint32_t column;
    if (at != p->line_at)
        co_scan_place(&p->scan, at, &p->line, &column);
    p->line_at = at;
    return p->line;
}

// ---- Statements and lists ----------------------------------------------------------------------

static bool at_separator(CoParser *p)
{
    int c = co_scan_peek(&p->scan);
    return c == '\n' || c == '\r' || c == ';';
}

bool co_parse_statements(CoParser *p, char close, CoItemFn *item, void *context)
{
    bool good = true;
    co_scan_space(&p->scan);
    while (!co_scan_char(&p->scan, close)) {
        if (p->scan.at >= p->scan.end)
            return co_parse_char(p, close);
        if (!item(p, context)) {
            good = false;
            if (p->stopped)
                return false;
            co_parse_recover(p);
            if (p->scan.at >= p->scan.end)
                return false;
        }
        co_scan_line(&p->scan);
        if (at_separator(p))
            p->scan.at++;
        else if (co_scan_peek(&p->scan) != close)
            return co_parse_expected(p, close == ')' ? "a line end, ';' or ')'"
                                                     : "a line end, ';' or '}'");
        co_scan_space(&p->scan);
    }
    return good;
}

bool co_parse_list(CoParser *p, char close, bool at_least_one, CoItemFn *item, void *context)
{
    co_scan_space(&p->scan);
    if (!at_least_one && co_scan_char(&p->scan, close))
        return true;
    for (;;) {
        if (!item(p, context))
            return false;
        co_scan_inline(&p->scan);
        bool comma = co_scan_char(&p->scan, ',');
        co_scan_space(&p->scan);
        if (co_scan_char(&p->scan, close))
            return true;
        if (!comma)
            return co_parse_expected(p, close == ']'   ? "',' or ']'"
                                        : close == ')' ? "',' or ')'"
                                                       : "',' or '}'");
    }
}

bool co_parse_assignment(CoParser *p)
{
    co_scan_inline(&p->scan);
    if (!co_scan_char(&p->scan, '='))
        return co_parse_expected(p, "'='");
    co_scan_inline(&p->scan);
    return true;
}

// To the end of a string or asset path, or of as much of the text as one without an end takes up:
// the rest of the line, or of the file in triple quotes.
static void skip_quoted(CoScan *scan)
{
    CoSlice ignored;
    bool triple;
    char c = *scan->at;
    CoScanStatus status =
        c == '@' ? co_scan_asset(scan, &ignored, &triple) : co_scan_string(scan, &ignored);
    if (status == CO_SCAN_OK)
        return;
    triple = c != '@' && scan->end - scan->at > 2 && scan->at[1] == c && scan->at[2] == c;
    const char *stop = memchr(scan->at, '\n', (size_t)(scan->end - scan->at));
    scan->at = triple || !stop ? scan->end : stop;
}

// Moves over one bracket, string, comment or character; tracks the brackets opened.
static void skip_one(CoScan *scan, size_t *open)
{
    char c = *scan->at;
    if (c == '"' || c == '\'' || c == '@') {
        skip_quoted(scan);
        return;
    }
    if ((c == '#' || c == '/') && co_scan_line(scan))
        return;
    *open += c == '(' || c == '[' || c == '{';
    if (*open && (c == ')' || c == ']' || c == '}'))
        --*open;
    scan->at++;
}

void co_parse_recover(CoParser *p)
{
    size_t open = 0;
    while (p->scan.at < p->scan.end) {
        char c = *p->scan.at;
        if (!open && (c == '\n' || c == ';' || c == '}' || c == ')'))
            return;
        skip_one(&p->scan, &open);
    }
}
