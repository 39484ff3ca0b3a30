// Variable expressions: strings, functions, and what is wrong with the rest.

#include "usda_loader/compose/composer_fixture.h"

static CoVariables variables;

static int begin_variables(void **state)
{
    static CohortString name = {"oak", 3}, nested = {"`\"${NAME}_tree\"`", 16};
    static CohortString endless = {"`\"${LOOP}\"`", 11};
    static int64_t count = 3;
    static uint8_t yes = 1;
    static CohortString words[] = {{"ash", 3}, {"fir", 3}};
    static int32_t numbers[] = {4, 5, 6};
    static uint8_t flags[] = {0, 1};
    static float floats[] = {0.5f};
    static CoValue values[] = {
        {COHORT_TYPE_STRING, false, 1, &name},    {COHORT_TYPE_STRING, false, 1, &nested},
        {COHORT_TYPE_INT64, false, 1, &count},    {COHORT_TYPE_BOOL, false, 1, &yes},
        {COHORT_TYPE_STRING, false, 1, &endless}, {COHORT_TYPE_STRING, true, 2, words},
        {COHORT_TYPE_INT, true, 3, numbers},      {COHORT_TYPE_BOOL, true, 2, flags},
        {COHORT_TYPE_FLOAT, true, 1, floats}};
    static const char *const names[] = {"NAME",  "NESTED",  "COUNT", "YES",   "LOOP",
                                        "WORDS", "NUMBERS", "FLAGS", "FLOATS"};
    static CoVariable items[9];
    for (size_t i = 0; i < 9; i++)
        items[i] = (CoVariable){names[i], &values[i]};
    variables = (CoVariables){items, 9};
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
        {"`at([\"a\", 'b'], 1)`", "b"},
        {"`at([\"a\", \"b\"], -2)`", "a"},
        {"`at(\"abc\", -1)`", "c"},
        {"`at(${WORDS}, 0)`", "ash"},
        {"`if(contains(${WORDS}, 'fir'), 'y', 'n')`", "y"},
        {"`if(contains([${NAME}], \"ash\"), 'y', 'n')`", "n"},
        {"`if(contains([ ], \"ash\"), 'y', 'n')`", "n"},
        {"`if(eq(len([1, 2, ${COUNT}]), 3), 'y')`", "y"},
        {"`if(eq(at(${NUMBERS}, 2), 6), 'y')`", "y"},
        {"`if(at(${FLAGS}, 1), 'y')`", "y"},
        {"`if(eq(len([]), 0), 'empty')`", "empty"},
        {"`at(if(True, [\"a\"], [\"b\"]), 0)`", "a"},
        {"`at([1, 2, 3, 4, 5, 6, 7, 8, 9, \"x\"], 0)`", NULL},
        {"`[\"a\"]`", NULL},
        {"`[1, \"a\"]`", NULL},
        {"`len([\"a\", [\"b\"]])`", NULL},
        {"`at([None], 0)`", NULL},
        {"`at([\"a\", ], 0)`", NULL},
        {"`at([\"a\" \"b\"], 0)`", NULL},
        {"`at([\"a\"`", NULL},
        {"`at(${WORDS}, 2)`", NULL},
        {"`at(${WORDS}, -3)`", NULL},
        {"`at(${WORDS}, \"a\")`", NULL},
        {"`at([], 0)`", NULL},
        {"`\"${WORDS}\"`", NULL},
        {"`at(${FLOATS}, 0)`", NULL},
        {"`if(contains([\"a\"], 1), 'y')`", NULL},
        {"`if(contains(\"a\", 1), 'y')`", NULL},
        {"`if(eq([\"a\"], [\"a\"]), 'y')`", NULL},
        {"`if(True, \"a\", [\"b\"])`", NULL},
        {"`if(len(3), 'y')`", NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        if (cases[i].value)
            assert_string_equal(evaluate(cases[i].text), cases[i].value);
        else
            assert_null(evaluate(cases[i].text));
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
