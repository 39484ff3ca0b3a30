// What a stack moves: later layers yield, contradictions are left out.

#include "usda_loader/compose/composer_fixture.h"

#include <stdio.h>

static CoStack *stack_of(const char *relocates)
{
    static char text[1 << 17];
    int length =
        snprintf(text, sizeof text, "#usda 1.0\n(\n relocates = {\n%s\n }\n)\n", relocates);
    CohortError err = {0};
    static CoLayerFile file;
    if (file.layer)
        co_layer_destroy(file.layer);
    file = (CoLayerFile){.path = "test.usda", .time_codes_per_second = 24};
    file.layer = co_layer_parse("test.usda", text, (size_t)length, NULL, NULL, NULL, &err);
    assert_non_null(file.layer);
    CoStack *stack = co_composer_alloc(&composer, sizeof *stack);
    stack->layers = co_composer_array(&composer, 1, sizeof *stack->layers);
    stack->layers[0].file = &file;
    stack->layer_count = 1;
    co_stack_relocates(&composer, stack);
    return stack;
}

static void moves_may_follow_each_other(void **state)
{
    (void)state;
    CoStack *stack = stack_of("</A/B>: </A/C>, </A/C/Q>: </A/R>, </A/D>: <>");
    assert_int_equal(stack->relocate_count, 3);
    char text[64];
    co_path_text(stack->relocates[1].origin, text, sizeof text);
    assert_string_equal(text, "/A/B/Q");
    assert_null(stack->relocates[2].target);
}

static void what_is_not_allowed_is_left_out(void **state)
{
    (void)state;
    assert_int_equal(stack_of("</A>: </B/C>")->relocate_count, 0);
    assert_int_equal(stack_of("</A>: <>")->relocate_count, 0);
    assert_int_equal(stack_of("</A/B>: </A/B>")->relocate_count, 0);
    assert_int_equal(stack_of("</A/B>: </A/B/C>")->relocate_count, 0);
    assert_int_equal(stack_of("</A/B/C>: </A/B>")->relocate_count, 0);
    assert_int_equal(stack_of("</A/B>: </Q>")->relocate_count, 1);
}

static void contradictions_leave_out_all_that_take_part(void **state)
{
    (void)state;
    // One target twice; a target that is a source.
    assert_int_equal(stack_of("</A/B>: </A/C>, </A/D>: </A/C>")->relocate_count, 0);
    assert_int_equal(stack_of("</A/B>: </A/C>, </A/C>: </A/D>")->relocate_count, 0);
    // What lies below a source has moved with it: only that one is left out.
    CoStack *stack = stack_of("</A/B>: </A/C>, </A/B/X>: </A/Y>, </A/Z>: </A/B/Z>");
    assert_int_equal(stack->relocate_count, 1);
    assert_string_equal(stack->relocates[0].source->name, "B");
}

static void many_moves_are_found_by_path(void **state)
{
    (void)state;
    enum {
        MOVES = 2000
    };
    static char text[MOVES * 40];
    size_t length = 0;
    for (int i = 0; i < MOVES; i++)
        length += (size_t)snprintf(text + length, sizeof text - length, "</A/p%d>: </A/G/q%d>,\n",
                                   i, i == 7 ? 8 : i);
    CoStack *stack = stack_of(text);
    // Two lead to one target: neither is left.
    assert_int_equal(stack->relocate_count, MOVES - 2);
    const CoPath *above = stack->relocates[0].source->parent;
    const CoMove *last = &stack->relocates[MOVES - 3];
    assert_ptr_equal(co_stack_move_from(stack, last->source), last);
    assert_ptr_equal(co_stack_move_to(stack, last->target), last);
    assert_null(co_stack_move_from(stack, last->target));
    assert_true(co_stack_moves_at(stack, above)->is_above);
    assert_false(co_stack_moves_at(stack, last->target->parent)->is_above);
    size_t count = 0;
    uint32_t number = co_stack_moves_at(stack, above)->first[CO_MOVES_OF_CHILDREN];
    for (; number; number = stack->relocates[number - 1].next[CO_MOVES_OF_CHILDREN])
        assert_int_equal(number, ++count);
    assert_int_equal(count, MOVES - 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(moves_may_follow_each_other, begin, end),
        cmocka_unit_test_setup_teardown(what_is_not_allowed_is_left_out, begin, end),
        cmocka_unit_test_setup_teardown(contradictions_leave_out_all_that_take_part, begin, end),
        cmocka_unit_test_setup_teardown(many_moves_are_found_by_path, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
