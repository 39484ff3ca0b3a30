// Asset-valued attributes: where each path leads, from the layer that says it.

#include "stage/stage_data.h"

#include <dirent.h>
#include <math.h>
#include <string.h>

// True if dir/prefixNNNNsuffix exists for any tile 1001 ... 9999.
static bool any_tile_exists(const char *path, const char *mark)
{
    char folder[4096];
    const char *slash = mark;
    while (slash > path && *slash != '/')
        slash--;
    size_t length = (size_t)(slash - path);
    if (length >= sizeof folder || strchr(mark, '/'))
        return false;
    memcpy(folder, path, length);
    folder[length] = 0;
    const char *prefix = slash + 1, *suffix = mark + strlen("<UDIM>");
    size_t prefix_length = (size_t)(mark - prefix), suffix_length = strlen(suffix);
    DIR *dir = opendir(length ? folder : "/");
    bool found = false;
    for (struct dirent *entry; dir && !found && (entry = readdir(dir));) {
        const char *name = entry->d_name, *tile = name + prefix_length;
        found = strlen(name) == prefix_length + 4 + suffix_length &&
                !memcmp(name, prefix, prefix_length) && strspn(tile, "0123456789") >= 4 &&
                *tile != '0' && !strcmp(tile + 4, suffix);
    }
    if (dir)
        closedir(dir);
    return found;
}

bool co_asset_locate(CohortStage *stage, const CoSource *source, const CohortString *text,
                     CohortAsset *out)
{
    // Anchoring may intern and evaluate, which the composer does in its own memory.
    CoComposer *c = &stage->composer;
    if (setjmp(c->escape) != 0) {
        stage->refusals++;
        return false;
    }
    const char *why;
    const char *authored = co_expression_evaluate(c, source->stack->variables, text->text, &why);
    out->authored = authored ? authored : text->text;
    out->anchored = co_asset_anchor(c, source->file, out->authored);
    out->resolved = "";
    const char *mark = strstr(out->anchored, "<UDIM>");
    if (*out->anchored &&
        (mark ? any_tile_exists(out->anchored, mark) : co_asset_exists(c, out->anchored)))
        out->resolved = out->anchored;
    return true;
}

size_t cohort_prim_assets(const CohortPrim *prim, const char *name, double time,
                          const CohortAsset **out)
{
    CohortValue value;
    if (!cohort_prim_value(prim, name, time, &value) || value.type != COHORT_TYPE_ASSET)
        return 0;
    CoValueSource from = co_prim_value_source(prim, name, isnan(time));
    CohortStage *stage = prim->data->stage;
    CoQueryKey key = {value.data, from.source, CO_QUERY_ASSETS, 0};
    co_stage_lock(stage);
    const CoAnswer *known = co_stage_find_answer(stage, &key);
    CoAnswer answer = known ? *known : (CoAnswer){.count = value.count};
    if (!known) {
        CohortAsset *assets = co_stage_alloc(stage, value.count, sizeof *assets);
        answer.data = assets;
        for (size_t i = 0; answer.data && i < value.count; i++)
            if (!co_asset_locate(stage, from.source, (const CohortString *)value.data + i,
                                 &assets[i]))
                answer.data = NULL;
        if (answer.data)
            co_stage_keep_answer(stage, &key, &answer);
    }
    co_stage_unlock(stage);
    *out = answer.data;
    return answer.data ? answer.count : 0;
}
