// Triangles, kernel by kernel: tiny meshes that are all edge, rays from and to their points; the
// same bits from every kernel, whatever rays come along and whatever stands beside a triangle.

#include "exact.h"

#include <float.h>

enum {
    RAYS = 150, // not a multiple of a group
    POINTS = 12,
    TRIS = 24
};

static bool chance(Random *random, uint32_t one_in)
{
    return random_bits(random) % one_in == 0;
}

// Few points, in eighths or anywhere, and triangles among them: shared edges, points in one place,
// triangles without area, the same ones again.
static TestMesh make_mesh(Random *random, float size, CoVec3 offset)
{
    uint32_t tris = 1 + random_bits(random) % TRIS, points = 3 + random_bits(random) % (POINTS - 2);
    bool is_lattice = chance(random, 2);
    TestMesh m = mesh_alloc(points, tris);
    for (uint32_t i = 0; i < points; i++) {
        CoVec3 p = random_vec3(random, -1.0f, 1.0f);
        if (is_lattice)
            p = co_vec3(rintf(2.0f * p.x) / 2.0f, rintf(2.0f * p.y) / 2.0f, rintf(p.z));
        if (i && chance(random, 10))
            p.x = nextafterf(p.x, 2.0f);
        co_vec3_store(m.points + 3 * (size_t)i, co_madd(offset, p, size));
    }
    for (uint32_t i = 0; i < 3 * tris; i++)
        m.indices[i] = random_bits(random) % points;
    mesh_box(&m);
    return m;
}

// Lengths are multiplied by a power of ten up to 10^(+-reach).
static void make_rays(Random *random, const TestMesh *mesh, float size, uint32_t reach,
                      CoRayBatch *rays)
{
    for (size_t i = 0; i < rays->count; i++) {
        CoVec3 p[3], org, dir;
        do {
            const uint32_t *tri = mesh->indices + 3 * (random_bits(random) % mesh->mesh.tri_count);
            for (int c = 0; c < 3; c++)
                p[c] = co_vec3_load(mesh->points + 3 * (size_t)tri[c]);
            uint32_t how = random_bits(random);
            CoVec3 at = how % 3 == 0 ? p[0] : co_lerp3(p[0], p[1], random_float(random, 0, 1));
            if (how % 3 == 2)
                at = co_lerp3(at, p[2], random_float(random, 0, 1));
            CoVec3 to = co_lerp3(p[0], p[2], 0.5f);
            org = co_madd(to, random_vec3(random, -2.0f, 2.0f), size);
            if (chance(random, 8)) // from a point of the mesh, or in the plane of a triangle
                org = chance(random, 2) ? p[2] : co_madd(p[2], co_sub(p[2], p[1]), 2.0f);
            dir = co_sub(at, org);
            if (chance(random, 6))
                dir.x = copysignf(0.0f, dir.x);
            if (chance(random, 6))
                dir.z = chance(random, 2) ? -0.0f : copysignf(1e-42f, dir.z);
            float length =
                reach ? powf(10.0f, random_float(random, -(float)reach, (float)reach)) : 1;
            dir = co_scale(dir, chance(random, 2) ? length : 1.0f);
        } while (!(fabsf(dir.x) + fabsf(dir.y) + fabsf(dir.z) > 0.0f) ||
                 !isfinite(fabsf(dir.x) + fabsf(dir.y) + fabsf(dir.z)));
        ray_set(rays, i, org, dir);
        rays->tnear[i] = 0.0f;
        rays->tfar[i] = INFINITY;
    }
}

static void copy_hit(const CoHitBatch *from, size_t i, CoHitBatch *to, size_t j)
{
#define COPY(type, name) to->name[j] = from->name[i];
    CO_HIT_FIELDS(COPY)
#undef COPY
}

static bool same_hits(const CoHitBatch *a, const CoHitBatch *b, size_t count)
{
    return same_bits(a->t, b->t, count) && same_bits(a->u, b->u, count) &&
           same_bits(a->v, b->v, count) && same_bits(a->instance, b->instance, count) &&
           same_bits(a->tri, b->tri, count);
}

// The same rays in another order and in runs of other lengths.
static void check_company(Random *random, const CoAccelScene *scene, const CoRayBatch *rays,
                          const CoHitBatch *want)
{
    CoRayBatch mixed = rays_alloc(RAYS);
    CoHitBatch hits = hits_alloc(RAYS), back = hits_alloc(RAYS);
    size_t place[RAYS];
    for (size_t i = 0; i < RAYS; i++) {
        size_t j = random_bits(random) % (i + 1);
        place[i] = place[j];
        place[j] = i;
    }
    for (size_t i = 0; i < RAYS; i++) {
#define COPY(type, name) mixed.name[i] = rays->name[place[i]];
        CO_RAY_FIELDS(COPY)
#undef COPY
    }
    for (int k = 0; k < TEST_ISA_COUNT; k++) {
        const CoAccelKernels *kernels = co_accel_kernels(test_isas[k]);
        CoTraverseStats stats = {0};
        if (!kernels)
            continue;
        for (size_t begin = 0, end; begin < RAYS; begin = end) {
            end = begin + 1 + random_bits(random) % 70;
            end = end < RAYS ? end : RAYS;
            kernels->traverse(scene, &mixed, NULL, &hits, begin, end, true, &stats);
        }
        for (size_t i = 0; i < RAYS; i++)
            copy_hit(&hits, i, &back, place[i]);
        assert_true(same_hits(&back, want, RAYS));
    }
    rays_free(&mixed);
    hits_free(&hits);
    hits_free(&back);
}

// Each triangle in a mesh of its own, with triangles without area that keep its box: the nearest of
// what is found is what is found of all.
static void check_alone(const TestMesh *mesh, const CoRayBatch *rays, const CoHitBatch *want)
{
    CoHitBatch best = hits_alloc(RAYS), hits = hits_alloc(RAYS);
    uint32_t points = mesh->mesh.point_count, tris = mesh->mesh.tri_count;
    for (uint32_t tri = 0; tri < tris; tri++) {
        // Each triangle once as 0, 1, 1 and once as 2, 2, 1.
        TestMesh one = mesh_alloc(points, 1 + 2 * tris);
        memcpy(one.points, mesh->points, 3 * sizeof(float) * points);
        memcpy(one.indices, mesh->indices + 3 * (size_t)tri, 3 * sizeof(uint32_t));
        for (uint32_t i = 0; i < tris; i++) {
            const uint32_t *c = mesh->indices + 3 * (size_t)i;
            const uint32_t flat[6] = {c[0], c[1], c[1], c[2], c[2], c[1]};
            memcpy(one.indices + 3 + 6 * (size_t)i, flat, sizeof flat);
        }
        mesh_box(&one);
        TestScene s = {0};
        CoInstance instance = place(scene_add_mesh(&s, &one), co_mat4d_identity());
        scene_add_group(&s, &instance, 1);
        CoTraverseStats stats = {0};
        co_accel_kernels(NULL)->traverse(&s.scene, rays, NULL, &hits, 0, RAYS, tri % 2, &stats);
        for (size_t i = 0; i < RAYS; i++) {
            assert_true(hits.tri[i] == 0 || hits.tri[i] == COHORT_INVALID_ID);
            if (tri == 0 || hits.t[i] < best.t[i]) {
                copy_hit(&hits, i, &best, i);
                best.tri[i] = hits.tri[i] == 0 ? tri : COHORT_INVALID_ID;
            }
        }
        scene_clear(&s);
        mesh_free(&one);
    }
    assert_true(same_hits(&best, want, RAYS));
    hits_free(&best);
    hits_free(&hits);
}

static void tiny_meshes_have_one_answer(void **state)
{
    (void)state;
    const struct {
        float size;
        CoVec3 offset;
    } places[] = {{1.0f, {0, 0, 0}},      {1.0f, {100, -30, 7}}, {1e-6f, {0, 0, 0}},
                  {1e7f, {0, 0, 0}},      {1e-38f, {0, 0, 0}},   {1e30f, {0, 0, 0}},
                  {1.0f, {1e6f, 3e5f, 1}}};
    CoRayBatch rays = rays_alloc(RAYS);
    CoHitBatch hits = hits_alloc(RAYS);
    size_t found = 0, trials = 0;
    for (uint64_t trial = 0; trial < 60 * sizeof places / sizeof *places; trial++) {
        Random random = {trial << 24};
        float size = places[trial % 7].size;
        TestMesh mesh = make_mesh(&random, size, places[trial % 7].offset);
        make_rays(&random, &mesh, size, size == 1.0f ? 30 : 0, &rays);
        TestScene s = {0};
        CoInstance instance = place(scene_add_mesh(&s, &mesh), co_mat4d_identity());
        scene_add_group(&s, &instance, 1);
        traverse_all(&s.scene, &rays, NULL, &hits, NULL);
        check_company(&random, &s.scene, &rays, &hits);
        check_alone(&mesh, &rays, &hits);
        for (size_t i = 0; i < RAYS; i++)
            found += hits.tri[i] != COHORT_INVALID_ID;
        trials += RAYS;
        scene_clear(&s);
        mesh_free(&mesh);
    }
    assert_true(found > trials / 4 && found < trials);
    rays_free(&rays);
    hits_free(&hits);
}

// Makes slivers of some triangles, up to a thousand times as long as wide.
static void make_slivers(TestMesh *soup, Random *random)
{
    for (uint32_t tri = 0; tri < soup->mesh.tri_count; tri += 3) {
        float *p = soup->points + 9 * (size_t)tri;
        CoVec3 on =
            co_lerp3(co_vec3_load(p), co_vec3_load(p + 3), random_float(random, 0.0f, 1.0f));
        co_vec3_store(p + 6, co_add(on, random_vec3(random, -1e-3f, 1e-3f)));
    }
    mesh_box(soup);
}

static void scale_mesh(TestMesh *mesh, float scale)
{
    for (size_t i = 0; i < 3 * (size_t)mesh->mesh.point_count; i++)
        mesh->points[i] *= scale;
    mesh_box(mesh);
}

// Random triangles against a search over all of them in double. Of some sizes the square of a
// length is a float and the cube is none.
static void soups_are_judged_exactly(void **state)
{
    (void)state;
    CoRayBatch rays = rays_alloc(RAYS);
    CoHitBatch hits = hits_alloc(RAYS);
    static const float sizes[] = {1.0f, 1.0f, 0x1p43f, 0x1p-48f};
    double worst_miss = 0.0, worst_t = 0.0;
    size_t found = 0;
    for (uint64_t trial = 0; trial < 240; trial++) {
        const float size = sizes[trial / 3 % 4];
        Random random = {trial << 24 | 1};
        TestMesh soup = mesh_soup(40, trial % 2 ? 0.1f : 1.0f, trial << 20);
        make_slivers(&soup, &random);
        scale_mesh(&soup, size);
        make_rays(&random, &soup, size, trial % 3 || size != 1.0f ? 0 : 30, &rays);
        TestScene s = {0};
        CoInstance instance = place(scene_add_mesh(&s, &soup), co_mat4d_identity());
        scene_add_group(&s, &instance, 1);
        traverse_all(&s.scene, &rays, NULL, &hits, NULL);
        for (size_t i = 0; i < RAYS; i++) {
            ExactVerdict verdict = exact_judge(&soup, &rays, &hits, i);
            assert_true(verdict.is_nearest);
            worst_miss = fmax(worst_miss, verdict.miss_ulps);
            worst_t = fmax(worst_t, verdict.t_ulps);
            found += hits.tri[i] != COHORT_INVALID_ID;
        }
        scene_clear(&s);
        mesh_free(&soup);
    }
    print_message("%zu hits: %.2f ulp beside a triangle, %.2f off its plane\n", found, worst_miss,
                  worst_t);
    assert_true(found > 10000);
    assert_true(worst_miss <= 4.0);
    assert_true(worst_t <= 2.0);
    rays_free(&rays);
    hits_free(&hits);
}

// Rejected before anything is touched, alone and among good rays.
static void rays_without_a_number_are_rejected(void **state)
{
    (void)state;
    TestMesh soup = mesh_soup(500, 0.5f, 3);
    TestScene s = {0};
    CoInstance instance = place(scene_add_mesh(&s, &soup), co_mat4d_identity());
    scene_add_group(&s, &instance, 1);
    CoRayBatch rays = rays_alloc(RAYS);
    CoHitBatch hits = hits_alloc(RAYS);
    for (uint32_t field = 0; field < 8; field++) {
        float *fields[8] = {rays.org_x, rays.org_y, rays.org_z, rays.dir_x,
                            rays.dir_y, rays.dir_z, rays.tnear, rays.tfar};
        Random random = {field << 20};
        make_rays(&random, &soup, 1.0f, 0, &rays);
        for (size_t i = 0; i < RAYS; i += 2)
            fields[field][i] = NAN;
        traverse_all(&s.scene, &rays, NULL, &hits, NULL);
        for (size_t i = 0; i < RAYS; i++)
            assert_true(isnan(hits.t[i]) == (i % 2 == 0));
    }
    for (size_t i = 0; i < RAYS; i++)
        ray_set(&rays, i, co_vec3_splat(NAN), co_vec3_splat(NAN));
    for (int k = 0; k < 2 * TEST_ISA_COUNT; k++) {
        const CoAccelKernels *kernels = co_accel_kernels(test_isas[k / 2]);
        CoTraverseStats stats = {0};
        if (!kernels)
            continue;
        kernels->traverse(&s.scene, &rays, NULL, &hits, 0, RAYS, k % 2, &stats);
        assert_int_equal(stats.invalid, RAYS);
        assert_int_equal(stats.bottom_nodes + stats.triangles + stats.top_nodes_single, 0);
    }
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&s);
    mesh_free(&soup);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiny_meshes_have_one_answer),
        cmocka_unit_test(soups_are_judged_exactly),
        cmocka_unit_test(rays_without_a_number_are_rejected),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
