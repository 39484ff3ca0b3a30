#include "base/parallel.h"

#include <omp.h>
#include <stdio.h>

// Each thread that starts parallel work has its own count, so that two renders of one process do
// not disturb each other. 0: not chosen yet.
static _Thread_local int thread_count;

void co_worker_count_set(uint32_t count)
{
    // Far more threads than processors only cost memory, and starting them may fail without a word.
    int procs = omp_get_num_procs(), most = procs > 16 ? 4 * procs : 64;
    thread_count = count == 0 ? procs : count > (uint32_t)most ? most : (int)count;
}

uint32_t co_worker_count(void)
{
    if (thread_count == 0)
        thread_count = omp_get_num_procs();
    return (uint32_t)thread_count;
}

// Of all processes; 0 where the system does not say.
static unsigned running_threads(void)
{
    FILE *f = fopen("/proc/loadavg", "r");
    unsigned running;
    bool is_read = f && fscanf(f, "%*s %*s %*s %u", &running) == 1;
    if (f)
        fclose(f);
    return is_read ? running : 0;
}

uint32_t co_worker_count_at_hand(void)
{
    uint32_t count = co_worker_count();
    // Threads of this process that wait by spinning are among those that run.
    bool is_busy = count > 1 && running_threads() > 2 * (unsigned)omp_get_num_procs();
    return is_busy ? 1 : count;
}

bool co_in_parallel(void)
{
    return omp_in_parallel();
}

void co_parallel_for(size_t count, size_t grain, CoParallelFn *fn, void *context)
{
    if (count == 0)
        return;
    if (grain == 0)
        grain = 1;
    size_t blocks = (count - 1) / grain + 1;
    int threads = (int)co_worker_count();
    if (blocks == 1 || threads == 1) {
        fn(context, 0, count, 0);
        return;
    }
    threads = blocks < (size_t)threads ? (int)blocks : threads;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t block = 0; block < blocks; block++) {
        size_t begin = block * grain;
        size_t end = count - begin < grain ? count : begin + grain;
        fn(context, begin, end, (uint32_t)omp_get_thread_num());
    }
}
