// Commit: makes the edits of a scene effective, rebuilding only what was edited.

#include "integrate/scene_data.h"

#include "base/error.h"
#include "base/parallel.h"
#include "base/stop.h"

#include <string.h>

#define TAG CO_MEMORY_SCENE

// Meshes larger than this are built one at a time, each by all threads; smaller ones side by side.
enum {
    PARALLEL_BUILD_TRIANGLES = 50000
};

// Trees of small meshes share blocks where so many triangles are built at once; after small edits
// each stands alone, so that it can be freed alone.
enum {
    SHARED_BLOCK_TRIANGLES = 1 << 20
};

typedef struct MeshBuilds {
    CohortScene *scene;
    const uint32_t *list; // object ids
    CohortError *errors;  // one per entry
    CoBvhBlocks *blocks;  // by worker; NULL: trees stand alone
    const volatile int *stop;
} MeshBuilds;

static void build_meshes(void *context, size_t begin, size_t end, uint32_t worker)
{
    const MeshBuilds *b = context;
    for (size_t i = begin; i < end; i++) {
        CoSceneObject *o = &b->scene->objects[b->list[i]];
        if (co_is_stopped(b->stop)) {
            CO_FAIL(&b->errors[i], COHORT_ERROR_CANCELLED, "stopped");
            continue;
        }
        if (o->is_deformed && co_bvh_refit(o->bvh, &o->mesh))
            continue;
        o->is_deformed = false;
        co_bvh_destroy(o->bvh);
        o->bvh = co_bvh_create(&o->mesh, &b->errors[i]);
        if (o->bvh && b->blocks)
            co_bvh_pack(o->bvh, &b->blocks[worker]);
    }
}

static void build_small_meshes(MeshBuilds *builds, size_t count)
{
    const uint32_t workers = co_worker_count();
    uint64_t triangles = 0;
    for (size_t i = 0; i < count; i++)
        triangles += builds->scene->objects[builds->list[i]].mesh.tri_count;
    if (triangles >= SHARED_BLOCK_TRIANGLES)
        builds->blocks = co_alloc_zero(TAG, workers * sizeof *builds->blocks);
    co_parallel_for(count, 1, build_meshes, builds);
    for (uint32_t w = 0; builds->blocks && w < workers; w++)
        co_bvh_blocks_close(&builds->blocks[w]);
    co_free(TAG, builds->blocks, workers * sizeof *builds->blocks);
    builds->blocks = NULL;
}

static bool commit_mesh_list(MeshBuilds *builds, size_t small, size_t count, CohortError *err)
{
    build_small_meshes(builds, small);
    for (size_t i = small; i < count; i++)
        build_meshes(builds, i, i + 1, 0);
    for (size_t i = 0; i < count; i++) {
        CoSceneObject *o = &builds->scene->objects[builds->list[i]];
        if (builds->errors[i].code != COHORT_OK) // still to be done
            continue;
        builds->scene->counts.mesh_refits += o->is_deformed;
        o->is_deformed = false;
    }
    for (size_t i = 0; i < count; i++)
        if (builds->errors[i].code != COHORT_OK) {
            if (err && err->code == COHORT_OK)
                *err = builds->errors[i];
            return false;
        }
    return true;
}

static bool commit_meshes(CohortScene *scene, const volatile int *stop, CohortError *err)
{
    uint32_t n = scene->object_count, small = 0, count = 0;
    uint32_t *list = co_alloc(TAG, n * sizeof *list);
    CohortError *errors = co_alloc_zero(TAG, n * sizeof *errors);
    bool ok = list && errors;
    for (int pass = 0; ok && pass < 2; pass++) {
        for (uint32_t i = 0; i < n; i++) {
            const CoSceneObject *o = &scene->objects[i];
            bool is_large = o->mesh.tri_count > PARALLEL_BUILD_TRIANGLES;
            if (o->kind == CO_OBJECT_MESH && (!o->bvh || o->is_deformed) && is_large == (pass == 1))
                list[count++] = i;
        }
        if (pass == 0)
            small = count;
    }
    MeshBuilds builds = {.scene = scene, .list = list, .errors = errors, .stop = stop};
    ok = ok ? commit_mesh_list(&builds, small, count, err)
            : CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for %u objects", n);
    co_free(TAG, list, n * sizeof *list);
    co_free(TAG, errors, n * sizeof *errors);
    return ok;
}

// The instance's matrix with the moved origin of its mesh taken back.
static CoMat4d placement_matrix(const CohortScene *scene, const CohortInstanceDesc *desc)
{
    const CoSceneObject *child = &scene->objects[desc->object];
    CoMat4d m, shift = co_mat4d_identity();
    memcpy(m.m, desc->transform, sizeof m.m);
    for (int k = 0; k < 3; k++)
        shift.m[3][k] = child->origin[k];
    return co_mat4d_mul(&shift, &m);
}

static bool box_is_empty(CoVec3 lo, CoVec3 hi)
{
    return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z);
}

static void grow_box(double box[6], const CoMat4d *m, CoVec3 lo, CoVec3 hi)
{
    for (int corner = 0; corner < 8; corner++) {
        double p[3] = {(double)(corner & 1 ? hi.x : lo.x), (double)(corner & 2 ? hi.y : lo.y),
                       (double)(corner & 4 ? hi.z : lo.z)};
        for (int k = 0; k < 3; k++) {
            double x = p[0] * m->m[0][k] + p[1] * m->m[1][k] + p[2] * m->m[2][k] + m->m[3][k];
            box[k] = fmin(box[k], x);
            box[k + 3] = fmax(box[k + 3], x);
        }
    }
}

// Whether a placement puts anything anywhere.
static bool shows(const CohortScene *scene, const CohortInstanceDesc *desc)
{
    const CoSceneObject *child = &scene->objects[desc->object];
    return !desc->hidden && !box_is_empty(child->box_min, child->box_max);
}

// Fills object->instances with the placements that show, less `frame`.
static void place_instances(CohortScene *scene, CoSceneObject *object, const double frame[3])
{
    object->instance_count = 0;
    for (uint32_t i = 0; i < co_scene_placed_count(object); i++) {
        const CohortInstanceDesc *desc = co_scene_placed(object, i);
        if (!shows(scene, desc))
            continue;
        CoMat4d m = placement_matrix(scene, desc), inverse;
        for (int k = 0; k < 3; k++)
            m.m[3][k] -= frame[k];
        if (!co_mat4d_invert_placement(&m, &inverse)) {
            co_scene_warn(scene, COHORT_SEVERITY_WARNING, "",
                          "an instance's transform is singular, not finite or scales beyond 1e18: "
                          "left out");
            continue;
        }
        CoInstance *out = &object->instances[object->instance_count];
        out->object = desc->object;
        out->hidden_from = desc->hidden_from;
        out->to_group = co_affine_from_mat4d(&m);
        out->to_object = co_affine_from_mat4d(&inverse);
        object->edit_of[object->instance_count++] = i;
    }
}

static void group_box(const CohortScene *scene, const CoSceneObject *object, double box[6])
{
    for (int k = 0; k < 3; k++) {
        box[k] = HUGE_VAL;
        box[k + 3] = -HUGE_VAL;
    }
    for (uint32_t i = 0; i < co_scene_placed_count(object); i++) {
        const CohortInstanceDesc *desc = co_scene_placed(object, i);
        const CoSceneObject *child = &scene->objects[desc->object];
        CoMat4d m = placement_matrix(scene, desc), inverse;
        if (shows(scene, desc) && co_mat4d_invert_placement(&m, &inverse))
            grow_box(box, &m, child->box_min, child->box_max);
    }
}

// Beyond, what rays add up to is no float.
#define REACH 8e37

// Center of the box, rounded to a power-of-two grid about as coarse as the scene: what is
// subtracted is then exact in double and does not move when the scene changes a little.
static void choose_frame(CohortScene *scene)
{
    const double *box = scene->box;
    scene->has_box = box[0] <= box[3] && box[1] <= box[4] && box[2] <= box[5];
    double size = 0.0;
    for (int k = 0; k < 3 && scene->has_box; k++)
        size = fmax(size, box[k + 3] - box[k]);
    int exponent = 0; // of the least power of two that is not below the size
    if (size > 0.0 && isfinite(size) && frexp(size, &exponent) == 0.5)
        exponent--;
    double grid = ldexp(1.0, exponent), farthest = 0.0;
    for (int k = 0; k < 3; k++) {
        scene->frame[k] = scene->has_box ? grid * round(0.5 * (box[k] + box[k + 3]) / grid) : 0.0;
        for (int side = 0; side < 6 && scene->has_box; side += 3)
            farthest = fmax(farthest, fabs(box[k + side] - scene->frame[k]));
    }
    if (farthest > REACH)
        co_scene_warn(scene, COHORT_SEVERITY_WARNING, "",
                      "the scene reaches farther than 8e37 from its middle: rays go wrong there");
}

static bool commit_group(CohortScene *scene, uint32_t id, CohortError *err)
{
    static const double no_frame[3] = {0.0, 0.0, 0.0};
    CoSceneObject *o = &scene->objects[id];
    CoTop *kept = o->top;
    o->top = NULL;
    co_scene_object_release(o);
    o->top = kept;
    if (!co_scene_list_parts(scene, o, err))
        return false;
    double box[6];
    group_box(scene, o, box);
    if (id == 0) {
        memcpy(scene->box, box, sizeof box);
        choose_frame(scene);
    }
    const double *frame = id == 0 ? scene->frame : no_frame;
    for (int k = 0; k < 3; k++) {
        (&o->box_min.x)[k] = (float)(box[k] - frame[k]);
        (&o->box_max.x)[k] = (float)(box[k + 3] - frame[k]);
    }
    uint32_t count = o->instance_capacity = co_scene_placed_count(o);
    if (count > 0) {
        o->instances = co_alloc(TAG, count * sizeof *o->instances);
        o->edit_of = co_alloc(TAG, count * sizeof *o->edit_of);
        CO_CHECK(o->instances && o->edit_of, err, COHORT_ERROR_OUT_OF_MEMORY,
                 "out of memory for %u instances", count);
        place_instances(scene, o, frame);
    }
    if (kept && co_top_refit(kept, o->instances, o->instance_count, scene->accel_objects)) {
        scene->counts.group_refits++;
        return true;
    }
    co_top_destroy(kept);
    o->top = co_top_create(o->instances, o->instance_count, scene->accel_objects, err);
    scene->counts.group_builds++;
    return o->top != NULL;
}

static void publish(CohortScene *scene, uint32_t id)
{
    CoSceneObject *o = &scene->objects[id];
    CoObject *out = &scene->accel_objects[id];
    memset(out, 0, sizeof *out);
    if (o->kind == CO_OBJECT_MESH) {
        out->mesh = &o->mesh;
        out->bvh = o->bvh;
        o->box_min = o->mesh.box_min;
        o->box_max = o->mesh.box_max;
        if (o->mesh.tri_count == 0) {
            o->box_min = co_vec3_splat(INFINITY);
            o->box_max = co_vec3_splat(-INFINITY);
        }
    } else if (o->kind == CO_OBJECT_GROUP) {
        out->top = o->top;
        out->instances = o->instances;
        out->instance_count = o->instance_count;
    } else {
        o->box_min = co_vec3_splat(INFINITY);
        o->box_max = co_vec3_splat(-INFINITY);
    }
    out->box_min = o->box_min;
    out->box_max = o->box_max;
}

// A group that does not stand: others only ask whether anything is in it.
static bool commit_merged(CohortScene *scene, CoSceneObject *o, CohortError *err)
{
    co_scene_object_release(o);
    o->box_min = co_vec3_splat(INFINITY);
    o->box_max = co_vec3_splat(-INFINITY);
    for (uint32_t i = 0; i < o->edit_count; i++)
        if (shows(scene, &o->edits[i]))
            o->box_min = o->box_max = co_vec3_splat(0.0f);
    return co_scene_list_parts(scene, o, err);
}

// Children first. A group is rebuilt when it or anything below it was edited.
static bool commit_object(CohortScene *scene, uint32_t id, CohortError *err)
{
    CoSceneObject *o = &scene->objects[id];
    if (o->visit == CO_VISIT_DONE)
        return true;
    for (uint32_t i = 0; i < o->edit_count; i++) {
        uint32_t child = o->edits[i].object;
        if (!commit_object(scene, child, err))
            return false;
        o->is_dirty = o->is_dirty || scene->objects[child].is_dirty;
    }
    if (o->is_merged ? !commit_merged(scene, o, err)
                     : o->kind == CO_OBJECT_GROUP && (o->is_dirty || !o->top) &&
                           !commit_group(scene, id, err))
        return false;
    publish(scene, id);
    o->visit = CO_VISIT_DONE;
    return true;
}

static bool commit_paths(CohortScene *scene, CohortError *err)
{
    CoAccelScene accel = {
        .objects = scene->accel_objects, .object_count = scene->object_count, .root = 0};
    scene->accel = accel;
    return co_accel_path_count(&scene->accel, &scene->path_count) ||
           CO_FAIL(err, COHORT_ERROR_LIMIT, "more than 2^32 instances in all");
}

static void count_mesh(CohortSceneCounts *c, const CoSceneObject *o)
{
    CoMeshMemory memory;
    co_mesh_memory(&o->mesh, &memory);
    size_t accel = co_bvh_bytes(o->bvh), leaves = co_bvh_leaf_bytes(o->bvh);
    c->mesh_count++;
    c->triangle_count += o->mesh.tri_count;
    c->geometry_bytes += o->mesh.bytes;
    c->point_bytes += memory.points;
    c->topology_bytes += memory.topology;
    c->normal_bytes += memory.normals;
    c->accel_bytes += accel;
    c->leaf_bytes += leaves;
    c->node_bytes += accel - leaves;
}

// What there is once all is built.
static void count_scene(CohortScene *scene)
{
    CohortSceneCounts *c = &scene->counts;
    c->triangle_count = c->mesh_count = c->instance_count = 0;
    c->geometry_bytes = c->point_bytes = c->topology_bytes = c->normal_bytes = 0;
    c->accel_bytes = c->leaf_bytes = c->node_bytes = 0;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        CoSceneObject *o = &scene->objects[i];
        o->is_dirty = o->visit != CO_VISIT_DONE; // what is out of the scene may become stale
        c->instance_count += o->instance_count;
        if (o->kind == CO_OBJECT_MESH)
            count_mesh(c, o);
        else if (o->top)
            c->accel_bytes += co_top_bytes(o->top);
    }
}

bool co_scene_commit_objects(CohortScene *scene, const volatile int *stop, CohortError *err)
{
    if (!commit_meshes(scene, stop, err))
        return false;
    co_free(TAG, scene->accel_objects, scene->accel_object_count * sizeof *scene->accel_objects);
    scene->accel_object_count = scene->object_count;
    scene->accel_objects = co_alloc_zero(TAG, scene->object_count * sizeof *scene->accel_objects);
    CO_CHECK_MEMORY(scene->accel_objects, err);
    if (!co_scene_nest(scene, err))
        return false;
    for (uint32_t i = 0; i < scene->object_count; i++)
        scene->objects[i].visit = CO_VISIT_NEW;
    if (!commit_object(scene, 0, err) || !commit_paths(scene, err))
        return false;
    count_scene(scene);
    return true;
}

bool co_scene_commit_camera(CohortScene *scene, CohortError *err)
{
    const CohortCameraDesc *desc = &scene->camera_desc;
    CoCamera *out = &scene->camera;
    double axes[3][3], scale[3];
    for (int i = 0; i < 3; i++) {
        scale[i] = 0.0;
        for (int k = 0; k < 3; k++)
            scale[i] += desc->transform[i][k] * desc->transform[i][k];
        scale[i] = sqrt(scale[i]);
        CO_CHECK(scale[i] > 0.0, err, COHORT_ERROR_SCENE, "the camera's transform is singular");
        for (int k = 0; k < 3; k++)
            axes[i][k] = desc->transform[i][k] / scale[i];
    }
    out->right = co_vec3((float)axes[0][0], (float)axes[0][1], (float)axes[0][2]);
    out->up = co_vec3((float)axes[1][0], (float)axes[1][1], (float)axes[1][2]);
    out->back = co_vec3((float)axes[2][0], (float)axes[2][1], (float)axes[2][2]);
    out->origin = co_vec3((float)(desc->transform[3][0] - scene->frame[0]),
                          (float)(desc->transform[3][1] - scene->frame[1]),
                          (float)(desc->transform[3][2] - scene->frame[2]));
    CO_CHECK(co_is_finite3(out->origin), err, COHORT_ERROR_SCENE,
             "the camera is farther from the scene than numbers go");
    // A scaled camera sees what it would see unscaled in a scene scaled the other way.
    for (int i = 0; i < 4; i++)
        out->window[i] = desc->window[i] * scale[i / 2] / (desc->orthographic ? 1.0 : scale[2]);
    out->is_orthographic = desc->orthographic;
    out->clip_near = (float)(fmax(desc->clip_near, 0.0) * scale[2]);
    out->clip_far =
        desc->clip_far > desc->clip_near ? (float)(desc->clip_far * scale[2]) : INFINITY;
    out->lens_radius = (float)(desc->lens_radius * scale[0]);
    out->focus_distance = (float)(desc->focus_distance * scale[2]);
    if (scene->camera_dirty)
        scene->counts.camera_builds++;
    scene->camera_dirty = false;
    return true;
}

static bool publish_warnings(CohortScene *scene)
{
    co_free(TAG, scene->diagnostics, scene->diagnostic_capacity * sizeof *scene->diagnostics);
    scene->diagnostic_capacity = scene->warning_count;
    scene->diagnostics = NULL;
    if (scene->warning_count == 0)
        return true;
    scene->diagnostics = co_alloc(TAG, scene->warning_count * sizeof *scene->diagnostics);
    for (uint32_t i = 0; scene->diagnostics && i < scene->warning_count; i++) {
        const CoWarning *w = &scene->warnings[i];
        CohortDiagnostic d = {w->severity, w->place, w->text, w->count};
        scene->diagnostics[i] = d;
    }
    return scene->diagnostics != NULL;
}

bool cohort_scene_commit(CohortScene *scene, const CohortSceneOptions *options, CohortError *err)
{
    static const CohortSceneOptions defaults;
    if (!options)
        options = &defaults;
    CO_CHECK(scene->has_camera, err, COHORT_ERROR_SCENE, "the scene has no camera");
    if (!co_scene_commit_textures(scene, options, err) ||
        !co_scene_displace(scene, options->stop, err) ||
        !co_scene_commit_objects(scene, options->stop, err) ||
        !co_scene_commit_lights(scene, err) || !co_scene_commit_camera(scene, err))
        return false;
    CO_CHECK(publish_warnings(scene), err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    scene->is_committed = true;
    return true;
}

void cohort_scene_counts(const CohortScene *scene, CohortSceneCounts *out)
{
    *out = scene->counts;
}

bool cohort_scene_bounds(const CohortScene *scene, double box[6])
{
    if (scene->has_box)
        memcpy(box, scene->box, sizeof scene->box);
    return scene->has_box;
}
