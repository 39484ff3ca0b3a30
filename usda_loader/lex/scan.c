#include "lex/scan.h"

#include <string.h>

void co_scan_init(CoScan *scan, const char *text, size_t size)
{
    *scan = (CoScan){.begin = text, .end = text + size, .at = text, .counted = text};
    scan->line_begin = text;
    scan->line = 1;
    scan->unclosed = scan->end;
    // A character that neither a number nor white space has stops both.
    const char *safe = scan->end;
    while (safe > text && strchr(" \t\r\n.+-eE0123456789", safe[-1]) && safe[-1])
        safe--;
    safe = safe > text ? safe - 1 : text;
    size_t ahead = size < CO_SCAN_AHEAD ? size : CO_SCAN_AHEAD;
    scan->safe = safe < scan->end - ahead ? safe : scan->end - ahead;
}

// Back to a place before what was counted.
static void uncount(CoScan *scan, const char *at)
{
    const char *p = at;
    uint32_t lines = 0;
    while (p < scan->counted && (p = memchr(p, '\n', (size_t)(scan->counted - p))) != NULL) {
        lines++;
        p++;
    }
    scan->counted = at;
    if (!lines)
        return;
    scan->line -= lines;
    while (at > scan->begin && at[-1] != '\n')
        at--;
    scan->line_begin = at;
}

void co_scan_place(CoScan *scan, const char *at, uint32_t *line, uint32_t *column)
{
    if (at < scan->counted)
        uncount(scan, at);
    const char *p = scan->counted;
    while (p < at && (p = memchr(p, '\n', (size_t)(at - p))) != NULL) {
        scan->line++;
        scan->line_begin = ++p;
    }
    scan->counted = at;
    *line = scan->line;
    *column = (uint32_t)(at - scan->line_begin) + 1;
}

void co_scan_count_lines(CoScan *scan, const char *at, uint32_t lines)
{
    scan->counted = at;
    scan->line += lines;
    if (!lines)
        return;
    while (at[-1] != '\n')
        at--;
    scan->line_begin = at;
}

// ---- White space -------------------------------------------------------------------------------

static bool skip_block(CoScan *scan)
{
    if (scan->end - scan->at < 4 || scan->at[1] != '*' || scan->at >= scan->unclosed)
        return false;
    for (const char *p = scan->at + 2; (p = memchr(p, '*', (size_t)(scan->end - p))) != NULL;) {
        p++;
        if (p < scan->end && *p == '/') {
            scan->at = p + 1;
            return true;
        }
    }
    scan->unclosed = scan->at;
    return false;
}

static inline bool skip_block_comment(CoScan *scan)
{
    return scan->at < scan->end && *scan->at == '/' && skip_block(scan);
}

static bool skip_line_comment(CoScan *scan)
{
    const char *p = scan->at;
    if (p >= scan->end || !(*p == '#' || (scan->end - p >= 2 && p[0] == '/' && p[1] == '/')))
        return false;
    const char *stop = memchr(p, '\n', (size_t)(scan->end - p));
    scan->at = stop ? stop : scan->end;
    if (stop && stop > p && stop[-1] == '\r')
        scan->at--;
    return true;
}

static void skip_blanks(CoScan *scan)
{
    while (scan->at < scan->end && (*scan->at == ' ' || *scan->at == '\t'))
        scan->at++;
}

bool co_scan_inline(CoScan *scan)
{
    const char *from = scan->at;
    do
        skip_blanks(scan);
    while (skip_block_comment(scan));
    return scan->at > from;
}

bool co_scan_line(CoScan *scan)
{
    const char *from = scan->at;
    do
        skip_blanks(scan);
    while (skip_block_comment(scan) || skip_line_comment(scan));
    return scan->at > from;
}

bool co_scan_space(CoScan *scan)
{
    const char *from = scan->at;
    for (;;) {
        while (scan->at < scan->end &&
               (*scan->at == ' ' || *scan->at == '\t' || *scan->at == '\n' || *scan->at == '\r'))
            scan->at++;
        if (scan->at >= scan->end || (*scan->at != '#' && *scan->at != '/'))
            break;
        if (!skip_block_comment(scan) && !skip_line_comment(scan))
            break;
    }
    return scan->at > from;
}

bool co_scan_gap(CoScan *scan)
{
    const char *from = scan->at;
    bool blank = false;
    do {
        const char *before = scan->at;
        skip_blanks(scan);
        blank |= scan->at > before;
    } while (skip_block_comment(scan));
    if (!blank)
        scan->at = from;
    return blank;
}

// ---- Words -------------------------------------------------------------------------------------

// Bytes of the identifier character at p, 0 if none.
static size_t identifier_char(const char *p, const char *end, bool first)
{
    if (p >= end)
        return 0;
    unsigned char c = (unsigned char)*p;
    if ((unsigned)(c | 32) - 'a' < 26 || c == '_')
        return 1;
    if (c < 0x80)
        return !first && (unsigned)c - '0' < 10;
    uint32_t code;
    size_t length = co_utf8_decode(p, end, &code);
    if (!length)
        return 0;
    return (first ? co_utf8_is_xid_start(code) : co_utf8_is_xid_continue(code)) ? length : 0;
}

static const char *identifier_end(const char *p, const char *end)
{
    size_t step = identifier_char(p, end, true);
    while (step) {
        p += step;
        step = identifier_char(p, end, false);
    }
    return p;
}

bool co_scan_word_rest(CoScan *scan, const char *word)
{
    size_t length = strlen(word);
    if ((size_t)(scan->end - scan->at) < length || memcmp(scan->at, word, length) != 0 ||
        identifier_char(scan->at + length, scan->end, false))
        return false;
    scan->at += length;
    return true;
}

bool co_scan_identifier(CoScan *scan, CoSlice *out)
{
    const char *stop = identifier_end(scan->at, scan->end);
    if (stop == scan->at)
        return false;
    *out = (CoSlice){scan->at, (size_t)(stop - scan->at)};
    scan->at = stop;
    return true;
}

bool co_scan_namespaced(CoScan *scan, CoSlice *out)
{
    const char *stop = identifier_end(scan->at, scan->end);
    if (stop == scan->at)
        return false;
    while (stop < scan->end && *stop == ':') {
        const char *next = identifier_end(stop + 1, scan->end);
        if (next == stop + 1)
            break;
        stop = next;
    }
    *out = (CoSlice){scan->at, (size_t)(stop - scan->at)};
    scan->at = stop;
    return true;
}

bool co_slice_is_identifier(CoSlice slice)
{
    return slice.length &&
           identifier_end(slice.begin, slice.begin + slice.length) == slice.begin + slice.length;
}

// ---- Quoted things -----------------------------------------------------------------------------

static bool is_triple(const char *p, const char *end, char c)
{
    return end - p >= 3 && p[0] == c && p[1] == c && p[2] == c;
}

CoScanStatus co_scan_string(CoScan *scan, CoSlice *out)
{
    int quote = co_scan_peek(scan);
    if (quote != '"' && quote != '\'')
        return CO_SCAN_NONE;
    bool triple = is_triple(scan->at, scan->end, (char)quote);
    const char *from = scan->at + (triple ? 3 : 1);
    for (const char *p = from; p < scan->end; p++) {
        if (*p == quote && (!triple || is_triple(p, scan->end, (char)quote))) {
            *out = (CoSlice){from, (size_t)(p - from)};
            scan->at = p + (triple ? 3 : 1);
            return CO_SCAN_OK;
        }
        if (*p == '\\' && scan->end - p >= 2 && (p[1] == '\\' || p[1] == quote))
            p++;
        else if (!triple && (*p == '\n' || *p == '\r'))
            return CO_SCAN_OPEN;
    }
    return CO_SCAN_OPEN;
}

static bool is_line_end(char c)
{
    return c == '\n' || c == '\r';
}

static CoScanStatus scan_triple_asset(CoScan *scan, CoSlice *out)
{
    const char *from = scan->at + 3;
    for (const char *p = from; p < scan->end && !is_line_end(*p); p++) {
        if (*p == '\\' && is_triple(p + 1, scan->end, '@')) {
            p += 3;
        } else if (is_triple(p, scan->end, '@')) {
            // Of up to five @ the last three close; the ones before belong to the path.
            for (int i = 0; i < 2 && p + 3 < scan->end && p[3] == '@'; i++)
                p++;
            *out = (CoSlice){from, (size_t)(p - from)};
            scan->at = p + 3;
            return CO_SCAN_OK;
        }
    }
    return CO_SCAN_OPEN;
}

CoScanStatus co_scan_asset(CoScan *scan, CoSlice *out, bool *triple)
{
    if (co_scan_peek(scan) != '@')
        return CO_SCAN_NONE;
    *triple = is_triple(scan->at, scan->end, '@');
    if (*triple)
        return scan_triple_asset(scan, out);
    const char *from = scan->at + 1;
    const char *p = from;
    while (p < scan->end && *p != '@' && !is_line_end(*p))
        p++;
    if (p >= scan->end || *p != '@')
        return CO_SCAN_OPEN;
    *out = (CoSlice){from, (size_t)(p - from)};
    scan->at = p + 1;
    return CO_SCAN_OK;
}

CoScanStatus co_scan_path(CoScan *scan, CoSlice *out)
{
    if (co_scan_peek(scan) != '<')
        return CO_SCAN_NONE;
    const char *from = scan->at + 1;
    const char *p = from;
    while (p < scan->end && *p != '>' && !is_line_end(*p))
        p++;
    if (p >= scan->end || *p != '>')
        return CO_SCAN_OPEN;
    *out = (CoSlice){from, (size_t)(p - from)};
    scan->at = p + 1;
    return CO_SCAN_OK;
}

// ---- Escapes -----------------------------------------------------------------------------------

static int hex_digit(char c)
{
    return c >= '0' && c <= '9'                 ? c - '0'
           : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10
                                                : -1;
}

// Reads up to `most` digits of a base; returns how many.
static size_t escape_number(const char *p, const char *end, int base, size_t most, char *out)
{
    unsigned value = 0;
    size_t count = 0;
    while (count < most && p + count < end) {
        int digit = hex_digit(p[count]);
        if (digit < 0 || digit >= base)
            break;
        value = value * (unsigned)base + (unsigned)digit;
        count++;
    }
    *out = (char)(unsigned char)value;
    return count;
}

size_t co_scan_unescape(CoSlice slice, char *out)
{
    static const char letters[] = "abfnrtv", codes[] = "\a\b\f\n\r\t\v";
    const char *end = slice.begin + slice.length;
    size_t length = 0;
    for (const char *p = slice.begin; p < end; p++) {
        if (*p != '\\' || p + 1 >= end) {
            out[length++] = *p;
            continue;
        }
        const char *known = memchr(letters, *++p, sizeof letters - 1);
        if (known) {
            out[length++] = codes[known - letters];
        } else if (*p == 'x' || hex_digit(*p) >= 0) {
            bool hex = *p == 'x';
            size_t used = escape_number(p + hex, end, hex ? 16 : 8, hex ? 2 : 3, &out[length]);
            if (used || hex)
                p += hex ? used : used - 1;
            else
                out[length] = *p;
            length++;
        } else {
            out[length++] = *p;
        }
    }
    return length;
}
