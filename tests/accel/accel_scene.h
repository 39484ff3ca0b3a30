// Small scenes for the tests of the accel room: meshes from numbers, placements, ray batches.

#ifndef TESTS_ACCEL_ACCEL_SCENE_H
#define TESTS_ACCEL_ACCEL_SCENE_H

#include "accel/accel.h"
#include "base/memory.h"
#include "support/rays.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum {
    TEST_OBJECTS_MAX = 16,
    TEST_ISA_COUNT = 4,
    SLIVERS = 600, // of mesh_slivers, along so many lines
    LINES = 20
};

static const char *const test_isas[TEST_ISA_COUNT] = {"scalar", "sse42", "avx2", "avx512"};

// A mesh that owns its arrays.
typedef struct TestMesh {
    CoMesh mesh;
    float *points;
    uint32_t *indices;
} TestMesh;

static inline TestMesh mesh_alloc(uint32_t points, uint32_t tris)
{
    TestMesh m = {.points = calloc(3 * (size_t)points + 1, sizeof(float)),
                  .indices = calloc(3 * (size_t)tris + 1, sizeof(uint32_t))};
    m.mesh.points = m.points;
    m.mesh.indices = m.indices;
    m.mesh.point_count = points;
    m.mesh.tri_count = tris;
    return m;
}

static inline void mesh_free(TestMesh *m)
{
    free(m->points);
    free(m->indices);
}

static inline void mesh_box(TestMesh *m)
{
    m->mesh.box_min = co_vec3_splat(INFINITY);
    m->mesh.box_max = co_vec3_splat(-INFINITY);
    float *lo = &m->mesh.box_min.x, *hi = &m->mesh.box_max.x;
    for (size_t i = 0; i < 3 * (size_t)m->mesh.point_count; i++) {
        lo[i % 3] = fminf(lo[i % 3], m->points[i]);
        hi[i % 3] = fmaxf(hi[i % 3], m->points[i]);
    }
}

// Triangles that share nothing.
static inline TestMesh mesh_soup(uint32_t tris, float size, uint64_t seed)
{
    Random random = {seed};
    TestMesh m = mesh_alloc(3 * tris, tris);
    for (uint32_t i = 0; i < 3 * tris; i++)
        m.indices[i] = i;
    for (uint32_t i = 0; i < tris; i++) {
        CoVec3 center = random_vec3(&random, -1.0f, 1.0f);
        for (uint32_t c = 0; c < 3; c++)
            co_vec3_store(m.points + 9 * i + 3 * c,
                          co_add(center, random_vec3(&random, -size, size)));
    }
    mesh_box(&m);
    return m;
}

// A closed sphere of n x 2n quads, poles shared, bumpy; scaled, then moved.
static inline TestMesh mesh_sphere(uint32_t n, float scale, CoVec3 offset)
{
    uint32_t across = 2 * n;
    TestMesh m = mesh_alloc((n - 1) * across + 2, 2 * across * (n - 1));
    uint32_t south = (n - 1) * across, north = south + 1, tri = 0;
    for (uint32_t i = 1; i < n; i++) {
        for (uint32_t j = 0; j < across; j++) {
            double theta = M_PI * i / n, phi = 2.0 * M_PI * j / across;
            double r = 1.0 + 0.05 * sin(7.0 * theta) * cos(5.0 * phi);
            CoVec3 p = co_vec3((float)(r * sin(theta) * cos(phi)), (float)(r * cos(theta)),
                               (float)(r * sin(theta) * sin(phi)));
            co_vec3_store(m.points + 3 * ((i - 1) * across + j), co_madd(offset, p, scale));
        }
    }
    co_vec3_store(m.points + 3 * (size_t)south, co_madd(offset, co_vec3(0, -1, 0), scale));
    co_vec3_store(m.points + 3 * (size_t)north, co_madd(offset, co_vec3(0, 1, 0), scale));
    for (uint32_t j = 0; j < across; j++) {
        uint32_t k = (j + 1) % across, last = (n - 2) * across;
        uint32_t caps[2][3] = {{north, j, k}, {south, last + k, last + j}};
        memcpy(m.indices + 3 * (size_t)tri, caps, sizeof caps);
        tri += 2;
        for (uint32_t i = 0; i + 2 < n; i++) {
            uint32_t a = i * across + j, b = i * across + k;
            uint32_t quad[2][3] = {{a, a + across, b + across}, {a, b + across, b}};
            memcpy(m.indices + 3 * (size_t)tri, quad, sizeof quad);
            tri += 2;
        }
    }
    mesh_box(&m);
    return m;
}

static inline CoAffine affine_identity(void)
{
    CoAffine a = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    return a;
}

static inline CoInstance place(uint32_t object, CoMat4d to_group)
{
    CoInstance instance = {.object = object, .to_group = co_affine_from_mat4d(&to_group)};
    CoMat4d inverse = co_mat4d_identity();
    assert_true(co_mat4d_invert_affine(&to_group, &inverse));
    instance.to_object = co_affine_from_mat4d(&inverse);
    return instance;
}

// Rotation about y by `angle`, then scale, then translation.
static inline CoMat4d matrix(double angle, CoVec3 scale, CoVec3 offset)
{
    double c = cos(angle), s = sin(angle);
    CoMat4d m = {{{c * (double)scale.x, 0, -s * (double)scale.z, 0},
                  {0, (double)scale.y, 0, 0},
                  {s * (double)scale.x, 0, c * (double)scale.z, 0},
                  {(double)offset.x, (double)offset.y, (double)offset.z, 1}}};
    return m;
}

// Objects in the order of their making: every group after what it places.
typedef struct TestScene {
    CoObject objects[TEST_OBJECTS_MAX];
    CoBvh *bvhs[TEST_OBJECTS_MAX];
    CoTop *tops[TEST_OBJECTS_MAX];
    CoAccelScene scene;
} TestScene;

static inline uint32_t scene_add_mesh(TestScene *s, const TestMesh *m)
{
    uint32_t id = s->scene.object_count++;
    CohortError err = {0};
    s->bvhs[id] = co_bvh_create(&m->mesh, &err);
    assert_non_null(s->bvhs[id]);
    s->objects[id] = (CoObject){.mesh = &m->mesh,
                                .bvh = s->bvhs[id],
                                .box_min = m->mesh.box_min,
                                .box_max = m->mesh.box_max};
    s->scene.objects = s->objects;
    return id;
}

// The box of a group is what its caller would compute: corners of the children's boxes.
static inline void group_box(const TestScene *s, CoObject *group)
{
    group->box_min = co_vec3_splat(INFINITY);
    group->box_max = co_vec3_splat(-INFINITY);
    for (uint32_t i = 0; i < group->instance_count; i++) {
        const CoObject *child = &s->objects[group->instances[i].object];
        if (child->box_min.x > child->box_max.x)
            continue;
        for (int c = 0; c < 8; c++) {
            CoVec3 corner = co_vec3(c & 1 ? child->box_max.x : child->box_min.x,
                                    c & 2 ? child->box_max.y : child->box_min.y,
                                    c & 4 ? child->box_max.z : child->box_min.z);
            CoVec3 p = co_affine_point(&group->instances[i].to_group, corner);
            group->box_min = co_vec3(fminf(group->box_min.x, p.x), fminf(group->box_min.y, p.y),
                                     fminf(group->box_min.z, p.z));
            group->box_max = co_vec3(fmaxf(group->box_max.x, p.x), fmaxf(group->box_max.y, p.y),
                                     fmaxf(group->box_max.z, p.z));
        }
    }
}

static inline uint32_t scene_add_group(TestScene *s, const CoInstance *instances, uint32_t count)
{
    uint32_t id = s->scene.object_count++;
    CohortError err = {0};
    s->tops[id] = co_top_create(instances, count, s->objects, &err);
    assert_non_null(s->tops[id]);
    s->objects[id] =
        (CoObject){.top = s->tops[id], .instances = instances, .instance_count = count};
    group_box(s, &s->objects[id]);
    s->scene.objects = s->objects;
    s->scene.root = id;
    return id;
}

static inline void scene_clear(TestScene *s)
{
    for (uint32_t i = 0; i < s->scene.object_count; i++) {
        co_bvh_destroy(s->bvhs[i]);
        co_top_destroy(s->tops[i]);
    }
    memset(s, 0, sizeof *s);
}

// Each allocation fails alone: what can do without it is a tree, the rest says so.
static inline void create_despite_one_failure(const CoMesh *mesh, uint64_t allocations)
{
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    for (uint64_t n = 1; n <= allocations; n++) {
        CohortError err = {0};
        co_memory_fail_once(n);
        CoBvh *bvh = co_bvh_create(mesh, &err);
        co_memory_fail_once(0);
        assert_int_equal(err.code, bvh ? COHORT_OK : COHORT_ERROR_OUT_OF_MEMORY);
        co_bvh_destroy(bvh);
        assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
    }
}

// Builds over a mesh while the first allocation fails and all after it, then the second, until none
// does; what fails says so and leaves nothing behind.
static inline CoBvh *create_despite_failures(const CoMesh *mesh, uint64_t least_allocations)
{
    size_t before = co_memory_live(CO_MEMORY_ACCEL);
    for (uint64_t n = 1; n < 100; n++) {
        CohortError err = {0};
        co_memory_fail_after(n);
        CoBvh *bvh = co_bvh_create(mesh, &err);
        co_memory_fail_after(0);
        if (bvh) {
            assert_int_equal(err.code, COHORT_OK);
            assert_true(n > least_allocations);
            co_bvh_destroy(bvh);
            create_despite_one_failure(mesh, n - 1);
            return co_bvh_create(mesh, &err);
        }
        assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), before);
    }
    fail_msg("a hundred allocations and no end");
    return NULL;
}

static inline bool same_bits(const void *a, const void *b, size_t count)
{
    return memcmp(a, b, 4 * count) == 0;
}

// Traverses with every kernel of this machine, grouped and single, and demands the same bits. The
// result is the scalar kernel's; `stats` (may be NULL) the last kernel's grouped counters.
static inline void traverse_all(const CoAccelScene *scene, const CoRayBatch *rays,
                                const uint8_t *occlusion, CoHitBatch *hits, CoTraverseStats *stats)
{
    CoHitBatch other = hits_alloc(rays->count);
    CoTraverseStats ignored = {0};
    co_accel_kernels("scalar")->traverse(scene, rays, occlusion, hits, 0, rays->count, false,
                                         &ignored);
    for (int k = 0; k < 2 * TEST_ISA_COUNT; k++) {
        const CoAccelKernels *kernels = co_accel_kernels(test_isas[k / 2]);
        bool is_grouped = k % 2 == 1;
        if (!kernels)
            continue;
        CoTraverseStats mine = {0};
        memset(other.t, 0x55, 4 * rays->count);
        kernels->traverse(scene, rays, occlusion, &other, 0, rays->count, is_grouped, &mine);
        bool is_same = same_bits(hits->t, other.t, rays->count) &&
                       same_bits(hits->u, other.u, rays->count) &&
                       same_bits(hits->v, other.v, rays->count) &&
                       same_bits(hits->instance, other.instance, rays->count) &&
                       same_bits(hits->tri, other.tri, rays->count);
        if (!is_same)
            print_error("%s, %s\n", kernels->isa, is_grouped ? "grouped" : "single");
        assert_true(is_same);
        if (stats && is_grouped)
            *stats = mine;
    }
    hits_free(&other);
}

// Triangles a millionth as wide as long, 30 along each of 20 lines: whatever a ray meets of a line,
// it meets many of them, at distances that rounding decides.
static inline TestMesh mesh_slivers(uint64_t seed)
{
    Random random = {seed};
    TestMesh m = mesh_soup(SLIVERS, 0.5f, seed);
    CoVec3 ends[LINES][2];
    for (int i = 0; i < LINES; i++) {
        ends[i][0] = ends[i][1] = random_vec3(&random, -1.0f, 1.0f);
        if (i % 2) { // the boxes of such slivers are thin: they know the distance better
            ends[i][0].x = -1.0f;
            ends[i][1].x = 1.0f;
        } else {
            ends[i][1] = random_vec3(&random, -1.0f, 1.0f);
        }
    }
    for (uint32_t i = 0; i < SLIVERS; i++) {
        const CoVec3 *line = ends[i % LINES];
        for (uint32_t c = 0; c < 3; c++) {
            CoVec3 p = co_lerp3(line[0], line[1], random_float(&random, 0.0f, 1.0f));
            co_vec3_store(m.points + 9 * i + 3 * c, co_add(p, random_vec3(&random, -1e-6f, 1e-6f)));
        }
    }
    mesh_box(&m);
    return m;
}

// Along the long edges of the first `slivers` triangles, at small angles.
static inline CoRayBatch rays_along_slivers(const TestMesh *mesh, uint32_t slivers, size_t count,
                                            uint64_t seed)
{
    Random random = {seed};
    CoRayBatch rays = rays_alloc(count);
    for (size_t i = 0; i < count; i++) {
        const float *p = mesh->points + 9 * (size_t)(random_bits(&random) % slivers);
        CoVec3 a = co_vec3_load(p), b = co_vec3_load(p + 3);
        CoVec3 at = co_lerp3(a, b, random_float(&random, 0.0f, 1.0f));
        float angle = ldexpf(1.0f, -(int)(random_bits(&random) % 20));
        CoVec3 along = co_normalize(co_sub(b, a));
        CoVec3 dir = co_madd(along, random_vec3(&random, -1.0f, 1.0f), angle);
        ray_set(&rays, i, co_madd(at, dir, -2.0f), dir);
    }
    return rays;
}

#endif
