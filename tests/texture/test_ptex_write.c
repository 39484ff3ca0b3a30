// The Ptex writer against what the reference library stored: ptex_encode.c, ptex_texels.c too.

#include "support/faults.h"
#include "texture_support.h"

#include "texture/half.h"
#include "texture/ptex_block.h"

#include <math.h>

#define GOLDENS COHORT_SHARED_DIR "/ptex/goldens/"

// Rewrites a file and compares every face, level, constant and neighbor.
static void check_rewrite(const char *name)
{
    char path[512];
    snprintf(path, sizeof path, GOLDENS "%s.ptx", name);
    CohortError err = {0};
    CoPtexFile *a = co_ptex_open(path, &err);
    if (!a)
        skip();
    CoPtexWriteDesc desc = {.face_count = a->faces_count,
                            .type = a->type,
                            .channels = a->channels,
                            .has_alpha = a->alpha >= 0,
                            .alpha = a->alpha >= 0 ? (uint32_t)a->alpha : 0,
                            .u_border = a->u_border,
                            .v_border = a->v_border,
                            .is_tangent = a->is_tangent,
                            .no_levels = a->levels == 1};
    CoPtexWriter *writer = co_ptex_writer_create(in_folder("copy.ptx"), &desc, &err);
    for (uint32_t i = 0; i < a->faces_count; i++) {
        uint32_t face = a->faces_count - 1 - i; // any order will do
        void *texels = texels_of(a, face, a->faces[face].ulog2, a->faces[face].vlog2);
        assert_true(co_ptex_writer_face(writer, face, &a->faces[face],
                                        (const void *const[]){texels}, 1, &err));
        free(texels);
    }
    assert_true(co_ptex_writer_finish(writer, &err));
    CoPtexFile *b = co_ptex_open(in_folder("copy.ptx"), &err);
    if (!b)
        fail_msg("%s: %s", name, err.message);
    assert_int_equal(a->levels, b->levels);
    assert_memory_equal(a->level_faces, b->level_faces, a->levels * sizeof(uint32_t));
    assert_int_equal(a->alpha, b->alpha);
    size_t pixel = co_ptex_pixel_size(a);
    for (uint32_t face = 0; face < a->faces_count; face++) {
        const CoPtexFace *info = &a->faces[face];
        assert_int_equal(info->flags & 9, b->faces[face].flags & 9);
        assert_int_equal(info->adjedges, b->faces[face].adjedges);
        assert_memory_equal(info->adjfaces, b->faces[face].adjfaces, sizeof info->adjfaces);
        if (memcmp(a->constants + face * pixel, b->constants + face * pixel, pixel) != 0)
            fail_msg("%s: constant of face %u", name, face);
        for (int u = info->ulog2, v = info->vlog2; u >= 0 && v >= 0; u--, v--) {
            void *left = texels_of(a, face, u, v), *right = texels_of(b, face, u, v);
            if (memcmp(left, right, co_ptex_block_size(a, u, v)) != 0)
                fail_msg("%s: face %u at 2^%d x 2^%d", name, face, u, v);
            free(left);
            free(right);
        }
    }
    co_ptex_close(a);
    co_ptex_close(b);
}

static void rewriting_keeps_everything(void **state)
{
    (void)state;
    static const char *const names[] = {
        "cube_u8_c3",         "cube_u8_c4a",          "cube_u8_c4_alpha0",  "cube_u16_c4a",
        "cube_u16_c5_alpha4", "cube_f16_c4a",         "cube_f16_c4_alpha1", "cube_f32_c4a",
        "cube_u8_c7",         "tiled_u8_rgb",         "tiled_f32_rgba",     "varres_u8_rgb",
        "torus_varres_u16",   "nomip_u8_rgb",         "const_grid_u8",      "subface_mixed_u8",
        "tanvec_tiled_u8_c3", "border_black_periodic"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        check_rewrite(names[i]);
}

static void the_writer_refuses_nonsense(void **state)
{
    (void)state;
    CohortError err = {0};
    CoPtexWriteDesc desc = {.face_count = 2, .channels = 0};
    assert_null(co_ptex_writer_create(in_folder("no.ptx"), &desc, &err));
    desc.channels = 1;
    const unsigned char texel[4] = {1, 2, 3, 4};
    CoPtexFace info = {.adjfaces = {-1, -1, -1, -1}};
    for (int fault = 0; fault < 4; fault++) {
        CoPtexWriter *writer = co_ptex_writer_create(in_folder("no.ptx"), &desc, &err);
        CoPtexFace bad = info;
        bad.ulog2 = fault == 0 ? 20 : 0;
        bad.adjfaces[2] = fault == 1 ? 2 : -1;
        if (fault == 3)
            assert_true(
                co_ptex_writer_face(writer, 0, &info, (const void *const[]){texel}, 1, &err));
        assert_false(co_ptex_writer_face(writer, fault == 2 ? 2 : 0, &bad,
                                         (const void *const[]){texel}, 1, &err));
        assert_false(co_ptex_writer_finish(writer, &err));
        assert_int_not_equal(access(in_folder("no.ptx"), F_OK), 0);
    }
    assert_false(co_ptex_writer_finish(NULL, &err));
    // Faces that are left out are one black texel.
    CoPtexWriter *writer = co_ptex_writer_create(in_folder("one.ptx"), &desc, &err);
    info.ulog2 = info.vlog2 = 1;
    assert_true(co_ptex_writer_face(writer, 1, &info, (const void *const[]){texel}, 1, &err));
    assert_true(co_ptex_writer_finish(writer, &err));
    CoPtexFile *file = co_ptex_open(in_folder("one.ptx"), &err);
    assert_int_equal(file->faces[0].flags, CO_PTEX_CONSTANT);
    assert_int_equal(file->constants[0], 0);
    assert_int_equal(file->constants[1], 2); // (1 + 2 + 3 + 4) / 4, cut
    co_ptex_close(file);
}

static void means_over_footprints_are_means_of_texels(void **state)
{
    (void)state;
    write_grid(in_folder("means.ptx"), 3, 6, CO_PTEX_F32, 1);
    CohortError err = {0};
    CoTexturesOptions options = {.converted_folder = test_folder};
    CoTextures *textures = co_textures_create(&options, &err);
    CohortTextureDesc desc = {.path = in_folder("means.ptx")};
    uint32_t id = co_textures_add(textures, &desc, &err);
    enum {
        SIDE = 48
    };
    static CoLookup lookups[9 * SIDE * SIDE];
    static float out[9 * SIDE * SIDE][4];
    double mean[5];
    for (int w = 0; w < 5; w++) {
        for (int i = 0; i < 9 * SIDE * SIDE; i++) {
            int x = i % SIDE, y = i / SIDE % SIDE;
            lookups[i] = (CoLookup){id,
                                    (uint32_t)(i / SIDE / SIDE),
                                    ((float)x + .5f) / SIDE,
                                    ((float)y + .5f) / SIDE,
                                    .2f * (float)w,
                                    0,
                                    0,
                                    .1f * (float)w};
        }
        assert_true(co_textures_evaluate(textures, lookups, 9 * SIDE * SIDE, out, CO_LOOKUP_SORTED,
                                         NULL, NULL, NULL, &err));
        mean[w] = 0;
        for (int i = 0; i < 9 * SIDE * SIDE; i++)
            mean[w] += (double)out[i][0] / (9 * SIDE * SIDE);
        assert_true(fabs(mean[w] - mean[0]) < .01 * mean[0]);
    }
    co_textures_destroy(textures);
}

static void halves_round_as_ptex_has_it(void **state)
{
    (void)state;
    for (uint32_t bits = 0; bits < 65536; bits++) {
        uint16_t half = (uint16_t)bits;
        float value = co_half_to_float(half);
        if (isnan(value) || half == 0x8000)
            continue;
        assert_int_equal(co_half_from_float(value), half);
    }
    assert_int_equal(co_half_from_float(65520.0f), 0x7c00);
    assert_int_equal(co_half_from_float(-0.0f), 0);
    assert_int_equal(co_half_from_float(1.0f + 0x1p-11f), 0x3c01); // half way: away from zero
    assert_true(isnan(co_half_to_float(co_half_from_float(NAN))));
}

static void count_file(void *context, const char *path)
{
    (void)path;
    ++*(int *)context;
}

// Of three faces one is cut into tiles, one of them of one color, one has a level besides its own
// and one is constant. Alpha is premultiplied.
static bool write_three(const unsigned char *texels, CohortError *err)
{
    static const CoPtexFace infos[] = {{.ulog2 = 8, .vlog2 = 8, .adjfaces = {-1, -1, -1, -1}},
                                       {.ulog2 = 4, .vlog2 = 3, .adjfaces = {-1, -1, -1, -1}},
                                       {.ulog2 = 0, .vlog2 = 0, .adjfaces = {-1, -1, -1, -1}}};
    const CoPtexWriteDesc desc = {
        .face_count = 3, .type = CO_PTEX_U8, .channels = 4, .has_alpha = true, .alpha = 3};
    CoPtexWriter *writer = co_ptex_writer_create(in_folder("three.ptx"), &desc, err);
    for (uint32_t i = 0; writer && i < 3; i++)
        if (!co_ptex_writer_face(writer, i, &infos[i], (const void *const[]){texels}, 1, err))
            break;
    return co_ptex_writer_finish(writer, err);
}

static void unwritten_files_leave_nothing(void **state)
{
    (void)state;
    static unsigned char texels[4 << 16];
    for (uint32_t i = 0; i < sizeof texels / 2; i++)
        texels[i] = (unsigned char)(random_at(3, i) * 255.0f);
    int before = 0;
    test_each_file(test_folder, count_file, &before);
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CohortError err = {0};
        test_faults_begin(&faults);
        bool ok = write_three(texels, &err);
        test_faults_end(&faults, ok, &err);
        int after = 0;
        test_each_file(test_folder, count_file, &after);
        assert_int_equal(after, before + ok);
        if (!ok)
            assert_true(write_three(texels, &err));
        CoPtexFile *file = co_ptex_open(in_folder("three.ptx"), &err);
        assert_non_null(file);
        unsigned char *got = texels_of(file, 0, 8, 8);
        assert_memory_equal(got, texels, sizeof texels);
        free(got);
        co_ptex_close(file);
        unlink(in_folder("three.ptx"));
    }
    assert_true(faults.count > 15);
}

static void faces_without_memory_are_not_broken(void **state)
{
    (void)state;
    write_grid(in_folder("face.ptx"), 1, 8, CO_PTEX_U8, 3);
    CohortError err = {0};
    CoPtexFile *file = co_ptex_open(in_folder("face.ptx"), &err);
    assert_non_null(file);
    static unsigned char texels[3 << 16];
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CoPtexDecoder decoder = {0};
        err = (CohortError){0};
        test_faults_begin(&faults);
        bool ok = co_ptex_face_texels(file, 0, 8, 8, &decoder, texels, &err);
        test_faults_end(&faults, ok, &err);
        co_ptex_decoder_clear(&decoder);
    }
    assert_int_equal(faults.count, 2);
    co_ptex_close(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rewriting_keeps_everything),
        cmocka_unit_test(the_writer_refuses_nonsense),
        cmocka_unit_test(means_over_footprints_are_means_of_texels),
        cmocka_unit_test(halves_round_as_ptex_has_it),
        cmocka_unit_test(unwritten_files_leave_nothing),
        cmocka_unit_test(faces_without_memory_are_not_broken),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
