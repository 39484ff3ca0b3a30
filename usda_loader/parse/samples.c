// name.timeSamples = { 1: value, 2: None, ... }

#include "parse/parser.h"

typedef struct Samples {
    const CoSpec *attribute;
    CoTimeSamples *samples;
    bool sorted;
    bool has_opaque; // a value of a type that is not known
} Samples;

// Of a type that is not known the reference takes one value only; None and paths do not count.
static bool take_opaque(CoParser *p, Samples *samples, const char *at, const CoValue *value)
{
    if (value->type != COHORT_TYPE_OPAQUE || *at == '<')
        return true;
    if (samples->has_opaque)
        return co_parse_fail(p, at, "found a second value of type '%s', which is not known",
                             samples->attribute->type_name);
    samples->has_opaque = true;
    return true;
}

static bool sample_item(CoParser *p, void *context)
{
    Samples *samples = context;
    CoNumber time;
    CoValue parsed;
    if (co_scan_number(&p->scan, &time) != CO_SCAN_OK)
        return co_parse_expected(p, "a time or '}'");
    co_scan_inline(&p->scan);
    if (!co_parse_char(p, ':'))
        return false;
    co_scan_inline(&p->scan);
    const char *at = p->scan.at;
    if (!co_parse_typed(p, samples->attribute, &parsed) || !take_opaque(p, samples, at, &parsed))
        return false;
    CoTimeSamples *all = samples->samples;
    double *slot = co_parse_push(p, &all->times, all->count, sizeof *slot);
    CoValue *value = co_parse_push(p, &all->values, all->count, sizeof *value);
    if (!slot || !value)
        return false;
    *slot = time.real;
    *value = parsed;
    size_t n = ++all->count;
    samples->sorted &= n < 2 || all->times[n - 2] < all->times[n - 1];
    return true;
}

// Brings samples into the order of their times by a merge sort; of equal times the last one stays.
static bool sort_samples(CoParser *p, CoTimeSamples *samples)
{
    size_t n = samples->count;
    double *times = co_parse_alloc(p, n, sizeof *times);
    CoValue *values = co_parse_alloc(p, n, sizeof *values);
    if (!times || !values)
        return false;
    for (size_t width = 1; width < n; width *= 2) {
        for (size_t from = 0; from < n; from += 2 * width) {
            size_t middle = from + width < n ? from + width : n;
            size_t stop = middle + width < n ? middle + width : n;
            for (size_t a = from, b = middle, to = from; to < stop; to++) {
                bool first = b >= stop || (a < middle && !(samples->times[b] < samples->times[a]));
                size_t take = first ? a++ : b++;
                times[to] = samples->times[take];
                values[to] = samples->values[take];
            }
        }
        double *old_times = samples->times;
        CoValue *old_values = samples->values;
        samples->times = times;
        samples->values = values;
        times = old_times;
        values = old_values;
    }
    size_t kept = 0;
    for (size_t i = 0; i < n; i++)
        if (i + 1 == n || samples->times[i] != samples->times[i + 1]) {
            samples->times[kept] = samples->times[i];
            samples->values[kept++] = samples->values[i];
        }
    samples->count = kept;
    return true;
}

bool co_parse_samples(CoParser *p, CoSpec *attribute)
{
    const char *at = p->scan.at;
    CoTimeSamples *all = co_parse_alloc(p, 1, sizeof *all);
    Samples samples = {attribute, all, true, false};
    co_parse_line(p, at);
    if (!all || !co_parse_assignment(p) || !co_parse_char(p, '{') ||
        !co_parse_list(p, '}', false, sample_item, &samples))
        return false;
    if (!samples.sorted && !sort_samples(p, all))
        return false;
    CoValue *value = co_parse_field(p, attribute, "timeSamples", at);
    if (value)
        *value = (CoValue){.type = COHORT_TYPE_TIME_SAMPLES, .count = 1, .data = all};
    return value != NULL;
}
