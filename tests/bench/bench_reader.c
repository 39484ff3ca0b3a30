// One reading of one stage by Cohort, measured: every array element is summed, every prim visited
// and every transform resolved before the clock stops. bench_reader.py runs it against the
// reference.
//
// Prints one JSON object: cpu_seconds, wall_seconds, peak_bytes (less what the process held
// before), prims, elements, sum.

#include "arguments.h"
#include "cohort/usda.h"
#include "timing.h"

#include <math.h>
#include <stdio.h>

static const char usage[] = "usage: bench_reader_once STAGE THREADS\n";

typedef struct Totals {
    double sum;
    uint64_t prims, elements;
} Totals;

// In four lanes: the sum must not take longer than the reading.
#define DEFINE_SUM(name, type) \
    static double name(const type *values, size_t count) \
    { \
        double sums[4] = {0}; \
        size_t i = 0; \
        for (; i + 4 <= count; i += 4) \
            for (size_t j = 0; j < 4; j++) \
                sums[j] += (double)values[i + j]; \
        for (; i < count; i++) \
            sums[0] += (double)values[i]; \
        return sums[0] + sums[1] + sums[2] + sums[3]; \
    }

DEFINE_SUM(sum_floats, float)
DEFINE_SUM(sum_doubles, double)
DEFINE_SUM(sum_ints, int32_t)

// Of the types that the measured files hold.
static double sum_value(const CohortValue *value)
{
    switch ((int)value->type) {
    case COHORT_TYPE_INT:
        return sum_ints(value->data, value->count);
    case COHORT_TYPE_FLOAT:
        return sum_floats(value->data, value->count);
    case COHORT_TYPE_FLOAT2:
    case COHORT_TYPE_TEXCOORD2F:
        return sum_floats(value->data, 2 * value->count);
    case COHORT_TYPE_FLOAT3:
    case COHORT_TYPE_POINT3F:
    case COHORT_TYPE_NORMAL3F:
    case COHORT_TYPE_VECTOR3F:
    case COHORT_TYPE_COLOR3F:
        return sum_floats(value->data, 3 * value->count);
    case COHORT_TYPE_DOUBLE:
        return sum_doubles(value->data, value->count);
    case COHORT_TYPE_DOUBLE3:
        return sum_doubles(value->data, 3 * value->count);
    default:
        return 0;
    }
}

static void visit(const CohortPrim *prim, Totals *totals)
{
    double matrix[4][4];
    bool resets;
    if (cohort_prim_local_transform(prim, 0, matrix, &resets))
        totals->sum += matrix[3][0];
    size_t count = cohort_prim_property_count(prim);
    for (size_t i = 0; i < count; i++) {
        const char *name = cohort_prim_property_name(prim, i);
        CohortValue value;
        if (!cohort_prim_value(prim, name, 0, &value))
            continue;
        totals->elements += value.count;
        if (value.is_array)
            totals->sum += sum_value(&value);
    }
    totals->prims++;
    for (size_t i = 0; i < cohort_prim_child_count(prim); i++)
        visit(cohort_prim_child(prim, i), totals);
}

// A line of /proc/self/status in bytes; not getrusage, which counts the process that started this
// one.
static long memory(const char *name)
{
    char line[256];
    long kilobytes = 0;
    FILE *file = fopen("/proc/self/status", "r");
    while (file && fgets(line, sizeof line, file))
        if (strncmp(line, name, strlen(name)) == 0)
            kilobytes = strtol(line + strlen(name), NULL, 10);
    if (file)
        fclose(file);
    return kilobytes * 1024;
}

int main(int argc, char **argv)
{
    const char *path = NULL;
    double threads = 0;
    const BenchArgument arguments[] = {
        {.name = "STAGE", .text = &path},
        {.name = "THREADS", .number = &threads, .least = 1, .most = 1024}};
    bench_arguments_read(argc, argv, usage, arguments, sizeof arguments / sizeof *arguments);
    if (threads == 0)
        bench_refuse(argv[0], "STAGE and THREADS are wanted");
    CohortStageOptions options = {.threads = (uint32_t)threads};
    long base = memory("VmRSS:");
    double wall = bench_seconds(CLOCK_MONOTONIC), cpu = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
    CohortError err = {0};
    CohortStage *stage = cohort_stage_open(path, &options, &err);
    if (!stage) {
        fprintf(stderr, "bench_reader_once: %s\n", err.message);
        return 1;
    }
    Totals totals = {0};
    visit(cohort_stage_root(stage), &totals);
    cpu = bench_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu;
    wall = bench_seconds(CLOCK_MONOTONIC) - wall;
    printf("{\"cpu_seconds\": %.6f, \"wall_seconds\": %.6f, \"peak_bytes\": %ld, \"prims\": %llu, "
           "\"elements\": %llu, \"sum\": %.17g}\n",
           cpu, wall, memory("VmHWM:") - base, (unsigned long long)totals.prims,
           (unsigned long long)totals.elements, totals.sum);
    cohort_stage_destroy(stage);
    return 0;
}
