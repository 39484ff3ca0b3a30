// The textures of a scene: what stays decoded, and limits that change it from batch to batch and no
// bit of what is looked up.

#include "texture_support.h"

#include "base/memory.h"
#include "texture/textures.h"

enum {
    COUNT = 2000,
    FACES = 16
};

static CoLookup lookups[COUNT];

static CoLookupStats evaluate(CoTextures *textures, float out[COUNT][4])
{
    CohortError err = {0};
    CoLookupStats stats = {0};
    if (!co_textures_evaluate(textures, lookups, COUNT, out, CO_LOOKUP_SORTED, NULL, test_folder,
                              &stats, &err))
        fail_msg("%s", err.message);
    return stats;
}

static CoTextures *open_grid(Warnings *warnings)
{
    CohortError err = {0};
    write_grid(in_folder("grid.ptx"), 4, 5, CO_PTEX_U8, 3);
    CoTextures *textures = create_textures(warnings, 0);
    CohortTextureDesc desc = {.path = in_folder("grid.ptx"), .color_space = COHORT_COLOR_RAW};
    assert_int_equal(co_textures_add(textures, &desc, &err), 0);
    for (uint32_t i = 0; i < COUNT; i++)
        lookups[i] = (CoLookup){.face = i % FACES,
                                .s = random_at(1, i),
                                .t = random_at(2, i),
                                .ds0 = i % 3 ? .2f * random_at(3, i) : 0,
                                .dt1 = .1f * random_at(4, i)};
    return textures;
}

static void limits_change_what_stays_and_nothing_else(void **state)
{
    (void)state;
    Warnings warnings = {0};
    static float expected[COUNT][4], got[COUNT][4];
    CoTextures *textures = open_grid(&warnings);
    assert_true(evaluate(textures, expected).blocks_read > 0);
    assert_int_equal(evaluate(textures, got).blocks_read, 0); // all of it stays
    assert_memory_equal(expected, got, sizeof got);
    size_t resident = co_memory_live(CO_MEMORY_TEXTURE);

    co_textures_limit(textures, 1, 0); // nothing may stay
    CoLookupStats first = evaluate(textures, got), again = evaluate(textures, got);
    assert_true(first.blocks_read > 0 && again.blocks_read == first.blocks_read);
    assert_int_equal(again.blocks_twice, 0);
    assert_memory_equal(expected, got, sizeof got);
    assert_true(co_memory_live(CO_MEMORY_TEXTURE) < resident + 4 * (size_t)textures->block_bytes);

    co_textures_limit(textures, 1, 1); // requests to scratch files too
    evaluate(textures, got);
    assert_memory_equal(expected, got, sizeof got);

    co_textures_limit(textures, 0, 0); // as the options say, again
    assert_true(evaluate(textures, got).blocks_read > 0);
    assert_int_equal(evaluate(textures, got).blocks_read, 0);
    assert_memory_equal(expected, got, sizeof got);

    co_textures_limit(textures, UINT64_MAX, UINT64_MAX); // never above the options
    assert_int_equal(textures->resident_limit, textures->options.resident_bytes);
    assert_int_equal(evaluate(textures, got).blocks_read, 0);
    co_textures_destroy(textures);
    assert_int_equal(co_memory_live(CO_MEMORY_TEXTURE), 0);
    assert_int_equal(warnings.count, 0);
}

static void the_largest_block_is_known(void **state)
{
    (void)state;
    CohortError err = {0};
    Warnings warnings = {0};
    CoTextures *textures = create_textures(&warnings, 0);
    assert_int_equal(co_textures_block_bytes(textures), 0);
    for (int log2 = 2; log2 <= 5; log2++) {
        char name[16];
        snprintf(name, sizeof name, "b%d.ptx",
                 log2 == 5 ? 3 : 2 * log2); // the last one is no larger
        write_grid(in_folder(name), 1, log2 == 5 ? 3 : 2 * log2, CO_PTEX_U16, 2);
        CohortTextureDesc desc = {.path = in_folder(name), .color_space = COHORT_COLOR_RAW};
        co_textures_add(textures, &desc, &err);
        size_t side = (size_t)1 << (log2 == 5 ? 8 : 2 * log2);
        assert_int_equal(co_textures_block_bytes(textures), 2 * 2 * side * side);
    }
    co_textures_destroy(textures);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limits_change_what_stays_and_nothing_else),
        cmocka_unit_test(the_largest_block_is_known),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
