#include "compose/read_ahead.h"

#include "base/error.h"

#include <stdarg.h>
#include <string.h>

bool co_composer_init(CoComposer *c, const CohortStageOptions *options, CohortError *err)
{
    c->arena.tag = c->scratch.tag = CO_MEMORY_USDA;
    c->err = err;
    if (options)
        c->options = *options;
    if (!c->options.max_depth)
        c->options.max_depth = 512;
    if (!c->options.max_prims)
        c->options.max_prims = 5000000;
    if (!c->options.max_layers)
        c->options.max_layers = 100000;
    co_path_table_init(&c->paths, &c->arena);
    bool ok = true;
#define INTERN(name) ok = ok && (c->names.name = co_token(#name, sizeof #name - 1)) != NULL;
    CO_FIELD_NAMES(INTERN)
#undef INTERN
    c->names.default_value = co_token("default", 7);
    c->names.any_type = co_token("__AnyType__", 11);
    CO_CHECK(ok && c->names.default_value && c->names.any_type, err, COHORT_ERROR_OUT_OF_MEMORY,
             "out of memory");
    return true;
}

void co_composer_clear(CoComposer *c)
{
    for (size_t i = 0; i < c->file_count; i++)
        if (c->files[i]->layer)
            co_layer_destroy(c->files[i]->layer);
    c->file_count = 0;
    co_read_ahead_drop(c);
    c->entry_capacity = 0;
    co_arena_clear(&c->scratch);
    co_arena_clear(&c->arena);
}

void co_composer_fail(CoComposer *c, CohortErrorCode code, const char *text)
{
    CO_FAIL(c->err, code, "%s", text);
    longjmp(c->escape, 1);
}

void co_composer_limit(CoComposer *c, const CoLayerFile *layer, const CoPath *path,
                       const char *what, uint64_t limit, const char *option)
{
    char where[256];
    CO_FAIL(c->err, COHORT_ERROR_LIMIT, "%s than the limit of %llu; raise %s to open it", what,
            (unsigned long long)limit, option);
    if (path)
        co_path_text(path, where, sizeof where);
    if (c->err)
        co_error_place(c->err, layer ? layer->path : NULL, 0, 0, path ? where : NULL);
    longjmp(c->escape, 1);
}

void *co_composer_alloc(CoComposer *c, size_t size)
{
    void *memory = co_arena_alloc(&c->arena, size);
    if (!memory)
        co_composer_fail(c, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    return memory;
}

void *co_composer_array(CoComposer *c, size_t count, size_t size)
{
    size_t bytes;
    if (!co_size_mul(count, size, &bytes))
        co_composer_fail(c, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    return co_composer_alloc(c, bytes);
}

void *co_composer_scratch(CoComposer *c, size_t count, size_t size)
{
    void *memory = co_arena_array(&c->scratch, count, size);
    if (!memory)
        co_composer_fail(c, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    return memory;
}

void *co_composer_grow(CoComposer *c, void *items, size_t count, size_t *capacity, size_t size)
{
    if (count < *capacity)
        return items;
    size_t wanted = *capacity ? *capacity * 2 : 8;
    void *moved = co_composer_array(c, wanted, size);
    if (count)
        memcpy(moved, items, count * size);
    *capacity = wanted;
    return moved;
}

const void *co_composer_need(CoComposer *c, const void *made)
{
    if (!made)
        co_composer_fail(c, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    return made;
}

static void keep_problem(CoComposer *c, CohortProblem problem)
{
    c->problems = co_composer_grow(c, c->problems, c->problem_count, &c->problem_capacity,
                                   sizeof *c->problems);
    problem.prim =
        co_composer_need(c, co_arena_string(&c->arena, problem.prim, strlen(problem.prim)));
    problem.text =
        co_composer_need(c, co_arena_string(&c->arena, problem.text, strlen(problem.text)));
    c->problems[c->problem_count++] = problem;
}

void co_composer_warn(CoComposer *c, CohortProblemKind kind, const CoLayerFile *layer,
                      uint32_t line, const CoPath *path, const char *format, ...)
{
    c->warning_count++;
    c->is_strict_failure |= c->options.strict;
    char text[512], where[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    where[0] = 0;
    if (path)
        co_path_text(path, where, sizeof where);
    keep_problem(c, (CohortProblem){kind, layer ? layer->path : "", where, text, line});
    if (c->options.strict && c->err && c->err->code == COHORT_OK) {
        CO_FAIL(c->err, COHORT_ERROR_COMPOSITION, "%s", text);
        co_error_place(c->err, layer ? layer->path : NULL, line, 0, path ? where : NULL);
    }
    if (c->options.report)
        c->options.report(c->options.cookie,
                          c->options.strict ? COHORT_SEVERITY_ERROR : COHORT_SEVERITY_WARNING,
                          layer ? layer->path : "", line, 0, path ? where : "", text);
}
