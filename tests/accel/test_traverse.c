// Traversal against a brute-force oracle in double, over all kernels, grouped and single.

#include "accel/paths.h"
#include "accel_scene.h"

#include <float.h>

// Nearest hit by Moeller-Trumbore in double over all paths of a scene.
typedef struct OracleHit {
    double t, second; // nearest, and the next one at another distance
    double margin;    // least barycentric of the nearest
    uint32_t path, tri;
} OracleHit;

typedef struct Vec3d {
    double x, y, z;
} Vec3d;

static Vec3d sub3(Vec3d a, Vec3d b)
{
    return (Vec3d){a.x - b.x, a.y - b.y, a.z - b.z};
}

static Vec3d cross3(Vec3d a, Vec3d b)
{
    return (Vec3d){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static double dot3(Vec3d a, Vec3d b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static Vec3d transform(const CoAffine *a, const float *p)
{
    double r[3];
    for (int i = 0; i < 3; i++)
        r[i] = (double)a->m[i][0] * (double)p[0] + (double)a->m[i][1] * (double)p[1] +
               (double)a->m[i][2] * (double)p[2] + (double)a->m[i][3];
    return (Vec3d){r[0], r[1], r[2]};
}

static void oracle_mesh(const CoMesh *mesh, const CoAffine *to_world, uint32_t path, Vec3d org,
                        Vec3d dir, OracleHit *hit)
{
    for (uint32_t i = 0; i < mesh->tri_count; i++) {
        Vec3d p[3];
        for (uint32_t c = 0; c < 3; c++)
            p[c] = transform(to_world, mesh->points + 3 * (size_t)mesh->indices[3 * i + c]);
        Vec3d e1 = sub3(p[1], p[0]), e2 = sub3(p[2], p[0]), s = sub3(org, p[0]);
        Vec3d h = cross3(dir, e2), q = cross3(s, e1);
        double det = dot3(e1, h), u = dot3(s, h) / det, v = dot3(dir, q) / det;
        double t = dot3(e2, q) / det;
        double margin = fmin(fmin(u, v), 1.0 - u - v);
        if (!(margin > -1e-4) || !(t > 0.0) || !isfinite(t))
            continue;
        if (t < hit->t) {
            hit->second = hit->t;
            *hit = (OracleHit){t, hit->t, margin, path, i};
        } else if (t < hit->second) {
            hit->second = t;
        }
    }
}

static OracleHit oracle(const CoAccelScene *scene, const CoRayBatch *rays, size_t i)
{
    OracleHit hit = {DBL_MAX, DBL_MAX, 0.0, 0, 0};
    Vec3d org = {(double)rays->org_x[i], (double)rays->org_y[i], (double)rays->org_z[i]};
    Vec3d dir = {(double)rays->dir_x[i], (double)rays->dir_y[i], (double)rays->dir_z[i]};
    uint64_t paths;
    assert_true(co_accel_path_count(scene, &paths));
    for (uint32_t path = 0; path < paths; path++) {
        CoPlacement placement;
        co_accel_placement(scene, path, &placement);
        oracle_mesh(scene->objects[placement.object].mesh, &placement.to_world, path, org, dir,
                    &hit);
    }
    return hit;
}

// Where the oracle's answer is clear, the traversal's must be it.
static void compare(const CoAccelScene *scene, const CoRayBatch *rays, const CoHitBatch *hits,
                    size_t *clear_hits)
{
    for (size_t i = 0; i < rays->count; i++) {
        OracleHit hit = oracle(scene, rays, i);
        if (hit.t == DBL_MAX) {
            assert_true(isinf(hits->t[i]));
            continue;
        }
        if (hit.margin < 1e-4 || hit.second - hit.t < 1e-4 * hit.t)
            continue;
        ++*clear_hits;
        assert_int_equal(hits->instance[i], hit.path);
        assert_int_equal(hits->tri[i], hit.tri);
        assert_true(fabs((double)hits->t[i] - hit.t) < 2e-5 * hit.t + 1e-6);
    }
}

static CoRayBatch random_rays(size_t count, float reach, uint64_t seed)
{
    Random random = {seed};
    CoRayBatch rays = rays_alloc(count);
    for (size_t i = 0; i < count; i++) {
        CoVec3 org = random_vec3(&random, -reach, reach);
        CoVec3 target = random_vec3(&random, -0.7f * reach, 0.7f * reach);
        ray_set(&rays, i, org, co_sub(target, org));
    }
    return rays;
}

static void check_scene(const CoAccelScene *scene, float reach, size_t count)
{
    CoRayBatch rays = random_rays(count, reach, 99);
    CoHitBatch hits = hits_alloc(count), blocked = hits_alloc(count);
    size_t clear_hits = 0;
    traverse_all(scene, &rays, NULL, &hits, NULL);
    compare(scene, &rays, &hits, &clear_hits);
    assert_true(clear_hits > count / 20);
    uint8_t *occlusion = malloc(count);
    memset(occlusion, 1, count);
    for (size_t i = 0; i < count; i += 3)
        occlusion[i] = 0;
    traverse_all(scene, &rays, occlusion, &blocked, NULL);
    for (size_t i = 0; i < count; i++) {
        if (!occlusion[i])
            assert_memory_equal(&blocked.t[i], &hits.t[i], sizeof(float));
        else
            assert_true(blocked.t[i] == (isinf(hits.t[i]) ? INFINITY : 0.0f));
    }
    // A surface strictly before the end of the ray: the hit itself is no longer inside.
    for (size_t i = 0; i < count; i++)
        rays.tfar[i] = hits.t[i];
    memset(occlusion, 1, count);
    traverse_all(scene, &rays, occlusion, &blocked, NULL);
    for (size_t i = 0; i < count; i++)
        assert_true(isinf(blocked.t[i]));
    for (size_t i = 0; i < count; i++)
        rays.tfar[i] = nextafterf(hits.t[i], INFINITY);
    traverse_all(scene, &rays, NULL, &blocked, NULL);
    assert_true(same_bits(blocked.t, hits.t, count) && same_bits(blocked.tri, hits.tri, count));
    free(occlusion);
    rays_free(&rays);
    hits_free(&hits);
    hits_free(&blocked);
}

// Number of hits along a ray, by the oracle; 0 when it is too close to an edge or a tie to tell.
static size_t count_hits(const CoAccelScene *scene, const CoRayBatch *rays, size_t i)
{
    const CoMesh *mesh = scene->objects[0].mesh;
    const CoAffine identity = affine_identity();
    Vec3d org = {(double)rays->org_x[i], (double)rays->org_y[i], (double)rays->org_z[i]};
    Vec3d dir = {(double)rays->dir_x[i], (double)rays->dir_y[i], (double)rays->dir_z[i]};
    double distances[64];
    size_t count = 0;
    for (uint32_t tri = 0; tri < mesh->tri_count && count < 64; tri++) {
        CoMesh one = *mesh;
        OracleHit hit = {DBL_MAX, DBL_MAX, 0.0, 0, 0};
        one.indices += 3 * (size_t)tri;
        one.tri_count = 1;
        oracle_mesh(&one, &identity, 0, org, dir, &hit);
        if (hit.t == DBL_MAX)
            continue;
        for (size_t k = 0; k < count; k++)
            if (fabs(distances[k] - hit.t) < 1e-4)
                return 0;
        if (hit.margin < 1e-4)
            return 0;
        distances[count++] = hit.t;
    }
    return count;
}

// Moving tnear to each hit in turn finds every triangle along the ray once.
static void tnear_peels_hit_by_hit(void **state)
{
    (void)state;
    enum {
        RAYS = 500
    };
    TestScene s = {0};
    TestMesh soup = mesh_soup(60, 0.6f, 8);
    CoInstance instance = place(scene_add_mesh(&s, &soup), co_mat4d_identity());
    scene_add_group(&s, &instance, 1);
    CoRayBatch rays = random_rays(RAYS, 1.5f, 12);
    CoHitBatch hits = hits_alloc(RAYS);
    size_t found[RAYS] = {0}, deepest = 0;
    for (size_t round = 0; round < 64; round++) {
        traverse_all(&s.scene, &rays, NULL, &hits, NULL);
        for (size_t i = 0; i < RAYS; i++) {
            if (isinf(hits.t[i]))
                continue;
            assert_true(hits.t[i] > rays.tnear[i]);
            rays.tnear[i] = hits.t[i];
            found[i]++;
        }
    }
    for (size_t i = 0; i < RAYS; i++) {
        size_t expected = count_hits(&s.scene, &rays, i);
        if (expected)
            assert_int_equal(found[i], expected);
        deepest = expected > deepest ? expected : deepest;
    }
    assert_true(deepest >= 4);
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&s);
    mesh_free(&soup);
}

static void soups_match_the_oracle(void **state)
{
    (void)state;
    const uint32_t counts[] = {1, 2, 3, 7, 40, 300};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        TestScene s = {0};
        TestMesh soup = mesh_soup(counts[k], counts[k] < 10 ? 1.0f : 0.3f, k);
        CoInstance instance = place(scene_add_mesh(&s, &soup), co_mat4d_identity());
        scene_add_group(&s, &instance, 1);
        check_scene(&s.scene, 1.5f, 1000);
        scene_clear(&s);
        mesh_free(&soup);
    }
}

// In one plane, where leaves of few triangles are tested by themselves.
static void flat_soups_match_the_oracle(void **state)
{
    (void)state;
    const uint32_t counts[] = {1, 2, 3, 7, 40, 300};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        TestScene s = {0};
        TestMesh soup = mesh_soup(counts[k], 1.6f / sqrtf((float)counts[k]), k);
        for (uint32_t i = 0; i < soup.mesh.point_count; i++) {
            float *p = soup.points + 3 * i;
            p[2] = 0.5f * p[0] - 0.25f * p[1];
        }
        mesh_box(&soup);
        soup.mesh.is_flat = true;
        CoInstance instance = place(scene_add_mesh(&s, &soup), co_mat4d_identity());
        scene_add_group(&s, &instance, 1);
        check_scene(&s.scene, 1.5f, 1000);
        scene_clear(&s);
        mesh_free(&soup);
    }
}

static void nested_instances_match_the_oracle(void **state)
{
    (void)state;
    TestScene s = {0};
    TestMesh soup = mesh_soup(20, 0.5f, 5), sphere = mesh_sphere(5, 1.0f, co_vec3(0, 0, 0));
    uint32_t a = scene_add_mesh(&s, &soup), b = scene_add_mesh(&s, &sphere);
    CoVec3 half = co_vec3_splat(0.5f), thin = co_vec3(0.7f, 0.1f, 0.4f);
    CoInstance inner[3] = {place(a, matrix(0.3, half, co_vec3(-1, 0, 0))),
                           place(b, matrix(1.1, thin, co_vec3(1, 0.5f, 0))),
                           place(b, matrix(2.0, half, co_vec3(0, -0.5f, 1)))};
    uint32_t pair = scene_add_group(&s, inner, 3);
    CoInstance middle[2] = {place(pair, matrix(0.7, half, co_vec3(0.3f, 0.6f, 0.1f))),
                            place(a, matrix(-0.7, thin, co_vec3(0, -0.7f, 0)))};
    uint32_t tower = scene_add_group(&s, middle, 2);
    CoInstance outer[3] = {place(tower, matrix(0.1, co_vec3(-1, 1, 1), co_vec3(0.5f, 0, 0.5f))),
                           place(pair, matrix(2.1, half, co_vec3(-1, 0, -1))),
                           place(tower, matrix(0.0, half, co_vec3(0, 1, 1)))};
    scene_add_group(&s, outer, 3);
    check_scene(&s.scene, 2.5f, 1500);
    scene_clear(&s);
    mesh_free(&soup);
    mesh_free(&sphere);
}

static void set_ray(CoRayBatch *rays, size_t i, float org, float dir)
{
    ray_set(rays, i, co_vec3(0.1f, 0.2f, org), co_vec3(0.0f, 0.0f, dir));
}

static void invalid_rays_are_counted(void **state)
{
    (void)state;
    enum {
        RAYS = 100
    };
    TestScene s = {0};
    TestMesh sphere = mesh_sphere(8, 1.0f, co_vec3(0, 0, 0));
    CoInstance instance = place(scene_add_mesh(&s, &sphere), co_mat4d_identity());
    scene_add_group(&s, &instance, 1);
    CoRayBatch rays = rays_alloc(RAYS);
    CoHitBatch hits = hits_alloc(RAYS);
    for (size_t i = 0; i < RAYS; i++)
        set_ray(&rays, i, 3.0f, -1.0f);
    float *fields[6] = {rays.org_x, rays.org_y, rays.org_z, rays.dir_x, rays.dir_y, rays.dir_z};
    const float poisons[3] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < 18; i++)
        fields[i % 6][5 * i] = poisons[i / 6];
    rays.dir_z[95] = -0.0f;
    rays.tnear[96] = NAN;
    rays.tfar[97] = NAN;
    CoTraverseStats stats;
    traverse_all(&s.scene, &rays, NULL, &hits, &stats);
    size_t invalid = 0;
    for (size_t i = 0; i < RAYS; i++) {
        bool is_bad = (i % 5 == 0 && i / 5 < 18) || (i >= 95 && i <= 97);
        invalid += is_bad;
        assert_true(is_bad ? isnan(hits.t[i]) : fabsf(hits.t[i] - 2.0f) < 0.1f);
    }
    assert_int_equal(stats.invalid, invalid);
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&s);
    mesh_free(&sphere);
}

// t is in units of the direction, whatever its length.
static void directions_of_any_length_work(void **state)
{
    (void)state;
    TestScene s = {0};
    TestMesh sphere = mesh_sphere(8, 1.0f, co_vec3(0, 0, 0));
    CoInstance instance =
        place(scene_add_mesh(&s, &sphere), matrix(0.5, co_vec3(1, 1, 2), co_vec3(0, 0, 0)));
    scene_add_group(&s, &instance, 1);
    CoRayBatch rays = rays_alloc(201);
    CoHitBatch hits = hits_alloc(201);
    for (int i = 0; i <= 200; i++) {
        float length = ldexpf(1.0f, i - 100); // 2^-100 to 2^100: 7.9e-31 to 1.3e30
        ray_set(&rays, (size_t)i, co_vec3(0.3f, 0.2f, 5.0f),
                co_scale(co_vec3(-0.06f, 0.02f, -0.8f), length));
        rays.tfar[i] = 1e3f / length;
        rays.tnear[i] = 1e-3f / length;
    }
    traverse_all(&s.scene, &rays, NULL, &hits, NULL);
    for (int i = 0; i <= 200; i++)
        assert_true(hits.t[i] == ldexpf(hits.t[100], 100 - i) && !isinf(hits.t[100]));
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&s);
    mesh_free(&sphere);
}

static void nothing_is_hit_in_empty_scenes(void **state)
{
    (void)state;
    TestScene s = {0};
    TestMesh none = mesh_alloc(0, 0);
    mesh_box(&none);
    uint32_t empty = scene_add_mesh(&s, &none);
    CoRayBatch rays = random_rays(70, 1.0f, 1);
    CoHitBatch hits = hits_alloc(70);
    CoInstance instances[2] = {place(empty, co_mat4d_identity()), place(1, co_mat4d_identity())};
    scene_add_group(&s, NULL, 0);
    traverse_all(&s.scene, &rays, NULL, &hits, NULL);
    for (int i = 0; i < 70; i++)
        assert_true(isinf(hits.t[i]) && hits.tri[i] == COHORT_INVALID_ID);
    scene_add_group(&s, instances, 2);
    traverse_all(&s.scene, &rays, NULL, &hits, NULL);
    for (int i = 0; i < 70; i++)
        assert_true(isinf(hits.t[i]) && hits.instance[i] == COHORT_INVALID_ID);
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&s);
    mesh_free(&none);
}

// What is hidden from a ray is as if it were not there; from others it is not hidden.
static void hidden_instances_are_not_met(void **state)
{
    (void)state;
    enum {
        RAYS = 3000
    };
    TestMesh near = mesh_soup(200, 0.5f, 5), far = mesh_soup(300, 0.5f, 6);
    const uint32_t all = COHORT_HIDDEN_FROM_CAMERA | COHORT_HIDDEN_FROM_SHADOW;
    CoHitBatch hits[3];
    uint8_t *flags = malloc(RAYS);
    assert_non_null(flags);
    for (int i = 0; i < RAYS; i++)
        flags[i] = i % 3 ? COHORT_HIDDEN_FROM_INDIRECT : COHORT_HIDDEN_FROM_CAMERA;
    // Hidden from no ray, from some, from those and the group's own: as the far one alone.
    for (int k = 0; k < 3; k++) {
        TestScene s = {0};
        uint32_t a = scene_add_mesh(&s, &near), b = scene_add_mesh(&s, &far);
        CoInstance inner[2] = {place(a, co_mat4d_identity()), place(b, co_mat4d_identity())};
        inner[0].hidden_from = k == 1 ? all : 0;
        uint32_t group = scene_add_group(&s, inner, 2);
        CoInstance outer[2] = {place(group, co_mat4d_identity()), place(b, co_mat4d_identity())};
        outer[0].hidden_from = k == 2 ? all : 0;
        s.scene.root = scene_add_group(&s, outer, 2);
        CoRayBatch rays = rays_alloc(RAYS);
        Random random = {9};
        for (size_t i = 0; i < RAYS; i++)
            ray_set(&rays, i, random_vec3(&random, -1, 1), random_vec3(&random, -1, 1));
        hits[k] = hits_alloc(RAYS);
        traverse_all(&s.scene, &rays, flags, &hits[k], NULL);
        rays_free(&rays);
        scene_clear(&s);
    }
    size_t missed = 0;
    for (size_t i = 0; i < RAYS; i++) {
        bool is_seeing = flags[i] == COHORT_HIDDEN_FROM_INDIRECT;
        for (int k = 1; k < 3; k++) {
            if (is_seeing) {
                assert_true(same_bits(&hits[0].t[i], &hits[k].t[i], 1));
                assert_int_equal(hits[0].instance[i], hits[k].instance[i]);
            } else if (hits[k].instance[i] != COHORT_INVALID_ID) {
                assert_int_equal(hits[k].instance[i],
                                 k); // path 0: hidden; 1: in the group; 2: beside it
            }
        }
        missed += !is_seeing && hits[0].instance[i] == 0;
    }
    assert_true(missed > 100);
    for (int k = 0; k < 3; k++)
        hits_free(&hits[k]);
    free(flags);
    mesh_free(&near);
    mesh_free(&far);
}

// Nodes of the top level that a group of rays fetched, and those that they tested.
static CoTraverseStats walk_group(const CoAccelScene *scene, uint64_t seed, float spread)
{
    CoRayBatch rays = rays_alloc(64);
    CoHitBatch hits = hits_alloc(64);
    CoTraverseStats stats = {0};
    Random random = {seed};
    for (size_t i = 0; i < 64; i++)
        ray_set(&rays, i, random_vec3(&random, -0.1f, 0.1f),
                co_madd(co_vec3(1.0f - spread, 0, 0), random_vec3(&random, -1, 1), spread));
    traverse_all(scene, &rays, NULL, &hits, &stats);
    rays_free(&rays);
    hits_free(&hits);
    return stats;
}

// Rays all around walk alone, those about one direction together although their signs differ: hits
// are the same.
static void scattered_groups_walk_alone(void **state)
{
    (void)state;
    enum {
        PARTS = 300
    };
    static CoInstance parts[PARTS];
    TestMesh part = mesh_sphere(20, 0.05f, co_vec3(0, 0, 0));
    TestScene s = {0};
    Random random = {17};
    uint32_t mesh = scene_add_mesh(&s, &part);
    for (size_t i = 0; i < PARTS; i++)
        parts[i] = place(mesh, matrix((double)i, co_vec3_splat(1), random_vec3(&random, -2, 2)));
    scene_add_group(&s, parts, PARTS);
    for (uint64_t seed = 0; seed < 20; seed++) {
        CoTraverseStats stats = walk_group(&s.scene, seed << 20, 1.0f);
        assert_int_equal(stats.top_nodes_grouped, stats.top_nodes_single);
        stats = walk_group(&s.scene, seed << 20, 0.2f);
        assert_true(2 * stats.top_nodes_grouped < stats.top_nodes_single);
    }
    scene_clear(&s);
    mesh_free(&part);
}

// Ten copies of a triangle in a mesh that stands twice in one place.
static void coinciding_hits_follow_each_other(void **state)
{
    (void)state;
    enum {
        COPIES = 10
    };
    TestMesh mesh = mesh_soup(COPIES, 1.0f, 5);
    for (size_t i = 9; i < 9 * COPIES; i++)
        mesh.points[i] = mesh.points[i % 9];
    mesh_box(&mesh);
    TestScene s = {0};
    const CoMat4d placement = matrix(0.6, co_vec3(1, 2, 1), co_vec3(0.1f, 0.2f, 0.3f));
    CoInstance instances[2];
    instances[0] = instances[1] = place(scene_add_mesh(&s, &mesh), placement);
    instances[1].hidden_from = COHORT_HIDDEN_FROM_CAMERA;
    scene_add_group(&s, instances, 2);
    CoRayBatch rays = rays_alloc(64);
    CoHitBatch hits = hits_alloc(64);
    Random random = {9};
    for (size_t i = 0; i < rays.count; i++) {
        CoVec3 at =
            co_scale(co_add(co_add(co_vec3_load(mesh.points), co_vec3_load(mesh.points + 3)),
                            co_vec3_load(mesh.points + 6)),
                     1.0f / 3.0f);
        CoVec3 org = random_vec3(&random, -4.0f, 4.0f);
        ray_set(&rays, i, org, co_sub(co_affine_point(&instances[0].to_group, at), org));
    }
    traverse_all(&s.scene, &rays, NULL, &hits, NULL);
    for (size_t i = 0; i < 2 * TEST_ISA_COUNT * rays.count; i++) {
        const CoAccelKernels *kernels = co_accel_kernels(test_isas[i % TEST_ISA_COUNT]);
        const size_t ray = i / (2 * TEST_ISA_COUNT);
        const bool is_camera = i / TEST_ISA_COUNT % 2;
        const CoVec3 org = co_vec3(rays.org_x[ray], rays.org_y[ray], rays.org_z[ray]);
        const CoVec3 dir = co_vec3(rays.dir_x[ray], rays.dir_y[ray], rays.dir_z[ray]);
        CoRayHit hit = {hits.t[ray], hits.u[ray], hits.v[ray], hits.instance[ray], hits.tri[ray]};
        const CoRayHit first = hit;
        assert_int_equal(hit.instance + hit.tri, 0);
        uint32_t count = 1;
        for (; kernels &&
               kernels->next(&s.scene, org, dir, is_camera ? COHORT_HIDDEN_FROM_CAMERA : 0, &hit);
             count++) {
            assert_int_equal(hit.instance * COPIES + hit.tri, count);
            assert_memory_equal(&hit, &first, 3 * sizeof(float));
        }
        assert_int_equal(count, !kernels ? 1 : is_camera ? COPIES : 2 * COPIES);
    }
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&s);
    mesh_free(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(soups_match_the_oracle),
        cmocka_unit_test(flat_soups_match_the_oracle),
        cmocka_unit_test(nested_instances_match_the_oracle),
        cmocka_unit_test(tnear_peels_hit_by_hit),
        cmocka_unit_test(invalid_rays_are_counted),
        cmocka_unit_test(directions_of_any_length_work),
        cmocka_unit_test(hidden_instances_are_not_met),
        cmocka_unit_test(nothing_is_hit_in_empty_scenes),
        cmocka_unit_test(scattered_groups_walk_alone),
        cmocka_unit_test(coinciding_hits_follow_each_other),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
