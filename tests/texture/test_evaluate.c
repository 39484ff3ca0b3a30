// Batches of lookups: the same bits in every schedule, and every block read once. Also tests
// ptex_request.c, reader.c and request.c.

#include "ptex_evaluate.h"
#include "support/faults.h"
#include "texture_support.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "texture/textures.h"

#include <math.h>

#define COUNT 8000

static CoLookup lookups[COUNT];
static float expected[COUNT][4], results[COUNT][4];

// Half of them near an edge; footprints from nothing to several faces, round and slanted.
static void make_lookups(uint32_t textures, uint32_t faces)
{
    for (uint32_t i = 0; i < COUNT; i++) {
        float w = random_at(1, i) < 0.2f ? 0 : random_at(2, i) * random_at(2, i) * random_at(3, i);
        CoLookup *lookup = &lookups[i];
        lookup->texture = (uint32_t)(random_at(4, i) * (float)textures);
        lookup->face = (uint32_t)(random_at(5, i) * (float)faces);
        lookup->s = random_at(6, i);
        lookup->t = i & 1 ? random_at(7, i) : random_at(7, i) * 0.01f;
        lookup->ds0 = w;
        lookup->dt0 = i % 3 ? 0 : w;
        lookup->ds1 = i % 5 ? 0 : 0.1f * w;
        lookup->dt1 = random_at(8, i) < 0.5f ? w : 0.05f * w;
    }
}

static CoLookupStats evaluate(CoTextures *textures, CoLookupMode mode, size_t parts)
{
    CohortError err = {0};
    CoLookupStats sum = {0}, stats;
    memset(results, 0xff, sizeof results);
    for (size_t i = 0; i < parts; i++) {
        size_t begin = COUNT * i / parts, end = COUNT * (i + 1) / parts;
        if (!co_textures_evaluate(textures, lookups + begin, end - begin, results + begin, mode,
                                  NULL, test_folder, &stats, &err))
            fail_msg("%s", err.message);
        if (mode == CO_LOOKUP_SORTED)
            assert_int_equal(stats.blocks_twice, 0);
        sum.lookups += stats.lookups;
        sum.requests += stats.requests;
        sum.blocks_read += stats.blocks_read;
    }
    assert_int_equal(sum.lookups, COUNT);
    return sum;
}

static void all_schedules_give_the_same_bits(void **state)
{
    (void)state;
    write_grid(in_folder("a.ptx"), 4, 5, CO_PTEX_U8, 3);
    write_grid(in_folder("b.ptx"), 4, 8, CO_PTEX_U16, 4);
    write_grid(in_folder("c.ptx"), 4, 3, CO_PTEX_F32, 1);
    Warnings warnings = {0};
    CohortError err = {0};
    make_lookups(4, 16);
    bool is_first = true;
    for (int resident = 0; resident < 2; resident++) {
        for (uint32_t threads = 1; threads <= 3; threads++) {
            co_worker_count_set(threads);
            CoTextures *textures = create_textures(&warnings, resident ? 0 : 100000);
            for (int i = 0; i < 4; i++) {
                CohortTextureDesc desc = {.path = in_folder(i == 0 || i == 3 ? "a.ptx"
                                                            : i == 1         ? "b.ptx"
                                                                             : "c.ptx"),
                                          .color_space = COHORT_COLOR_RAW,
                                          .ptex_filter =
                                              i == 3 ? COHORT_PTEX_BOX : COHORT_PTEX_BILINEAR};
                assert_int_equal(co_textures_add(textures, &desc, &err), i);
            }
            for (int mode = 0; mode < 2; mode++) {
                for (size_t parts = 1; parts <= 7; parts += 3) {
                    CoLookupStats stats = evaluate(textures, (CoLookupMode)mode, parts);
                    assert_true(stats.requests > COUNT);
                    if (is_first)
                        memcpy(expected, results, sizeof expected);
                    is_first = false;
                    assert_memory_equal(expected, results, sizeof expected);
                }
            }
            co_textures_destroy(textures);
        }
    }
    assert_int_equal(warnings.count, 0);
    assert_int_equal(co_memory_live(CO_MEMORY_TEXTURE), 0);
    co_worker_count_set(0);
}

// A Ptex file of the folder alone, none of which stays decoded.
static CoTextures *open_one(const char *name)
{
    static Warnings ignored;
    CohortError err = {0};
    CoTextures *textures = create_textures(&ignored, 1);
    CohortTextureDesc desc = {.path = in_folder(name), .color_space = COHORT_COLOR_RAW};
    assert_int_equal(co_textures_add(textures, &desc, &err), 0);
    return textures;
}

static void a_batch_equals_single_evaluations(void **state)
{
    (void)state;
    write_grid(in_folder("d.ptx"), 3, 4, CO_PTEX_U8, 3);
    CohortError err = {0};
    CoTextures *textures = open_one("d.ptx");
    make_lookups(1, 9);
    evaluate(textures, CO_LOOKUP_SORTED, 1);
    CoPtexFile *file = co_ptex_open(in_folder("d.ptx"), &err);
    CoPtexDecoder decoder = {0};
    for (int i = 0; i < COUNT; i += 7) {
        const CoLookup *l = &lookups[i];
        CoPtexQuery query = {l->face, l->s, l->t, l->ds0, l->dt0, l->ds1, l->dt1, 1, 0};
        float rgb[3];
        assert_true(evaluate_ptex(file, &(CoPtexFilter){0}, &query, 0, 3, &decoder, rgb));
        assert_memory_equal(rgb, results[i], sizeof rgb);
        assert_true(results[i][3] == 1);
    }
    co_ptex_decoder_clear(&decoder);
    co_ptex_close(file);
    co_textures_destroy(textures);
}

// Files whose tiles are so small that a coarse texel spans several, and whose faces have no levels.
static void tiled_files_agree_with_single_evaluations(void **state)
{
    (void)state;
    static const char *const names[] = {"odd_small_tiles", "tiled_u8_rgb",  "tanvec_tiled_u8_c3",
                                        "nomip_u8_rgb",    "odd_long_thin", "edited_applied"};
    for (int n = 0; n < 6; n++) {
        char path[512];
        snprintf(path, sizeof path, COHORT_SHARED_DIR "/ptex/goldens/%s.ptx", names[n]);
        CohortError err = {0};
        CoPtexFile *file = co_ptex_open(path, &err);
        if (!file)
            skip();
        Warnings warnings = {0};
        CoTextures *textures = create_textures(&warnings, 200000);
        CohortTextureDesc desc = {.path = path, .color_space = COHORT_COLOR_RAW};
        assert_int_equal(co_textures_add(textures, &desc, &err), 0);
        make_lookups(1, file->faces_count);
        for (int mode = 0; mode < 2; mode++) {
            evaluate(textures, (CoLookupMode)mode, 1);
            if (mode == 0)
                memcpy(expected, results, sizeof expected);
            assert_memory_equal(expected, results, sizeof expected);
        }
        CoPtexDecoder decoder = {0};
        for (int i = 0; i < COUNT; i += 101) {
            const CoLookup *l = &lookups[i];
            CoPtexQuery query = {l->face, l->s, l->t, l->ds0, l->dt0, l->ds1, l->dt1, 1, 0};
            float first[2];
            uint32_t channels = file->channels < 2 ? 1 : 2;
            assert_true(
                evaluate_ptex(file, &(CoPtexFilter){0}, &query, 0, channels, &decoder, first));
            for (uint32_t c = 0; c < channels; c++) // cut at tiles, the sums round otherwise
                assert_true(fabsf(first[c] - results[i][c]) < 2e-6f);
        }
        co_ptex_decoder_clear(&decoder);
        co_ptex_close(file);
        co_textures_destroy(textures);
        assert_int_equal(warnings.count, 0);
    }
}

static void requests_over_budget_go_to_scratch_files(void **state)
{
    (void)state;
    CohortError err = {0};
    CoTextures *textures = open_one("a.ptx");
    make_lookups(1, 16);
    evaluate(textures, CO_LOOKUP_SORTED, 1);
    memcpy(expected, results, sizeof expected);
    atomic_store(&textures->request_budget, 0);
    size_t peak = co_memory_peak(CO_MEMORY_TEXTURE);
    evaluate(textures, CO_LOOKUP_SORTED, 1);
    assert_memory_equal(expected, results, sizeof expected);
    assert_int_equal(co_memory_peak(CO_MEMORY_TEXTURE), peak);
    // Where there is no room for them either, the batch fails and says so.
    assert_false(co_textures_evaluate(textures, lookups, COUNT, results, CO_LOOKUP_SORTED, NULL,
                                      "/nowhere", NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    co_textures_destroy(textures);
}

static void blocks_are_read_once_though_kernels_cross(void **state)
{
    (void)state;
    write_grid(in_folder("e.ptx"), 4, 4, CO_PTEX_U8, 3);
    CoTextures *textures = open_one("e.ptx");
    for (int i = 0; i < COUNT; i++) // all at corners: four faces each
        lookups[i] =
            (CoLookup){.face = (uint32_t)i % 16, .s = (float)(i & 1), .t = (float)(i >> 1 & 1)};
    CoLookupStats stats = evaluate(textures, CO_LOOKUP_SORTED, 1);
    assert_true(stats.requests > 2 * COUNT);
    assert_int_equal(stats.blocks_read, 16);
    co_textures_destroy(textures);
}

static void damaged_blocks_show_the_fallback(void **state)
{
    (void)state;
    const char *path = in_folder("f.ptx");
    write_grid(path, 2, 6, CO_PTEX_U8, 3);
    CohortError err = {0};
    CoPtexFile *file = co_ptex_open(path, &err);
    long at = (long)file->blocks[1].offset;
    co_ptex_close(file);
    FILE *broken = fopen(path, "r+b");
    fseek(broken, at + 20, SEEK_SET);
    fwrite("garbage garbage", 1, 15, broken);
    fclose(broken);
    for (int mode = 0; mode < 2; mode++) {
        Warnings warnings = {0};
        CoTextures *textures = create_textures(&warnings, 1);
        CohortTextureDesc desc = {.path = path, .color_space = COHORT_COLOR_RAW};
        co_textures_add(textures, &desc, &err);
        CoLookup inside[2] = {{.face = 1, .s = .5f, .t = .5f}, {.face = 0, .s = .5f, .t = .5f}};
        float out[2][4];
        for (int i = 0; i < 2; i++) // told once
            assert_true(co_textures_evaluate(textures, inside, 2, out, (CoLookupMode)mode, NULL,
                                             NULL, NULL, &err));
        assert_int_equal(warnings.count, 1);
        assert_true(out[0][0] == 1 && out[0][1] == 0 && out[0][2] == 1);
        assert_true(out[1][1] > 0);
        co_textures_destroy(textures);
    }
}

static void missing_files_are_magenta(void **state)
{
    (void)state;
    CohortError err = {0};
    Warnings warnings = {0};
    CoTextures *textures = create_textures(&warnings, 1);
    CohortTextureDesc ptex = {.path = in_folder("none.ptx"), .asset = "./none.ptx"};
    CohortTextureDesc image = {.path = in_folder("none.png"), .fallback = {.1f, .2f, .3f, .4f}};
    assert_int_equal(co_textures_add(textures, &ptex, &err), 0);
    assert_non_null(strstr(warnings.text, "./none.ptx"));
    assert_int_equal(co_textures_add(textures, &image, &err), 1);
    assert_int_equal(warnings.count, 2);
    assert_int_equal(err.code, COHORT_OK);
    CoLookup two[3] = {{.texture = 0}, {.texture = 1}, {.texture = 77}};
    float out[3][4];
    assert_true(
        co_textures_evaluate(textures, two, 3, out, CO_LOOKUP_SORTED, NULL, NULL, NULL, &err));
    assert_true(out[0][0] == 1 && out[0][1] == 0 && out[0][2] == 1 && out[0][3] == 1);
    assert_memory_equal(out[1], image.fallback, sizeof out[1]);
    bool is_triangle;
    assert_int_equal(co_texture_ptex_faces(textures, 0, &is_triangle), 0);
    co_textures_destroy(textures);
}

static void cancelling_stops_a_batch(void **state)
{
    (void)state;
    CohortError err = {0};
    CoTextures *textures = open_one("a.ptx");
    make_lookups(1, 16);
    volatile int cancel = 1;
    assert_false(co_textures_evaluate(textures, lookups, COUNT, results, CO_LOOKUP_SORTED, &cancel,
                                      NULL, NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_CANCELLED);
    err = (CohortError){0};
    assert_true(co_textures_evaluate(textures, lookups, 0, results, CO_LOOKUP_SORTED, NULL, NULL,
                                     NULL, &err));
    co_textures_destroy(textures);
}

static void senseless_lookups_are_harmless(void **state)
{
    (void)state;
    CohortError err = {0};
    CoTextures *textures = open_one("a.ptx");
    static const float values[] = {0,      1,           -1e30f,       1e38f,
                                   1e-38f, 1.0f / 0.0f, -1.0f / 0.0f, 0.0f / 0.0f};
    for (uint32_t i = 0; i < 512; i++)
        lookups[i] = (CoLookup){0,
                                i % 20,
                                values[i % 8],
                                values[i / 8 % 8],
                                values[i / 64],
                                values[i % 7],
                                values[i % 5],
                                values[i % 3]};
    assert_true(co_textures_evaluate(textures, lookups, 512, results, CO_LOOKUP_SORTED, NULL, NULL,
                                     NULL, &err));
    for (int i = 0; i < 512; i++)
        for (int c = 0; c < 4; c++)
            assert_true(results[i][c] >= 0 && results[i][c] <= 1.00001f);
    co_textures_destroy(textures);
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    co_worker_count_set(1);
    Warnings warnings = {0};
    CoTexturesOptions options = {
        .resident_bytes = 1, .warn = keep_warning, .warn_cookie = &warnings};
    CohortTextureDesc desc = {.path = in_folder("a.ptx"), .color_space = COHORT_COLOR_RAW};
    make_lookups(1, 16);
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CohortError err = {0};
        test_faults_begin(&faults);
        CoTextures *textures = co_textures_create(&options, &err);
        bool ok = textures && co_textures_add(textures, &desc, &err) != COHORT_INVALID_ID &&
                  co_textures_evaluate(textures, lookups, 500, results, CO_LOOKUP_SORTED, NULL,
                                       NULL, NULL, &err);
        test_faults_end(&faults, ok, &err);
        co_textures_destroy(textures);
    }
    assert_true(faults.count > 20);
    assert_int_equal(warnings.count, 0);
    co_worker_count_set(0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_schedules_give_the_same_bits),
        cmocka_unit_test(a_batch_equals_single_evaluations),
        cmocka_unit_test(tiled_files_agree_with_single_evaluations),
        cmocka_unit_test(requests_over_budget_go_to_scratch_files),
        cmocka_unit_test(blocks_are_read_once_though_kernels_cross),
        cmocka_unit_test(damaged_blocks_show_the_fallback),
        cmocka_unit_test(missing_files_are_magenta),
        cmocka_unit_test(cancelling_stops_a_batch),
        cmocka_unit_test(senseless_lookups_are_harmless),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
