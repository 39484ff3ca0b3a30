#include "accel/paths.h"

#include "accel/node.h"

static CoMat4d from_affine(const CoAffine *a)
{
    CoMat4d r = co_mat4d_identity();
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            r.m[j][i] = (double)a->m[i][j];
    return r;
}

bool co_accel_path_count(const CoAccelScene *scene, uint64_t *out)
{
    const CoTop *top = scene->objects[scene->root].top;
    *out = top ? top->path_count : 0;
    return *out <= UINT32_MAX - 1u;
}

// The last instance whose first path is at most `path`: those without paths share their
// successor's.
static uint32_t find_instance(const CoTop *top, uint32_t path)
{
    uint32_t low = 0, high = top->count; // the answer is in [low, high)
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (top->placed[middle].first_path <= path)
            low = middle;
        else
            high = middle;
    }
    return low;
}

uint32_t co_accel_path_object(const CoAccelScene *scene, uint32_t instance)
{
    uint32_t id = scene->root;
    const CoObject *object = &scene->objects[id];
    while (!object->mesh && object->top && object->top->count) {
        uint32_t index = find_instance(object->top, instance);
        instance -= object->top->placed[index].first_path;
        id = object->instances[index].object;
        object = &scene->objects[id];
    }
    return id;
}

void co_accel_placement(const CoAccelScene *scene, uint32_t instance, CoPlacement *out)
{
    const CoObject *object = &scene->objects[scene->root];
    CoMat4d to_world = co_mat4d_identity(), to_object = co_mat4d_identity();
    out->object = scene->root;
    out->chain_length = 0;
    out->is_baked = false;
    while (!object->mesh && object->top && object->top->count) {
        uint32_t index = find_instance(object->top, instance);
        const CoInstance *placed = &object->instances[index];
        CoMat4d up = from_affine(&placed->to_group), down = from_affine(&placed->to_object);
        instance -= object->top->placed[index].first_path;
        out->is_baked = object->top->placed[index].is_baked;
        to_world = co_mat4d_mul(&up, &to_world);
        to_object = co_mat4d_mul(&to_object, &down);
        out->chain[out->chain_length++] = index;
        out->object = placed->object;
        object = &scene->objects[placed->object];
    }
    out->to_world = co_affine_from_mat4d(&to_world);
    out->to_object = co_affine_from_mat4d(&to_object);
}
