// Displacement of meshes at commit, when their textures are open: Cook, Carpenter, Catmull, "The
// Reyes Image Rendering Architecture" (1987), without its splitting and dicing by eye.

#include "geometry/displace.h"
#include "integrate/material.h"
#include "integrate/scene_data.h"

#include "base/error.h"
#include "base/stop.h"

#include <stdio.h>

#define TAG CO_MEMORY_SCENE

typedef struct DisplaceJob {
    CohortScene *scene;
    uint32_t object;
    const CoMesh *mesh;
    CoLookup *lookups;
    float (*texels)[4];
    uint32_t *which; // the point that a lookup is for
    size_t capacity;
} DisplaceJob;

static const CoMaterial *material_of(const DisplaceJob *job, uint32_t tri)
{
    uint32_t slot = co_mesh_face_material(job->mesh, co_mesh_tri_face(job->mesh, tri));
    const CoMaterial *m = co_scene_material(job->scene, job->object, slot);
    return m && m->displaces ? m : NULL;
}

// Side of the square that two such triangles fill: what the textures are filtered to.
static float square_side(const CoMesh *mesh, uint32_t tri)
{
    uint32_t point[3];
    CoVec3 p[3];
    co_mesh_triangle(mesh, tri, point);
    for (int c = 0; c < 3; c++)
        p[c] = co_vec3_load(mesh->points + 3 * (size_t)point[c]);
    return sqrtf(co_length(co_cross(co_sub(p[1], p[0]), co_sub(p[2], p[0]))));
}

// What a Ptex file has no face for stays where it is: its missing color is no height.
static bool is_missing(const DisplaceJob *job, const CoLookupSource *source, const CoLookup *lookup)
{
    bool is_triangle;
    return source->is_ptex && lookup->face >= co_texture_ptex_faces(job->scene->textures,
                                                                    lookup->texture, &is_triangle);
}

// The amount at a point, or a lookup for it; returns how many lookups there are then.
static size_t ask(const DisplaceJob *job, const CoDisplacePoint *point, uint32_t index,
                  size_t count, float *amount)
{
    const CoMaterial *m = material_of(job, point->tri);
    *amount = 0.0f;
    if (!m)
        return count;
    const CoInputSource *input = &m->displacement;
    *amount = input->value[0];
    if (input->kind == COHORT_INPUT_PRIMVAR) {
        float value[4];
        int primvar = co_mesh_primvar_find(job->mesh, input->primvar);
        if (primvar >= 0) {
            co_mesh_primvar(job->mesh, primvar, point->tri, point->u, point->v, value);
            *amount = value[0];
        }
    }
    if (input->kind != COHORT_INPUT_TEXTURE)
        return count;
    const CoLookupSource *source = &m->lookups[input->lookup];
    CoLookup *lookup = &job->lookups[count];
    CoSurface surface;
    co_mesh_surface(job->mesh, point->tri, point->u, point->v, &surface);
    co_material_lookup(job->scene, source, job->mesh, point->tri, point->u, point->v, &surface,
                       square_side(job->mesh, point->tri), lookup);
    *amount = 0.0f;
    if (is_missing(job, source, lookup))
        return count;
    job->which[count] = index;
    return count + 1;
}

static void release(DisplaceJob *job)
{
    co_free(TAG, job->lookups, job->capacity * sizeof *job->lookups);
    co_free(TAG, job->texels, job->capacity * sizeof *job->texels);
    co_free(TAG, job->which, job->capacity * sizeof *job->which);
}

static bool grow(DisplaceJob *job, size_t count)
{
    if (count <= job->capacity)
        return true;
    release(job);
    job->capacity = count;
    job->lookups = co_alloc(TAG, count * sizeof *job->lookups);
    job->texels = co_alloc(TAG, count * sizeof *job->texels);
    job->which = co_alloc(TAG, count * sizeof *job->which);
    return job->lookups && job->texels && job->which;
}

static bool find_amounts(void *cookie, const CoDisplacePoint *points, size_t count, float *amounts,
                         CohortError *err)
{
    DisplaceJob *job = cookie;
    CO_CHECK(grow(job, count), err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for displacement");
    size_t lookups = 0;
    for (size_t k = 0; k < count; k++)
        lookups = ask(job, &points[k], (uint32_t)k, lookups, &amounts[k]);
    CoLookupStats stats;
    if (!co_textures_evaluate(job->scene->textures, job->lookups, lookups, job->texels,
                              CO_LOOKUP_SORTED, NULL, NULL, &stats, err))
        return false;
    for (size_t k = 0; k < lookups; k++) {
        const CoMaterial *m = material_of(job, points[job->which[k]].tri);
        const CoLookupSource *source = &m->lookups[m->displacement.lookup];
        uint32_t c = m->displacement.channel;
        amounts[job->which[k]] = job->texels[k][c] * source->scale[c] + source->bias[c];
    }
    return true;
}

static void check_ptex(CohortScene *scene, const CoMaterial *m, const CoMesh *mesh)
{
    if (m->displacement.kind != COHORT_INPUT_TEXTURE)
        return;
    const CoLookupSource *source = &m->lookups[m->displacement.lookup];
    bool is_triangle;
    uint32_t faces = source->is_ptex
                         ? co_texture_ptex_faces(scene->textures,
                                                 scene->texture_ids[source->texture], &is_triangle)
                         : mesh->ptex_face_count;
    if (faces == mesh->ptex_face_count || faces == 0)
        return;
    char text[160];
    snprintf(text, sizeof text,
             "Ptex file has %u faces, the mesh it displaces has %u: faces it lacks stay", faces,
             mesh->ptex_face_count);
    co_scene_warn(scene, COHORT_SEVERITY_WARNING, scene->texture_descs[source->texture].asset,
                  text);
}

static bool displace_mesh(CohortScene *scene, uint32_t object, CohortError *err)
{
    CoMesh *mesh = &scene->objects[object].mesh;
    DisplaceJob job = {.scene = scene, .object = object, .mesh = mesh};
    CoDisplaceCounts counts;
    bool ok = co_mesh_displace(mesh, find_amounts, &job, &counts, err);
    release(&job);
    scene->counts.displaced_meshes += ok;
    scene->counts.displaced_points += counts.moved;
    if (counts.broken) {
        char text[128];
        snprintf(text, sizeof text, "displacement is not finite at %llu points: they stay",
                 (unsigned long long)counts.broken);
        co_scene_warn(scene, COHORT_SEVERITY_WARNING, "", text);
    }
    return ok;
}

static bool is_displaced(CohortScene *scene, uint32_t object)
{
    bool is_any = false;
    for (uint32_t slot = 0; slot < scene->objects[object].material_slots; slot++) {
        const CoMaterial *m = co_scene_material(scene, object, slot);
        if (!m || !m->displaces)
            continue;
        check_ptex(scene, m, &scene->objects[object].mesh);
        is_any = true;
    }
    return is_any;
}

bool co_scene_displace(CohortScene *scene, const volatile int *stop, CohortError *err)
{
    for (uint32_t i = 0; i < scene->object_count; i++) {
        CoSceneObject *o = &scene->objects[i];
        if (o->kind != CO_OBJECT_MESH || o->is_settled)
            continue;
        CO_CHECK_STOP(stop, err);
        if (is_displaced(scene, i) && !displace_mesh(scene, i, err))
            return false;
        o->is_settled = true;
    }
    return true;
}
