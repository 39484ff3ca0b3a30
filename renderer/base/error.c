#include "base/error.h"

#include <stdarg.h>
#include <string.h>

bool co_error_set(CohortError *err, const char *where, CohortErrorCode code, const char *format,
                  ...)
{
    if (!err || err->code != COHORT_OK)
        return false;
    memset(err, 0, sizeof *err);
    err->code = code;
    const char *slash = strrchr(where, '/');
    err->where = slash ? slash + 1 : where;
    va_list args;
    va_start(args, format);
    vsnprintf(err->message, sizeof err->message, format, args);
    va_end(args);
    return false;
}

void co_error_place(CohortError *err, const char *file, uint32_t line, uint32_t column,
                    const char *prim_path)
{
    if (!err)
        return;
    if (file)
        snprintf(err->file, sizeof err->file, "%s", file);
    if (line)
        err->line = line;
    if (column)
        err->column = column;
    if (prim_path)
        snprintf(err->prim_path, sizeof err->prim_path, "%s", prim_path);
}
