// The lexical level of USDA: white space, comments, identifiers, strings, asset and path
// references.
//
// The grammar is sensitive to line ends in some places and not in others, so there is no token
// stream: the parser asks for what may stand at the cursor. Each `co_scan_*` either consumes
// exactly what its name says and returns true, or leaves the cursor where it was and returns false.
// Threads: a CoScan belongs to one thread.

#ifndef CO_LEX_SCAN_H
#define CO_LEX_SCAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    CO_SCAN_AHEAD = 32
};

typedef struct CoScan {
    const char *begin, *end;
    const char *at; // the cursor
    // What skips a number or white space from before this place needs no test for the end, and may
    // read CO_SCAN_AHEAD characters at once.
    const char *safe;
    const char *unclosed; // no "*/" stands behind this place: keeps repeated searches linear
    // Lines are counted only when asked for, from the last question on.
    const char *counted;    // everything before has been counted
    const char *line_begin; // of the line that `counted` stands in
    uint32_t line;          // 1-based
} CoScan;

// A run of bytes inside the text.
typedef struct CoSlice {
    const char *begin;
    size_t length;
} CoSlice;

typedef enum CoScanStatus {
    CO_SCAN_NONE = 0, // something else stands here; the cursor did not move
    CO_SCAN_OK,
    CO_SCAN_OPEN // it begins here but never ends; the cursor did not move
} CoScanStatus;

void co_scan_init(CoScan *scan, const char *text, size_t size);

// Line and column (both 1-based, columns in bytes) of a place in the text. Cheap when asked in
// order.
void co_scan_place(CoScan *scan, const char *at, uint32_t *line, uint32_t *column);

// Says how many line ends stand between the place last asked for and `at`, where someone else has
// counted.
void co_scan_count_lines(CoScan *scan, const char *at, uint32_t lines);

// Padding of three strengths: blanks and /* */; also # and // comments up to the line's end; also
// line ends. An unterminated /* is no padding. Each returns whether anything was skipped.
bool co_scan_inline(CoScan *scan);
bool co_scan_line(CoScan *scan);
bool co_scan_space(CoScan *scan);

// Inline padding that holds at least one blank or tab: what must stand between two words.
bool co_scan_gap(CoScan *scan);

static inline int co_scan_peek(const CoScan *scan)
{
    return scan->at < scan->end ? (unsigned char)*scan->at : -1;
}

static inline bool co_scan_char(CoScan *scan, char c)
{
    if (scan->at >= scan->end || *scan->at != c)
        return false;
    scan->at++;
    return true;
}

// A whole word: no identifier character follows it. Most of the words asked for are not there,
// which the first character tells.
bool co_scan_word_rest(CoScan *scan, const char *word);
static inline bool co_scan_word(CoScan *scan, const char *word)
{
    return scan->at < scan->end && *scan->at == word[0] && co_scan_word_rest(scan, word);
}

// Letters, digits, _ and Unicode XID characters, not beginning with a digit. Code points that are
// no well-formed UTF-8 never match.
bool co_scan_identifier(CoScan *scan, CoSlice *out);

// identifier (":" identifier)*
bool co_scan_namespaced(CoScan *scan, CoSlice *out);

// A quoted string in any of the four forms; `out` is what stands between the quotes, escapes
// untouched.
CoScanStatus co_scan_string(CoScan *scan, CoSlice *out);

// @...@ or @@@...@@@; *triple says which, `out` is what stands between.
CoScanStatus co_scan_asset(CoScan *scan, CoSlice *out, bool *triple);

// <...> up to the first '>' on the line; what is inside is not judged here.
CoScanStatus co_scan_path(CoScan *scan, CoSlice *out);

// Undoes the escapes of a string (\n \t \xhh \ooo ...) into `out`, which has room for slice.length
// bytes. Returns the length.
size_t co_scan_unescape(CoSlice slice, char *out);

// True when the whole slice is one identifier.
bool co_slice_is_identifier(CoSlice slice);

// Decodes one code point; returns its bytes, 0 when ill-formed or at the end.
size_t co_utf8_decode(const char *at, const char *end, uint32_t *code);
bool co_utf8_is_xid_start(uint32_t code);
bool co_utf8_is_xid_continue(uint32_t code);

#endif
