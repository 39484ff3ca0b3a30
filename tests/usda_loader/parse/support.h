// Parsing a text and keeping what was reported.

#ifndef TEST_PARSE_SUPPORT_H
#define TEST_PARSE_SUPPORT_H

#include "parse/layer.h"
#include "support/files.h"

typedef struct Reports {
    size_t count;
    uint32_t line, column; // of the first
    char text[512];
    char prim[256];
} Reports;

static inline void keep_report(void *cookie, CohortSeverity severity, const char *file,
                               uint32_t line, uint32_t column, const char *prim, const char *text)
{
    Reports *reports = cookie;
    (void)severity;
    (void)file;
    if (reports->count++)
        return;
    reports->line = line;
    reports->column = column;
    snprintf(reports->text, sizeof reports->text, "%s", text);
    snprintf(reports->prim, sizeof reports->prim, "%s", prim);
}

// Parses a copy without a NUL behind it, so that a sanitizer sees any read past the end.
static inline CoLayer *parse_bytes(const char *text, size_t size, const CohortStageOptions *options,
                                   Reports *reports, CohortError *err)
{
    char *copy = malloc(size ? size : 1);
    if (!copy)
        abort();
    memcpy(copy, text, size);
    *reports = (Reports){0};
    *err = (CohortError){0};
    CoLayer *layer = co_layer_parse("test.usda", copy, size, options, keep_report, reports, err);
    free(copy);
    return layer;
}

static inline const char *token(const char *text)
{
    return co_token(text, strlen(text));
}

// Reads a whole file of tests/data/usda; the caller frees it.
static inline char *read_data(const char *name, size_t *size)
{
    char path[1024];
    snprintf(path, sizeof path, COHORT_TEST_DATA_DIR "/usda/%s", name);
    char *text = test_read_file(path, size);
    assert_non_null(text);
    return text;
}

#endif
