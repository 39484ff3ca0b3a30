// Metadata: strongest, merged or edited, by its type; and the order of names. Also tests
// edit_list.c.

#include "stage/stage_data.h"
#include "usda_loader/stage/usda_stage_fixture.h"

static int64_t dict_int(const CoDict *dict, const char *key)
{
    for (size_t i = 0; i < dict->count; i++)
        if (!strcmp(dict->entries[i].key, key))
            return *(const int32_t *)dict->entries[i].value->data;
    return -1;
}

static void dictionaries_merge(void **state)
{
    (void)state;
    CohortStage *stage = test_open("lists.usda", NULL);
    CohortValue value;
    assert_true(cohort_prim_metadata(test_prim(stage, "/P"), "customData", &value));
    assert_int_equal(value.type, COHORT_TYPE_DICTIONARY);
    const CoDict *dict = value.data;
    assert_int_equal(dict->count, 3);
    assert_int_equal(dict_int(dict, "strong"), 1);
    assert_int_equal(dict_int(dict, "weak"), 2);
    assert_string_equal(dict->entries[0].key, "inner");
    const CoDict *inner = dict->entries[0].value->data;
    assert_int_equal(dict_int(inner, "x"), 1);
    assert_int_equal(dict_int(inner, "y"), 2);
    cohort_stage_destroy(stage);
}

static void list_ops_apply_weak_to_strong(void **state)
{
    (void)state;
    CohortStage *stage = test_open("lists.usda", NULL);
    const CohortPrim *prim = test_prim(stage, "/P");
    CohortValue value;
    assert_true(cohort_prim_metadata(prim, "apiSchemas", &value));
    assert_int_equal(value.count, 2);
    assert_string_equal(((const CohortString *)value.data)[0].text, "C");
    assert_string_equal(((const CohortString *)value.data)[1].text, "A");
    assert_true(cohort_prim_has_api(prim, "A"));
    assert_false(cohort_prim_has_api(prim, "B"));
    assert_string_equal(cohort_prim_kind(prim), "component");
    assert_string_equal(cohort_prim_kind(cohort_stage_root(stage)), "");
    assert_false(cohort_prim_metadata(prim, "absent", &value));
    cohort_stage_destroy(stage);
}

static void properties_are_sorted_as_people_read(void **state)
{
    (void)state;
    CohortStage *stage = test_open("lists.usda", NULL);
    const CohortPrim *prim = test_prim(stage, "/P");
    static const char *const expected[] = {"zeta", "alpha", "Beta", "beta9", "beta10", "to"};
    assert_int_equal(cohort_prim_property_count(prim), 6);
    for (size_t i = 0; i < 6; i++)
        assert_string_equal(cohort_prim_property_name(prim, i), expected[i]);
    assert_null(cohort_prim_property_name(prim, 6));
    const char *layer;
    uint32_t line;
    assert_true(cohort_prim_origin(prim, "zeta", &layer, &line));
    assert_non_null(strstr(layer, "lists_sub.usda"));
    assert_true(line > 0);
    assert_false(cohort_prim_origin(prim, "absent", &layer, &line));
    cohort_stage_destroy(stage);
}

static void names_compare_like_the_reference(void **state)
{
    (void)state;
    static const struct {
        const char *less, *more;
    } pairs[] = {{"a", "B"},    {"A", "a"},      {"a_b", "ab"},  {"a1", "a01"},
                 {"a_", "A_b"}, {"_a", "a"},     {"_", "Z"},     {"Ab", "aB"},
                 {"a9", "a10"}, {"a1a", "a01b"}, {"aB0", "ab1"}, {"a", "a1"}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        assert_true(co_name_compare(pairs[i].less, pairs[i].more) < 0);
        assert_true(co_name_compare(pairs[i].more, pairs[i].less) > 0);
        assert_int_equal(co_name_compare(pairs[i].less, pairs[i].less), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dictionaries_merge),
        cmocka_unit_test(list_ops_apply_weak_to_strong),
        cmocka_unit_test(properties_are_sorted_as_people_read),
        cmocka_unit_test(names_compare_like_the_reference),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
