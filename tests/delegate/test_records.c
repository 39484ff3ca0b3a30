// Records of the adapter: paths in the index, materials met once, and what is told of others.

#include "stage_fixture.h"

#include "stage_adapter/adapter.h"
#include "support/faults.h"

static const char body[] = "def Mesh 'M' { $triangle } def Xform 'X' {} def Material 'A' {}";

static CoRecord *add(const char *path, CohortError *err)
{
    CoRecord record = {.kind = CO_RECORD_CAMERA, .path = path, .prototype = CO_WORLD};
    return co_record_add(stage.adapter, &record, COHORT_PRIM_CAMERA, err);
}

// Another place of a prim that is there already gets a path of its own, and each is found.
static void test_taken_paths_get_a_number(void **state)
{
    (void)state;
    open_stage(body);
    static const char *const want[] = {"/X@2", "/X@3", "/X@4"};
    assert_string_equal(add("/X", NULL)->path, "/X");
    for (int i = 0; i < 3; i++)
        assert_string_equal(add("/X", NULL)->path, want[i]);
    for (int i = 0; i < 3; i++)
        assert_string_equal(co_record_find(stage.adapter, want[i])->path, want[i]);
    assert_null(co_record_find(stage.adapter, "/X@5"));
    assert_null(co_record_find(stage.adapter, ""));
}

static void test_materials_are_met_once(void **state)
{
    (void)state;
    open_stage(body);
    CohortAdapter *adapter = stage.adapter;
    CoPlace from = {cohort_stage_prim(adapter->stage, "/M"), CO_WORLD};
    size_t before = adapter->record_count;
    assert_null(co_record_material(adapter, from, NULL, NULL));
    assert_false(is_reported("/M", "material:binding"));
    const char *a = co_record_material(adapter, from, "/A", NULL);
    assert_string_equal(a, "/A");
    assert_ptr_equal(co_record_material(adapter, from, "/A", NULL), a);
    assert_int_equal(adapter->record_count, before + 1);
    // What is there but is no material, in the index or out of it.
    assert_null(co_record_material(adapter, from, "/M", NULL));
    assert_null(co_record_material(adapter, from, "/X", NULL));
    assert_null(co_record_material(adapter, from, "/Nowhere", NULL));
    assert_true(is_reported("/M", "material:binding"));
    assert_int_equal(adapter->record_count, before + 1);
}

// A record that could not be added leaves the path free.
static void test_allocation_failures(void **state)
{
    (void)state;
    open_stage(body);
    size_t before = stage.adapter->record_count;
    CoRecord *record = NULL;
    int failures = 0;
    for (uint64_t n = 1; n < 100 && !record; n++) {
        CohortError err = {0};
        co_memory_fail_after(n);
        record = add("/new", &err);
        co_memory_fail_after(0);
        if (!record) {
            assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
            assert_int_equal(stage.adapter->record_count, before);
            assert_null(co_record_find(stage.adapter, "/new"));
            failures++;
        }
    }
    assert_non_null(record);
    assert_string_equal(record->path, "/new");
    assert_true(failures > 0);
    // Nor does the number of a taken one.
    CohortError err = {0};
    test_arena_leave(&stage.adapter->arena, 0);
    assert_null(add("/new", &err));
    assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
    assert_int_equal(stage.adapter->record_count, before + 1);
    stage.adapter->arena.limit = 0;
    assert_string_equal(add("/new", NULL)->path, "/new@2");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_taken_paths_get_a_number, close_stage),
        cmocka_unit_test_teardown(test_materials_are_met_once, close_stage),
        cmocka_unit_test_teardown(test_allocation_failures, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
