// Names to numbers: what was set is found, removed is gone, growth and failing memory lose nothing.

#include "index/string_map.h"

#include <stdio.h>
#include <string.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void an_empty_map_finds_nothing(void **state)
{
    (void)state;
    CoStringMap map = {0};
    assert_int_equal(co_string_map_find(&map, "/World"), COHORT_INVALID_ID);
    co_string_map_remove(&map, "/World");
    co_string_map_clear(&map);
}

static void names_keep_their_numbers(void **state)
{
    (void)state;
    CoStringMap map = {0};
    char key[32];
    for (uint32_t i = 0; i < 5000; i++) {
        snprintf(key, sizeof key, "/World/mesh_%u", i);
        assert_true(co_string_map_set(&map, key, i));
        memset(key, 'z', sizeof key); // keys are copied
    }
    assert_true(co_string_map_set(&map, "", 77)); // a name like any other
    for (uint32_t i = 0; i < 5000; i++) {
        snprintf(key, sizeof key, "/World/mesh_%u", i);
        assert_int_equal(co_string_map_find(&map, key), i);
    }
    assert_int_equal(co_string_map_find(&map, ""), 77);
    assert_int_equal(co_string_map_find(&map, "/World/mesh_5000"), COHORT_INVALID_ID);
    assert_int_equal(co_string_map_find(&map, "/World/mesh_"), COHORT_INVALID_ID);
    assert_true(map.used * 2 <= map.capacity);
    co_string_map_clear(&map);
    assert_int_equal(co_string_map_find(&map, ""), COHORT_INVALID_ID);
}

static void removed_names_come_back(void **state)
{
    (void)state;
    CoStringMap map = {0};
    assert_true(co_string_map_set(&map, "/a", 1));
    assert_true(co_string_map_set(&map, "/b", 2));
    co_string_map_remove(&map, "/a");
    co_string_map_remove(&map, "/c");
    assert_int_equal(co_string_map_find(&map, "/a"), COHORT_INVALID_ID);
    assert_int_equal(co_string_map_find(&map, "/b"), 2);
    size_t used = map.used;
    for (uint32_t i = 0; i < 1000; i++) { // makes no more of it
        assert_true(co_string_map_set(&map, "/a", i));
        co_string_map_remove(&map, "/a");
    }
    assert_int_equal(map.used, used);
    assert_true(co_string_map_set(&map, "/a", 3));
    assert_int_equal(co_string_map_find(&map, "/a"), 3);
    co_string_map_clear(&map);
}

static void failing_memory_changes_nothing(void **state)
{
    (void)state;
    size_t live = co_memory_live(CO_MEMORY_DELEGATE);
    CoStringMap map = {0};
    co_memory_fail_after(1);
    assert_false(co_string_map_set(&map, "/first", 1));
    co_memory_fail_after(0);
    assert_int_equal(co_string_map_find(&map, "/first"), COHORT_INVALID_ID);
    char key[300];
    memset(key, 'k', sizeof key - 1);
    key[sizeof key - 1] = '\0';
    size_t failures = 0, set = 0;
    for (uint32_t i = 0; i < 600; i++) {
        snprintf(key, 10, "/%u", i);
        key[strlen(key)] = '/';
        co_memory_fail_after(1);
        bool is_set = co_string_map_set(&map, key, i);
        co_memory_fail_after(0);
        assert_int_equal(co_string_map_find(&map, key), is_set ? i : COHORT_INVALID_ID);
        failures += !is_set;
        set += is_set;
        if (!is_set)
            assert_true(co_string_map_set(&map, key, i));
        for (uint32_t k = 0; k <= i; k += 97) {
            char other[300];
            memset(other, 'k', sizeof other - 1);
            other[sizeof other - 1] = '\0';
            snprintf(other, 10, "/%u", k);
            other[strlen(other)] = '/';
            assert_int_equal(co_string_map_find(&map, other), k);
        }
    }
    assert_true(failures > 2 && set > 100);
    co_string_map_clear(&map);
    assert_int_equal(co_memory_live(CO_MEMORY_DELEGATE), live);
}

// However full the map is, another value for a name that it has takes no memory.
static void known_names_need_no_memory(void **state)
{
    (void)state;
    CoStringMap map = {0};
    for (uint32_t i = 0; i < 200; i++) {
        char key[16];
        snprintf(key, sizeof key, "/%u", i);
        assert_true(co_string_map_set(&map, key, i));
        co_memory_fail_after(1);
        bool is_set = co_string_map_set(&map, key, i + 1000);
        co_memory_fail_after(0);
        assert_true(is_set);
        assert_int_equal(co_string_map_find(&map, key), i + 1000);
    }
    co_string_map_clear(&map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_map_finds_nothing),
        cmocka_unit_test(names_keep_their_numbers),
        cmocka_unit_test(removed_names_come_back),
        cmocka_unit_test(failing_memory_changes_nothing),
        cmocka_unit_test(known_names_need_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
