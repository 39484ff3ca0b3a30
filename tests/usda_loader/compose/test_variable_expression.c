// Variable expressions: strings, functions, and what is wrong with the rest.

#include "usda_loader/compose/composer_fixture.h"

static CoVariables variables;

static int begin_variables(void **state)
{
    static CohortString name = {"oak", 3}, nested = {"`\"${NAME}_tree\"`", 16};
    static CohortString endless = {"`\"${LOOP}\"`", 11};
    static int64_t count = 3;
    static uint8_t yes = 1;
    static CoValue values[] = {{COHORT_TYPE_STRING, false, 1, &name},
                               {COHORT_TYPE_STRING, false, 1, &nested},
                               {COHORT_TYPE_INT64, false, 1, &count},
                               {COHORT_TYPE_BOOL, false, 1, &yes},
                               {COHORT_TYPE_STRING, false, 1, &endless}};
    static const char *const names[] = {"NAME", "NESTED", "COUNT", "YES", "LOOP"};
    static CoVariable items[5];
    for (size_t i = 0; i < 5; i++)
        items[i] = (CoVariable){names[i], &values[i]};
    variables = (CoVariables){items, 5};
    return begin(state);
}

static const char *evaluate(const char *text)
{
    const char *why = NULL;
    const char *out = co_expression_evaluate(&composer, &variables, text, &why);
    assert_true((out == NULL) == (why != NULL));
    return out;
}

static void expressions_give_text(void **state)
{
    (void)state;
    static const struct {
        const char *text, *value;
    } cases[] = {
        {"plain ${NAME}", "plain ${NAME}"},
        {"`\"a_${NAME}.usda\"`", "a_oak.usda"},
        {"`'${NESTED}'`", "oak_tree"},
        {"`${NAME}`", "oak"},
        {"`\"\\${NAME}\"`", "${NAME}"},
        {"`\"${UNKNOWN}.png\"`", "${UNKNOWN}.png"},
        {"`if(${YES}, \"y\", \"n\")`", "y"},
        {"`if(gt(${COUNT}, 3), \"y\", \"n\")`", "n"},
        {"`if(eq(${COUNT}, 3), \"y\")`", "y"},
        {"`if(not(${YES}), \"y\")`", ""},
        {"`if(and(${YES}, leq(2, 2), neq(\"a\", \"b\")), ${NAME})`", "oak"},
        {"`if(or(False, contains(\"abc\", \"b\")), 'in')`", "in"},
        {"`if(defined(\"NAME\", \"COUNT\"), 'd', 'u')`", "d"},
        {"`if(defined(\"NOT\"), 'd', 'u')`", "u"},
        {"`if(geq(len(${NAME}), 3), 'long')`", "long"},
        {"`None`", ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_string_equal(evaluate(cases[i].text), cases[i].value);
}

static void nonsense_is_refused(void **state)
{
    (void)state;
    static const char *const wrong[] = {"``",
                                        "`\"open`",
                                        "`${}`",
                                        "`${NAME`",
                                        "`3`",
                                        "`'a' 'b'`",
                                        "`nothing('a')`",
                                        "`if('a', 'b')`",
                                        "`lt(1, 'a')`",
                                        "`'${COUNT}'`",
                                        "`${NOT}`",
                                        "`'${LOOP}'`",
                                        "`if(True 'a')`",
                                        "`and(True, 1)`",
                                        "`len(${COUNT})`",
                                        "`not(${NAME})`"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_null(evaluate(wrong[i]));
}

static void nesting_has_an_end(void **state)
{
    (void)state;
    char text[2048] = "`";
    for (int i = 0; i < 400; i++)
        strcat(text, "not(");
    strcat(text, "`");
    assert_null(evaluate(text));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(expressions_give_text, begin_variables, end),
        cmocka_unit_test_setup_teardown(nonsense_is_refused, begin_variables, end),
        cmocka_unit_test_setup_teardown(nesting_has_an_end, begin_variables, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
