// Interned paths: equal means same, and text round-trips.

#include "parse/layer.h"
#include "path_fixture.h"

#include <stdio.h>

static const CoPath *parse(const char *text, const CoPath *anchor)
{
    bool malformed;
    return co_path_parse(&table, text, strlen(text), anchor ? anchor : &table.root, &malformed);
}

static void equal_paths_are_one_object(void **state)
{
    (void)state;
    const CoPath *a = parse("/A/B", NULL);
    assert_ptr_equal(a, parse("/A/B", NULL));
    assert_ptr_equal(a, parse("B", a->parent));
    assert_ptr_equal(a, parse("../B", a));
    assert_ptr_equal(a, parse(".", a));
    assert_ptr_equal(parse("/", NULL), &table.root);
    assert_int_equal(a->depth, 2);
    assert_ptr_equal(co_path_find_child(&table, a->parent, co_token("B", 1)), a);
    assert_null(co_path_find_child(&table, a, co_token("B", 1)));
}

static void malformed_text_is_refused(void **state)
{
    (void)state;
    static const char *const wrong[] = {"", "//A", "/A//B", "/A/", "..", "/A.b", "/A{v=x}", "/A B"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        bool malformed = false;
        assert_null(co_path_parse(&table, wrong[i], strlen(wrong[i]), &table.root, &malformed));
        assert_true(malformed);
    }
}

static void variants_are_elements_without_depth(void **state)
{
    (void)state;
    const CoPath *a = parse("/A", NULL);
    const CoPath *variant = co_path_variant(&table, a, co_token("v", 1), co_token("x", 1));
    const CoPath *child = co_path_child(&table, variant, co_token("B", 1));
    assert_int_equal(child->depth, 2);
    assert_int_equal(child->length, 3);
    assert_ptr_equal(child->prim, parse("/A/B", NULL));
    assert_ptr_equal(variant->prim, a);
    char text[64], small[5];
    assert_int_equal(co_path_text(child, text, sizeof text), strlen("/A{v=x}B"));
    assert_string_equal(text, "/A{v=x}B");
    assert_int_equal(co_path_text(child, small, sizeof small), strlen("/A{v=x}B"));
    assert_string_equal(small, "/A{v");
    assert_true(co_path_has_prefix(child, variant));
    assert_false(co_path_has_prefix(variant, child));
    assert_ptr_equal(co_path_replace_prefix(&table, child, variant, a), child->prim);
}

static void many_paths_stay_apart(void **state)
{
    (void)state;
    const CoPath *paths[3000];
    for (int i = 0; i < 3000; i++) {
        char text[32];
        snprintf(text, sizeof text, "/P%d/Q%d", i / 10, i);
        paths[i] = parse(text, NULL);
    }
    for (int i = 0; i < 3000; i++) {
        char text[32], again[32];
        snprintf(text, sizeof text, "/P%d/Q%d", i / 10, i);
        co_path_text(paths[i], again, sizeof again);
        assert_string_equal(text, again);
        assert_ptr_equal(parse(text, NULL), paths[i]);
    }
}

static void memory_may_run_out(void **state)
{
    (void)state;
    bool malformed = true;
    co_memory_fail_after(1);
    assert_null(co_path_parse(&table, "/A", 2, &table.root, &malformed));
    co_memory_fail_after(0);
    assert_false(malformed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(equal_paths_are_one_object, begin, end),
        cmocka_unit_test_setup_teardown(malformed_text_is_refused, begin, end),
        cmocka_unit_test_setup_teardown(variants_are_elements_without_depth, begin, end),
        cmocka_unit_test_setup_teardown(many_paths_stay_apart, begin, end),
        cmocka_unit_test_setup_teardown(memory_may_run_out, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
