// Where asset paths lead.

#include "usda_loader/compose/composer_fixture.h"

static void paths_are_relative_to_their_layer(void **state)
{
    (void)state;
    CoLayerFile layer = {.path = "/show/shot/a.usda"};
    static const struct {
        const char *authored, *anchored;
    } cases[] = {
        {"", ""},
        {"./b.usda", "/show/shot/b.usda"},
        {"b.usda", "/show/shot/b.usda"},
        {"../b.usda", "/show/b.usda"},
        {"../../../../b.usda", "/b.usda"},
        {"x/./y/../b.usda", "/show/shot/x/b.usda"},
        {"/abs//b.usda", "/abs/b.usda"},
        {"//host/b.usda", "//host/b.usda"},
        {"///abs/b.usda", "/abs/b.usda"},
        {"tex.<UDIM>.exr", "/show/shot/tex.<UDIM>.exr"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_string_equal(co_asset_anchor(&composer, &layer, cases[i].authored),
                            cases[i].anchored);
    assert_int_equal(co_asset_anchor(&composer, NULL, "x.usda")[0], '/');
}

static void long_paths_are_whole(void **state)
{
    (void)state;
    char text[3001] = {0};
    memset(text, 'a', 3000);
    CoLayerFile layer = {.path = "/x.usda"};
    const char *anchored = co_asset_anchor(&composer, &layer, text);
    assert_int_equal(strlen(anchored), 3001);
    assert_false(co_asset_exists(&composer, anchored));
    assert_true(co_asset_exists(&composer, "/"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(paths_are_relative_to_their_layer, begin, end),
        cmocka_unit_test_setup_teardown(long_paths_are_whole, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
