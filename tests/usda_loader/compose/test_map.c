// Map functions: longest match, no way back means no image, and composition.

#include "compose/map.h"
#include "path_fixture.h"

#include <stdio.h>

static const CoPath *path(const char *text)
{
    bool malformed;
    return co_path_parse(&table, text, strlen(text), &table.root, &malformed);
}

static void a_reference_maps_its_prim_only(void **state)
{
    (void)state;
    const CoMap *map = co_map_pair(&table, path("/Model"), path("/World/M"), false, 10, 2);
    assert_ptr_equal(co_map_to_target(&table, map, path("/Model/Geo")), path("/World/M/Geo"));
    assert_ptr_equal(co_map_to_source(&table, map, path("/World/M")), path("/Model"));
    assert_null(co_map_to_target(&table, map, path("/Other")));
    assert_null(co_map_to_source(&table, map, path("/World")));
}

static void a_class_maps_the_rest_to_itself(void **state)
{
    (void)state;
    const CoMap *map = co_map_pair(&table, path("/C"), path("/A"), true, 0, 1);
    assert_ptr_equal(co_map_to_target(&table, map, path("/C/x")), path("/A/x"));
    assert_ptr_equal(co_map_to_target(&table, map, path("/Other")), path("/Other"));
    // /A itself is what /C became: nothing leads there by identity.
    assert_null(co_map_to_target(&table, map, path("/A")));
    assert_null(co_map_to_source(&table, map, path("/C")));
}

static void maps_compose_and_invert(void **state)
{
    (void)state;
    const CoMap *inner = co_map_pair(&table, path("/Leaf"), path("/Tree/L"), false, 1, 2);
    const CoMap *outer = co_map_pair(&table, path("/Tree"), path("/World/T"), false, 10, 3);
    const CoMap *both = co_map_compose(&table, outer, inner);
    assert_ptr_equal(co_map_to_target(&table, both, path("/Leaf/v")), path("/World/T/L/v"));
    assert_null(co_map_to_target(&table, both, path("/Tree/L")));
    assert_true(both->scale == 6 && both->offset == 13);
    const CoMap *back = co_map_inverse(&table, both);
    assert_ptr_equal(co_map_to_target(&table, back, path("/World/T/L")), path("/Leaf"));
    assert_true(back->scale * both->offset + back->offset == 0);
    const CoMap *identity = co_map_identity(&table);
    assert_true(co_map_is_identity(identity));
    assert_true(co_map_equal(co_map_compose(&table, identity, outer), outer));
    assert_false(co_map_equal(inner, outer));
    assert_false(co_map_is_identity(outer));
}

static void what_a_pair_claims_stays_cut_off(void **state)
{
    (void)state;
    // An heir of /R/Class moves its child to /R/Anim; nothing else may lead there.
    CoMapPair inner_pairs[] = {{path("/R/Class"), path("/R/Heir")},
                               {path("/R/Class/Child"), path("/R/Anim/Moved")},
                               {&table.root, &table.root}};
    CoMapPair outer_pairs[] = {{path("/R"), path("/World/R")},
                               {path("/R/Anim/Moved"), path("/World/Face")}};
    const CoMap *inner = co_map_pairs(&table, inner_pairs, 3);
    CoMap *outer = co_map_pairs(&table, outer_pairs, 2);
    assert_null(co_map_to_target(&table, inner, path("/R/Anim/Moved")));
    const CoMap *at_once = co_map_compose_exactly(&table, outer, inner);
    assert_ptr_equal(co_map_to_target(&table, at_once, path("/R/Anim/Moved")),
                     path("/World/R/Anim/Moved"));
    outer->is_in_steps = true;
    const CoMap *map = co_map_compose_exactly(&table, outer, inner);
    assert_null(co_map_to_target(&table, map, path("/R/Anim/Moved")));
    assert_ptr_equal(co_map_to_target(&table, map, path("/R/Class/Child")), path("/World/Face"));
    assert_ptr_equal(co_map_to_target(&table, map, path("/R/Anim")), path("/World/R/Anim"));
}

static void implied_pairs_are_dropped(void **state)
{
    (void)state;
    CoMapPair pairs[] = {{&table.root, &table.root}, {path("/A"), path("/A")}};
    const CoMap *map = co_map_pairs(&table, pairs, 2);
    assert_int_equal(map->count, 1);
    assert_true(co_map_is_identity(map));
    CoMapPair renames[] = {{&table.root, &table.root}, {path("/A"), path("/B")}};
    assert_int_equal(co_map_pairs(&table, renames, 2)->count, 2);
    assert_true(co_map_equal(co_map_with_root(&table, co_map_pairs(&table, renames + 1, 1)),
                             co_map_pairs(&table, renames, 2)));
}

// Maps of many pairs are looked up by hash: they answer as small ones do.
static void many_pairs_answer_as_few(void **state)
{
    (void)state;
    enum {
        PAIRS = 60
    };
    CoMapPair pairs[PAIRS + 3];
    char text[64];
    for (int i = 0; i < PAIRS; i++) {
        snprintf(text, sizeof text, "/Model/p%d", i);
        pairs[i].source = path(text);
        snprintf(text, sizeof text, "/World/Moved/q%d", i);
        pairs[i].target = i % 10 == 9 ? NULL : path(text);
    }
    pairs[PAIRS] = (CoMapPair){path("/Model"), path("/World")};
    pairs[PAIRS + 1] = pairs[0];                                        // said twice
    pairs[PAIRS + 2] = (CoMapPair){path("/Model/x"), path("/World/x")}; // implied
    const CoMap *map = co_map_pairs(&table, pairs, PAIRS + 3);
    assert_int_equal(map->count, PAIRS + 1);
    assert_ptr_equal(co_map_to_target(&table, map, path("/Model/p7/a")), path("/World/Moved/q7/a"));
    assert_null(co_map_to_target(&table, map, path("/Model/p9/a")));
    assert_ptr_equal(co_map_to_target(&table, map, path("/Model/x/y")), path("/World/x/y"));
    assert_ptr_equal(co_map_to_source(&table, map, path("/World/Moved/q7")), path("/Model/p7"));
    assert_null(co_map_to_source(&table, map, path("/World/p7")));
    assert_null(co_map_to_target(&table, map, path("/Other")));
    const CoMap *outer = co_map_pair(&table, path("/World"), path("/Set/W"), false, 3, 2);
    const CoMap *both = co_map_compose_exactly(&table, outer, map);
    assert_ptr_equal(co_map_to_target(&table, both, path("/Model/p8")), path("/Set/W/Moved/q8"));
    assert_null(co_map_to_target(&table, both, path("/Model/p9")));
    assert_ptr_equal(co_map_compose_exactly(&table, outer, map), both);
    assert_true(co_map_equal(co_map_compose(&table, outer, map), both));
    assert_false(co_map_equal(map, both));
    const CoMap *back = co_map_inverse(&table, both);
    assert_ptr_equal(co_map_to_target(&table, back, path("/Set/W/Moved/q8")), path("/Model/p8"));
    const CoMap *rooted = co_map_with_root(&table, both);
    assert_ptr_equal(co_map_to_target(&table, rooted, path("/Other")), path("/Other"));
    assert_ptr_equal(co_map_with_root(&table, rooted), rooted);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_reference_maps_its_prim_only, begin, end),
        cmocka_unit_test_setup_teardown(a_class_maps_the_rest_to_itself, begin, end),
        cmocka_unit_test_setup_teardown(maps_compose_and_invert, begin, end),
        cmocka_unit_test_setup_teardown(what_a_pair_claims_stays_cut_off, begin, end),
        cmocka_unit_test_setup_teardown(implied_pairs_are_dropped, begin, end),
        cmocka_unit_test_setup_teardown(many_pairs_answer_as_few, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
