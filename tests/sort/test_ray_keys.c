// Keys of the ray sort (kernels/keys.c): curves that visit neighbors, the same keys from every
// instruction set.

#include "ray_sort_support.h"
#include "sort/hilbert.h"

static uint32_t hilbert(uint32_t x, uint32_t y, uint32_t z, int dimensions, uint32_t bits)
{
    uint32_t at[3][CO_HILBERT_CELLS] = {{0}}, keys[CO_HILBERT_CELLS];
    at[0][5] = x;
    at[1][5] = y;
    at[2][5] = z;
    if (dimensions == 2)
        co_hilbert2(at[0], at[1], bits, keys);
    else
        co_hilbert3(at[0], at[1], at[2], bits, keys);
    return keys[5];
}

// Every cell once, and each step goes to a cell that shares a side. The first cells of a finer
// curve are those of a coarser one.
static void hilbert_curves_visit_neighbors(void **state)
{
    (void)state;
    static uint32_t cell[4096];
    for (int dimensions = 2; dimensions <= 3; dimensions++) {
        memset(cell, 0xff, sizeof cell);
        uint32_t bits = dimensions == 2 ? 6 : 4, mask = (1u << bits) - 1;
        for (uint32_t i = 0; i < 4096; i++) {
            uint32_t x = i & mask, y = i >> bits & mask, z = i >> (2 * bits) & mask;
            uint32_t key = hilbert(x, y, z, dimensions, bits);
            assert_true(key < 4096 && cell[key] == UINT32_MAX);
            cell[key] = i;
            assert_int_equal(hilbert(x >> 1, y >> 1, z >> 1, dimensions, bits - 1),
                             key >> dimensions);
        }
        for (uint32_t key = 1; key < 4096; key++) {
            int distance = 0;
            for (uint32_t shift = 0; shift < 18; shift += bits)
                distance +=
                    abs((int)(cell[key] >> shift & mask) - (int)(cell[key - 1] >> shift & mask));
            assert_int_equal(distance, 1);
        }
    }
    const uint32_t most2 = 65535, most3 = 1023;
    assert_true(hilbert(most2, 0, 0, 2, 16) == UINT32_MAX ||
                hilbert(0, most2, 0, 2, 16) == UINT32_MAX);
    assert_true(hilbert(most3, 0, 0, 3, 10) == (1u << 30) - 1 ||
                hilbert(0, most3, 0, 3, 10) == (1u << 30) - 1 ||
                hilbert(0, 0, most3, 3, 10) == (1u << 30) - 1);
}

// With every instruction set, for parts of any length: rays of all kinds, infinite and NaN ones
// too.
static void keys_do_not_depend_on_the_instruction_set(void **state)
{
    (void)state;
    static const char *const isas[] = {"sse42", "avx2", "avx512"};
    enum {
        COUNT = 5003
    };
    static uint32_t words[COUNT * CO_RAY_WORDS];
    static uint64_t expected[COUNT], items[COUNT + 1];
    for (uint32_t i = 0; i < COUNT; i++) {
        const float odd[] = {NAN, INFINITY, -INFINITY, 3e38f};
        CoRay ray = scene_ray(i);
        float org[3] = {ray.org.x, ray.org.y, ray.org.z};
        if (i % 10 == 0)
            org[i / 10 % 3] = odd[i / 30 % 4];
        memcpy(words + i * CO_RAY_WORDS, org, sizeof org);
        words[i * CO_RAY_WORDS + 3] = co_hash32(i);
        words[i * CO_RAY_WORDS + 4] = co_hash32(i + COUNT);
    }
    for (int k = 0; k < 6; k++) {
        CoKeyGrid grid = {{0, -1, 0}, 0.0f, 7, 12, 27, 0, 13};
        if (k % 2)
            grid = (CoKeyGrid){{0, -1, 0}, 1.28f, 7, 5, 21, 13, 13};
        CoRayRecords records = {
            .words = words, .count = COUNT, .stride = CO_RAY_WORDS, .bin = CO_RAY_BIN_MIXED};
        CoRayKeysFn *keys = co_ray_keys(isas[k / 2]);
        if (!keys)
            continue;
        co_ray_keys("scalar")(&records, &grid, 0, COUNT, expected);
        items[COUNT] = 77;
        keys(&records, &grid, 1000, COUNT, items);
        keys(&records, &grid, 0, 1000, items);
        assert_memory_equal(items, expected, sizeof expected);
        assert_int_equal(items[COUNT], 77);
        for (uint32_t i = 0; i < COUNT; i++) {
            const uint32_t *w = words + i * CO_RAY_WORDS;
            bool is_valid = true;
            for (int a = 0; a < 3; a++)
                is_valid = is_valid && (w[a] & 0x7f800000u) != 0x7f800000u;
            assert_int_equal(items[i] & 8191u, i);
            assert_int_equal(items[i] >> (13 + grid.direction_bits + grid.place_bits), !is_valid);
        }
    }
    assert_null(co_ray_keys("no such"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hilbert_curves_visit_neighbors),
        cmocka_unit_test(keys_do_not_depend_on_the_instruction_set),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
