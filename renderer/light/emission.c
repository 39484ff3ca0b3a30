// What a light sends: radiance, texture, focus and cone (UsdLuxLightAPI, UsdLuxShapingAPI).

#include "light/light_internal.h"
#include "math/elementary.h"

static float usable(float texel)
{
    return texel > 0.0f && texel <= 1e30f ? texel : 0.0f;
}

CoVec3 co_light_image_texel(const CoLightImage *image, uint32_t x, uint32_t y)
{
    const float *p = image->pixels + ((size_t)y * image->width + x) * 4;
    return co_vec3(usable(p[0]), usable(p[1]), usable(p[2]));
}

// Column or row `i` of `count`, from -1 to count.
static uint32_t neighbor(int i, uint32_t count, bool wrap)
{
    if (i < 0)
        return wrap ? count - 1 : 0;
    if ((uint32_t)i >= count)
        return wrap ? 0 : count - 1;
    return (uint32_t)i;
}

CoVec3 co_light_image_lookup(const CoLightImage *image, float x, float y, bool wrap)
{
    x = co_clamp(x, 0.0f, (float)image->width) - 0.5f;
    y = co_clamp(y, 0.0f, (float)image->height) - 0.5f;
    int ix = (int)floorf(x), iy = (int)floorf(y);
    float fx = x - (float)ix, fy = y - (float)iy;
    uint32_t x0 = neighbor(ix, image->width, wrap), x1 = neighbor(ix + 1, image->width, wrap);
    uint32_t y0 = neighbor(iy, image->height, false), y1 = neighbor(iy + 1, image->height, false);
    CoVec3 top =
        co_lerp3(co_light_image_texel(image, x0, y0), co_light_image_texel(image, x1, y0), fx);
    CoVec3 low =
        co_lerp3(co_light_image_texel(image, x0, y1), co_light_image_texel(image, x1, y1), fx);
    return co_lerp3(top, low, fy);
}

// Focus tints what leaves off the axis, the cone ends it (text of the ShapingAPI schema).
static CoVec3 shaping(const CoLight *light, CoVec3 dir)
{
    float cosine = co_clamp(-co_dot(dir, light->axis), -1.0f, 1.0f);
    CoVec3 color = co_vec3_splat(1.0f);
    if (light->focus > 0.0f)
        color = co_lerp3(light->focus_tint, color, co_powf(fabsf(cosine), light->focus));
    if (light->cone_outer < CO_PI) {
        float off = co_acosf(cosine);
        if (off > light->cone_outer)
            return co_vec3_splat(0.0f);
        float width = light->cone_outer - light->cone_inner;
        if (width > 0.0f && off > light->cone_inner) {
            float x = (off - light->cone_inner) / width;
            color = co_scale(color, 1.0f - x * x * (3.0f - 2.0f * x));
        }
    }
    return color;
}

CoVec3 co_light_emission(const CoLight *light, CoVec3 dir, float a, float b)
{
    CoVec3 radiance = light->radiance;
    if (light->type == COHORT_LIGHT_RECT && light->image.pixels != NULL) {
        // The first texel stands at (+X, +Y): upright for those the light shines on.
        float x = 0.5f * (1.0f - a) * (float)light->image.width;
        float y = 0.5f * (1.0f - b) * (float)light->image.height;
        radiance = co_mul(radiance, co_light_image_lookup(&light->image, x, y, false));
    }
    if (light->is_shaped)
        radiance = co_mul(radiance, shaping(light, dir));
    return radiance;
}
