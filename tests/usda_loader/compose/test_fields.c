// Values of fields as plain C types: every number, text of scalars alone, nothing of what is
// neither.

#include "compose/fields.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static CoValue value_of(CohortType type, const void *data)
{
    return (CoValue){.type = type, .count = 1, .data = data};
}

static void every_number_is_a_double(void **state)
{
    (void)state;
    const uint8_t byte = 200;
    const int32_t i = INT32_MIN;
    const uint32_t u = UINT32_MAX;
    const int64_t i64 = INT64_MIN;
    const uint64_t u64 = UINT64_MAX;
    const uint16_t half = 0xbe00;
    const float f = 1e-45f;
    const double d = -1e300;
    const struct {
        CohortType type;
        const void *data;
        double expected;
    } numbers[] = {
        {COHORT_TYPE_BOOL, &byte, 200},     {COHORT_TYPE_UCHAR, &byte, 200},
        {COHORT_TYPE_INT, &i, -0x1p31},     {COHORT_TYPE_UINT, &u, 0x1p32 - 1},
        {COHORT_TYPE_INT64, &i64, -0x1p63}, {COHORT_TYPE_UINT64, &u64, 0x1p64},
        {COHORT_TYPE_HALF, &half, -1.5},    {COHORT_TYPE_FLOAT, &f, 0x1p-149},
        {COHORT_TYPE_DOUBLE, &d, -1e300},   {COHORT_TYPE_TIMECODE, &d, -1e300},
    };
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) {
        CoValue value = value_of(numbers[k].type, numbers[k].data);
        double out = 7;
        bool is_set = false;
        assert_true(co_value_double(&value, &out));
        assert_true(out == numbers[k].expected);
        assert_true(co_value_bool(&value, &is_set) && is_set);
        assert_null(co_value_text(&value));
        value.is_array = true;
        out = 7;
        assert_false(co_value_double(&value, &out));
        assert_false(co_value_bool(&value, &is_set));
        assert_true(out == 7);
        value = value_of(numbers[k].type, NULL); // a block
        assert_false(co_value_double(&value, &out));
    }
}

static void zero_is_false(void **state)
{
    (void)state;
    const double zeros[] = {0.0, -0.0};
    for (int i = 0; i < 2; i++) {
        CoValue value = value_of(COHORT_TYPE_DOUBLE, &zeros[i]);
        bool is_set = true;
        assert_true(co_value_bool(&value, &is_set));
        assert_false(is_set);
    }
}

static void text_is_that_of_scalars(void **state)
{
    (void)state;
    const CohortString text = {"text", 4};
    const CohortType types[] = {COHORT_TYPE_STRING, COHORT_TYPE_TOKEN, COHORT_TYPE_ASSET,
                                COHORT_TYPE_PATH_EXPRESSION};
    for (size_t k = 0; k < 4; k++) {
        CoValue value = value_of(types[k], &text);
        double out = 7;
        assert_ptr_equal(co_value_text(&value), &text);
        assert_false(co_value_double(&value, &out));
        value.is_array = true;
        assert_null(co_value_text(&value));
    }
}

static void each_kind_is_asked_for_by_itself(void **state)
{
    (void)state;
    const char anything = 0;
    for (int type = 0; type <= COHORT_TYPE_PAYLOAD_LIST_OP + 20; type++) {
        CoValue value = value_of((CohortType)type, &anything);
        bool is_dict = type == COHORT_TYPE_DICTIONARY || type == COHORT_TYPE_VARIANT_SELECTION;
        bool is_list_op = type >= COHORT_TYPE_TOKEN_LIST_OP && type <= COHORT_TYPE_PAYLOAD_LIST_OP;
        assert_int_equal(co_value_dict(&value) != NULL, is_dict);
        assert_int_equal(co_value_list_op(&value) != NULL, is_list_op);
        assert_int_equal(co_value_samples(&value) != NULL, type == COHORT_TYPE_TIME_SAMPLES);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_number_is_a_double),
        cmocka_unit_test(zero_is_false),
        cmocka_unit_test(text_is_that_of_scalars),
        cmocka_unit_test(each_kind_is_asked_for_by_itself),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
