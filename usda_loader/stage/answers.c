// Answers that had to be worked out, kept behind one lock for as long as the stage lives.

#include "stage/stage_data.h"

#include "base/hash.h"

#include <string.h>

// The cache is not part of what a stage is, so a const stage may fill it.
static CohortStage *mutable_stage(const CohortStage *stage)
{
    return stage->self;
}

void co_stage_lock(const CohortStage *stage)
{
    CohortStage *own = mutable_stage(stage);
    pthread_mutex_lock(&own->lock);
    own->refusals_before = own->refusals;
}

void co_stage_unlock(const CohortStage *stage)
{
    pthread_mutex_unlock(&mutable_stage(stage)->lock);
}

void *co_stage_alloc(const CohortStage *stage, size_t count, size_t size)
{
    CohortStage *own = mutable_stage(stage);
    void *array = co_arena_array(&own->answers_arena, count, size);
    own->refusals += !array;
    return array;
}

bool cohort_stage_ran_short(const CohortStage *stage)
{
    CohortStage *own = mutable_stage(stage);
    co_stage_lock(stage);
    bool is_short = own->refusals != own->told;
    own->told = own->refusals;
    co_stage_unlock(stage);
    return is_short;
}

static bool is_same(const CoQueryKey *a, const CoQueryKey *b)
{
    return a->subject == b->subject && a->detail == b->detail && a->number == b->number &&
           !memcmp(&a->time, &b->time, sizeof a->time);
}

static CoAnswerSlot *find_slot(CoAnswerSlot *slots, size_t capacity, const CoQueryKey *key)
{
    uint64_t time;
    memcpy(&time, &key->time, sizeof time);
    uint64_t h =
        co_hash_combine((uint64_t)(uintptr_t)key->subject, (uint64_t)(uintptr_t)key->detail);
    h = co_hash_combine(h, key->number ^ time << 1);
    for (size_t at = h & (capacity - 1);; at = (at + 1) & (capacity - 1))
        if (!slots[at].is_used || is_same(&slots[at].key, key))
            return &slots[at];
}

const CoAnswer *co_stage_find_answer(const CohortStage *stage, const CoQueryKey *key)
{
    if (!stage->answer_capacity)
        return NULL;
    CoAnswerSlot *slot = find_slot(stage->answers, stage->answer_capacity, key);
    return slot->is_used ? &slot->answer : NULL;
}

static bool grow(CohortStage *stage)
{
    size_t capacity = stage->answer_capacity ? stage->answer_capacity * 2 : 256;
    CoAnswerSlot *slots = co_stage_alloc(stage, capacity, sizeof *slots);
    if (!slots)
        return false;
    for (size_t i = 0; i < stage->answer_capacity; i++)
        if (stage->answers[i].is_used)
            *find_slot(slots, capacity, &stage->answers[i].key) = stage->answers[i];
    stage->answers = slots;
    stage->answer_capacity = capacity;
    return true;
}

const CoAnswer *co_stage_keep_answer(const CohortStage *stage, const CoQueryKey *key,
                                     const CoAnswer *answer)
{
    CohortStage *own = mutable_stage(stage);
    if (own->refusals != own->refusals_before)
        return NULL;
    if (2 * own->answer_count >= own->answer_capacity && !grow(own))
        return NULL;
    CoAnswerSlot *slot = find_slot(own->answers, own->answer_capacity, key);
    if (!slot->is_used)
        own->answer_count++;
    *slot = (CoAnswerSlot){*key, *answer, true};
    return &slot->answer;
}
