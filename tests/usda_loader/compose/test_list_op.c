// List ops: every edit, and the order they come in.

#include "compose/list_op.h"
#include "usda_loader/compose/composer_fixture.h"

// Lists are strings of letters.
static bool letter(void *context, const CoListOp *op, CoListOpKind kind, size_t i, CoListItem *out)
{
    (void)context;
    *out = (CoListItem){.a = (const void *)(uintptr_t)((const char *)op->list[kind].items)[i]};
    return ((const char *)op->list[kind].items)[i] != '-';
}

static void edit(CoList *list, CoListOpKind kind, char *items)
{
    CoListOp op = {.is_explicit = kind == CO_LIST_EXPLICIT};
    op.list[kind].items = items;
    op.list[kind].count = strlen(items);
    co_list_apply(&composer, list, &op, letter, NULL);
}

static void assert_list(const CoList *list, const char *expected)
{
    assert_int_equal(list->count, strlen(expected));
    for (size_t i = 0; i < list->count; i++)
        assert_int_equal((uintptr_t)list->items[i].a, expected[i]);
}

static void edits_do_what_they_say(void **state)
{
    (void)state;
    CoList list = {0};
    edit(&list, CO_LIST_EXPLICIT, (char[]){"abcb"});
    assert_list(&list, "abc");
    edit(&list, CO_LIST_PREPENDED, (char[]){"xb"});
    assert_list(&list, "xbac");
    edit(&list, CO_LIST_APPENDED, (char[]){"xy"});
    assert_list(&list, "bacxy");
    edit(&list, CO_LIST_ADDED, (char[]){"az"});
    assert_list(&list, "bacxyz");
    edit(&list, CO_LIST_DELETED, (char[]){"cq"});
    assert_list(&list, "baxyz");
    edit(&list, CO_LIST_APPENDED, (char[]){"-"}); // dropped by the reader
    assert_list(&list, "baxyz");
    edit(&list, CO_LIST_EXPLICIT, (char[]){""});
    assert_list(&list, "");
}

static void reordering_takes_followers_along(void **state)
{
    (void)state;
    CoList list = {0};
    edit(&list, CO_LIST_EXPLICIT, (char[]){"abcdef"});
    edit(&list, CO_LIST_ORDERED, (char[]){"ebq"});
    assert_list(&list, "aefbcd");
    edit(&list, CO_LIST_ORDERED, (char[]){"q"});
    assert_list(&list, "aefbcd");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(edits_do_what_they_say, begin, end),
        cmocka_unit_test_setup_teardown(reordering_takes_followers_along, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
