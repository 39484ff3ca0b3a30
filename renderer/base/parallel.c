#include "base/parallel.h"

#include <omp.h>
#include <stdatomic.h>
#include <stdio.h>

enum {
    PARTS = 64 // of a call; further threads share them
};

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

typedef struct Call {
    size_t count, grain, blocks;
    size_t large, least; // blocks of `grain` items, those of the others
    CoParallelFn *fn;
    void *context;
} Call;

// False when it was for one thread and is done.
static bool begin_call(Call *call, int *threads)
{
    size_t grain = call->grain ? call->grain : 1, full = call->count / grain;
    size_t least = call->least == 0 ? 1 : call->least < grain ? call->least : grain;
    *threads = (int)co_worker_count();
    size_t kept = least < grain ? (size_t)*threads : 0; // to be cut up
    call->grain = grain;
    call->least = least;
    call->large = full > kept ? full - kept : 0;
    size_t rest = call->count - call->large * grain;
    call->blocks = call->large + (rest ? (rest - 1) / least + 1 : 0);
    *threads = call->blocks < (size_t)*threads ? (int)call->blocks : *threads;
    if (*threads > 1)
        return true;
    if (call->count)
        call->fn(call->context, 0, call->count, 0);
    return false;
}

static void do_block(const Call *call, size_t block)
{
    bool is_large = block < call->large;
    size_t size = is_large ? call->grain : call->least, before = is_large ? 0 : call->large;
    size_t begin = before * call->grain + (block - before) * size, left = call->count - begin;
    size_t end = left < size ? call->count : begin + size;
    call->fn(call->context, begin, end, (uint32_t)omp_get_thread_num());
}

void co_parallel_for_tapered(size_t count, size_t grain, size_t least, CoParallelFn *fn,
                             void *context)
{
    Call call = {.count = count, .grain = grain, .least = least, .fn = fn, .context = context};
    int threads;
    if (!begin_call(&call, &threads))
        return;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (size_t block = 0; block < call.blocks; block++)
        do_block(&call, block);
}

void co_parallel_for(size_t count, size_t grain, CoParallelFn *fn, void *context)
{
    co_parallel_for_tapered(count, grain, grain, fn, context);
}

// A thread's own blocks: the next of them, and where they end. A cache line, as each has its own.
typedef struct Part {
    _Alignas(64) atomic_size_t next;
    size_t end;
} Part;

void co_parallel_for_parts(size_t count, size_t grain, CoParallelFn *fn, void *context)
{
    Call call = {.count = count, .grain = grain, .least = grain, .fn = fn, .context = context};
    Part parts[PARTS];
    int threads;
    if (!begin_call(&call, &threads))
        return;
    const int most = threads < PARTS ? threads : PARTS;
    for (int i = 0; i < most; i++) {
        size_t each = call.blocks / (size_t)most, more = call.blocks % (size_t)most, at = (size_t)i;
        atomic_init(&parts[i].next, at * each + (at < more ? at : more));
        parts[i].end = (at + 1) * each + (at < more ? at + 1 : more);
    }
#pragma omp parallel num_threads(threads)
    for (int i = 0; i < most; i++) {
        Part *part = &parts[(omp_get_thread_num() + i) % most];
        size_t block;
        while ((block = atomic_fetch_add(&part->next, 1)) < part->end)
            do_block(&call, block);
    }
}
