// Numbers and flat tuples of them: all of a mesh. Anything else (comments, nan, odd separators,
// errors) ends a run before its element and is left to the general reader, which judges it.

#include "parse/array.h"

#include <string.h>

// What depends on the type must fold in each loop.
#define ALWAYS_INLINE inline __attribute__((always_inline))

static inline const char *skip_white(const char *p)
{
    while (*p == ' ' || *p == '\n' || *p == '\t' || *p == '\r')
        p++;
    return p;
}

static inline const char *skip_blank(const char *p)
{
    while (*p == ' ' || *p == '\t')
        p++;
    return p;
}

static ALWAYS_INLINE const char *read_component(const char *p, CoScalar scalar, unsigned char *out)
{
    if (scalar == CO_SCALAR_INT) {
        int32_t value;
        p = co_integer_read(p, &value);
        if (p)
            memcpy(out, &value, sizeof value);
        return p;
    }
    double real;
    p = co_number_read(p, &real);
    if (!p)
        return NULL;
    if (scalar == CO_SCALAR_FLOAT) {
        float value = (float)real;
        memcpy(out, &value, sizeof value);
    } else if (scalar == CO_SCALAR_DOUBLE) {
        memcpy(out, &real, sizeof real);
    } else {
        uint16_t half = co_half_from_float((float)real);
        memcpy(out, &half, sizeof half);
    }
    return p;
}

// One element at p, or NULL.
static ALWAYS_INLINE const char *read_element(const char *p, CoScalar scalar, unsigned width,
                                              size_t size, unsigned char *out, const char *safe)
{
    if (!width)
        return read_component(p, scalar, out);
    if (*p++ != '(')
        return NULL;
    for (unsigned i = 0; i < width; i++) {
        if (p > safe || (p = skip_white(p)) >= safe)
            return NULL;
        p = read_component(p, scalar, out + i * size);
        if (!p)
            return NULL;
        p = skip_blank(p);
        if (i + 1 < width && *p++ != ',')
            return NULL;
    }
    return *p == ')' ? p + 1 : NULL;
}

static ALWAYS_INLINE void read_run(CoScalar scalar, unsigned width, const char *safe,
                                   CoPlainRun *run)
{
    size_t size = co_scalar_size(scalar), element = size * (width ? width : 1), count = 0;
    const char *at = run->at, *stop = run->stop;
    unsigned char *out = run->out;
    for (size_t most = run->most; count < most && at < stop; count++, out += element) {
        const char *next = read_element(at, scalar, width, size, out, safe);
        if (!next || next > safe)
            break;
        next = skip_blank(next);
        if (next >= safe || *next != ',')
            break;
        at = skip_white(next + 1);
    }
    run->at = at;
    run->count = count;
}

bool co_plain_type(const CoTypeInfo *info)
{
    return !info->rows && !info->is_quaternion &&
           (info->scalar == CO_SCALAR_INT || info->scalar == CO_SCALAR_FLOAT ||
            info->scalar == CO_SCALAR_DOUBLE || info->scalar == CO_SCALAR_HALF);
}

void co_plain_read(const CoTypeInfo *info, const char *safe, CoPlainRun *run)
{
    if (info->scalar == CO_SCALAR_INT && !info->columns)
        read_run(CO_SCALAR_INT, 0, safe, run);
    else if (info->scalar == CO_SCALAR_FLOAT && !info->columns)
        read_run(CO_SCALAR_FLOAT, 0, safe, run);
    else if (info->scalar == CO_SCALAR_FLOAT && info->columns == 2)
        read_run(CO_SCALAR_FLOAT, 2, safe, run);
    else if (info->scalar == CO_SCALAR_FLOAT && info->columns == 3)
        read_run(CO_SCALAR_FLOAT, 3, safe, run);
    else
        read_run(info->scalar, info->columns, safe, run);
}
