// The AOVs there are.

#include "cohort/delegate.h"

#include <math.h>
#include <string.h>

static const CohortAovDescriptor table[] = {
    {"color",
     COHORT_AOV_COLOR,
     COHORT_FORMAT_FLOAT32_VEC4,
     {0},
     true,
     "Premultiplied RGBA, linear in the rendering space."},
    {"depth",
     COHORT_AOV_DEPTH,
     COHORT_FORMAT_FLOAT32,
     {1.0f},
     false,
     "Clip-space depth from 0 (near) to 1 (far)."},
    {"cameraDepth",
     COHORT_AOV_CAMERA_DEPTH,
     COHORT_FORMAT_FLOAT32,
     {INFINITY},
     false,
     "Distance along the viewing axis in scene units."},
    {"normal",
     COHORT_AOV_NORMAL,
     COHORT_FORMAT_FLOAT32_VEC3,
     {0},
     true,
     "World-space shading normal."},
    {"albedo",
     COHORT_AOV_ALBEDO,
     COHORT_FORMAT_FLOAT32_VEC3,
     {0},
     true,
     "Color of the surface without lighting."},
    {"primId",
     COHORT_AOV_PRIM_ID,
     COHORT_FORMAT_INT32,
     {-1.0f},
     false,
     "Number of the mesh, see cohort_render_index_prim_path."},
    {"elementId", COHORT_AOV_ELEMENT_ID, COHORT_FORMAT_INT32, {-1.0f}, false, "Face of the cage."},
    {"sampleCount", COHORT_AOV_SAMPLE_COUNT, COHORT_FORMAT_FLOAT32, {0}, false, "Samples taken."},
    {"error",
     COHORT_AOV_ERROR,
     COHORT_FORMAT_FLOAT32,
     {0},
     false,
     "Estimated standard error of the mean of R, G and B."},
};

size_t cohort_format_size(CohortFormat format)
{
    switch (format) {
    case COHORT_FORMAT_NONE:
        return 0;
    case COHORT_FORMAT_FLOAT32:
    case COHORT_FORMAT_INT32:
        return 4;
    case COHORT_FORMAT_FLOAT32_VEC3:
        return 12;
    case COHORT_FORMAT_FLOAT32_VEC4:
        return 16;
    }
    return 0;
}

CohortAovDescriptor cohort_aov_descriptor(const char *name)
{
    for (size_t i = 0; name && i < sizeof table / sizeof table[0]; i++)
        if (strcmp(table[i].name, name) == 0)
            return table[i];
    return (CohortAovDescriptor){.name = ""};
}

size_t cohort_aov_descriptors(const CohortAovDescriptor **out)
{
    *out = table;
    return sizeof table / sizeof table[0];
}
