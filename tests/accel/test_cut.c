// Halves of triangles hold all of them, and what a first cut saves is known beforehand.

#include "accel/cut.h"

#include "accel_scene.h"

enum {
    TRIS = 4000
};

// Of every size, some flat along an axis or long.
static TestMesh mesh_of_all_kinds(void)
{
    TestMesh m = mesh_soup(TRIS, 1.0f, 7);
    for (uint32_t i = 0; i < 3 * TRIS; i++) {
        float *p = m.points + 3 * (size_t)i, size = ldexpf(1.0f, (int)(i / 3 % 41) - 20);
        for (int k = 0; k < 3; k++)
            p[k] *= size;
        p[i / 3 % 3] *= i / 3 % 5 == 0 ? 0.0f : i / 3 % 5 == 1 ? 100.0f : 1.0f;
    }
    return m;
}

static CoBuildPrim prim_of(const TestMesh *m, uint32_t id)
{
    CoBuildPrim prim = {.id = id};
    CoBox box;
    co_box_empty(&box);
    for (size_t c = 0; c < 3; c++)
        co_box_extend(&box, m->points + 9 * (size_t)id + 3 * c, m->points + 9 * (size_t)id + 3 * c);
    memcpy(prim.lo, box.lo, sizeof box.lo);
    memcpy(prim.hi, box.hi, sizeof box.hi);
    return prim;
}

static CoFour rounding_of(const CoBuildPrim *prim)
{
    CoFour r = {0.0f, 0.0f, 0.0f, 0.0f};
    for (int k = 0; k < 3; k++)
        r[k] = 1e-6f * fmaxf(fabsf(prim->lo[k]), fabsf(prim->hi[k]));
    return r;
}

static bool holds(const CoShard *shard, const double p[3])
{
    bool is_in = true;
    for (int k = 0; k < 3; k++)
        is_in = is_in && p[k] >= (double)shard->lo[k] && p[k] <= (double)shard->hi[k];
    return is_in;
}

static void assert_within(const CoShard *half, const CoShard *whole)
{
    for (int k = 0; k < 3; k++)
        assert_true(half->lo[k] >= whole->lo[k] && half->hi[k] <= whole->hi[k]);
    assert_in_range(half->count, 1, CO_CUT_CORNERS);
}

// A point of the triangle goes down with the halves that hold it, cut after cut.
static void points_are_in_a_half(void **state)
{
    (void)state;
    TestMesh m = mesh_of_all_kinds();
    Random random = {3};
    size_t cuts = 0;
    for (uint32_t id = 0; id < TRIS; id++) {
        CoBuildPrim prim = prim_of(&m, id);
        CoFour rounding = rounding_of(&prim);
        CoShard shard, halves[2];
        double w[3], p[3] = {0.0, 0.0, 0.0}, sum = 0.0;
        for (int c = 0; c < 3; c++)
            sum += w[c] = c == 0 && id % 3 == 0 ? 0.0 : (double)random_float(&random, 0.0f, 1.0f);
        for (size_t c = 0; c < 3; c++)
            for (size_t k = 0; k < 3; k++)
                p[k] += w[c] / sum * (double)m.points[9 * (size_t)id + 3 * c + k];
        co_cut_start(&m.mesh, &prim, &shard);
        for (int depth = 0; depth < 8; depth++) {
            if (!co_cut_halve(&shard, rounding * co_four_set1((float)(depth + 1)), halves))
                break;
            assert_within(&halves[0], &shard);
            assert_within(&halves[1], &shard);
            assert_true(holds(&halves[0], p) || holds(&halves[1], p));
            shard = halves[holds(&halves[0], p) ? 0 : 1];
            cuts++;
        }
    }
    assert_true(cuts > 7 * TRIS);
    mesh_free(&m);
}

static double area_of(const CoShard *shard)
{
    CoFour sides = co_shard_sides(shard);
    return (double)sides[0] + (double)sides[1] + (double)sides[2];
}

static void first_cuts_save_what_is_said(void **state)
{
    (void)state;
    TestMesh m = mesh_of_all_kinds();
    for (uint32_t id = 0; id < TRIS; id += 4) {
        const uint32_t ids[4] = {id, id + 1, id + 2, id + 3};
        CoFour saving = co_cut_saving(&m.mesh, ids);
        for (uint32_t i = 0; i < 4; i++) {
            CoBuildPrim prim = prim_of(&m, ids[i]);
            CoShard whole, halves[2];
            co_cut_start(&m.mesh, &prim, &whole);
            assert_true(co_cut_halve(&whole, co_four_set1(0.0f), halves));
            double area = area_of(&whole), saved = area - area_of(&halves[0]) - area_of(&halves[1]);
            assert_true(fabs((double)saving[i] - saved) <= 1e-5 * area);
        }
    }
    mesh_free(&m);
}

static void points_are_not_cut(void **state)
{
    (void)state;
    TestMesh m = mesh_soup(4, 0.0f, 1);
    const uint32_t ids[4] = {0, 1, 2, 3};
    CoFour saving = co_cut_saving(&m.mesh, ids);
    for (uint32_t id = 0; id < 4; id++) {
        CoBuildPrim prim = prim_of(&m, id);
        CoShard whole, halves[2];
        co_cut_start(&m.mesh, &prim, &whole);
        assert_false(co_cut_halve(&whole, co_four_set1(0.0f), halves));
        assert_false(saving[id] > 0.0f);
    }
    mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_in_a_half),
        cmocka_unit_test(first_cuts_save_what_is_said),
        cmocka_unit_test(points_are_not_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
