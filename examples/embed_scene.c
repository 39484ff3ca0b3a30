// Builds a scene in memory and renders it with the engine alone: no USD, no delegate. A cube at
// subdivision level 4, red clay, under a white dome.
//
// cc embed_scene.c $(pkg-config --cflags --libs cohort); base.h says how the module that reads
// images is found. usage: embed_scene OUT.exr [SAMPLES]

#include "cohort/image.h"
#include "cohort/render.h"

#include <stdio.h>
#include <stdlib.h>

enum {
    SIDE = 128
};

static const float points[] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1,
                               -1, -1, 1,  1, -1, 1,  1, 1, 1,  -1, 1, 1};
static const int32_t counts[] = {4, 4, 4, 4, 4, 4};
static const int32_t indices[] = {4, 5, 6, 7, 1, 0, 3, 2, 5, 1, 2, 6,
                                  0, 4, 7, 3, 7, 6, 2, 3, 0, 1, 5, 4};
static const CohortInstanceDesc at_origin = {
    .transform = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};

static bool build(CohortScene *scene, CohortError *err)
{
    CohortMaterialDesc clay = cohort_material_default();
    clay.diffuse_color.value[0] = 0.6f;
    uint32_t material = cohort_scene_new_material(scene, err);
    CohortMeshDesc cube = {.path = "cube",
                           .level = 4,
                           .points = points,
                           .point_count = 8,
                           .face_vertex_counts = counts,
                           .face_count = 6,
                           .face_vertex_indices = indices,
                           .face_vertex_index_count = 24,
                           .material = material};
    CohortInstanceDesc place = at_origin;
    place.object = cohort_scene_new_object(scene, err);
    CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
    CohortCameraDesc camera = {
        .window = {-0.4, 0.4, -0.4, 0.4}, .clip_near = 0.1, .clip_far = 100.0};
    for (int i = 0; i < 4; i++)
        camera.transform[i][i] = 1.0;
    camera.transform[3][2] = 3.0;
    return cohort_scene_set_material(scene, material, &clay, err) &&
           cohort_scene_set_mesh(scene, place.object, &cube, err) &&
           cohort_scene_set_group(scene, 0, &place, 1, err) &&
           cohort_scene_set_light(scene, cohort_scene_new_light(scene, err), &dome, err) &&
           cohort_scene_set_camera(scene, &camera, err) && cohort_scene_commit(scene, NULL, err);
}

static bool render(const CohortScene *scene, uint32_t samples, float *pixels, CohortError *err)
{
    CohortRenderSettings settings = {.width = SIDE, .height = SIDE, .spp = samples};
    CohortRender *r = cohort_render_create(scene, &settings, err);
    bool ok = r != NULL;
    while (ok && !cohort_render_is_done(r))
        ok = cohort_render_round(r, err);
    ok = ok && cohort_render_aov(r, COHORT_AOV_COLOR, pixels);
    cohort_render_destroy(r);
    return ok;
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        fprintf(stderr, "usage: %s OUT.exr [SAMPLES]\n", argv[0]);
        return 2;
    }
    static float pixels[SIDE * SIDE][4];
    const CohortChannel channels[] = {{"R", COHORT_CHANNEL_HALF, &pixels[0][0], sizeof *pixels},
                                      {"G", COHORT_CHANNEL_HALF, &pixels[0][1], sizeof *pixels},
                                      {"B", COHORT_CHANNEL_HALF, &pixels[0][2], sizeof *pixels},
                                      {"A", COHORT_CHANNEL_HALF, &pixels[0][3], sizeof *pixels}};
    CohortExrDesc desc = {.width = SIDE, .height = SIDE, .channels = channels, .channel_count = 4};
    CohortError err = {0};
    CohortScene *scene = cohort_scene_create(&err);
    uint32_t samples = argc > 2 ? (uint32_t)atoi(argv[2]) : 16;
    bool ok = scene && build(scene, &err) && render(scene, samples, &pixels[0][0], &err) &&
              cohort_exr_write(argv[1], &desc, &err);
    if (!ok)
        fprintf(stderr, "%s\n", err.message);
    if (scene)
        cohort_scene_destroy(scene);
    return ok ? 0 : 1;
}
