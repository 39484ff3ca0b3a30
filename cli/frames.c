#include "frames.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Range {
    double first, last, stride;
} Range;

// Decimal digits only: strtod itself would take the "0x2" of "-4:0x2" for a hexadecimal two.
static bool parse_part(const char **p, double *out)
{
    char text[64];
    size_t length = strspn(*p, "+-.0123456789");
    if (length == 0 || length >= sizeof text)
        return false;
    memcpy(text, *p, length);
    text[length] = 0;
    char *end = NULL;
    *out = strtod(text, &end);
    *p += length;
    return !*end && isfinite(*out);
}

static bool parse_range(const char **p, Range *r)
{
    if (!parse_part(p, &r->first))
        return false;
    r->last = r->first;
    r->stride = 1.0;
    if (**p == ':') {
        (*p)++;
        if (!parse_part(p, &r->last))
            return false;
        r->stride = r->last >= r->first ? 1.0 : -1.0;
        if (**p == 'x') {
            (*p)++;
            if (!parse_part(p, &r->stride))
                return false;
        }
    }
    bool is_forward = r->last >= r->first;
    return r->stride != 0.0 && (r->last == r->first || (r->stride > 0.0) == is_forward);
}

static int digits_needed(double x)
{
    for (int digits = 0; digits < 6; digits++) {
        double scaled = x * pow(10.0, digits);
        if (fabs(scaled - round(scaled)) < 1e-6)
            return digits;
    }
    return 6;
}

static bool append(FrameList *list, double time)
{
    if ((list->count & (list->count - 1)) == 0) {
        double *grown = realloc(list->times, (list->count ? list->count * 2 : 1) * sizeof *grown);
        if (!grown)
            return false;
        list->times = grown;
    }
    list->times[list->count++] = time;
    int digits = digits_needed(time);
    list->precision = digits > list->precision ? digits : list->precision;
    return true;
}

static bool append_range(const Range *r, FrameList *list)
{
    // The end is reached in spite of rounding, as in the reference: half a millionth of a stride.
    double steps = floor((r->last - r->first) / r->stride + 1e-6);
    if (!(steps >= 0.0) || steps + (double)list->count >= (double)FRAMES_MAX)
        return false;
    for (double i = 0.0; i <= steps; i += 1.0)
        if (!append(list, r->first + i * r->stride))
            return false;
    return true;
}

bool frames_parse(const char *spec, FrameList *out, char *why, size_t why_size)
{
    FrameList list = {0};
    const char *p = spec;
    bool ok = *p != 0;
    while (ok) {
        Range range;
        ok = parse_range(&p, &range) && append_range(&range, &list);
        if (!ok || !*p)
            break;
        ok = *p++ == ',';
    }
    if (ok) {
        *out = list;
        return true;
    }
    frames_clear(&list);
    snprintf(why, why_size,
             "\"%s\" is no frame spec: expected 7, 1:5, 5:1, 1:9x2 or several "
             "joined by commas, at most %d frames",
             spec, FRAMES_MAX);
    return false;
}

void frames_clear(FrameList *list)
{
    free(list->times);
    memset(list, 0, sizeof *list);
}

typedef struct Placeholder {
    size_t begin, end;
    int width, precision; // width of the whole number's part; precision -1: no point
} Placeholder;

// Returns how many groups of hashes the name has; the first goes to *out.
static int find_placeholder(const char *pattern, Placeholder *out)
{
    int groups = 0;
    for (size_t i = 0; pattern[i];) {
        if (pattern[i] != '#') {
            i++;
            continue;
        }
        Placeholder found = {i, 0, (int)strspn(pattern + i, "#"), -1};
        i += (size_t)found.width;
        if (pattern[i] == '.' && pattern[i + 1] == '#') {
            found.precision = (int)strspn(pattern + i + 1, "#");
            i += 1 + (size_t)found.precision;
        }
        found.end = i;
        if (groups++ == 0)
            *out = found;
    }
    return groups;
}

bool frames_path(const char *pattern, const FrameList *list, size_t frame, char *out, size_t size,
                 char *why, size_t why_size)
{
    Placeholder p = {0, 0, 0, -1};
    int groups = find_placeholder(pattern, &p);
    size_t count = list ? list->count : 0;
    if (groups > 1 || (groups == 1 && count == 0) || (groups == 0 && count > 1)) {
        snprintf(why, why_size, "%s: %s", pattern,
                 groups > 1    ? "more than one group of # in the name"
                 : groups == 1 ? "the name has a frame placeholder, but no --frames are given"
                               : "several frames need a placeholder such as #### in the name");
        return false;
    }
    snprintf(why, why_size, "%.200s...: the name is too long", pattern);
    if (groups == 0)
        return (size_t)snprintf(out, size, "%s", pattern) < size;
    int precision = p.precision < 0 ? 0 : p.precision;
    if (precision < list->precision) {
        snprintf(why, why_size, "%s: the frames need %d digits after the point, as in ###.%.*s",
                 pattern, list->precision, list->precision, "######");
        return false;
    }
    int width = p.width + (precision ? 1 + precision : 0);
    int n = snprintf(out, size, "%.*s%0*.*f%s", (int)p.begin, pattern, width, precision,
                     list->times[frame], pattern + p.end);
    return n > 0 && (size_t)n < size;
}
