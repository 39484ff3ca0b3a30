// Scratch memory of one pull.

#include "index/index.h"

void *cohort_pull_array(CohortPull *pull, size_t count, size_t size)
{
    void *array = co_arena_array(&pull->arena, count, size);
    pull->is_short = pull->is_short || !array;
    return array;
}
