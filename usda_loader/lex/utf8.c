// UTF-8, and which characters identifiers may have.

#include "lex/scan.h"
#include "lex/xid_table.h"

size_t co_utf8_decode(const char *at, const char *end, uint32_t *code)
{
    const unsigned char *p = (const unsigned char *)at;
    size_t left = (size_t)(end - at);
    if (left == 0)
        return 0;
    if (p[0] < 0x80) {
        *code = p[0];
        return 1;
    }
    size_t length = p[0] >= 0xf0 ? 4 : p[0] >= 0xe0 ? 3 : 2;
    if (p[0] < 0xc2 || p[0] > 0xf4 || left < length)
        return 0;
    uint32_t value = p[0] & (0x7fu >> length);
    for (size_t i = 1; i < length; i++) {
        if ((p[i] & 0xc0) != 0x80)
            return 0;
        value = value << 6 | (p[i] & 0x3fu);
    }
    static const uint32_t least[5] = {0, 0, 0x80, 0x800, 0x10000};
    if (value < least[length] || value > 0x10ffff || (value >= 0xd800 && value < 0xe000))
        return 0;
    *code = value;
    return length;
}

static bool in_ranges(const CoCodeRange *ranges, size_t count, uint32_t code)
{
    size_t low = 0, high = count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (ranges[middle].last < code)
            low = middle + 1;
        else
            high = middle;
    }
    return low < count && ranges[low].first <= code;
}

bool co_utf8_is_xid_start(uint32_t code)
{
    if (code < 0x80)
        return (code | 32) - 'a' < 26 || code == '_';
    return in_ranges(xid_start, sizeof xid_start / sizeof *xid_start, code);
}

bool co_utf8_is_xid_continue(uint32_t code)
{
    if (code < 0x80)
        return (code | 32) - 'a' < 26 || code == '_' || code - '0' < 10;
    return in_ranges(xid_start, sizeof xid_start / sizeof *xid_start, code) ||
           in_ranges(xid_continue, sizeof xid_continue / sizeof *xid_continue, code);
}
