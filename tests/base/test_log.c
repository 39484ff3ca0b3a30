// Messages: silent without a sink, filtered by severity, one call at a time from many threads.

#include "base/log.h"
#include "base/parallel.h"

#include <stdio.h>
#include <string.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

typedef struct Heard {
    size_t count, length;
    char channel[16], text[2048];
    CohortSeverity severity;
    int inside; // calls under way
    int most;
} Heard;

static void listen(void *cookie, const char *channel, CohortSeverity severity, const char *text)
{
    Heard *heard = cookie;
    heard->inside++;
    heard->most = heard->inside > heard->most ? heard->inside : heard->most;
    heard->count++;
    heard->severity = severity;
    heard->length = strlen(text);
    strncpy(heard->channel, channel, sizeof heard->channel - 1);
    strncpy(heard->text, text, sizeof heard->text - 1);
    heard->inside--;
}

static void silence_is_the_default(void **state)
{
    (void)state;
    Heard heard = {0};
    co_log("base", COHORT_SEVERITY_ERROR, "nobody hears %d", 1);
    cohort_log_set(listen, &heard, COHORT_SEVERITY_WARNING);
    cohort_log_set(NULL, NULL, COHORT_SEVERITY_TRACE);
    co_log("base", COHORT_SEVERITY_ERROR, "nor this");
    assert_int_equal(heard.count, 0);
}

static void details_are_left_out(void **state)
{
    (void)state;
    Heard heard = {0};
    cohort_log_set(listen, &heard, COHORT_SEVERITY_WARNING);
    co_log("accel", COHORT_SEVERITY_INFO, "too much");
    assert_int_equal(heard.count, 0);
    co_log("accel", COHORT_SEVERITY_WARNING, "%s %d", "rays:", 7);
    assert_int_equal(heard.count, 1);
    assert_string_equal(heard.channel, "accel");
    assert_string_equal(heard.text, "rays: 7");
    assert_int_equal(heard.severity, COHORT_SEVERITY_WARNING);
    co_log("accel", COHORT_SEVERITY_ERROR, "worse");
    assert_int_equal(heard.count, 2);
    cohort_log_set(NULL, NULL, COHORT_SEVERITY_ERROR);
}

static void long_messages_are_cut(void **state)
{
    (void)state;
    Heard heard = {0};
    char text[3000];
    memset(text, 'y', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    cohort_log_set(listen, &heard, COHORT_SEVERITY_TRACE);
    co_log("usda", COHORT_SEVERITY_TRACE, "%s", text);
    assert_int_equal(heard.count, 1);
    assert_in_range(heard.length, 100, sizeof text - 2);
    cohort_log_set(NULL, NULL, COHORT_SEVERITY_ERROR);
}

static void speak(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)context;
    for (size_t i = begin; i < end; i++)
        co_log("rays", COHORT_SEVERITY_INFO, "%zu by %u", i, worker);
}

static void calls_come_one_at_a_time(void **state)
{
    (void)state;
    Heard heard = {0};
    cohort_log_set(listen, &heard, COHORT_SEVERITY_TRACE);
    co_worker_count_set(8);
    co_parallel_for(2000, 1, speak, NULL);
    co_worker_count_set(0);
    cohort_log_set(NULL, NULL, COHORT_SEVERITY_ERROR);
    assert_int_equal(heard.count, 2000);
    assert_int_equal(heard.most, 1);
}

static void the_version_has_three_numbers(void **state)
{
    (void)state;
    unsigned major = 0, minor = 0, patch = 0;
    char rest = 0;
    assert_int_equal(sscanf(cohort_version(), "%u.%u.%u%c", &major, &minor, &patch, &rest), 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(silence_is_the_default),        cmocka_unit_test(details_are_left_out),
        cmocka_unit_test(long_messages_are_cut),         cmocka_unit_test(calls_come_one_at_a_time),
        cmocka_unit_test(the_version_has_three_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
