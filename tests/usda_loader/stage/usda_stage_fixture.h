// Opening the stages of tests/data/compose, with what was reported while doing so.

#ifndef TEST_USDA_STAGE_FIXTURE_H
#define TEST_USDA_STAGE_FIXTURE_H

#include "cohort/usda.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define DATA COHORT_TEST_DATA_DIR "/compose/"

typedef struct Reports {
    int count;
    char text[32][512]; // "prim|line|text"
} Reports;

static inline void test_report(void *cookie, CohortSeverity severity, const char *file,
                               uint32_t line, uint32_t column, const char *prim, const char *text)
{
    (void)severity;
    (void)file;
    (void)column;
    Reports *reports = cookie;
    if (reports && reports->count < 32)
        snprintf(reports->text[reports->count++], sizeof reports->text[0], "%s|%u|%s", prim, line,
                 text);
}

static inline bool test_was_reported(const Reports *reports, const char *prim, const char *part)
{
    for (int i = 0; i < reports->count; i++)
        if (!strncmp(reports->text[i], prim, strlen(prim)) && strstr(reports->text[i], part))
            return true;
    return false;
}

static inline CohortStage *test_open(const char *name, Reports *reports)
{
    char path[1024];
    snprintf(path, sizeof path, DATA "%s", name);
    CohortError err = {0};
    CohortStageOptions options = {.report = test_report, .cookie = reports};
    CohortStage *stage = cohort_stage_open(path, &options, &err);
    if (!stage)
        print_error("%s: %s\n", path, err.message);
    assert_non_null(stage);
    return stage;
}

static inline const CohortPrim *test_prim(const CohortStage *stage, const char *path)
{
    const CohortPrim *prim = cohort_stage_prim(stage, path);
    if (!prim)
        print_error("no prim %s\n", path);
    assert_non_null(prim);
    return prim;
}

static inline void test_text(const CohortStage *stage, const char *prim, const char *name,
                             const char *expected)
{
    assert_string_equal(
        cohort_prim_token(test_prim(stage, prim), name, COHORT_TIME_DEFAULT, "<none>"), expected);
}

#endif
