#include "integrate/vertex.h"

#include "shading/normal_map.h"

#include <string.h>

static CoVec3 abs3(CoVec3 a)
{
    return co_vec3(fabsf(a.x), fabsf(a.y), fabsf(a.z));
}

static CoAffine abs_affine(const CoAffine *a)
{
    CoAffine r;
    for (int i = 0; i < 12; i++)
        r.m[i / 4][i % 4] = fabsf(a->m[i / 4][i % 4]);
    return r;
}

// a after b.
static CoAffine affine_after(const CoAffine *a, const CoAffine *b)
{
    CoAffine r;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 4; k++)
            r.m[i][k] = a->m[i][0] * b->m[0][k] + a->m[i][1] * b->m[1][k] + a->m[i][2] * b->m[2][k];
        r.m[i][3] += a->m[i][3];
    }
    return r;
}

// Level by level, not of the product: a part may be far from its group's origin and the group
// placed so that it comes back, and rays are rounded out there.
static void find_abs(const CohortScene *scene, CoPlacementMemo *memo)
{
    const CoPlacement *placement = &memo->placement;
    const CoObject *object = &scene->accel.objects[scene->accel.root];
    for (uint32_t level = 0; level < placement->chain_length; level++) {
        const CoInstance *placed = &object->instances[placement->chain[level]];
        CoAffine up = abs_affine(&placed->to_group), down = abs_affine(&placed->to_object);
        memo->abs_to_world = level ? affine_after(&memo->abs_to_world, &up) : up;
        memo->abs_to_object = level ? affine_after(&down, &memo->abs_to_object) : down;
        object = &scene->accel.objects[placed->object];
    }
}

// The group on the way to a mesh, and which of what is placed in it.
static const CoSceneObject *group_at(const CohortScene *scene, const CoPlacement *placement,
                                     uint32_t level, uint32_t *placed)
{
    uint32_t object = scene->accel.root;
    for (uint32_t i = 0; i < level; i++)
        object = scene->objects[object].instances[placement->chain[i]].object;
    const CoSceneObject *group = &scene->objects[object];
    *placed = group->edit_of[placement->chain[level]];
    return group;
}

// The color of a placement for meshes that have one or have none; NULL: it has none for them.
static const float *placed_color(const CoSceneObject *group, uint32_t placed, bool has_own)
{
    const CohortInstanceDesc *desc = co_scene_placed(group, placed);
    if (!has_own)
        return desc->display_color;
    if (group->parts)
        return group->parts[placed].firm_color;
    return desc->color_yields ? NULL : desc->display_color;
}

// The instance's displayColor, else the mesh's, else USD's 0.18 gray.
static void recall_display(const CohortScene *scene, CoPlacementMemo *memo)
{
    if (memo->has_display)
        return;
    memo->has_display = true;
    memo->display_primvar = -1;
    memo->opacity_primvar = co_mesh_primvar_find(memo->triangle.mesh, "displayOpacity");
    int own = co_mesh_primvar_find(memo->triangle.mesh, "displayColor");
    for (uint32_t level = memo->placement.chain_length; level-- > 0;) {
        uint32_t placed;
        const CoSceneObject *group = group_at(scene, &memo->placement, level, &placed);
        const float *color = placed_color(group, placed, own >= 0);
        if (!color)
            continue;
        memo->display = co_vec3_load(color);
        return;
    }
    memo->display = co_vec3_splat(0.18f);
    memo->display_primvar = own;
}

static void recall_placement(const CohortScene *scene, CoPlacementMemo *memo, uint32_t instance)
{
    if (memo->instance == instance)
        return;
    co_accel_placement(&scene->accel, instance, &memo->placement);
    find_abs(scene, memo);
    memo->instance = instance;
    memo->has_triangle = memo->has_display = false;
}

static void recall_triangle(const CohortScene *scene, CoPlacementMemo *memo, uint32_t tri)
{
    if (memo->has_triangle && memo->triangle.tri == tri)
        return;
    const CoPlacement *placement = &memo->placement;
    co_triangle_make(scene->accel.objects[placement->object].mesh, tri, &memo->triangle);
    memo->ng = co_normalize(co_affine_transposed_vector(&placement->to_object, memo->triangle.ng));
    memo->material = co_scene_material(scene, placement->object, memo->triangle.material);
    memo->has_triangle = true;
}

// Error bound in the render frame, per axis: of the point itself and the triangle test, of its way
// out through the instance's transforms, and of a ray origin's way back in, gamma(n) = n eps /
// (1 - n eps) per level (Pharr, Jakob, Humphreys, "Physically Based Rendering", 6.8).
static CoVec3 error_bound(const CoVertex *vertex)
{
    const CoPlacementMemo *memo = vertex->memo;
    const CoSurface *surface = &vertex->hit.surface;
    const float gamma = 4.0f * (float)memo->placement.chain_length * 0x1p-23f;
    CoVec3 way_in = co_scale(co_affine_point(&memo->abs_to_object, abs3(vertex->p)), gamma);
    CoVec3 reach = co_add(surface->p_error, co_vec3_splat(surface->reach));
    CoVec3 local = co_add(reach, way_in);
    CoVec3 way_out = co_scale(co_affine_point(&memo->abs_to_world, abs3(surface->p)), gamma);
    return co_add(co_affine_vector(&memo->abs_to_world, local), way_out);
}

static bool is_same(CoVec3 a, CoVec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static float largest(CoVec3 v)
{
    return co_max(fabsf(v.x), co_max(fabsf(v.y), fabsf(v.z)));
}

// On a triangle that is huge against what is around the hit, such as a ground, the hit is where the
// ray says: a barycentric of a million units is good to a twentieth of one.
static void settle_on_vast(const CoPlacementMemo *memo, const CoHitRecord *hit, const CoRay *ray,
                           CoSurface *surface)
{
    if (memo->placement.is_baked || !co_triangle_is_vast(&memo->triangle, largest(surface->p)))
        return;
    const CoAffine *m = &memo->placement.to_object;
    double world[3] = {(double)ray->org.x + (double)hit->t * (double)hit->dir.x,
                       (double)ray->org.y + (double)hit->t * (double)hit->dir.y,
                       (double)ray->org.z + (double)hit->t * (double)hit->dir.z};
    CoVec3 p = co_vec3((float)world[0], (float)world[1], (float)world[2]);
    float size = largest(co_affine_point(&memo->abs_to_object, abs3(p)));
    if (!co_triangle_is_vast(&memo->triangle, size))
        return;
    double q[3];
    for (int r = 0; r < 3; r++)
        q[r] = (double)m->m[r][0] * world[0] + (double)m->m[r][1] * world[1] +
               (double)m->m[r][2] * world[2] + (double)m->m[r][3];
    co_triangle_settle(&memo->triangle, q, size, surface);
}

void co_vertex_make(const CohortScene *scene, CoPlacementMemo *memo, const CoHitRecord *hit,
                    const CoRay *ray, CoVertex *out)
{
    recall_placement(scene, memo, hit->instance);
    recall_triangle(scene, memo, hit->tri);
    const CoPlacement *placement = &memo->placement;
    out->hit.mesh = memo->triangle.mesh;
    out->hit.tri = hit->tri;
    out->hit.u = hit->u;
    out->hit.v = hit->v;
    out->placement = placement;
    out->memo = memo;
    out->material = memo->material;
    CoSurface *s = &out->hit.surface;
    co_triangle_surface(&memo->triangle, hit->u, hit->v, s);
    settle_on_vast(memo, hit, ray, s);
    if (memo->material && memo->material->reads_ptex)
        co_triangle_ptex(&memo->triangle, hit->u, hit->v, s);
    if (!memo->material)
        recall_display(scene, memo);
    out->p = co_affine_point(&placement->to_world, s->p);
    out->start = co_affine_point(&placement->to_world, s->start);
    out->ng = out->ns = memo->ng;
    if (!is_same(s->ns, s->ng))
        out->ns = co_normalize(co_affine_transposed_vector(&placement->to_object, s->ns));
    out->wo = co_neg(hit->dir);
    out->width = ray->width + ray->spread * hit->t;
}

CoVec3 co_vertex_origin(const CoVertex *vertex, CoVec3 ng)
{
    float reach = co_dot(abs3(ng), error_bound(vertex));
    CoVec3 o = co_madd(vertex->start, ng, reach);
    // Adding may have rounded back towards the surface: one more step outward per axis.
    float *x = &o.x;
    const float *n = &ng.x;
    for (int k = 0; k < 3; k++)
        if (n[k] != 0.0f)
            x[k] += copysignf(fabsf(x[k]) * 0x1p-23f, n[k]);
    return o;
}

int32_t co_placement_prim_id(const CohortScene *scene, const CoPlacement *placement)
{
    for (uint32_t level = placement->chain_length; level-- > 0;) {
        uint32_t placed;
        const CoSceneObject *group = group_at(scene, placement, level, &placed);
        int32_t id = co_scene_placed(group, placed)->prim_id;
        if (id >= 0)
            return id;
    }
    return -1;
}

static CoVec3 display_color(const CoVertex *vertex)
{
    const CoShadeHit *hit = &vertex->hit;
    float value[4];
    if (vertex->memo->display_primvar < 0)
        return vertex->memo->display;
    co_mesh_primvar(hit->mesh, vertex->memo->display_primvar, hit->tri, hit->u, hit->v, value);
    return co_vec3_load(value);
}

static CoVec3 shading_normal(const CoVertex *vertex)
{
    CoVec3 tangent_normal;
    CoTexCoord frame;
    if (!vertex->material ||
        !co_material_normal(vertex->material, &vertex->hit, &tangent_normal, &frame))
        return vertex->ns;
    const CoAffine *m = &vertex->placement->to_world;
    return co_normal_map(vertex->ns, vertex->ng, co_affine_vector(m, frame.dpds),
                         co_affine_vector(m, frame.dpdt), tangent_normal);
}

void co_vertex_bsdf(const CohortScene *scene, const CoVertex *vertex, CoBsdf *out, CoVec3 *emissive)
{
    CoVec3 ns = shading_normal(vertex);
    if (!vertex->material) {
        *emissive = co_vec3_splat(0.0f);
        CoVec3 color = display_color(vertex);
        if (scene->converts)
            color = co_color_apply(scene->rec709, color);
        co_bsdf_lambert(color, ns, vertex->ng, vertex->wo, out);
        return;
    }
    CoPreviewSurface surface;
    co_material_evaluate(vertex->material, &vertex->hit, &surface);
    *emissive = surface.emissive_color;
    if (vertex->material->is_lambert)
        co_bsdf_lambert(surface.diffuse_color, ns, vertex->ng, vertex->wo, out);
    else
        co_bsdf_preview(&surface, ns, vertex->ng, vertex->wo, out);
}

static float display_opacity(const CoVertex *vertex)
{
    const CoShadeHit *hit = &vertex->hit;
    float value[4];
    co_mesh_primvar(hit->mesh, vertex->memo->opacity_primvar, hit->tri, hit->u, hit->v, value);
    return value[0];
}

bool co_vertex_may_pass(const CoVertex *vertex)
{
    return vertex->material ? vertex->material->may_pass : vertex->memo->opacity_primvar >= 0;
}

CoVec3 co_vertex_transmittance(const CoVertex *vertex, const CoBsdf *bsdf)
{
    const CoMaterial *material = vertex->material;
    if (!co_vertex_may_pass(vertex))
        return co_vec3_splat(0.0f);
    if (!material)
        return co_vec3_splat(1.0f - co_clamp(display_opacity(vertex), 0.0f, 1.0f));
    if (material->opacity_threshold <= 0.0f && !material->opacity_presence)
        return co_bsdf_transmittance(bsdf, vertex->wo);
    float opacity = co_material_opacity(material, &vertex->hit);
    if (material->opacity_threshold > 0.0f)
        return co_vec3_splat(opacity < material->opacity_threshold ? 1.0f : 0.0f);
    return co_vec3_splat(1.0f - co_clamp(opacity, 0.0f, 1.0f));
}
