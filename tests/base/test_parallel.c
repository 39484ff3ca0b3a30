// The pool: each item once, workers of their own, blocks as large as asked for.

#include "base/parallel.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum {
    COUNT = 10007,
    WORKERS = 64
};

typedef struct Work {
    atomic_uint seen[COUNT];
    atomic_uint busy[WORKERS]; // calls under way, by worker
    atomic_uint shared;        // times a worker was found busy
    atomic_size_t largest, calls;
} Work;

static void mark(void *context, size_t begin, size_t end, uint32_t worker)
{
    Work *work = context;
    size_t size = end - begin, largest = atomic_load(&work->largest);
    if (worker >= WORKERS || atomic_fetch_add(&work->busy[worker], 1) != 0)
        atomic_fetch_add(&work->shared, 1);
    while (size > largest && !atomic_compare_exchange_weak(&work->largest, &largest, size))
        ;
    atomic_fetch_add(&work->calls, 1);
    for (size_t i = begin; i < end; i++)
        atomic_fetch_add(&work->seen[i], 1);
    atomic_fetch_sub(&work->busy[worker], 1);
}

typedef void ForFn(size_t count, size_t grain, CoParallelFn *fn, void *context);
static ForFn *const for_fns[2] = {co_parallel_for, co_parallel_for_parts};

static void check_each_item(ForFn *each)
{
    static Work work;
    const size_t grains[] = {0, 1, 7, 64, COUNT - 1, COUNT, COUNT + 1, SIZE_MAX};
    const size_t counts[] = {1, 2, 63, COUNT};
    for (uint32_t threads = 1; threads <= 8; threads *= 2) {
        co_worker_count_set(threads);
        assert_int_equal(co_worker_count(), threads);
        for (size_t g = 0; g < sizeof grains / sizeof *grains; g++) {
            for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
                memset(&work, 0, sizeof work);
                each(counts[c], grains[g], mark, &work);
                for (size_t i = 0; i < COUNT; i++)
                    assert_int_equal(work.seen[i], i < counts[c]);
                assert_int_equal(work.shared, 0);
                if (threads > 1)
                    assert_true(work.largest <= (grains[g] ? grains[g] : 1) || work.largest == 1);
            }
        }
    }
    co_worker_count_set(0);
}

static void each_item_is_done_once(void **state)
{
    (void)state;
    for (size_t f = 0; f < 2; f++)
        check_each_item(for_fns[f]);
}

// Large blocks first, in order; as many as threads, and what is over, are cut up.
static void the_last_blocks_are_short(void **state)
{
    (void)state;
    static Work work;
    const size_t counts[] = {1, 9, 100, 299, 300, 301, 409, COUNT};
    for (uint32_t threads = 2; threads <= 8; threads *= 2) {
        co_worker_count_set(threads);
        for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
            memset(&work, 0, sizeof work);
            co_parallel_for_tapered(counts[c], 100, 10, mark, &work);
            for (size_t i = 0; i < COUNT; i++)
                assert_int_equal(work.seen[i], i < counts[c]);
            assert_int_equal(work.shared, 0);
            size_t full = counts[c] / 100, large = full > threads ? full - threads : 0;
            assert_int_equal(work.calls, large + (counts[c] - large * 100 + 9) / 10);
            assert_true(work.largest <= (large ? 100u : 10u));
        }
        memset(&work, 0, sizeof work);
        co_parallel_for_tapered(25, 0, 0, mark, &work);
        assert_int_equal(work.calls, 25);
        memset(&work, 0, sizeof work);
        co_parallel_for_tapered(25, 5, 7, mark, &work); // no longer than the long ones
        assert_int_equal(work.calls, 5);
    }
    co_worker_count_set(0);
}

static void nothing_to_do_calls_nobody(void **state)
{
    (void)state;
    static Work work;
    memset(&work, 0, sizeof work);
    co_parallel_for(0, 1, mark, &work);
    co_parallel_for_parts(0, 1, mark, &work);
    assert_int_equal(work.calls, 0);
}

static void one_thread_gets_all_at_once(void **state)
{
    (void)state;
    static Work work;
    memset(&work, 0, sizeof work);
    co_worker_count_set(1);
    co_parallel_for(COUNT, 10, mark, &work);
    assert_int_equal(work.calls, 1);
    assert_int_equal(work.largest, COUNT);
    co_worker_count_set(0);
}

static void counts_of_threads_are_bounded(void **state)
{
    (void)state;
    co_worker_count_set(UINT32_MAX);
    assert_in_range(co_worker_count(), 64, 1u << 16);
    co_worker_count_set(0);
    assert_true(co_worker_count() >= 1);
}

typedef struct Begin {
    atomic_uint first[4]; // 1 + block, by worker; 0: it has not begun
    atomic_uint begun;
} Begin;

// None goes on before all have begun, or it takes ten seconds.
static void note_first(void *context, size_t begin, size_t end, uint32_t worker)
{
    Begin *all = context;
    (void)end;
    if (worker >= 4 || all->first[worker])
        return;
    all->first[worker] = 1 + (unsigned)begin;
    all->begun++;
    for (int i = 0; i < 10000 && all->begun < 4; i++)
        usleep(1000);
}

static void parts_are_begun_by_their_own(void **state)
{
    (void)state;
    co_worker_count_set(4);
    for (int pass = 0; pass < 3; pass++) {
        Begin all = {.begun = 0};
        co_parallel_for_parts(42, 1, note_first, &all);
        const unsigned first[4] = {0, 11, 22, 32};
        for (int i = 0; i < 4; i++)
            assert_int_equal(all.first[i], 1 + first[i]);
    }
    co_worker_count_set(0);
}

static void count_parallel(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    if (co_in_parallel())
        atomic_fetch_add((atomic_size_t *)context, end - begin);
}

static void call_again(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    for (size_t i = begin; i < end; i++)
        co_parallel_for(100, 1, count_parallel, context);
}

static void calls_within_calls_end(void **state)
{
    (void)state;
    atomic_size_t seen = 0;
    co_worker_count_set(4);
    co_parallel_for(50, 1, call_again, &seen);
    assert_int_equal(seen, 50 * 100);
    assert_false(co_in_parallel());
    co_worker_count_set(0);
}

static void count_workers(void *context, size_t begin, size_t end, uint32_t worker)
{
    atomic_size_t *calls = context;
    assert_int_equal(begin + 1, end);
    atomic_fetch_add(&calls[worker], 1);
}

// As many as blocks, however many threads there are; in calls so short that helpers come too late.
static void few_blocks_have_few_workers(void **state)
{
    (void)state;
    co_worker_count_set(8);
    for (size_t i = 0; i < 300; i++) {
        atomic_size_t calls[8] = {0};
        size_t blocks = 2 + i % 3, sum = 0;
        co_parallel_for(blocks, 1, count_workers, calls);
        for (size_t k = 0; k < 8; k++) {
            sum += calls[k];
            assert_true(calls[k] == 0 || k < blocks);
        }
        assert_int_equal(sum, blocks);
    }
    co_worker_count_set(0);
}

static void *work_alone(void *context)
{
    Work *work = context;
    co_worker_count_set(3);
    for (size_t count = 2; count < 2000; count += 37) {
        memset(work, 0, sizeof *work);
        co_parallel_for(count, 3, mark, work);
        for (size_t i = 0; i < count; i++)
            if (work->seen[i] != 1)
                return NULL;
        if (work->shared)
            return NULL;
    }
    return context;
}

static void callers_do_not_disturb_each_other(void **state)
{
    (void)state;
    enum {
        CALLERS = 4
    };
    static Work work[CALLERS];
    pthread_t callers[CALLERS];
    for (int i = 0; i < CALLERS; i++)
        assert_int_equal(pthread_create(&callers[i], NULL, work_alone, &work[i]), 0);
    for (int i = 0; i < CALLERS; i++) {
        void *done = NULL;
        pthread_join(callers[i], &done);
        assert_ptr_equal(done, &work[i]);
    }
}

static void parallel_calls_know_that_they_are(void **state)
{
    (void)state;
    atomic_size_t seen = 0;
    assert_false(co_in_parallel());
    co_worker_count_set(2);
    co_parallel_for(10, 1, count_parallel, &seen);
    assert_int_equal(seen, 10);
    co_worker_count_set(1);
    co_parallel_for(10, 1, count_parallel, &seen);
    assert_int_equal(seen, 10);
    co_worker_count_set(0);
}

typedef struct Crowd {
    atomic_uint here;
    atomic_bool is_over;
} Crowd;

static void *stand_around(void *context)
{
    Crowd *crowd = context;
    atomic_fetch_add(&crowd->here, 1);
    while (!atomic_load(&crowd->is_over))
        ;
    return NULL;
}

// Many more threads that want to run than there are processors leave none for short work.
static void no_worker_is_at_hand_in_a_crowd(void **state)
{
    (void)state;
    enum {
        MOST = 256
    };
    static pthread_t threads[MOST];
    static Crowd crowd;
    co_worker_count_set(0);
    uint32_t all = co_worker_count(), count = 2 * all + 1, at_hand = co_worker_count_at_hand();
    assert_true(at_hand == 1 || at_hand == all);
    if (count > MOST || access("/proc/loadavg", R_OK) != 0)
        skip();
    for (uint32_t i = 0; i < count; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, stand_around, &crowd), 0);
    while (atomic_load(&crowd.here) < count)
        ;
    at_hand = 0;
    for (int i = 0; i < 1000 && at_hand != 1; i++)
        at_hand = co_worker_count_at_hand();
    assert_int_equal(at_hand, 1);
    atomic_store(&crowd.is_over, true);
    for (uint32_t i = 0; i < count; i++)
        pthread_join(threads[i], NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_item_is_done_once),
        cmocka_unit_test(the_last_blocks_are_short),
        cmocka_unit_test(nothing_to_do_calls_nobody),
        cmocka_unit_test(parts_are_begun_by_their_own),
        cmocka_unit_test(one_thread_gets_all_at_once),
        cmocka_unit_test(counts_of_threads_are_bounded),
        cmocka_unit_test(parallel_calls_know_that_they_are),
        cmocka_unit_test(calls_within_calls_end),
        cmocka_unit_test(few_blocks_have_few_workers),
        cmocka_unit_test(callers_do_not_disturb_each_other),
        cmocka_unit_test(no_worker_is_at_hand_in_a_crowd),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
