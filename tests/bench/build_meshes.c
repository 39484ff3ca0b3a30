#include "build_meshes.h"

#include <string.h>

static CoMesh mesh_alloc(size_t points, size_t tris)
{
    CoMesh mesh = {.points = malloc(12 * points), .indices = malloc(12 * tris)};
    mesh.point_count = (uint32_t)points;
    mesh.tri_count = (uint32_t)tris;
    return mesh;
}

static float *points_of(const CoMesh *mesh)
{
    return (float *)(uintptr_t)mesh->points;
}

static uint32_t *indices_of(const CoMesh *mesh)
{
    return (uint32_t *)(uintptr_t)mesh->indices;
}

CoMesh bench_mesh_ball(uint32_t tris)
{
    uint32_t n = (uint32_t)sqrt(tris / 2.0);
    CoMesh mesh = mesh_alloc((size_t)(n + 1) * (n + 1), 2 * (size_t)n * n);
    float *points = points_of(&mesh);
    uint32_t *indices = indices_of(&mesh);
    for (uint32_t i = 0; i <= n; i++) {
        for (uint32_t j = 0; j <= n; j++) {
            float theta = CO_PI * (float)i / (float)n, phi = 2.0f * CO_PI * (float)j / (float)n;
            float r = 1.0f + 0.05f * sinf(41.0f * theta) * sinf(29.0f * phi);
            co_vec3_store(
                points + 3 * ((size_t)i * (n + 1) + j),
                co_vec3(r * sinf(theta) * cosf(phi), r * cosf(theta), r * sinf(theta) * sinf(phi)));
        }
    }
    for (uint32_t q = 0; q < n * n; q++) {
        uint32_t a = q / n * (n + 1) + q % n;
        uint32_t quad[6] = {a, a + 1, a + n + 2, a, a + n + 2, a + n + 1};
        memcpy(indices + 6 * (size_t)q, quad, sizeof quad);
    }
    return mesh;
}

CoMesh bench_mesh_soup(uint32_t tris, float stretch, Random *random)
{
    CoMesh mesh = mesh_alloc(3 * (size_t)tris, tris);
    float *points = points_of(&mesh), size = 1.0f / cbrtf((float)tris);
    uint32_t *indices = indices_of(&mesh);
    for (uint32_t i = 0; i < 3 * tris; i++)
        indices[i] = i;
    for (uint32_t i = 0; i < tris; i++) {
        float center[3] = {random_float(random, -1, 1), random_float(random, -1, 1),
                           random_float(random, -1, 1)};
        for (uint32_t c = 0; c < 9; c++)
            points[9 * (size_t)i + c] = center[c % 3] + (c % 3 == i % 3 ? stretch : 1.0f) * size *
                                                            random_float(random, -1, 1);
    }
    return mesh;
}

// Three directions at right angles, the first of them along `z`.
static void make_frame(CoVec3 z, CoVec3 out[3])
{
    CoVec3 up = fabsf(z.y) < 0.9f ? co_vec3(0, 1, 0) : co_vec3(1, 0, 0);
    out[0] = co_normalize(z);
    out[1] = co_normalize(co_cross(up, out[0]));
    out[2] = co_cross(out[0], out[1]);
}

CoMesh bench_mesh_turned(uint32_t tris, float stretch, Random *random)
{
    CoMesh mesh = bench_mesh_soup(tris, 1.0f, random);
    float size = 1.0f / cbrtf((float)tris);
    for (uint32_t i = 0; i < tris; i++) {
        float *p = points_of(&mesh) + 9 * (size_t)i;
        CoVec3 frame[3], center = co_vec3_load(p);
        make_frame(random_direction(random), frame);
        for (int c = 0; c < 3; c++) {
            CoVec3 at = co_madd(center, frame[0], size * stretch * random_float(random, -1, 1));
            at = co_madd(at, frame[1], size * random_float(random, -1, 1));
            co_vec3_store(p + 3 * c, co_madd(at, frame[2], size * random_float(random, -1, 1)));
        }
    }
    return mesh;
}

// A mesh that is put together.
typedef struct Site {
    CoMesh mesh; // with room
    CoVec3 corner;
} Site;

enum {
    STEPS = 16,
    BALUSTERS = 32,
    BALL = 24,
    BAR_TRIS = 12,
    BAY_TRIS = BAR_TRIS * (3 + STEPS + 2 + 2 + BALUSTERS + 8) + 2 * BALL * BALL
};

// The site is turned where points are put.
static uint32_t add_point(Site *site, CoVec3 p)
{
    const float c = cosf(0.5f), s = sinf(0.5f), d = cosf(0.3f), t = sinf(0.3f);
    p = co_add(p, site->corner);
    p = co_vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    p = co_vec3(p.x, d * p.y - t * p.z, t * p.y + d * p.z);
    co_vec3_store(points_of(&site->mesh) + 3 * (size_t)site->mesh.point_count, p);
    return site->mesh.point_count++;
}

static void add_quad(Site *site, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    uint32_t quad[6] = {a, b, c, a, c, d};
    memcpy(indices_of(&site->mesh) + 3 * (size_t)site->mesh.tri_count, quad, sizeof quad);
    site->mesh.tri_count += 2;
}

// A box from a to b, so wide and so high across.
static void add_bar(Site *site, CoVec3 a, CoVec3 b, float width, float height)
{
    static const uint8_t sides[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                        {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    CoVec3 frame[3];
    uint32_t first = site->mesh.point_count;
    make_frame(co_sub(b, a), frame);
    for (int i = 0; i < 8; i++) {
        CoVec3 p = co_madd(i & 4 ? b : a, frame[1], i & 1 ? 0.5f * width : -0.5f * width);
        add_point(site, co_madd(p, frame[2], i & 2 ? 0.5f * height : -0.5f * height));
    }
    for (int i = 0; i < 6; i++)
        add_quad(site, first + sides[i][0], first + sides[i][1], first + sides[i][2],
                 first + sides[i][3]);
}

static void add_ball(Site *site, CoVec3 center, float radius)
{
    uint32_t first = site->mesh.point_count;
    for (uint32_t i = 0; i <= BALL; i++)
        for (uint32_t j = 0; j <= BALL; j++) {
            float theta = CO_PI * (float)i / BALL, phi = 2.0f * CO_PI * (float)j / BALL;
            CoVec3 n = co_vec3(sinf(theta) * cosf(phi), cosf(theta), sinf(theta) * sinf(phi));
            add_point(site, co_madd(center, n, radius));
        }
    for (uint32_t q = 0; q < BALL * BALL; q++) {
        uint32_t a = first + q / BALL * (BALL + 1) + q % BALL;
        add_quad(site, a, a + 1, a + BALL + 2, a + BALL + 1);
    }
}

// 6 by 3 by 4 units.
static void add_bay(Site *site)
{
    add_bar(site, co_vec3(0, 0, 2), co_vec3(6, 0, 2), 4.0f, 0.2f);
    add_bar(site, co_vec3(0, 1.5f, 0), co_vec3(6, 1.5f, 0), 0.15f, 2.8f);
    add_bar(site, co_vec3(0, 1.5f, 0.1f), co_vec3(0, 1.5f, 4), 0.15f, 2.8f);
    for (int i = 0; i < STEPS; i++) {
        float x = 1.0f + 0.25f * (float)i, y = 0.2f + 2.8f * (float)i / STEPS;
        add_bar(site, co_vec3(x, y, 0.5f), co_vec3(x, y, 1.7f), 0.28f, 0.04f);
    }
    for (int side = 0; side < 2; side++) {
        float z = side ? 1.7f : 0.5f;
        add_bar(site, co_vec3(0.9f, 0.1f, z), co_vec3(5, 2.9f, z), 0.05f, 0.25f);
        add_bar(site, co_vec3(0.9f, 1.1f, z), co_vec3(5, 3.9f, z), 0.05f, 0.05f);
        for (int i = 0; i < BALUSTERS / 2; i++) {
            float x = 1.0f + 4.0f * (float)i / (BALUSTERS / 2), y = 0.2f + 0.68f * (x - 1.0f);
            add_bar(site, co_vec3(x, y, z), co_vec3(x, y + 0.9f, z), 0.02f, 0.02f);
        }
    }
    for (int i = 0; i < 8; i++) {
        CoVec3 a = co_vec3(i & 1 ? 6 : 0, 0, i & 2 ? 4 : 2.2f);
        CoVec3 b = co_vec3(i & 1 ? 0 : 6, 3, i & 4 ? 4 : 2.2f);
        add_bar(site, a, b, 0.05f, 0.05f);
    }
    add_ball(site, co_vec3(3.0f, 1.0f, 3.0f), 0.5f);
}

// Into [-1, 1].
static void fit(CoMesh *mesh)
{
    float *points = points_of(mesh), lo[3], hi[3], size = 0.0f;
    memcpy(lo, points, sizeof lo);
    memcpy(hi, points, sizeof hi);
    for (size_t i = 0; i < 3 * (size_t)mesh->point_count; i++) {
        lo[i % 3] = fminf(lo[i % 3], points[i]);
        hi[i % 3] = fmaxf(hi[i % 3], points[i]);
        size = fmaxf(size, hi[i % 3] - lo[i % 3]);
    }
    for (size_t i = 0; i < 3 * (size_t)mesh->point_count; i++)
        points[i] = (2.0f * points[i] - lo[i % 3] - hi[i % 3]) / size;
}

CoMesh bench_mesh_house(uint32_t tris)
{
    uint32_t bays = tris / BAY_TRIS + 1, side = (uint32_t)ceil(cbrt(bays));
    size_t room = (size_t)bays * BAY_TRIS;
    Site site = {.mesh = mesh_alloc(room, room)};
    site.mesh.point_count = site.mesh.tri_count = 0;
    for (uint32_t i = 0; i < bays; i++) {
        site.corner = co_vec3(6.0f * (float)(i % side), 3.0f * (float)(i / side % side),
                              4.0f * (float)(i / side / side));
        add_bay(&site);
    }
    fit(&site.mesh);
    return site.mesh;
}

CoMesh bench_mesh_shuffled(CoMesh mesh, Random *random)
{
    uint32_t *indices = indices_of(&mesh);
    for (uint32_t i = mesh.tri_count - 1; i > 0; i--) {
        uint32_t j = (uint32_t)(co_hash64(random->state++) % (i + 1)), moved[3];
        memcpy(moved, indices + 3 * (size_t)i, sizeof moved);
        memcpy(indices + 3 * (size_t)i, indices + 3 * (size_t)j, sizeof moved);
        memcpy(indices + 3 * (size_t)j, moved, sizeof moved);
    }
    return mesh;
}

void bench_mesh_free(CoMesh *mesh)
{
    free(points_of(mesh));
    free(indices_of(mesh));
}
