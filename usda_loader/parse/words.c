// Keywords, names of types, strings and assets.

#include "parse/parser.h"

#include <string.h>

// Names that no type and no metadata may have, by their first letter.
static const char *const keywords['z' - 'A' + 1][10] = {
    ['A' - 'A'] = {"AnimationBlock"},
    ['N' - 'A'] = {"None"},
    ['a' - 'A'] = {"add", "append"},
    ['b' - 'A'] = {"bezier"},
    ['c' - 'A'] = {"class", "config", "connect", "curve", "custom", "customData"},
    ['d' - 'A'] = {"default", "def", "delete", "dictionary", "displayUnit", "doc"},
    ['h' - 'A'] = {"held", "hermite"},
    ['i' - 'A'] = {"inherits"},
    ['k' - 'A'] = {"kind"},
    ['l' - 'A'] = {"linear", "loop"},
    ['n' - 'A'] = {"nameChildren", "none"},
    ['o' - 'A'] = {"offset", "oscillate", "over"},
    ['p' - 'A'] = {"payload", "permission", "post", "pre", "prefixSubstitutions", "prepend",
                   "properties"},
    ['r' - 'A'] = {"references", "relocates", "rel", "reorder", "rootPrims", "repeat", "reset"},
    ['s' - 'A'] = {"scale", "sloped", "subLayers", "suffixSubstitutions", "specializes", "spline",
                   "symmetryArguments", "symmetryFunction"},
    ['t' - 'A'] = {"timeSamples"},
    ['u' - 'A'] = {"uniform"},
    ['v' - 'A'] = {"variantSet", "variantSets", "variants", "varying"},
};

static bool is_keyword(CoSlice slice)
{
    unsigned letter = (unsigned)(unsigned char)slice.begin[0] - 'A';
    if (letter >= sizeof keywords / sizeof *keywords)
        return false;
    for (const char *const *word = keywords[letter]; *word; word++)
        if (co_slice_is(slice, *word))
            return true;
    return false;
}

bool co_scan_type_name(CoScan *scan, CoSlice *out)
{
    const char *from = scan->at, *stop = from;
    CoSlice part;
    while (co_scan_identifier(scan, &part) && !is_keyword(part)) {
        stop = scan->at;
        if (scan->end - stop < 2 || stop[0] != ':' || stop[1] != ':')
            break;
        scan->at += 2;
    }
    scan->at = stop;
    *out = (CoSlice){from, (size_t)(stop - from)};
    return stop > from;
}

static bool check_utf8(CoParser *p, CoSlice slice)
{
    const char *at = slice.begin, *end = slice.begin + slice.length;
    while (at < end) {
        uint64_t eight;
        while (end - at >= 8 &&
               (memcpy(&eight, at, 8), (eight & UINT64_C(0x8080808080808080)) == 0))
            at += 8;
        if (at >= end)
            break;
        uint32_t code;
        size_t step = (unsigned char)*at < 0x80 ? 1 : co_utf8_decode(at, end, &code);
        if (!step)
            return co_parse_fail(p, at, "found a byte of value %d, expected text in UTF-8",
                                 (unsigned char)*at);
        at += step;
    }
    return true;
}

bool co_parse_string(CoParser *p, CohortString *out)
{
    CoSlice slice;
    CoScanStatus status = co_scan_string(&p->scan, &slice);
    if (status == CO_SCAN_OPEN)
        return co_parse_fail(p, p->scan.at, "this string has no end; expected its closing quote%s",
                             p->scan.end - p->scan.at > 2 && p->scan.at[1] == p->scan.at[0]
                                 ? "s"
                                 : " on the same line");
    if (status != CO_SCAN_OK)
        return co_parse_expected(p, "a quoted string");
    if (!check_utf8(p, slice))
        return false;
    if (!memchr(slice.begin, '\\', slice.length)) {
        *out = (CohortString){co_parse_keep_text(p, slice.begin, slice.length), slice.length};
        return out->text != NULL;
    }
    char *text = co_parse_alloc(p, slice.length + 1, 1);
    if (!text)
        return false;
    *out = (CohortString){text, co_scan_unescape(slice, text)};
    return true;
}

bool co_asset_check(CoParser *p, const char *at, const CohortString *asset)
{
    const char *text = asset->text, *end = text + asset->length;
    while (text < end) {
        uint32_t code = 0;
        size_t step = co_utf8_decode(text, end, &code);
        if (!step)
            return co_parse_fail(p, at, "found an asset path that is not UTF-8");
        if (code < 0x20 || code == 0x7f || (code >= 0x80 && code < 0xa0))
            return co_parse_fail(p, at, "found a control character in an asset path");
        text += step;
    }
    return true;
}

bool co_parse_asset(CoParser *p, CohortString *out)
{
    const char *at = p->scan.at;
    CoSlice slice;
    bool triple;
    CoScanStatus status = co_scan_asset(&p->scan, &slice, &triple);
    if (status == CO_SCAN_OPEN)
        return co_parse_fail(p, at,
                             "this asset path has no end; expected its closing @ on the line");
    if (status != CO_SCAN_OK)
        return co_parse_expected(p, "an asset path between @");
    if (!check_utf8(p, slice))
        return false;
    char *text = co_parse_alloc(p, slice.length + 1, 1);
    if (!text)
        return false;
    size_t length = 0;
    for (size_t i = 0; i < slice.length; i++) {
        if (triple && slice.length - i >= 4 && memcmp(slice.begin + i, "\\@@@", 4) == 0)
            i++;
        text[length++] = slice.begin[i];
    }
    *out = (CohortString){text, length};
    return co_asset_check(p, at, out);
}
