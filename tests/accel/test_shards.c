// Shards cover their triangles, come only where they pay, and change no hit.

#include "accel/shards.h"

#include "accel_scene.h"
#include "base/parallel.h"

enum {
    BARS = 15,
    SIDES = 12,
    BAR_TRIS = 4 * SIDES - 4, // fewer than meshes that are cut have
    RAYS = 40000
};

// A closed bar, one triangle long between its ends, in the points and triangles from `bar` on.
static void put_bar(TestMesh *m, uint32_t bar, CoVec3 from, CoVec3 to, float radius)
{
    CoVec3 z = co_normalize(co_sub(to, from));
    CoVec3 x = co_normalize(co_cross(z, fabsf(z.y) < 0.9f ? co_vec3(0, 1, 0) : co_vec3(1, 0, 0)));
    CoVec3 y = co_cross(z, x);
    uint32_t first = bar * 2 * SIDES, *tri = m->indices + 3 * (size_t)bar * BAR_TRIS;
    for (uint32_t i = 0; i < 2 * SIDES; i++) {
        double phi = 2.0 * M_PI * (i / 2) / SIDES;
        CoVec3 p = co_madd(i % 2 ? to : from, x, radius * (float)cos(phi));
        co_vec3_store(m->points + 3 * (size_t)(first + i), co_madd(p, y, radius * (float)sin(phi)));
    }
    for (uint32_t i = 0; i < SIDES; i++) {
        uint32_t a = first + 2 * i, b = first + 2 * ((i + 1) % SIDES);
        uint32_t corners[12] = {a, b, b + 1, a, b + 1, a + 1, first, a, b, first + 1, b + 1, a + 1};
        bool has_ends = i > 0 && i + 1 < SIDES;
        memcpy(tri, corners, (has_ends ? 12 : 6) * sizeof *tri);
        tri += has_ends ? 12 : 6;
    }
}

// The axis of each bar, all through one place and along no axis of the space.
static void bar_ends(uint32_t bar, float scale, CoVec3 offset, CoVec3 ends[2])
{
    Random random = {100 + bar};
    CoVec3 along = random_direction(&random);
    CoVec3 center = random_vec3(&random, -0.1f, 0.1f);
    ends[0] = co_madd(offset, co_add(center, along), scale);
    ends[1] = co_madd(offset, co_sub(center, along), scale);
}

static TestMesh mesh_bars(uint32_t first, uint32_t count, float scale, CoVec3 offset)
{
    TestMesh m = mesh_alloc(count * 2 * SIDES, count * BAR_TRIS);
    for (uint32_t i = 0; i < count; i++) {
        CoVec3 ends[2];
        bar_ends(first + i, scale, offset, ends);
        put_bar(&m, i, ends[0], ends[1], scale * (i % 2 ? 0.02f : 0.002f));
    }
    mesh_box(&m);
    return m;
}

// Large triangles that lie anywhere among many small ones.
static TestMesh mesh_mixed(uint32_t small, uint32_t large)
{
    TestMesh m = mesh_soup(small + large, 0.01f, 3), huge = mesh_soup(large, 1.0f, 4);
    memcpy(m.points + 9 * (size_t)small, huge.points, 9 * sizeof(float) * large);
    mesh_free(&huge);
    mesh_box(&m);
    return m;
}

typedef struct Made {
    CoPrimArray prims;
    bool are_shards;
} Made;

static Made make(const CoMesh *mesh)
{
    Made made = {.prims = {.count = mesh->tri_count, .capacity = mesh->tri_count}};
    size_t blocks = co_shards_blocks(mesh->tri_count);
    CoBoxAreas *areas = calloc(blocks + 1, sizeof *areas);
    made.prims.prims = co_alloc(CO_MEMORY_ACCEL, mesh->tri_count * sizeof *made.prims.prims);
    for (uint32_t i = 0; i < mesh->tri_count; i++) {
        float area = co4_first(co_shards_whole(mesh, i, &made.prims.prims[i]));
        CoBoxAreas *block = &areas[i / CO_SHARDS_BLOCK];
        block->sum += area;
        block->largest = fmaxf(block->largest, area);
    }
    assert_true(co_shards_make(mesh, areas, &made.prims, &made.are_shards));
    free(areas);
    return made;
}

static bool holds(const CoBuildPrim *prim, const double p[3], double slack)
{
    bool is_within = true;
    for (int k = 0; k < 3; k++)
        is_within =
            is_within && p[k] >= (double)prim->lo[k] - slack && p[k] <= (double)prim->hi[k] + slack;
    return is_within;
}

// Points of triangles, their edges among them, are in one of their shards.
static void assert_covered(const TestMesh *m, const CoPrimArray *prims, uint64_t seed)
{
    Random random = {seed};
    double slack = 1e-14 * (double)(co_length(m->mesh.box_max) + co_length(m->mesh.box_min));
    size_t found = 0, wanted = 4000;
    for (size_t n = 0; n < wanted; n++) {
        uint32_t id = random_bits(&random) % m->mesh.tri_count, tri[3];
        double w[3], p[3] = {0.0, 0.0, 0.0}, sum = 0.0;
        for (int c = 0; c < 3; c++)
            sum += w[c] = n % 3 == 0 && c == 0 ? 0.0 : (double)random_float(&random, 0.0f, 1.0f);
        co_mesh_triangle(&m->mesh, id, tri);
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < 3; k++)
                p[k] += w[c] / sum * (double)m->points[3 * (size_t)tri[c] + (size_t)k];
        bool is_held = false;
        for (size_t i = 0; i < prims->count && !is_held; i++)
            is_held = prims->prims[i].id == id && holds(&prims->prims[i], p, slack);
        found += is_held;
    }
    assert_int_equal(found, wanted);
}

// Within what the triangle's box was; together as large; saving what they are made for.
static void assert_worth_it(const TestMesh *m, const CoPrimArray *prims, double least_saved)
{
    uint32_t count = m->mesh.tri_count;
    CoBox *all = malloc(count * sizeof *all);
    double before = 0.0, after = 0.0;
    assert_true(prims->count > count && (double)prims->count <= 1.4 * (double)count);
    for (uint32_t i = 0; i < count; i++)
        co_box_empty(&all[i]);
    for (size_t i = 0; i < prims->count; i++) {
        const CoBuildPrim *prim = &prims->prims[i];
        assert_true(prim->id < count && (i >= count || prim->id == i));
        co_box_extend(&all[prim->id], prim->lo, prim->hi);
        after += (double)co4_first(co_shards_area(co4_load(prim->lo), co4_load(prim->hi)));
    }
    for (uint32_t i = 0; i < count; i++) {
        CoBox box;
        uint32_t tri[3];
        co_box_empty(&box);
        co_mesh_triangle(&m->mesh, i, tri);
        for (int c = 0; c < 3; c++)
            co_box_extend(&box, m->points + 3 * (size_t)tri[c], m->points + 3 * (size_t)tri[c]);
        assert_memory_equal(&box, &all[i], sizeof box);
        before += co_box_area(&box);
    }
    assert_true(after < (1.0 - least_saved) * before);
    free(all);
}

static void shards_cover_their_triangles(void **state)
{
    (void)state;
    TestMesh meshes[4] = {mesh_bars(0, BARS, 1.0f, co_vec3(0, 0, 0)),
                          mesh_bars(0, BARS, 1e-6f, co_vec3(100, -20, 7)),
                          mesh_bars(0, BARS, 1e15f, co_vec3(0, 0, 0)), mesh_mixed(9000, 200)};
    for (size_t i = 0; i < 4; i++) {
        Made made = make(&meshes[i].mesh);
        if (i != 1) { // there floats leave bars few places to lie in
            assert_true(made.are_shards);
            assert_worth_it(&meshes[i], &made.prims, i == 3 ? 0.25 : 0.12);
        }
        assert_covered(&meshes[i], &made.prims, i);
        co_prims_free(&made.prims);
        mesh_free(&meshes[i]);
    }
}

static void others_stay_as_they_are(void **state)
{
    (void)state;
    TestMesh meshes[5] = {mesh_sphere(24, 1.0f, co_vec3(0, 0, 0)), mesh_soup(5000, 0.02f, 1),
                          mesh_bars(0, 1, 1.0f, co_vec3(0, 0, 0)), mesh_soup(300, 0.0f, 1),
                          mesh_soup(300, 1e25f, 1)};
    for (size_t i = 0; i < 5; i++) {
        Made made = make(&meshes[i].mesh);
        assert_false(made.are_shards);
        assert_int_equal(made.prims.count, meshes[i].mesh.tri_count);
        co_prims_free(&made.prims);
        mesh_free(&meshes[i]);
    }
}

// How often each triangle stands in the tree's leaves, no two times in one.
static size_t count_in_leaves(const CoBvh *bvh, uint32_t *times)
{
    size_t leaves = 0;
    for (size_t n = 0; n < bvh->tree.node_count; n++) {
        for (int c = 0; c < CO_NODE_WIDTH; c++) {
            uint32_t ref = bvh->tree.nodes[n].child[c];
            if (!(ref & CO_REF_LEAF))
                continue;
            CoTriLeaf leaf = co_leaf_open(bvh->leaves + CO_LEAF_UNIT * (ref & CO_REF_LEAF_PLACE));
            for (uint32_t i = 0; i < leaf.count; i++) {
                times[co_leaf_tri(&leaf, i)]++;
                assert_true(i == 0 || co_leaf_tri(&leaf, i) > co_leaf_tri(&leaf, i - 1));
            }
            leaves++;
        }
    }
    return leaves;
}

static void leaves_hold_a_triangle_once(void **state)
{
    (void)state;
    TestMesh meshes[2] = {mesh_bars(0, BARS, 1.0f, co_vec3(0, 0, 0)), mesh_mixed(9000, 200)};
    for (size_t i = 0; i < 2; i++) {
        CoBvh *bvh = co_bvh_create(&meshes[i].mesh, NULL);
        uint32_t *times = calloc(meshes[i].mesh.tri_count, sizeof *times), several = 0;
        assert_true(count_in_leaves(bvh, times) > 10);
        for (uint32_t t = 0; t < meshes[i].mesh.tri_count; t++) {
            assert_true(times[t] > 0);
            several += times[t] > 1;
        }
        assert_true(several > 50);
        free(times);
        co_bvh_destroy(bvh);
        mesh_free(&meshes[i]);
    }
}

static void trees_do_not_depend_on_threads(void **state)
{
    (void)state;
    TestMesh meshes[2] = {mesh_mixed(30000, 900), mesh_slivers(5)};
    for (size_t i = 0; i < 2; i++) {
        co_worker_count_set(1);
        CoBvh *one = co_bvh_create(&meshes[i].mesh, NULL);
        co_worker_count_set(3);
        CoBvh *three = co_bvh_create(&meshes[i].mesh, NULL);
        assert_int_equal(one->tree.node_count, three->tree.node_count);
        assert_memory_equal(one->tree.nodes, three->tree.nodes,
                            one->tree.node_count * sizeof(CoWideNode));
        assert_int_equal(one->leaf_bytes, three->leaf_bytes);
        assert_memory_equal(one->leaves, three->leaves, one->leaf_bytes);
        co_bvh_destroy(one);
        co_bvh_destroy(three);
        mesh_free(&meshes[i]);
    }
    co_worker_count_set(0);
}

static void no_memory_is_said(void **state)
{
    (void)state;
    TestMesh meshes[2] = {mesh_bars(0, BARS, 1.0f, co_vec3(0, 0, 0)), mesh_mixed(9000, 200)};
    for (size_t i = 0; i < 2; i++) {
        co_bvh_destroy(create_despite_failures(&meshes[i].mesh, 5));
        mesh_free(&meshes[i]);
    }
}

// A point where a plane of a shard's box cuts an edge of its triangle; else one of its corners.
static CoVec3 point_at_cut(Random *random, const TestMesh *m, const CoBuildPrim *shard, int axis)
{
    uint32_t tri[3], c = random_bits(random) % 3;
    float plane = random_bits(random) % 2 ? shard->lo[axis] : shard->hi[axis];
    co_mesh_triangle(&m->mesh, shard->id, tri);
    const float *a = m->points + 3 * (size_t)tri[c], *b = m->points + 3 * (size_t)tri[(c + 1) % 3];
    double w = ((double)plane - (double)a[axis]) / ((double)b[axis] - (double)a[axis]);
    if (!(w > 0.0 && w < 1.0))
        return co_vec3_load(a);
    float p[3];
    for (int k = 0; k < 3; k++)
        p[k] = (float)((double)a[k] + ((double)b[k] - (double)a[k]) * w);
    p[axis] = plane;
    return co_vec3_load(p);
}

// At cuts, edges and corners from anywhere and from within bars; some run in the plane of a cut.
static void aim_at_cuts(CoRayBatch *rays, const TestMesh *m, const CoPrimArray *prims, float scale,
                        CoVec3 offset)
{
    Random random = {21};
    for (size_t i = 0; i < rays->count; i++) {
        const CoBuildPrim *shard = &prims->prims[random_bits(&random) % prims->count];
        int axis = (int)(random_bits(&random) % 3);
        CoVec3 at = point_at_cut(&random, m, shard, axis), ends[2], org;
        bar_ends(shard->id / BAR_TRIS, scale, offset, ends);
        if (i % 2) // within
            org = co_lerp3(ends[0], ends[1], random_float(&random, 0.01f, 0.99f));
        else
            org = co_madd(offset, random_vec3(&random, -1.0f, 1.0f), i % 6 ? scale : 50.0f * scale);
        if (i % 4 == 0)
            (&org.x)[axis] = (&at.x)[axis];
        ray_set(rays, i, org, co_sub(at, org));
    }
}

// Hits of the whole are those of its bars alone, too few triangles each to be cut, bit for bit.
static void check_same_hits(const TestMesh *whole, float scale, CoVec3 offset)
{
    TestScene cut = {0}, apart = {0};
    TestMesh bars[BARS];
    CoInstance instances[BARS], instance = place(scene_add_mesh(&cut, whole), co_mat4d_identity());
    scene_add_group(&cut, &instance, 1);
    for (uint32_t i = 0; i < BARS; i++) {
        bars[i] = mesh_alloc(2 * SIDES, BAR_TRIS);
        memcpy(bars[i].points, whole->points + (size_t)i * 6 * SIDES, 24 * SIDES);
        memcpy(bars[i].indices, whole->indices, 12 * BAR_TRIS);
        mesh_box(&bars[i]);
        instances[i] = place(scene_add_mesh(&apart, &bars[i]), co_mat4d_identity());
    }
    scene_add_group(&apart, instances, BARS);
    CoRayBatch rays = rays_alloc(RAYS);
    CoHitBatch hits = hits_alloc(RAYS), others = hits_alloc(RAYS);
    Made made = make(&whole->mesh);
    size_t hit = 0;
    aim_at_cuts(&rays, whole, &made.prims, scale, offset);
    traverse_all(&cut.scene, &rays, NULL, &hits, NULL);
    traverse_all(&apart.scene, &rays, NULL, &others, NULL);
    for (size_t i = 0; i < RAYS; i++) {
        bool is_hit = hits.t[i] < INFINITY;
        if (is_hit)
            others.tri[i] += BAR_TRIS * others.instance[i];
        assert_int_equal(hits.tri[i], others.tri[i]);
        assert_true(is_hit || i % 2 == 0); // from within nothing gets out
        hit += is_hit;
    }
    assert_true(hit > RAYS / 2);
    assert_true(same_bits(hits.t, others.t, RAYS) && same_bits(hits.u, others.u, RAYS) &&
                same_bits(hits.v, others.v, RAYS));
    co_prims_free(&made.prims);
    rays_free(&rays);
    hits_free(&hits);
    hits_free(&others);
    scene_clear(&cut);
    scene_clear(&apart);
    for (uint32_t i = 0; i < BARS; i++)
        mesh_free(&bars[i]);
}

static void cuts_lose_no_hit(void **state)
{
    (void)state;
    const struct {
        float scale;
        CoVec3 offset;
    } cases[] = {{1.0f, {0, 0, 0}},
                 {1e-6f, {0, 0, 0}},
                 {1e6f, {0, 0, 0}},
                 {1.0f, {100, -200, 50}},
                 {1e-15f, {0, 0, 0}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        TestMesh whole = mesh_bars(0, BARS, cases[i].scale, cases[i].offset);
        check_same_hits(&whole, cases[i].scale, cases[i].offset);
        mesh_free(&whole);
    }
}

// The boxes of shards are no good for triangles that have moved.
static void refits_are_refused(void **state)
{
    (void)state;
    TestMesh meshes[2] = {mesh_bars(0, BARS, 1.0f, co_vec3(0, 0, 0)),
                          mesh_bars(0, 1, 1.0f, co_vec3(0, 0, 0))};
    for (size_t i = 0; i < 2; i++) {
        CoBvh *bvh = co_bvh_create(&meshes[i].mesh, NULL);
        for (size_t k = 0; k < meshes[i].mesh.point_count; k++)
            meshes[i].points[3 * k] += 0.01f;
        assert_int_equal(co_bvh_refit(bvh, &meshes[i].mesh), i == 1);
        co_bvh_destroy(bvh);
        mesh_free(&meshes[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shards_cover_their_triangles),
        cmocka_unit_test(others_stay_as_they_are),
        cmocka_unit_test(leaves_hold_a_triangle_once),
        cmocka_unit_test(trees_do_not_depend_on_threads),
        cmocka_unit_test(no_memory_is_said),
        cmocka_unit_test(cuts_lose_no_hit),
        cmocka_unit_test(refits_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
