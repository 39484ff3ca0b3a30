#include "accel/bake.h"

#include "accel/build.h"
#include "base/memory.h"

#include <math.h>

#define TAG CO_MEMORY_ACCEL

enum {
    BAKED_MOST = 256 // triangles: a mesh's tree is there twice then
};

// Points are rounded where they are put: triangles are to be at least this part of the farthest
// coordinate, a thousand times what it is rounded by.
#define FINENESS 0x1p-14

// The lengths of triangles, to which shading measures what the test of a triangle may be off by,
// may change by a factor, but hardly against each other: 9 for a similarity, 13.5 for one axis
// twice as long.
#define MOST_STRETCH 13.5

// What is so many times as large as the least that stands in the group stays what it was: rays are
// to find it to what that asks for, not to what its own corners are rounded by.
#define MOST_SIZES 0x1p13

static double sum_of_squares(const CoAffine *a)
{
    double sum = 0.0;
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 3; k++)
            sum += (double)a->m[r][k] * (double)a->m[r][k];
    return sum;
}

// How often the group has each object, up to 2.
static uint8_t *count_uses(const CoInstance *instances, uint32_t count, size_t *size)
{
    uint32_t last = 0;
    for (uint32_t i = 0; i < count; i++)
        last = instances[i].object > last ? instances[i].object : last;
    *size = (size_t)last + 1;
    uint8_t *uses = co_alloc_zero(TAG, *size);
    for (uint32_t i = 0; uses && i < count; i++)
        uses[instances[i].object] |= (uint8_t)(uses[instances[i].object] ? 2 : 1);
    return uses;
}

static double least_side(const CoTop *top)
{
    double least = HUGE_VAL;
    for (uint32_t i = 0; i < top->count; i++) {
        double side = co_box_size(&top->placed[i].box);
        if (side > 0.0) // a point tells of no size
            least = fmin(least, side);
    }
    return least;
}

static bool is_worth_it(const CoPlaced *placed, const CoInstance *instance, const CoMesh *mesh,
                        double least)
{
    if (!placed->bvh || placed->is_in_place || !mesh || mesh->patches ||
        mesh->tri_count > BAKED_MOST || co_box_is_empty(&placed->box))
        return false;
    if (!(sum_of_squares(&instance->to_group) * sum_of_squares(&instance->to_object) <=
          MOST_STRETCH))
        return false;
    double side = co_box_size(&placed->box), farthest = 0.0;
    if (side > MOST_SIZES * least)
        return false;
    for (int k = 0; k < 3; k++) {
        double lo = (double)placed->box.lo[k], hi = (double)placed->box.hi[k];
        farthest = fmax(farthest, fmax(fabs(lo), fabs(hi)));
    }
    return farthest < 1e37 && farthest * FINENESS <= side / sqrt((double)mesh->tri_count);
}

// The sums are taken in double and rounded once: points that were the same stay so.
static void put_points(const CoMesh *mesh, const CoAffine *to_group, float *out)
{
    for (size_t i = 0; i < mesh->point_count; i++)
        for (size_t r = 0; r < 3; r++) {
            const float *m = to_group->m[r], *p = mesh->points + 3 * i;
            double sum = (double)m[0] * (double)p[0] + (double)m[1] * (double)p[1] +
                         (double)m[2] * (double)p[2] + (double)m[3];
            out[3 * i + r] = (float)sum;
        }
}

static CoBvh *bake(const CoMesh *mesh, const CoAffine *to_group)
{
    size_t bytes = 3 * sizeof(float) * (size_t)mesh->point_count;
    float *points = co_alloc(TAG, bytes);
    if (!points)
        return NULL;
    put_points(mesh, to_group, points);
    CoMesh moved = *mesh;
    CohortError err = {0};
    moved.points = points;
    CoBvh *bvh = co_bvh_create(&moved, &err);
    co_free(TAG, points, bytes);
    return bvh;
}

static bool keep(CoTop *top, CoBvh *bvh)
{
    if (!bvh)
        return false;
    size_t capacity = top->baked_capacity;
    void *baked = top->baked;
    if (!co_grow(TAG, &baked, top->baked_count, &capacity, sizeof *top->baked)) {
        co_bvh_destroy(bvh);
        return false;
    }
    top->baked = baked;
    top->baked_capacity = (uint32_t)capacity;
    top->baked[top->baked_count++] = bvh;
    return true;
}

bool co_bake(CoTop *top, const CoInstance *instances, const CoObject *objects)
{
    co_bake_clear(top);
    size_t size;
    uint8_t *uses = count_uses(instances, top->count, &size);
    bool is_done = uses != NULL;
    const double least = least_side(top);
    for (uint32_t i = 0; is_done && i < top->count; i++) {
        CoPlaced *placed = &top->placed[i];
        const CoMesh *mesh = objects[instances[i].object].mesh;
        if (uses[instances[i].object] > 1 || !is_worth_it(placed, &instances[i], mesh, least))
            continue;
        CoBvh *bvh = bake(mesh, &instances[i].to_group);
        is_done = keep(top, bvh);
        if (is_done) {
            placed->bvh = bvh;
            placed->is_baked = true;
        }
    }
    co_free(TAG, uses, size);
    return is_done;
}

void co_bake_clear(CoTop *top)
{
    for (uint32_t i = 0; i < top->baked_count; i++)
        co_bvh_destroy(top->baked[i]);
    co_free(TAG, top->baked, top->baked_capacity * sizeof(CoBvh *));
    top->baked = NULL;
    top->baked_count = top->baked_capacity = 0;
}

size_t co_bake_bytes(const CoTop *top)
{
    size_t bytes = top->baked_capacity * sizeof(CoBvh *);
    for (uint32_t i = 0; i < top->baked_count; i++)
        bytes += co_bvh_bytes(top->baked[i]);
    return bytes;
}
