#include "fake_host.h"

#include "base/error.h"

#include <string.h>

static bool get_mesh(void *cookie, CohortPull *pull, const char *path, CohortMeshSource *out,
                     CohortError *err)
{
    FakeHost *host = cookie;
    (void)path;
    host->mesh_pulls++;
    CO_CHECK(!host->fail_mesh, err, COHORT_ERROR_SCENE, "the host has no such mesh");
    static const int32_t counts[] = {3}, indices[] = {0, 1, 2};
    static const float early[9] = {9, 9, 9}, now[9] = {1, 2, 3};
    CohortPointsSample *samples = cohort_pull_array(pull, 2, sizeof *samples);
    CO_CHECK_MEMORY(samples, err);
    samples[0] = (CohortPointsSample){.time = -0.5, .points = early};
    samples[1] = (CohortPointsSample){.time = 0.0, .points = now};
    out->points = samples;
    out->points_sample_count = 2;
    out->mesh.point_count = 3;
    out->mesh.face_vertex_counts = counts;
    out->mesh.face_count = 1;
    out->mesh.face_vertex_indices = indices;
    out->mesh.face_vertex_index_count = 3;
    out->material = host->material;
    return true;
}

static bool get_transform(void *cookie, CohortPull *pull, const char *path,
                          const CohortTransformSample **out, size_t *count, CohortError *err)
{
    FakeHost *host = cookie;
    (void)path;
    host->transform_pulls++;
    CohortTransformSample *samples = cohort_pull_array(pull, 2, sizeof *samples);
    CO_CHECK_MEMORY(samples, err);
    for (int s = 0; s < 2; s++)
        for (int i = 0; i < 4; i++)
            samples[s].matrix[i][i] = 1.0;
    samples[0].time = 0.0;
    samples[0].matrix[3][0] = host->x;
    samples[1].time = 1.0;
    samples[1].matrix[3][0] = 1000.0;
    *out = samples;
    *count = 2;
    return true;
}

static bool get_visible(void *cookie, const char *path)
{
    (void)path;
    return !((FakeHost *)cookie)->invisible;
}

static bool get_light(void *cookie, CohortPull *pull, const char *path, CohortLightDesc *out,
                      CohortError *err)
{
    (void)pull, (void)path, (void)err;
    ((FakeHost *)cookie)->light_pulls++;
    *out = cohort_light_default(COHORT_LIGHT_RECT);
    out->intensity = 5.0f;
    return true;
}

static bool get_camera(void *cookie, const char *path, CohortCameraSource *out, CohortError *err)
{
    (void)path, (void)err;
    FakeHost *host = cookie;
    host->camera_pulls++;
    *out = host->camera;
    return true;
}

static bool get_instancer(void *cookie, CohortPull *pull, const char *path,
                          CohortInstancerSource *out, CohortError *err)
{
    (void)pull, (void)path, (void)err;
    FakeHost *host = cookie;
    host->instancer_pulls++;
    *out = host->instancer;
    return true;
}

static bool get_material(void *cookie, CohortPull *pull, const char *path,
                         CohortMaterialNetwork *out, CohortError *err)
{
    (void)pull, (void)path;
    FakeHost *host = cookie;
    host->material_pulls++;
    CO_CHECK(host->network, err, COHORT_ERROR_SCENE, "no network");
    *out = *host->network;
    return true;
}

void fake_host_init(FakeHost *host)
{
    memset(host, 0, sizeof *host);
    host->camera = cohort_camera_source_default();
    host->scene = (CohortSceneDelegate){.cookie = host,
                                        .get_mesh = get_mesh,
                                        .get_transform = get_transform,
                                        .get_visible = get_visible,
                                        .get_light = get_light,
                                        .get_camera = get_camera,
                                        .get_instancer = get_instancer,
                                        .get_material = get_material};
}
