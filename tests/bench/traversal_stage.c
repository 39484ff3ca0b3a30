// Scenes by name: made ones, and a stage's meshes as the engine has them after a commit.
#include "traversal_scene.h"

#include "cohort/stage_adapter.h"
#include "index/index.h"
#include "integrate/scene_data.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool load_stage(const char *path, BenchScene *out, char *why, size_t why_size)
{
    CohortError err = {0};
    CohortAdapterOptions options = {0};
    CohortDelegate *delegate = cohort_delegate_create(&err);
    CohortRenderIndex *index = delegate ? cohort_render_index_create(delegate, &err) : NULL;
    CohortAdapter *adapter = index ? cohort_adapter_open(delegate, path, &options, &err) : NULL;
    if (!adapter || !cohort_adapter_populate(adapter, &err) ||
        !cohort_render_index_sync(index, &err)) {
        snprintf(why, why_size, "%s", err.message);
        cohort_adapter_destroy(adapter);
        cohort_delegate_destroy(delegate);
        return false;
    }
    // Never closed: the benchmark ends with the process.
    const CohortScene *scene = index->scene;
    *out = (BenchScene){.name = "shaderball", .accel = scene->accel};
    out->path_count = scene->path_count;
    for (uint32_t i = 0; i < scene->accel.object_count; i++) {
        const CoMesh *mesh = scene->accel.objects[i].mesh;
        out->own_triangles += mesh ? mesh->tri_count : 0;
        if (mesh)
            out->mesh_bytes +=
                12 * ((size_t)mesh->point_count + (mesh->indices ? mesh->tri_count : 0));
    }
    for (uint64_t i = 0; i < out->path_count; i++) {
        CoPlacement placement;
        co_accel_placement(&scene->accel, (uint32_t)i, &placement);
        out->triangles += scene->accel.objects[placement.object].mesh->tri_count;
    }
    const CoObject *root = &scene->accel.objects[scene->accel.root];
    CoVec3 middle = co_scale(co_add(root->box_min, root->box_max), 0.5f);
    CoVec3 half = co_scale(co_sub(root->box_max, root->box_min), 0.5f);
    // Cameras are set by render passes, of which there is none here.
    out->up = co_vec3(0, 1, 0);
    out->eye = co_add(middle, co_mul(half, co_vec3(0.35f, 0.5f, 0.6f)));
    out->target = middle;
    out->light_low = co_madd(middle, half, -0.2f);
    out->light_high = co_madd(middle, half, 0.2f);
    out->light_low.y = out->light_high.y = root->box_max.y;
    return true;
}

bool bench_scene_open(const char *name, const char *stage, double ground, BenchScene *out)
{
    char path[1024], why[256];
    const char *shared = getenv("COHORT_SHARED");
    if (strcmp(name, "shaderball") != 0)
        return bench_scene_make(name, ground, out) && bench_scene_build(out);
    snprintf(path, sizeof path, "%s/stages/full_assets/StandardShaderBall/%s",
             shared ? shared : COHORT_SHARED_DIR, "standard_shader_ball_scene.usda");
    if (load_stage(stage ? stage : path, out, why, sizeof why))
        return true;
    fprintf(stderr, "shaderball skipped: %s\n", why);
    return false;
}
