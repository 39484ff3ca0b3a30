// Small scenes built through the renderer's C API, for tests.

#ifndef TEST_SUPPORT_SCENES_H
#define TEST_SUPPORT_SCENES_H

#include "cohort/render.h"
#include "cohort/scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static inline void test_identity(double m[4][4])
{
    memset(m, 0, 16 * sizeof(double));
    for (int i = 0; i < 4; i++)
        m[i][i] = 1.0;
}

#define TEST_OK(call, err) \
    do { \
        if (!(call)) \
            fail_msg("%s: %s", #call, (err)->message); \
    } while (0)

static inline CohortScene *test_scene(CohortError *err)
{
    CohortScene *scene = cohort_scene_create(err);
    assert_non_null(scene);
    return scene;
}

// A Lambertian material that emits.
static inline uint32_t test_matte(CohortScene *scene, float albedo, float emission,
                                  CohortError *err)
{
    CohortMaterialDesc desc = cohort_material_default();
    for (int i = 0; i < 3; i++) {
        desc.diffuse_color.value[i] = albedo;
        desc.emissive_color.value[i] = emission;
    }
    desc.lambert = true;
    uint32_t id = cohort_scene_new_material(scene, err);
    TEST_OK(cohort_scene_set_material(scene, id, &desc, err), err);
    return id;
}

// A cage of polygons, all else as it is when nobody says more.
static inline CohortMeshDesc test_cage(const float *points, size_t point_count,
                                       const int32_t *counts, size_t face_count,
                                       const int32_t *indices, size_t index_count)
{
    return (CohortMeshDesc){.path = "/mesh",
                            .scheme = COHORT_SCHEME_NONE,
                            .points = points,
                            .point_count = point_count,
                            .face_vertex_counts = counts,
                            .face_count = face_count,
                            .face_vertex_indices = indices,
                            .face_vertex_index_count = index_count,
                            .material = COHORT_INVALID_ID};
}

// A square from -1 to 1 that faces +Z, of these points or its own.
static const float test_square_points[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};

static inline CohortMeshDesc test_square(const float *points)
{
    static const int32_t counts[] = {4}, indices[] = {0, 1, 2, 3};
    return test_cage(points ? points : test_square_points, 4, counts, 1, indices, 4);
}

static inline uint32_t test_mesh(CohortScene *scene, const CohortMeshDesc *desc, CohortError *err)
{
    uint32_t id = cohort_scene_new_object(scene, err);
    TEST_OK(cohort_scene_set_mesh(scene, id, desc, err), err);
    return id;
}

// A polygon mesh of quads with one constant displayColor.
static inline uint32_t test_quads(CohortScene *scene, const float *points, size_t point_count,
                                  const int32_t *indices, size_t quad_count, const float color[3],
                                  uint32_t material, CohortError *err)
{
    int32_t *counts = malloc(quad_count * sizeof *counts);
    for (size_t i = 0; i < quad_count; i++)
        counts[i] = 4;
    CohortPrimvarDesc display = {
        .name = "displayColor", .components = 3, .values = color, .value_count = 1};
    CohortMeshDesc desc =
        test_cage(points, point_count, counts, quad_count, indices, 4 * quad_count);
    desc.primvars = &display;
    desc.primvar_count = color ? 1 : 0;
    desc.material = material;
    uint32_t id = test_mesh(scene, &desc, err);
    free(counts);
    return id;
}

// A dome of radiance 1.
static inline void test_dome(CohortScene *scene, CohortError *err)
{
    CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
    uint32_t light = cohort_scene_new_light(scene, err);
    TEST_OK(cohort_scene_set_light(scene, light, &dome, err), err);
}

// An axis-parallel box from -1 to 1, six quads.
static const float test_box_points[24] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1,
                                          -1, -1, 1,  1, -1, 1,  1, 1, 1,  -1, 1, 1};
static const int32_t test_box_indices[24] = {4, 5, 6, 7, 1, 0, 3, 2, 5, 1, 2, 6,
                                             0, 4, 7, 3, 7, 6, 2, 3, 0, 1, 5, 4};

static inline CohortInstanceDesc test_place(uint32_t object, double x, double y, double z,
                                            double scale)
{
    CohortInstanceDesc desc = {.object = object, .prim_id = (int32_t)object};
    test_identity(desc.transform);
    for (int i = 0; i < 3; i++)
        desc.transform[i][i] = scale;
    desc.transform[3][0] = x;
    desc.transform[3][1] = y;
    desc.transform[3][2] = z;
    return desc;
}

// A pinhole at (x, y, z) looking along -Z; window half size `tangent`.
static inline void test_camera(CohortScene *scene, double x, double y, double z, double tangent,
                               CohortError *err)
{
    CohortCameraDesc desc = {
        .window = {-tangent, tangent, -tangent, tangent}, .clip_near = 1e-4, .clip_far = 1e6};
    test_identity(desc.transform);
    desc.transform[3][0] = x;
    desc.transform[3][1] = y;
    desc.transform[3][2] = z;
    TEST_OK(cohort_scene_set_camera(scene, &desc, err), err);
}

// Renders to the end and returns the color AOV (width * height * 4 floats, free it).
static inline float *test_render(const CohortScene *scene, const CohortRenderSettings *settings,
                                 CohortRenderStats *stats, CohortError *err)
{
    CohortRender *render = cohort_render_create(scene, settings, err);
    if (!render)
        fail_msg("%s", err->message);
    while (!cohort_render_is_done(render))
        TEST_OK(cohort_render_round(render, err), err);
    float *pixels = malloc((size_t)settings->width * settings->height * 4 * sizeof *pixels);
    assert_true(cohort_render_aov(render, COHORT_AOV_COLOR, pixels));
    if (stats)
        cohort_render_stats(render, stats);
    cohort_render_destroy(render);
    return pixels;
}

// A square wall of half side `half` at height z that faces the camera.
static inline void test_wall(CohortScene *scene, CohortInstanceDesc *place, double half, double z,
                             uint32_t material, CohortError *err)
{
    CohortMeshDesc desc = test_square(NULL);
    desc.material = material;
    *place = test_place(test_mesh(scene, &desc, err), 0, 0, z, half);
}

static inline uint32_t test_light(CohortScene *scene, const CohortLightDesc *light,
                                  CohortError *err)
{
    uint32_t id = cohort_scene_new_light(scene, err);
    TEST_OK(cohort_scene_set_light(scene, id, light, err), err);
    return id;
}

#endif
