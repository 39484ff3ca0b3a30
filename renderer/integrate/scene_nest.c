// Groups nested deeper than the kernels go: some of them give what they place to those that place
// them, so that no more than CO_GROUP_DEPTH_MAX stand within each other.

#include "integrate/scene_data.h"

#include "base/error.h"

#include <string.h>

#define TAG CO_MEMORY_SCENE

// Recursion ends here; a walk has a frame per level.
enum {
    DEPTH_MAX = 1024
};

static bool measure(CohortScene *scene, uint32_t id, uint32_t depth, CohortError *err)
{
    CoSceneObject *o = &scene->objects[id];
    if (o->visit == CO_VISIT_DONE)
        return true;
    CO_CHECK(o->visit == CO_VISIT_NEW, err, COHORT_ERROR_SCENE,
             "object %u contains itself through its instances", id);
    CO_CHECK(depth < DEPTH_MAX, err, COHORT_ERROR_LIMIT, "instances are nested more than %d deep",
             DEPTH_MAX);
    o->visit = CO_VISIT_OPEN;
    o->height = o->kind == CO_OBJECT_GROUP;
    for (uint32_t i = 0; i < o->edit_count; i++) {
        uint32_t child = o->edits[i].object;
        if (!measure(scene, child, depth + 1, err))
            return false;
        uint32_t height = scene->objects[child].height + 1;
        o->height = o->height > height ? o->height : height;
    }
    o->visit = CO_VISIT_DONE;
    return true;
}

// Neighboring heights whose groups become one: the lowest run first, each with its highest height
// and what the largest group of it may come to.
typedef struct Run {
    uint32_t top;
    double size;
} Run;

static uint32_t merge_runs(Run *runs, uint32_t count)
{
    while (count > CO_GROUP_DEPTH_MAX) {
        uint32_t least = 0;
        for (uint32_t i = 1; i + 1 < count; i++)
            if (runs[i].size * runs[i + 1].size < runs[least].size * runs[least + 1].size)
                least = i;
        runs[least + 1].size *= runs[least].size;
        count--;
        memmove(&runs[least], &runs[least + 1], (count - least) * sizeof *runs);
    }
    return count;
}

static void stand_all(CohortScene *scene, const Run *runs, uint32_t count)
{
    bool is_other = false;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        CoSceneObject *o = &scene->objects[i];
        bool is_merged = o->height > 0;
        for (uint32_t r = 0; r < count; r++)
            is_merged = is_merged && o->height != runs[r].top;
        is_other = is_other || is_merged != o->is_merged;
        o->is_merged = is_merged;
    }
    for (uint32_t i = 0; is_other && i < scene->object_count; i++)
        scene->objects[i].is_dirty |= scene->objects[i].kind == CO_OBJECT_GROUP;
}

bool co_scene_nest(CohortScene *scene, CohortError *err)
{
    for (uint32_t i = 0; i < scene->object_count; i++) {
        scene->objects[i].visit = CO_VISIT_NEW;
        scene->objects[i].height = 0;
    }
    if (!measure(scene, 0, 0, err))
        return false;
    uint32_t height = scene->objects[0].height, count = height;
    Run *runs = co_alloc_zero(TAG, height * sizeof *runs);
    CO_CHECK(runs || height == 0, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    for (uint32_t r = 0; r < height; r++)
        runs[r] = (Run){r + 1, 1.0};
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const CoSceneObject *o = &scene->objects[i];
        if (o->height > 0 && (double)o->edit_count > runs[o->height - 1].size)
            runs[o->height - 1].size = (double)o->edit_count;
    }
    count = merge_runs(runs, count);
    stand_all(scene, runs, count);
    co_free(TAG, runs, height * sizeof *runs);
    return true;
}

static uint64_t count_parts(const CohortScene *scene, const CoSceneObject *group)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < group->edit_count; i++) {
        const CoSceneObject *child = &scene->objects[group->edits[i].object];
        uint64_t more = group->edits[i].hidden ? 0 : child->is_merged ? child->part_count : 1;
        count = count + more < count ? UINT64_MAX : count + more;
    }
    return count;
}

// What is said of a placement within what is said of the group it stands in: the innermost color
// counts that is not for meshes without one alone, or for these the innermost at all.
static CoPart within(const CoPart *outer, const CohortInstanceDesc *edit)
{
    CoPart part = {.desc = *edit, .firm_color = edit->color_yields ? NULL : edit->display_color};
    if (!outer)
        return part;
    CoMat4d own, up;
    memcpy(own.m, edit->transform, sizeof own.m);
    memcpy(up.m, outer->desc.transform, sizeof up.m);
    own = co_mat4d_mul(&own, &up);
    memcpy(part.desc.transform, own.m, sizeof own.m);
    part.desc.hidden_from |= outer->desc.hidden_from;
    if (part.desc.prim_id < 0)
        part.desc.prim_id = outer->desc.prim_id;
    if (!part.firm_color)
        part.firm_color = outer->firm_color;
    if (!part.desc.display_color)
        part.desc.display_color = outer->desc.display_color;
    return part;
}

static CoPart *list_parts(const CohortScene *scene, const CoSceneObject *group, const CoPart *outer,
                          CoPart *out)
{
    for (uint32_t i = 0; i < group->edit_count; i++) {
        const CoSceneObject *child = &scene->objects[group->edits[i].object];
        if (group->edits[i].hidden)
            continue;
        CoPart part = within(outer, &group->edits[i]);
        if (child->is_merged)
            out = list_parts(scene, child, &part, out);
        else
            *out++ = part;
    }
    return out;
}

bool co_scene_list_parts(CohortScene *scene, CoSceneObject *group, CohortError *err)
{
    bool has_merged = false;
    for (uint32_t i = 0; i < group->edit_count && !has_merged; i++)
        has_merged = scene->objects[group->edits[i].object].is_merged;
    group->part_count = has_merged || group->is_merged ? count_parts(scene, group) : 0;
    if (!has_merged || group->is_merged)
        return true;
    CO_CHECK(group->part_count < UINT32_MAX / 2, err, COHORT_ERROR_LIMIT,
             "%llu instances in one group, nested more than %d deep",
             (unsigned long long)group->part_count, CO_GROUP_DEPTH_MAX);
    group->parts = co_alloc(TAG, group->part_count * sizeof *group->parts);
    CO_CHECK(group->parts || group->part_count == 0, err, COHORT_ERROR_OUT_OF_MEMORY,
             "out of memory for %llu instances", (unsigned long long)group->part_count);
    list_parts(scene, group, NULL, group->parts);
    return true;
}

// A walk's way from the root.
typedef struct Way {
    const struct Way *outer;
    uint32_t id, depth;
} Way;

static void tell_placements(const CohortScene *scene, const Way *way, const CoMat4d *to_world,
                            CohortPlacementFn *fn, void *cookie)
{
    const CoSceneObject *o = &scene->objects[way->id];
    if (o->kind == CO_OBJECT_MESH)
        fn(cookie, way->id, (const double(*)[4])to_world->m);
    // A circle of groups, which the commit refuses, is gone round once.
    for (const Way *at = way->outer; at; at = at->outer)
        if (at->id == way->id)
            return;
    for (uint32_t i = 0; way->depth < DEPTH_MAX && i < o->edit_count; i++) {
        if (o->edits[i].hidden)
            continue;
        const Way inner = {way, o->edits[i].object, way->depth + 1};
        CoMat4d own;
        memcpy(own.m, o->edits[i].transform, sizeof own.m);
        own = co_mat4d_mul(&own, to_world);
        tell_placements(scene, &inner, &own, fn, cookie);
    }
}

void cohort_scene_placements(const CohortScene *scene, CohortPlacementFn *fn, void *cookie)
{
    const CoMat4d identity = co_mat4d_identity();
    const Way root = {NULL, 0, 0};
    tell_placements(scene, &root, &identity, fn, cookie);
}
