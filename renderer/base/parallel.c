#define _GNU_SOURCE // sched_getaffinity

#include "base/parallel.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <unistd.h>

enum {
    SPINS = 2000,       // looks before a thread sleeps: some 50 microseconds, what waking it costs
    HELPERS_MOST = 1024 // threads that are started at most
};

// What one call of co_parallel_for has to do; lies on its caller's stack. Blocks are claimed without
// the lock, all else is guarded by it.
typedef struct Job {
    CoParallelFn *fn;
    void *context;
    size_t count, grain, blocks;
    atomic_size_t next;       // block
    atomic_uint busy;         // helpers
    uint32_t joined, helpers; // so far, at most
    struct Job *later;        // that wants helpers too
} Job;

// One for the process, as the processors are; threads are started when they are first wanted and
// wait for the next job until the process ends.
static struct {
    pthread_mutex_t lock;
    pthread_cond_t work, done;
    Job *first;       // of those that want helpers
    atomic_uint jobs; // in that list
    uint32_t started, asleep, looking; // helpers
} pool = {.lock = PTHREAD_MUTEX_INITIALIZER,
          .work = PTHREAD_COND_INITIALIZER,
          .done = PTHREAD_COND_INITIALIZER};

// Each thread that starts parallel work has its own count, so that two renders of one process do
// not disturb each other. 0: not chosen yet.
static _Thread_local uint32_t thread_count;
static _Thread_local bool is_inside;

static uint32_t processor_count(void)
{
#ifdef __linux__
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0 && CPU_COUNT(&set) > 0)
        return (uint32_t)CPU_COUNT(&set);
#endif
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count > 0 ? (uint32_t)count : 1;
}

void co_worker_count_set(uint32_t count)
{
    // Far more threads than processors only cost memory, and starting them may fail without a word.
    uint32_t processors = processor_count(), most = processors > 16 ? 4 * processors : 64;
    thread_count = count == 0 ? processors : count > most ? most : count;
}

uint32_t co_worker_count(void)
{
    if (thread_count == 0)
        thread_count = processor_count();
    return thread_count;
}

bool co_in_parallel(void)
{
    return is_inside;
}

static void pause_a_little(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

static void run_blocks(Job *job, uint32_t worker)
{
    for (size_t block; (block = atomic_fetch_add(&job->next, 1)) < job->blocks;) {
        size_t begin = block * job->grain;
        size_t end = job->count - begin < job->grain ? job->count : begin + job->grain;
        job->fn(job->context, begin, end, worker);
    }
}

// With the lock held.
static void remove_job(Job *job)
{
    for (Job **at = &pool.first; *at; at = &(*at)->later) {
        if (*at == job) {
            *at = job->later;
            atomic_fetch_sub(&pool.jobs, 1);
            return;
        }
    }
}

// With the lock held, which it gives up meanwhile. What is touched last of a job is its count of
// helpers, as its caller returns then.
static void help(Job *job)
{
    uint32_t worker = ++job->joined;
    atomic_fetch_add(&job->busy, 1);
    if (job->joined == job->helpers)
        remove_job(job);
    pthread_mutex_unlock(&pool.lock);
    run_blocks(job, worker);
    pthread_mutex_lock(&pool.lock);
    if (atomic_fetch_sub(&job->busy, 1) == 1)
        pthread_cond_broadcast(&pool.done);
}

static void *run_helper(void *unused)
{
    is_inside = true;
    pthread_mutex_lock(&pool.lock);
    for (;;) {
        while (pool.first)
            help(pool.first);
        pool.looking++;
        pthread_mutex_unlock(&pool.lock);
        for (int i = 0; i < SPINS && atomic_load(&pool.jobs) == 0; i++)
            pause_a_little();
        pthread_mutex_lock(&pool.lock);
        pool.looking--;
        pool.asleep++;
        while (!pool.first)
            pthread_cond_wait(&pool.work, &pool.lock);
        pool.asleep--;
    }
    return unused;
}

static bool start_helper(void)
{
    pthread_t thread;
    if (pool.started == HELPERS_MOST || pthread_create(&thread, NULL, run_helper, NULL) != 0)
        return false;
    pthread_detach(thread);
    pool.started++;
    return true;
}

// With the lock held. Threads that are about to look will see the job by themselves.
static void call_helpers(Job *job)
{
    job->later = pool.first;
    pool.first = job;
    atomic_fetch_add(&pool.jobs, 1);
    uint32_t coming = pool.looking, asleep = pool.asleep;
    for (; coming < job->helpers && asleep > 0; coming++, asleep--)
        pthread_cond_signal(&pool.work);
    while (coming < job->helpers && start_helper())
        coming++;
}

// Waits for the helpers that have come; those that have not are not needed any more.
static void run_job(Job *job)
{
    pthread_mutex_lock(&pool.lock);
    call_helpers(job);
    pthread_mutex_unlock(&pool.lock);
    is_inside = true;
    run_blocks(job, 0);
    is_inside = false;
    pthread_mutex_lock(&pool.lock);
    remove_job(job);
    pthread_mutex_unlock(&pool.lock);
    for (int i = 0; i < SPINS && atomic_load(&job->busy) > 0; i++)
        pause_a_little();
    pthread_mutex_lock(&pool.lock);
    while (atomic_load(&job->busy) > 0)
        pthread_cond_wait(&pool.done, &pool.lock);
    pthread_mutex_unlock(&pool.lock);
}

void co_parallel_for(size_t count, size_t grain, CoParallelFn *fn, void *context)
{
    if (count == 0)
        return;
    if (grain == 0)
        grain = 1;
    size_t blocks = (count - 1) / grain + 1, threads = is_inside ? 1 : co_worker_count();
    threads = blocks < threads ? blocks : threads;
    if (threads == 1) {
        fn(context, 0, count, 0);
        return;
    }
    Job job = {.fn = fn, .context = context, .count = count, .grain = grain, .blocks = blocks};
    job.helpers = (uint32_t)threads - 1;
    run_job(&job);
}
