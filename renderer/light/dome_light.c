// Domes: lat-long images sampled by their brightness, and plain ones by the cosine.
//
// Image: top row towards +Y, left edge at longitude +pi, longitude 0 towards +Z, +pi/2 towards +X
// (UsdLuxDomeLight). Cells of the table carry the bilinear lookup's own sums, so that no direction
// with light has density zero.

#include "light/light_internal.h"
#include "math/warp.h"

#include "base/error.h"

enum {
    CELLS_MAX = 1 << 22
};

static float mean3(CoVec3 v)
{
    return (v.x + v.y + v.z) * (1.0f / 3.0f);
}

// Of a bilinear lookup over one texel: 3/4 of it, 1/8 of either neighbor, in each axis.
static float texel_weight(const CoLightImage *image, uint32_t x, uint32_t y)
{
    uint32_t xs[3] = {x > 0 ? x - 1 : image->width - 1, x, x + 1 < image->width ? x + 1 : 0};
    uint32_t ys[3] = {y > 0 ? y - 1 : 0, y, y + 1 < image->height ? y + 1 : y};
    static const float share[3] = {0.125f, 0.75f, 0.125f};
    float sum = 0.0f;
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++)
            sum += share[i] * share[j] * mean3(co_light_image_texel(image, xs[i], ys[j]));
    return sum;
}

// Fraction of the image's width or height at which cell `i` begins.
static double edge(uint32_t i, uint32_t texels_per_cell, uint32_t texels)
{
    uint64_t texel = (uint64_t)i * texels_per_cell;
    return (double)(texel < texels ? texel : texels) / (double)texels;
}

// Cell weights to running shares in place; weights[count] gets 1. Cells with any light are raised
// to a thousandth of the mean, so that their share stays above the steps of a float. Returns the
// sum.
static double to_shares(float *weights, uint32_t count)
{
    double sum = 0.0, raised = 0.0, running = 0.0;
    for (uint32_t i = 0; i < count; i++)
        sum += (double)weights[i];
    float least = (float)(sum * 1e-3 / count);
    for (uint32_t i = 0; i < count; i++) {
        if (weights[i] > 0.0f && weights[i] < least)
            weights[i] = least;
        raised += (double)weights[i];
    }
    for (uint32_t i = 0; i < count; i++) {
        double weight = raised > 0.0 ? (double)weights[i] / raised : 1.0 / count;
        weights[i] = (float)running;
        running += weight;
    }
    weights[count] = 1.0f;
    return sum;
}

static bool allocate(CoDome *dome, CohortError *err)
{
    size_t columns = (size_t)dome->width + 1, rows = (size_t)dome->height + 1;
    dome->cos_edges = co_alloc(CO_MEMORY_LIGHT, rows * sizeof *dome->cos_edges);
    dome->row_edges = co_alloc_zero(CO_MEMORY_LIGHT, rows * sizeof *dome->row_edges);
    dome->cell_edges = co_alloc_zero(CO_MEMORY_LIGHT, columns * dome->height * sizeof(float));
    bool ok = dome->cos_edges != NULL && dome->row_edges != NULL && dome->cell_edges != NULL;
    CO_CHECK_MEMORY(ok ? dome : NULL, err);
    return true;
}

static float *row_of(const CoDome *dome, uint32_t row)
{
    return dome->cell_edges + (size_t)row * (dome->width + 1);
}

bool co_dome_light_build(CoLight *light, CohortError *err)
{
    const CoLightImage *image = &light->image;
    CoDome *dome = &light->dome;
    uint64_t k = 1;
    while (((image->width + k - 1) / k) * ((image->height + k - 1) / k) > CELLS_MAX)
        k++;
    dome->texels_per_cell = (uint32_t)k;
    dome->width = (uint32_t)((image->width + k - 1) / k);
    dome->height = (uint32_t)((image->height + k - 1) / k);
    if (!allocate(dome, err))
        return false;

    for (uint32_t j = 0; j <= dome->height; j++) {
        double sine, cosine;
        co_sincos_d(edge(j, (uint32_t)k, image->height) * CO_PI_D, &sine, &cosine);
        dome->cos_edges[j] = j == 0 ? 1.0 : j == dome->height ? -1.0 : cosine;
    }
    for (uint32_t y = 0; y < image->height; y++) {
        double s0, c0, s1, c1;
        co_sincos_d((double)y / image->height * CO_PI_D, &s0, &c0);
        co_sincos_d((double)(y + 1) / image->height * CO_PI_D, &s1, &c1);
        float band = (float)(c0 - c1), *row = row_of(dome, y / (uint32_t)k);
        for (uint32_t x = 0; x < image->width; x++)
            row[x / (uint32_t)k] += texel_weight(image, x, y) * band;
    }
    for (uint32_t j = 0; j < dome->height; j++)
        dome->row_edges[j] = (float)to_shares(row_of(dome, j), dome->width);
    double total = to_shares(dome->row_edges, dome->height);
    // Mean over the sphere: each band weighs (c0 - c1) per texel of a row, 2 W in all.
    light->strength *= (float)(total / (2.0 * image->width));
    return true;
}

void co_dome_light_clear(CoLight *light)
{
    CoDome *dome = &light->dome;
    size_t columns = (size_t)dome->width + 1, rows = (size_t)dome->height + 1;
    co_free(CO_MEMORY_LIGHT, dome->cos_edges, rows * sizeof *dome->cos_edges);
    co_free(CO_MEMORY_LIGHT, dome->row_edges, rows * sizeof *dome->row_edges);
    co_free(CO_MEMORY_LIGHT, dome->cell_edges, columns * dome->height * sizeof(float));
    *dome = (CoDome){0};
}

// The cell i with edges[i] <= u < edges[i + 1], and how far u is into it.
static uint32_t find(const float *edges, uint32_t count, float u, double *within)
{
    uint32_t lo = 0, hi = count;
    while (hi - lo > 1) {
        uint32_t mid = lo + (hi - lo) / 2;
        if (edges[mid] <= u)
            lo = mid;
        else
            hi = mid;
    }
    float width = edges[lo + 1] - edges[lo];
    *within = (double)(width > 0.0f ? co_clamp((u - edges[lo]) / width, 0.0f, 1.0f) : 0.5f);
    return lo;
}

static double cell_pdf(const CoLight *light, uint32_t x, uint32_t y)
{
    const CoDome *dome = &light->dome;
    const float *row = row_of(dome, y);
    double share =
        (double)(dome->row_edges[y + 1] - dome->row_edges[y]) * (double)(row[x + 1] - row[x]);
    double width = edge(x + 1, dome->texels_per_cell, light->image.width) -
                   edge(x, dome->texels_per_cell, light->image.width);
    return share / (2.0 * CO_PI_D * width * (dome->cos_edges[y] - dome->cos_edges[y + 1]));
}

// Image coordinates in [0, 1] of a direction: left to right, top to bottom.
static void to_image(const CoLight *light, CoVec3 dir, double *x, double *y)
{
    CoVec3 d = co_affine_vector(&light->to_local, dir);
    double around = co_atan2_d((double)d.x, (double)d.z);
    double across = sqrt((double)d.x * (double)d.x + (double)d.z * (double)d.z);
    *x = 0.5 - around / (2.0 * CO_PI_D);
    *y = co_atan2_d(across, (double)d.y) / CO_PI_D;
}

static CoVec3 sample_image(const CoLight *light, float u0, float u1)
{
    const CoDome *dome = &light->dome;
    double fx, fy, sine, cosine;
    uint32_t y = find(dome->row_edges, dome->height, u1, &fy);
    uint32_t x = find(row_of(dome, y), dome->width, u0, &fx);
    double up = dome->cos_edges[y] + (dome->cos_edges[y + 1] - dome->cos_edges[y]) * fy;
    double x0 = edge(x, dome->texels_per_cell, light->image.width);
    double x1 = edge(x + 1, dome->texels_per_cell, light->image.width);
    co_sincos_d((0.5 - (x0 + (x1 - x0) * fx)) * 2.0 * CO_PI_D, &sine, &cosine);
    double across = sqrt(fmax((1.0 - up) * (1.0 + up), 0.0));
    CoVec3 local = co_vec3((float)(across * sine), (float)up, (float)(across * cosine));
    return co_normalize(co_affine_transposed_vector(&light->to_local, local));
}

// A plain dome is sampled by the cosine around n, one time in eight over the whole sphere: n may be
// a little off the surface's.
static const float whole_share = 0.125f;

bool co_dome_light_sample(const CoLight *light, CoVec3 n, float u0, float u1, CoVec3 *wi)
{
    if (light->dome.width > 0) {
        *wi = sample_image(light, u0, u1);
        return true;
    }
    bool has_normal = co_dot(n, n) > 0.25f;
    if (!has_normal || u0 < whole_share) {
        *wi = co_warp_cone(2.0f, has_normal ? u0 / whole_share : u0, u1);
        return true;
    }
    CoVec3 axis = co_normalize(n), s, t;
    co_basis(axis, &s, &t);
    CoVec3 local = co_warp_cosine((u0 - whole_share) / (1.0f - whole_share), u1);
    *wi = co_normalize(co_from_frame(s, t, axis, local));
    return true;
}

float co_dome_light_pdf(const CoLight *light, CoVec3 n, CoVec3 wi)
{
    const float uniform = 0.25f * CO_INV_PI;
    if (light->dome.width > 0) {
        double x, y;
        to_image(light, wi, &x, &y);
        double k = (double)light->dome.texels_per_cell;
        double cx = x * light->image.width / k, cy = y * light->image.height / k;
        uint32_t column = cx < light->dome.width - 1 ? (uint32_t)cx : light->dome.width - 1;
        uint32_t row = cy < light->dome.height - 1 ? (uint32_t)cy : light->dome.height - 1;
        return (float)cell_pdf(light, column, row);
    }
    if (!(co_dot(n, n) > 0.25f))
        return uniform;
    float cosine = co_max(co_dot(co_normalize(n), wi), 0.0f);
    return (1.0f - whole_share) * cosine * CO_INV_PI + whole_share * uniform;
}

CoVec3 co_dome_light_radiance(const CoLight *light, CoVec3 dir)
{
    if (light->image.pixels == NULL)
        return light->radiance;
    double x, y;
    to_image(light, dir, &x, &y);
    CoVec3 texel = co_light_image_lookup(&light->image, (float)(x * light->image.width),
                                         (float)(y * light->image.height), true);
    return co_mul(light->radiance, texel);
}
