// Values as the adapter reads them: numbers of all precisions as floats, texts for the report.

#include "stage_adapter/adapter.h"

#include "base/memory.h"
#include "index/index.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static void test_halves(void **state)
{
    (void)state;
    CohortPull pull = {.arena = {.tag = CO_MEMORY_DELEGATE}};
    const uint16_t halves[] = {0x3c00, 0xc000, 0x0001, 0x7bff, 0x7c00, 0x7e00};
    CohortValue value = {.type = COHORT_TYPE_HALF3, .is_array = true, .count = 2, .data = halves};
    CoFloats out;
    assert_true(co_values_floats(&value, &pull, &out));
    assert_int_equal(out.components, 3);
    assert_true(out.values[0] == 1.0f && out.values[1] == -2.0f);
    assert_true(out.values[2] == 0x1p-24f && out.values[3] == 65504.0f);
    assert_true(isinf(out.values[4]) && isnan(out.values[5]));
    co_arena_clear(&pull.arena);
}

static void test_other_numbers(void **state)
{
    (void)state;
    CohortPull pull = {.arena = {.tag = CO_MEMORY_DELEGATE}};
    const double doubles[] = {1.5, -2.5};
    const int32_t ints[] = {7};
    const float floats[] = {3.0f};
    CohortValue value = {.type = COHORT_TYPE_DOUBLE2, .count = 1, .data = doubles};
    CoFloats out;
    assert_true(co_values_floats(&value, &pull, &out) && out.values[1] == -2.5f);
    value = (CohortValue){.type = COHORT_TYPE_INT, .count = 1, .data = ints};
    assert_true(co_values_floats(&value, &pull, &out) && out.values[0] == 7.0f);
    value = (CohortValue){.type = COHORT_TYPE_FLOAT, .count = 1, .data = floats};
    assert_true(co_values_floats(&value, &pull, &out) && out.values == floats); // not copied
    value = (CohortValue){.type = COHORT_TYPE_TOKEN, .count = 1};
    assert_false(co_values_floats(&value, &pull, &out));
    value = (CohortValue){.type = COHORT_TYPE_DOUBLE4, .count = SIZE_MAX / 2, .data = doubles};
    assert_false(co_values_floats(&value, &pull, &out));
    co_arena_clear(&pull.arena);
}

static void test_descriptions(void **state)
{
    (void)state;
    char text[32];
    const float color[] = {1.0f, 0.5f, 0.25f, 0.0f, 0.0f, 0.0f};
    CohortValue value = {.type = COHORT_TYPE_COLOR3F, .count = 1, .data = color};
    co_values_describe(&value, text, sizeof text);
    assert_string_equal(text, "1, 0.5, 0.25");
    value.is_array = true;
    value.count = 2;
    co_values_describe(&value, text, sizeof text);
    assert_string_equal(text, "2 elements");
    const CohortString token = {"none", 4};
    value = (CohortValue){.type = COHORT_TYPE_TOKEN, .count = 1, .data = &token};
    co_values_describe(&value, text, sizeof text);
    assert_string_equal(text, "none");
    char tiny[4];
    value = (CohortValue){.type = COHORT_TYPE_COLOR3F, .count = 1, .data = color};
    co_values_describe(&value, tiny, sizeof tiny);
    assert_true(strlen(tiny) < sizeof tiny);
}

// A number that is cut still ends, and a text that is no text is empty.
static void test_values_of_nothing(void **state)
{
    (void)state;
    CohortPull pull = {.arena = {.tag = CO_MEMORY_DELEGATE}};
    char text[32] = "?";
    CoFloats out;
    CohortValue value = {.type = COHORT_TYPE_COLOR3F, .is_array = true};
    assert_true(co_values_floats(&value, &pull, &out));
    assert_int_equal(out.count, 0);
    co_values_describe(&value, text, sizeof text);
    assert_string_equal(text, "");
    const CohortString none = {NULL, 0};
    value = (CohortValue){.type = COHORT_TYPE_STRING, .count = 1, .data = &none};
    assert_string_equal(co_values_text(&value), "");
    value = (CohortValue){.type = COHORT_TYPE_STRING};
    assert_string_equal(co_values_text(&value), "");
    const int32_t number = 3;
    value = (CohortValue){.type = COHORT_TYPE_INT, .count = 1, .data = &number};
    assert_string_equal(co_values_text(&value), "");
    co_arena_clear(&pull.arena);
}

// Doubles beyond floats are infinite, and a copy that finds no memory is none.
static void test_numbers_at_the_edges(void **state)
{
    (void)state;
    CohortPull pull = {.arena = {.tag = CO_MEMORY_DELEGATE}};
    const double doubles[] = {1e300, -1e300, (double)NAN, 1e-300};
    CohortValue value = {.type = COHORT_TYPE_DOUBLE4, .count = 1, .data = doubles};
    CoFloats out;
    assert_true(co_values_floats(&value, &pull, &out));
    assert_true(isinf(out.values[0]) && out.values[0] > 0.0f && out.values[1] < 0.0f);
    assert_true(isnan(out.values[2]) && out.values[3] == 0.0f);
    co_arena_clear(&pull.arena);
    co_memory_fail_after(1);
    assert_false(co_values_floats(&value, &pull, &out));
    co_memory_fail_after(0);
    co_arena_clear(&pull.arena);
}

static void test_prefixes(void **state)
{
    (void)state;
    assert_true(co_starts_with("primvars:st", "primvars:"));
    assert_true(co_starts_with("x", ""));
    assert_false(co_starts_with("prim", "primvars:"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_halves),
        cmocka_unit_test(test_other_numbers),
        cmocka_unit_test(test_descriptions),
        cmocka_unit_test(test_values_of_nothing),
        cmocka_unit_test(test_numbers_at_the_edges),
        cmocka_unit_test(test_prefixes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
