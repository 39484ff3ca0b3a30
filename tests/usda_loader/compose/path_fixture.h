// A table of paths, empty before each test, for tests of what works on paths.

#ifndef TEST_PATH_FIXTURE_H
#define TEST_PATH_FIXTURE_H

#include "compose/prim_path.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static CoArena arena = {.tag = CO_MEMORY_USDA};
static CoPathTable table;

static int begin(void **state)
{
    (void)state;
    co_path_table_init(&table, &arena);
    return 0;
}

static int end(void **state)
{
    (void)state;
    co_arena_clear(&arena);
    return 0;
}

#endif
