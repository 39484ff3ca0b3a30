// A white floor under a black roof.

#ifndef TEST_SHED_H
#define TEST_SHED_H

#include "support/scenes.h"

enum {
    SHED_FLOOR = 1, // objects
    SHED_ROOF = 2,
    SHED_SIDE = 8, // pixels
    SHED_VALUES = SHED_SIDE * SHED_SIDE * 4
};

// With a light and without a camera; the roof, if it has one, is hidden from some rays.
static inline CohortScene *shed_create(bool has_roof, uint32_t hidden_from,
                                       const CohortLightDesc *light, CohortError *err)
{
    static const float floor_points[] = {-9, -9, -2, 9, -9, -2, 9, 9, -2, -9, 9, -2};
    static const float roof_points[] = {-9, -9, 1, 9, -9, 1, 9, 9, 1, -9, 9, 1};
    static const int32_t indices[] = {0, 1, 2, 3};
    static const float white[3] = {0.8f, 0.8f, 0.8f}, black[3] = {0, 0, 0};
    CohortScene *scene = test_scene(err);
    CohortInstanceDesc places[2];
    for (int k = 0; k < 2; k++) {
        uint32_t id = test_quads(scene, k ? roof_points : floor_points, 4, indices, 1,
                                 k ? black : white, COHORT_INVALID_ID, err);
        assert_int_equal(id, k ? SHED_ROOF : SHED_FLOOR);
        places[k] = test_place(id, 0, 0, 0, 1);
    }
    places[1].hidden_from = hidden_from;
    TEST_OK(cohort_scene_set_group(scene, 0, places, has_roof ? 2 : 1, err), err);
    TEST_OK(cohort_scene_set_light(scene, cohort_scene_new_light(scene, err), light, err), err);
    return scene;
}

// Seen from height z.
static inline void shed_commit(CohortScene *scene, double z, CohortError *err)
{
    test_camera(scene, 0, 0, z, 0.5, err);
    TEST_OK(cohort_scene_commit(scene, NULL, err), err);
}

// Renders the shed and is done with it.
static inline void shed_render(CohortScene *scene, const CohortRenderSettings *settings,
                               float out[SHED_VALUES], CohortError *err)
{
    CohortRenderSettings sized = *settings;
    sized.width = sized.height = SHED_SIDE;
    float *pixels = test_render(scene, &sized, NULL, err);
    memcpy(out, pixels, SHED_VALUES * sizeof *out);
    free(pixels);
    cohort_scene_destroy(scene);
}

#endif
