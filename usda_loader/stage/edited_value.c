// Array edits: an opinion that changes a weaker opinion's array instead of replacing it.

#include "stage/stage_data.h"

#include <string.h>

#define MAX_ELEMENTS ((int64_t)1 << 31)

typedef struct CoEdited {
    const CohortStage *stage;
    char *bytes;
    size_t count, capacity, size; // size: bytes of one element
    bool is_out_of_memory;
} CoEdited;

static bool reserve(CoEdited *array, size_t count)
{
    if (count <= array->capacity)
        return true;
    size_t capacity = count + count / 2;
    char *bytes = co_stage_alloc(array->stage, capacity, array->size);
    if (!bytes) {
        array->is_out_of_memory = true;
        return false;
    }
    if (array->count)
        memcpy(bytes, array->bytes, array->count * array->size);
    array->bytes = bytes;
    array->capacity = capacity;
    return true;
}

// Indices below zero count from the end. `most` is the greatest that means something, plus one.
static bool find_index(int64_t index, size_t count, size_t most, size_t *out)
{
    if (index < 0)
        index += (int64_t)count;
    if (index < 0 || (uint64_t)index >= most)
        return false;
    *out = (size_t)index;
    return true;
}

static void insert(CoEdited *array, size_t at, const void *element)
{
    char copy[128]; // the element may move with the array
    memcpy(copy, element, array->size);
    if (!reserve(array, array->count + 1))
        return;
    memmove(array->bytes + (at + 1) * array->size, array->bytes + at * array->size,
            (array->count - at) * array->size);
    memcpy(array->bytes + at * array->size, copy, array->size);
    array->count++;
}

static void resize(CoEdited *array, size_t count, const void *fill)
{
    if (!reserve(array, count))
        return;
    for (size_t i = array->count; i < count; i++) {
        if (fill)
            memcpy(array->bytes + i * array->size, fill, array->size);
        else
            memset(array->bytes + i * array->size, 0, array->size);
    }
    array->count = count;
}

static void apply_sized(CoEdited *array, const CoArrayEditItem *item)
{
    if (item->at_or_size < 0 || item->at_or_size > MAX_ELEMENTS)
        return;
    size_t count = (size_t)item->at_or_size;
    bool grows = item->kind != CO_EDIT_MAXSIZE && count > array->count;
    bool shrinks = item->kind != CO_EDIT_MINSIZE && count < array->count;
    if (grows || shrinks)
        resize(array, count, item->literal ? item->literal->data : NULL);
}

static void apply(CoEdited *array, const CoArrayEditItem *item)
{
    if (item->kind >= CO_EDIT_MINSIZE) {
        apply_sized(array, item);
        return;
    }
    size_t at, from;
    if (item->kind == CO_EDIT_ERASE) {
        if (find_index(item->at_or_size, array->count, array->count, &at)) {
            array->count--;
            memmove(array->bytes + at * array->size, array->bytes + (at + 1) * array->size,
                    (array->count - at) * array->size);
        }
        return;
    }
    const void *element = item->literal ? item->literal->data : NULL;
    if (!element && find_index(item->source, array->count, array->count, &from))
        element = array->bytes + from * array->size;
    if (!element)
        return;
    if (item->kind == CO_EDIT_PREPEND)
        insert(array, 0, element);
    else if (item->kind == CO_EDIT_APPEND)
        insert(array, array->count, element);
    else if (item->kind == CO_EDIT_INSERT &&
             find_index(item->at_or_size, array->count, array->count + 1, &at))
        insert(array, at, element);
    else if (item->kind == CO_EDIT_WRITE &&
             find_index(item->at_or_size, array->count, array->count, &at))
        memmove(array->bytes + at * array->size, element, array->size);
}

bool co_value_edited(const CohortStage *stage, const CoArrayEdit *edit, CohortType type,
                     const CohortValue *base, double time, CohortValue *out)
{
    size_t size = co_type_size(type);
    if (!size || size > 128)
        return false;
    CoQueryKey key = {edit, base->data, CO_QUERY_VALUE, time};
    co_stage_lock(stage);
    const CoAnswer *answer = co_stage_find_answer(stage, &key);
    if (!answer) {
        CoEdited array = {.stage = stage, .size = size};
        if (base->count)
            resize(&array, base->count, NULL);
        if (base->count && !array.is_out_of_memory)
            memcpy(array.bytes, base->data, base->count * size);
        for (size_t i = 0; i < edit->count && !array.is_out_of_memory; i++)
            apply(&array, &edit->items[i]);
        if (!array.is_out_of_memory && reserve(&array, 1))
            answer = co_stage_keep_answer(stage, &key,
                                          &(CoAnswer){.data = array.bytes, .count = array.count});
    }
    if (answer)
        *out = (CohortValue){type, true, answer->count, answer->data};
    co_stage_unlock(stage);
    return answer != NULL;
}
