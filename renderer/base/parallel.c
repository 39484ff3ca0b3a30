#include "base/parallel.h"

#include <omp.h>

static int thread_count; // 0: not chosen yet

void co_worker_count_set(uint32_t count)
{
    thread_count = count ? (int)count : omp_get_num_procs();
}

uint32_t co_worker_count(void)
{
    if (thread_count == 0)
        thread_count = omp_get_num_procs();
    return (uint32_t)thread_count;
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
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t block = 0; block < blocks; block++) {
        size_t begin = block * grain;
        size_t end = count - begin < grain ? count : begin + grain;
        fn(context, begin, end, (uint32_t)omp_get_thread_num());
    }
}
