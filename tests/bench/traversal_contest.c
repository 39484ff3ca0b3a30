#include "traversal_contest.h"

#include "base/clock.h"
#include "base/parallel.h"

#include <stdio.h>
#include <string.h>

double bench_now(const Bench *bench)
{
    if (!bench->options->cpu)
        return co_clock_seconds();
    clockid_t clock = bench->threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_PROCESS_CPUTIME_ID;
    return bench_seconds(clock) / (double)bench->threads;
}

int bench_list_contenders(const Bench *bench, bool grouped, bool packets, bool coherent,
                          BenchContender *out)
{
    int n = 0;
    out[n++] = (BenchContender){.grouped = grouped};
    for (int mode = 0; mode < 2; mode++)
        for (uint32_t width = 1; bench->embree[mode] && width <= 16;
             width = width == 1 ? 8 : 2 * width)
            if (width == 1 || (packets && bench_embree_has(bench->embree[mode], width)))
                out[n++] = (BenchContender){.embree = bench->embree[mode],
                                            .width = width,
                                            .coherent = coherent && width > 1};
    return n;
}

static void trace_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const BenchTrace *trace = context;
    const BenchContender *c = trace->contender;
    CoTraverseStats stats = {0};
    (void)worker;
    if (c->embree)
        bench_embree_trace(c->embree, c->width, c->coherent, trace->occlusion != NULL, trace->rays,
                           trace->hits, begin, end);
    else
        trace->bench->kernels->traverse(&trace->bench->scene.accel, trace->rays, trace->occlusion,
                                        trace->hits, begin, end, c->grouped,
                                        trace->stats ? trace->stats : &stats);
}

double bench_trace_seconds(const BenchTrace *trace)
{
    double start = bench_now(trace->bench);
    co_parallel_for(trace->rays->count, BENCH_GRAIN, trace_range, (void *)(uintptr_t)trace);
    return bench_now(trace->bench) - start;
}

static void print_number(const char *key, double x)
{
    if (x > 0.0)
        printf(", \"%s\": %.4g", key, x);
    else
        printf(", \"%s\": null", key);
}

void bench_print_row(Bench *bench, const BenchRow *row)
{
    if (!bench->options->json) {
        printf("%-10s %-8s %u %-6s %-12s %8.3f | %8.3f %8.3f | %6.3f %6.3f\n", bench->scene.name,
               row->rays ? row->rays : "-", bench->threads, bench->isa, row->what, row->cohort,
               row->embree[0], row->embree[1], row->ratio[0], row->ratio[1]);
        fflush(stdout);
        return;
    }
    printf("%s\n  {\"scene\": \"%s\", \"rays\": ", bench->has_printed ? "," : "[",
           bench->scene.name);
    if (row->rays)
        printf("\"%s\"", row->rays);
    else
        printf("null");
    printf(", \"threads\": %u, \"isa\": \"%s\", \"what\": \"%s\"", bench->threads, bench->isa,
           row->what);
    if (strncmp(row->what, "sorted", 6) == 0)
        printf(", \"batch\": %zu", (size_t)1 << bench->options->batch_bits);
    print_number("cohort", row->cohort);
    print_number("embree_fast", row->embree[0]);
    print_number("embree_robust", row->embree[1]);
    print_number("ratio_fast", row->ratio[0]);
    print_number("ratio_robust", row->ratio[1]);
    printf("}");
    bench->has_printed = true;
    fflush(stdout);
}

void bench_finish_row(Bench *bench, const char *rays, const char *what, double count,
                      const BenchContender *contenders, int n)
{
    int repeats = bench->options->repeats;
    BenchRow row = {.rays = rays, .what = what};
    row.cohort = count * 1e-6 / bench_median(contenders[0].seconds, repeats);
    for (int c = 1; c < n; c++) {
        int mode = contenders[c].embree == bench->embree[1];
        double rate = count * 1e-6 / bench_median(contenders[c].seconds, repeats);
        if (rate <= row.embree[mode])
            continue;
        double ratios[BENCH_REPEATS_MAX];
        for (int i = 0; i < repeats; i++)
            ratios[i] = contenders[c].seconds[i] / contenders[0].seconds[i];
        row.embree[mode] = rate;
        row.ratio[mode] = bench_median(ratios, repeats);
    }
    bench_print_row(bench, &row);
}
