// Children taken over from an equal prim: shared where nothing tells them apart, and never felt.

#include "stage/share.h"
#include "usda_loader/stage/memory_files.h"

#include "base/memory.h"

static bool is_shared(const CohortStage *stage, const char *a, const char *b)
{
    return test_prim(stage, a)->data == test_prim(stage, b)->data;
}

static void equal_references_share_what_is_below(void **state)
{
    (void)state;
    CohortStage *stage = test_open("share.usda", NULL);
    assert_true(is_shared(stage, "/World/A/Seat", "/World/B/Seat"));
    assert_true(is_shared(stage, "/World/A/Leg/Foot", "/World/B/Leg/Foot"));
    assert_false(is_shared(stage, "/World/A", "/World/B"));
    assert_true(is_shared(stage, "/World/Set1/Chair1/Leg", "/World/Set1/Chair2/Leg"));
    assert_true(is_shared(stage, "/World/Set1/Chair2", "/World/Set2/Chair2"));
    assert_true(is_shared(stage, "/World/Set1/Chair1/Leg/Foot", "/World/Set2/Chair2/Leg/Foot"));
    CohortStageInfo info;
    cohort_stage_info(stage, &info);
    // The world, 7 chairs of 5 prims, one of them below a prim, and 2 sets of 2 chairs.
    assert_int_equal(info.prim_count, 1 + 7 * 5 + 1 + 2 * (1 + 2 * 5));
    cohort_stage_destroy(stage);
}

static void whatever_tells_them_apart_keeps_them_apart(void **state)
{
    (void)state;
    CohortStage *stage = test_open("share.usda", NULL);
    static const char *const others[] = {"Told", "Ordered", "Later", "Shiny", "Loose/Undefined"};
    for (size_t i = 0; i < 5; i++) {
        char path[64];
        snprintf(path, sizeof path, "/World/%s/Leg", others[i]);
        assert_false(is_shared(stage, "/World/A/Leg", path));
    }
    assert_true(cohort_prim_double(test_prim(stage, "/World/Told/Seat"), "a", 0, 0) == 10);
    assert_true(cohort_prim_double(test_prim(stage, "/World/B/Seat"), "a", 0, 0) == 1);
    assert_string_equal(cohort_prim_name(cohort_prim_child(test_prim(stage, "/World/Ordered"), 0)),
                        "Leg");
    test_text(stage, "/World/B/Leg", "finish", "dull");
    test_text(stage, "/World/Shiny/Leg", "finish", "shiny");
    assert_false(cohort_prim_is_defined(test_prim(stage, "/World/Loose/Undefined/Leg")));
    cohort_stage_destroy(stage);
}

static void shared_prims_know_where_they_stand(void **state)
{
    (void)state;
    CohortStage *stage = test_open("share.usda", NULL);
    const CohortPrim *foot = test_prim(stage, "/World/Set2/Chair2/Leg/Foot");
    assert_string_equal(cohort_prim_path(foot), "/World/Set2/Chair2/Leg/Foot");
    assert_string_equal(cohort_prim_path(cohort_prim_parent(foot)), "/World/Set2/Chair2/Leg");
    const CohortPrim *chair = test_prim(stage, "/World/Set2/Chair2");
    assert_int_equal(cohort_prim_child_count(chair), 2); // the class is not shown
    assert_ptr_equal(cohort_prim_parent(cohort_prim_child(chair, 0)), chair);
    CohortOpinion opinion;
    assert_int_equal(cohort_prim_opinion_count(foot), 1);
    assert_true(cohort_prim_opinion(foot, 0, &opinion));
    assert_false(opinion.is_introduced);
    assert_true(cohort_prim_opinion(chair, 1, &opinion));
    assert_true(opinion.is_introduced);
    cohort_stage_destroy(stage);
}

static void targets_lead_to_where_the_prim_stands(void **state)
{
    (void)state;
    CohortStage *stage = test_open("share.usda", NULL);
    static const char *const chairs[] = {"/World/A", "/World/B", "/World/Set1/Chair1",
                                         "/World/Set2/Chair2"};
    for (size_t i = 0; i < 4; i++) {
        char seat[64], leg[64], length[64];
        snprintf(seat, sizeof seat, "%s/Seat", chairs[i]);
        snprintf(leg, sizeof leg, "%s/Leg", chairs[i]);
        snprintf(length, sizeof length, "%s/Leg.length", chairs[i]);
        const char *const *paths;
        assert_int_equal(cohort_prim_targets(test_prim(stage, seat), "to", &paths), 2);
        assert_string_equal(paths[0], leg);
        assert_string_equal(paths[1], chairs[i]);
        assert_int_equal(cohort_prim_connections(test_prim(stage, seat), "width", &paths), 1);
        assert_string_equal(paths[0], length);
    }
    cohort_stage_destroy(stage);
}

// More of them than the table holds at first; and a limit of prims counts what is shared each time.
static void many_kinds_are_told_apart(void **state)
{
    (void)state;
    enum {
        KINDS = 100
    };
    static char root[KINDS * 128], library[KINDS * 64];
    size_t used = 0, room = 0;
    used += (size_t)snprintf(root, sizeof root, "#usda 1.0\n");
    room += (size_t)snprintf(library, sizeof library, "#usda 1.0\n");
    for (int i = 0; i < 2 * KINDS; i++)
        used += (size_t)snprintf(root + used, sizeof root - used,
                                 "def \"%c%d\" (references = @./lib.usda@</K%d>)\n{\n}\n",
                                 i < KINDS ? 'A' : 'B', i % KINDS, i % KINDS);
    for (int i = 0; i < KINDS; i++)
        room += (size_t)snprintf(library + room, sizeof library - room,
                                 "def \"K%d\"\n{\n def \"Leaf\"\n {\n }\n}\n", i);
    const MemoryFile files[] = {{"/mem/root.usda", root}, {"/mem/lib.usda", library}};
    MemoryFiles memory = FILES(files);
    CohortStage *stage = memory_stage(&memory, NULL, NULL);
    for (int i = 0; i < KINDS; i++) {
        char a[32], b[32], other[32];
        snprintf(a, sizeof a, "/A%d/Leaf", i);
        snprintf(b, sizeof b, "/B%d/Leaf", i);
        snprintf(other, sizeof other, "/B%d/Leaf", (i + 1) % KINDS);
        assert_true(is_shared(stage, a, b));
        assert_false(is_shared(stage, a, other));
    }
    cohort_stage_destroy(stage);
    CohortStageOptions few = {.max_prims = 4 * KINDS - 10};
    assert_null(memory_stage(&memory, &few, NULL));
}

static void failing_memory_is_survived(void **state)
{
    (void)state;
    char path[1024];
    snprintf(path, sizeof path, DATA "share.usda");
    int failures = 0;
    for (uint64_t i = 1; i < 400; i++) {
        CohortError err = {0};
        co_memory_fail_after(i);
        CohortStage *stage = cohort_stage_open(path, NULL, &err);
        co_memory_fail_after(0);
        if (stage) {
            cohort_stage_destroy(stage);
            break;
        }
        assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        failures++;
    }
    assert_true(failures > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_references_share_what_is_below),
        cmocka_unit_test(whatever_tells_them_apart_keeps_them_apart),
        cmocka_unit_test(shared_prims_know_where_they_stand),
        cmocka_unit_test(targets_lead_to_where_the_prim_stands),
        cmocka_unit_test(many_kinds_are_told_apart),
        cmocka_unit_test(failing_memory_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
