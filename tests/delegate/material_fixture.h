// Material networks given by a host, for tests of what becomes of them.

#ifndef COHORT_TEST_MATERIAL_FIXTURE_H
#define COHORT_TEST_MATERIAL_FIXTURE_H

#include "index_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

// The report's first entry of a name, NULL if there is none.
static inline const CohortReportEntry *report_of(const char *name)
{
    const CohortReportEntry *entries;
    size_t count = cohort_delegate_report(delegate, &entries);
    for (size_t i = 0; i < count; i++)
        if (strcmp(entries[i].name, name) == 0)
            return &entries[i];
    return NULL;
}

static inline CohortNodeInput text_input(const char *name, const char *text)
{
    return (CohortNodeInput){.name = name, .source_node = -1, .string = text, .resolved = text};
}

static inline CohortNodeInput number_input(const char *name, float value)
{
    return (CohortNodeInput){.name = name, .source_node = -1, .components = 1, .value = {value}};
}

static inline CohortNodeInput connection(const char *name, int32_t node, const char *output)
{
    return (CohortNodeInput){.name = name, .source_node = node, .source_output = output};
}

// A surface whose diffuseColor is connected to one node.
static inline void sync_with_node(const char *id, const CohortNodeInput *inputs, size_t count)
{
    const CohortNodeInput surface[] = {connection("diffuseColor", 1, "g")};
    const CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 1},
        {.path = "/m/t", .id = id, .inputs = inputs, .input_count = count}};
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 2};
    host.network = &network;
    if (cohort_render_index_prim_count(render_index, COHORT_PRIM_MATERIAL) == 0)
        insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_RESOURCE);
    sync_index();
    host.network = NULL;
}

#endif
