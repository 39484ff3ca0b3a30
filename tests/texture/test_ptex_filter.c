// Bilinear and box filters against values of the reference library.

#include "ptex_evaluate.h"
#include "texture_support.h"

#include <dirent.h>
#include <math.h>

#define GOLDENS COHORT_SHARED_DIR "/ptex/goldens"

typedef struct Row {
    CoPtexQuery query;
    uint32_t first, count;
    float tolerance, values[8];
} Row;

static bool read_row(char *line, Row *row)
{
    float cells[24];
    int count = 0;
    for (char *at = line; *at && count < 24; count++) {
        char *end;
        cells[count] = strtof(at, &end);
        if (end == at)
            return false;
        at = *end == ',' ? end + 1 : end;
        if (*end == '\n' || *end == '\r')
            *end = 0, at = end;
    }
    if (count < 14)
        return false;
    row->query = (CoPtexQuery){.face = (uint32_t)cells[1],
                               .u = cells[2],
                               .v = cells[3],
                               .uw1 = cells[4],
                               .vw1 = cells[5],
                               .uw2 = cells[6],
                               .vw2 = cells[7],
                               .width = cells[8],
                               .blur = cells[9]};
    row->first = (uint32_t)cells[10];
    row->count = (uint32_t)(count - 13);
    row->tolerance = cells[12];
    memcpy(row->values, cells + 13, row->count * sizeof(float));
    return true;
}

static int check_csv(const char *name, int *rows)
{
    char path[512], stem[256];
    const char *cut = strstr(name, "__");
    snprintf(stem, sizeof stem, "%.*s", (int)(cut - name), name);
    snprintf(path, sizeof path, GOLDENS "/%s.ptx", stem);
    CohortError err = {0};
    CoPtexFile *file = co_ptex_open(path, &err);
    if (!file)
        fail_msg("%s: %s", path, err.message);
    CoPtexFilter filter = {.kind =
                               strstr(cut, "__box") ? CO_PTEX_FILTER_BOX : CO_PTEX_FILTER_BILINEAR,
                           .no_edge_blend = strstr(cut, "noedgeblend") != NULL};
    snprintf(path, sizeof path, GOLDENS "/filters/%s", name);
    FILE *csv = fopen(path, "r");
    assert_non_null(csv);
    char line[1024];
    Row row;
    CoPtexDecoder decoder = {0};
    int bad = 0;
    while (fgets(line, sizeof line, csv)) {
        if (line[0] == 'i' || !read_row(line, &row))
            continue;
        // Where a black border lets a kernel reach beyond the second face, the reference reads past
        // its texels; nothing outside is what there is.
        if (row.query.u > 1.9f || row.query.v > 1.9f || row.query.u < -0.9f || row.query.v < -0.9f)
            continue;
        float out[8];
        assert_true(evaluate_ptex(file, &filter, &row.query, row.first, row.count, &decoder, out));
        bool is_bad = false;
        for (uint32_t i = 0; i < row.count; i++)
            is_bad |=
                !(fabsf(out[i] - row.values[i]) <= row.tolerance + 2e-6f * fabsf(row.values[i]));
        if (is_bad && bad++ < 2)
            print_message("%s face %u (%.9g, %.9g): %g, expected %g\n", name, row.query.face,
                          (double)row.query.u, (double)row.query.v, (double)out[0],
                          (double)row.values[0]);
        ++*rows;
    }
    fclose(csv);
    co_ptex_decoder_clear(&decoder);
    co_ptex_close(file);
    return bad;
}

static void filters_match_the_reference_library(void **state)
{
    (void)state;
    DIR *folder = opendir(GOLDENS "/filters");
    if (!folder)
        skip();
    int rows = 0, bad = 0;
    for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
        const char *kind = strstr(entry->d_name, "__");
        // Triangle files have a filter of their own; premultiplied reading is not for rendering.
        if (!kind || strstr(entry->d_name, "tri") || strstr(kind, "premult") ||
            (strncmp(kind, "__bilinear", 10) != 0 && strncmp(kind, "__box", 5) != 0))
            continue;
        bad += check_csv(entry->d_name, &rows);
    }
    closedir(folder);
    print_message("%d rows\n", rows);
    assert_true(rows > 3000);
    assert_int_equal(bad, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(filters_match_the_reference_library)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
