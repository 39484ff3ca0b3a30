// The report merges repeats, stays sorted and survives having no memory.

#include "index/report.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static bool add(CoReport *report, const char *path, const char *name)
{
    CohortReportEntry entry = {
        .severity = COHORT_SEVERITY_WARNING, .prim_path = path, .name = name, .action = "ignored"};
    return co_report_add(report, &entry);
}

static void test_repeats_are_counted(void **state)
{
    (void)state;
    CoReport report = {0};
    const CohortReportEntry *entries;
    assert_int_equal(co_report_entries(&report, &entries), 0);
    assert_true(add(&report, "/b", "x"));
    assert_true(add(&report, "/a", "y"));
    assert_true(add(&report, "/b", "x"));
    assert_true(add(&report, NULL, "x"));
    assert_int_equal(co_report_entries(&report, &entries), 3);
    assert_string_equal(entries[0].prim_path, "");
    assert_string_equal(entries[1].prim_path, "/a");
    assert_string_equal(entries[2].prim_path, "/b");
    assert_int_equal(entries[2].count, 2);
    assert_string_equal(entries[2].value, "");
    // Repeats find their entry after a sort too.
    assert_true(add(&report, "/b", "x"));
    assert_true(add(&report, "/a", "y"));
    assert_int_equal(co_report_entries(&report, &entries), 3);
    assert_int_equal(entries[1].count, 2);
    assert_int_equal(entries[2].count, 3);
    co_report_clear(&report);
    assert_int_equal(co_report_entries(&report, &entries), 0);
    assert_int_equal(co_memory_live(CO_MEMORY_DELEGATE), 0);
}

static void test_many_entries(void **state)
{
    (void)state;
    CoReport report = {0};
    const CohortReportEntry *entries;
    for (int round = 0; round < 2; round++)
        for (int i = 0; i < 1000; i++) {
            char path[32];
            snprintf(path, sizeof path, "/p%03d", (i * 37) % 1000);
            assert_true(add(&report, path, "n"));
        }
    assert_int_equal(co_report_entries(&report, &entries), 1000);
    for (size_t i = 0; i < 1000; i++) {
        assert_int_equal(entries[i].count, 2);
        assert_true(i == 0 || strcmp(entries[i - 1].prim_path, entries[i].prim_path) < 0);
    }
    co_report_clear(&report);
}

static void test_what_is_taken_back(void **state)
{
    (void)state;
    CoReport report = {0};
    const CohortReportEntry *entries;
    assert_true(add(&report, "/b", "x") && add(&report, "/a", "y"));
    for (int kept = 0; kept < 2; kept++) {
        for (int sorted = 0; sorted < 2; sorted++) {
            co_report_begin(&report);
            assert_true(add(&report, "/b", "x") && add(&report, "/b", "x"));
            assert_true(add(&report, "/0", "new") && add(&report, "/0", "new"));
            assert_true(add(&report, "/c", "newer"));
            co_report_end(&report, kept);
            // What was dropped is no entry that could be counted, nor is another in its place.
            assert_true(kept || add(&report, "/c", "newer"));
            size_t most = kept ? 4 : 3;
            if (sorted || kept)
                assert_int_equal(co_report_entries(&report, &entries), most);
        }
    }
    assert_string_equal(entries[0].prim_path, "/0");
    const uint64_t counts[] = {4, 1, 5, 4};
    for (size_t i = 0; i < 4; i++)
        assert_int_equal(entries[i].count, counts[i]);
    // What somebody has read stays.
    co_report_begin(&report);
    assert_true(add(&report, "/d", "read"));
    assert_int_equal(co_report_entries(&report, &entries), 5);
    co_report_end(&report, false);
    assert_int_equal(co_report_entries(&report, &entries), 5);
    co_report_clear(&report);
    assert_int_equal(co_memory_live(CO_MEMORY_DELEGATE), 0);
}

static void test_out_of_memory(void **state)
{
    (void)state;
    for (uint64_t n = 1; n < 12; n++) {
        CoReport report = {0};
        const CohortReportEntry *entries;
        co_memory_fail_after(n);
        bool first = add(&report, "/a", "x"), second = add(&report, "/b", "y");
        co_memory_fail_after(0);
        size_t count = co_report_entries(&report, &entries);
        assert_int_equal(count, (size_t)first + (size_t)second);
        assert_true(add(&report, "/c", "z"));
        // A repeat that could not be taken back is none.
        co_report_begin(&report);
        co_memory_fail_after(2);
        assert_false(add(&report, "/c", "z"));
        co_memory_fail_after(0);
        co_report_end(&report, false);
        assert_int_equal(co_report_entries(&report, &entries), count + 1);
        for (size_t i = 0; i <= count; i++)
            assert_int_equal(entries[i].count, 1);
        co_report_clear(&report);
        assert_int_equal(co_memory_live(CO_MEMORY_DELEGATE), 0);
    }
}

static void test_string_map(void **state)
{
    (void)state;
    CoStringMap map = {0};
    assert_int_equal(co_string_map_find(&map, "a"), COHORT_INVALID_ID);
    co_string_map_remove(&map, "a");
    char key[16];
    for (uint32_t i = 0; i < 500; i++) {
        snprintf(key, sizeof key, "k%u", i);
        assert_true(co_string_map_set(&map, key, i));
    }
    for (uint32_t i = 0; i < 500; i += 2) {
        snprintf(key, sizeof key, "k%u", i);
        co_string_map_remove(&map, key);
    }
    for (uint32_t i = 0; i < 500; i++) {
        snprintf(key, sizeof key, "k%u", i);
        assert_int_equal(co_string_map_find(&map, key), i % 2 ? i : COHORT_INVALID_ID);
    }
    assert_true(co_string_map_set(&map, "k0", 7));
    assert_true(co_string_map_set(&map, "", 8));
    assert_int_equal(co_string_map_find(&map, "k0"), 7);
    assert_int_equal(co_string_map_find(&map, ""), 8);
    co_string_map_clear(&map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_repeats_are_counted), cmocka_unit_test(test_many_entries),
        cmocka_unit_test(test_what_is_taken_back),  cmocka_unit_test(test_out_of_memory),
        cmocka_unit_test(test_string_map),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
