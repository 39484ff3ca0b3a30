// List ops over packed items, as queries apply them.

#include "stage/stage_data.h"

#include "base/hash.h"

#include <string.h>

static char *item_at(const CoEditList *list, size_t i)
{
    return (char *)list->items + i * list->item_size;
}

static bool is_equal(const CoEditList *list, const void *a, const void *b)
{
    if (!list->is_text)
        return !memcmp(a, b, list->item_size);
    const CohortString *x = a, *y = b;
    return x->length == y->length && !memcmp(x->text, y->text, x->length);
}

static size_t find(const CoEditList *list, const void *item)
{
    size_t i = 0;
    while (i < list->count && !is_equal(list, item_at(list, i), item))
        i++;
    return i;
}

static void remove_at(CoEditList *list, size_t i)
{
    if (i == list->count)
        return;
    list->count--;
    memmove(item_at(list, i), item_at(list, i + 1), (list->count - i) * list->item_size);
}

static bool insert_at(CoEditList *list, size_t i, const void *item)
{
    if (list->count == list->capacity) {
        size_t capacity = list->capacity ? list->capacity * 2 : 8;
        void *items = co_stage_alloc(list->stage, capacity, list->item_size);
        if (!items)
            return false;
        if (list->count)
            memcpy(items, list->items, list->count * list->item_size);
        list->items = items;
        list->capacity = capacity;
    }
    memmove(item_at(list, i + 1), item_at(list, i), (list->count - i) * list->item_size);
    memcpy(item_at(list, i), item, list->item_size);
    list->count++;
    return true;
}

static bool reorder(CoEditList *list, const CoEditList *order)
{
    if (!order->count || list->count < 2)
        return true;
    CoEditList out = *list;
    out.items = co_stage_alloc(list->stage, list->count, list->item_size);
    if (!out.items)
        return false;
    out.capacity = list->count;
    out.count = 0;
    size_t i = 0;
    for (; i < list->count && find(order, item_at(list, i)) == order->count; i++)
        insert_at(&out, out.count, item_at(list, i));
    for (size_t k = 0; k < order->count; k++) {
        size_t at = find(list, item_at(order, k));
        if (at == list->count || find(&out, item_at(order, k)) < out.count)
            continue;
        do
            insert_at(&out, out.count, item_at(list, at++));
        while (at < list->count && find(order, item_at(list, at)) == order->count);
    }
    *list = out;
    return true;
}

static bool edit(CoEditList *list, CoListOpKind kind, const void *item)
{
    size_t at = find(list, item);
    switch (kind) {
    case CO_LIST_EXPLICIT:
    case CO_LIST_ADDED:
        return at < list->count || insert_at(list, list->count, item);
    case CO_LIST_PREPENDED:
        remove_at(list, at);
        return insert_at(list, 0, item);
    case CO_LIST_APPENDED:
        remove_at(list, at);
        return insert_at(list, list->count, item);
    case CO_LIST_DELETED:
        remove_at(list, at);
        return true;
    case CO_LIST_ORDERED:
    case CO_LIST_KIND_COUNT:
        break;
    }
    return true;
}

static bool apply_kind(CoEditList *list, const CoListOp *op, CoListOpKind kind,
                       const CoEditTranslate *translate)
{
    CoEditList order = {
        .stage = list->stage, .item_size = list->item_size, .is_text = list->is_text};
    size_t count = op->list[kind].count;
    for (size_t i = 0; i < count; i++) {
        size_t at = kind == CO_LIST_PREPENDED ? count - 1 - i : i;
        const void *item = (const char *)op->list[kind].items + at * list->item_size;
        CohortString translated;
        if (translate) {
            if (!translate->fn(translate->context, item, &translated))
                continue;
            item = &translated;
        }
        bool ok =
            kind == CO_LIST_ORDERED ? insert_at(&order, order.count, item) : edit(list, kind, item);
        if (!ok)
            return false;
    }
    return reorder(list, &order);
}

bool co_edit_list_apply(CoEditList *list, const CoListOp *op, const CoEditTranslate *translate)
{
    if (op->is_explicit) {
        list->count = 0;
        return apply_kind(list, op, CO_LIST_EXPLICIT, translate);
    }
    static const CoListOpKind kinds[] = {CO_LIST_DELETED, CO_LIST_ADDED, CO_LIST_PREPENDED,
                                         CO_LIST_APPENDED, CO_LIST_ORDERED};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (!apply_kind(list, op, kinds[i], translate))
            return false;
    return true;
}
