// Camera rays: made from (pixel, sample) alone, so that any of them can be made again.

#include "integrate/render_data.h"

#include "base/parallel.h"

float co_camera_depth(const CoCamera *camera, CoVec3 p)
{
    return -co_dot(co_sub(p, camera->origin), camera->back);
}

float co_camera_far(const CoCamera *camera, CoVec3 dir)
{
    float cosine = -co_dot(dir, camera->back);
    return cosine > 0.0f ? (camera->clip_far - camera->clip_near) / cosine : INFINITY;
}

typedef struct CameraWork {
    CohortRender *render;
    uint64_t first; // path
} CameraWork;

// A point of the window, at distance 1 (perspective) or on the camera's plane (orthographic).
static void window_point(const CohortRender *render, uint32_t pixel, const float u[2], float *x,
                         float *y)
{
    const CohortRenderSettings *s = &render->settings;
    const double *w = render->scene->camera.window;
    float dx, dy;
    co_filter_sample(s->filter, u[0], u[1], &dx, &dy);
    double px = ((double)(pixel % s->width) + 0.5 + (double)dx) / (double)s->width;
    double py = ((double)(pixel / s->width) + 0.5 + (double)dy) / (double)s->height;
    *x = (float)(w[0] + px * (w[1] - w[0]));
    *y = (float)(w[3] + py * (w[2] - w[3]));
}

static void camera_ray(const CohortRender *render, uint32_t pixel, CoSampleKey key, CoRay *ray)
{
    const CoCamera *c = &render->scene->camera;
    bool has_lens = c->lens_radius > 0.0f && !c->is_orthographic;
    float u[4], x, y, lens_x = 0.0f, lens_y = 0.0f;
    co_sample(key, 0, 0, CO_DECISION_CAMERA, 0, 1, has_lens ? 4 : 2, u);
    window_point(render, pixel, u, &x, &y);
    CoVec3 local_org = co_vec3(0.0f, 0.0f, 0.0f), local_dir = co_vec3(x, y, -1.0f);
    if (c->is_orthographic) {
        local_org = co_vec3(x, y, 0.0f);
        local_dir = co_vec3(0.0f, 0.0f, -1.0f);
    } else if (has_lens) {
        co_disk_sample(u[2], u[3], &lens_x, &lens_y);
        local_org = co_vec3(lens_x * c->lens_radius, lens_y * c->lens_radius, 0.0f);
        local_dir = co_sub(co_scale(local_dir, c->focus_distance), local_org);
    }
    CoVec3 dir =
        co_madd(co_madd(co_scale(c->right, local_dir.x), c->up, local_dir.y), c->back, local_dir.z);
    CoVec3 org = co_madd(co_madd(c->origin, c->right, local_org.x), c->up, local_org.y);
    ray->dir = co_ray_snap_direction(co_normalize(dir), ray->code);
    float cosine = -co_dot(ray->dir, c->back);
    ray->org = co_madd(org, ray->dir, cosine > 0.0f ? c->clip_near / cosine : 0.0f);
}

// The size of a pixel at distance 1: growth of the footprint's width per unit length.
static float pixel_spread(const CohortRender *render)
{
    const CoCamera *c = &render->scene->camera;
    double pixel = fabs(c->window[1] - c->window[0]) / (double)render->settings.width;
    return c->is_orthographic ? 0.0f : (float)pixel;
}

static void make_rays(void *context, size_t begin, size_t end, uint32_t worker)
{
    const CameraWork *work = context;
    CohortRender *render = work->render;
    CoEmitter emitter = {.render = render, .worker = worker};
    const CoCamera *c = &render->scene->camera;
    float spread = pixel_spread(render);
    float width = c->is_orthographic
                      ? (float)(fabs(c->window[1] - c->window[0]) / (double)render->settings.width)
                      : 0.0f;
    uint32_t no_normal;
    co_ray_snap_normal(co_vec3_splat(0.0f), &no_normal);
    for (size_t i = begin; i < end; i++) {
        uint32_t path = (uint32_t)(work->first + i);
        CoSampleKey key = co_path_key(render, path);
        CoRay ray = {.weight = {1.0f, 1.0f, 1.0f},
                     .path = path,
                     .kind = CO_RAY_CAMERA,
                     .depth = 1,
                     .width = width,
                     .spread = spread,
                     .normal_code = no_normal};
        camera_ray(render, key.pixel, key, &ray);
        CoRayKey ray_key = {key.pixel, key.sample, key.seed};
        co_emit(&emitter, &ray, ray_key);
    }
    co_emit_flush(&emitter);
}

void co_stage_camera(CohortRender *render, size_t count)
{
    CameraWork work = {render, render->camera_next};
    co_parallel_for(count, 1024, make_rays, &work);
    render->camera_next += count;
}
