// EXR files: every bit comes back, metadata is where readers look for it, broken files are refused,
// and a failed write leaves nothing behind.

#include "cohort/image.h"

#include "support/faults.h"
#include "support/files.h"

#include <math.h>
#include <signal.h>
#include <sys/resource.h>

static const char path[] = "picture.exr";

static int files_in_folder(void)
{
    int count = 0;
    DIR *d = opendir(".");
    assert_non_null(d);
    while (readdir(d))
        count++;
    closedir(d);
    return count - 2;
}

static float from_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

// Values at the edges of float, then noise.
static void fill(float *pixels, size_t count)
{
    static const uint32_t edges[] = {0x00000000, 0x80000000, 0x00000001, 0x807fffff, 0x00800000,
                                     0x3f800000, 0x7f7fffff, 0x7f800000, 0xff800000, 0x7fc00001};
    uint32_t x = 1;
    for (size_t i = 0; i < count; i++) {
        x = x * 1664525u + 1013904223u;
        pixels[i] = i < sizeof edges / sizeof edges[0] ? from_bits(edges[i])
                                                       : (float)(x >> 8) * 0x1p-20f - 3.0f;
    }
}

static bool write_floats(const char *file, uint32_t width, uint32_t height, const float *pixels,
                         CohortCompression compression, CohortError *err)
{
    CohortChannel channels[3] = {{"R", COHORT_CHANNEL_FLOAT, pixels, 12},
                                 {"G", COHORT_CHANNEL_FLOAT, pixels + 1, 12},
                                 {"layer.X", COHORT_CHANNEL_FLOAT, pixels + 2, 12}};
    CohortExrDesc desc = {.width = width,
                          .height = height,
                          .compression = compression,
                          .channels = channels,
                          .channel_count = 3};
    return cohort_exr_write(file, &desc, err);
}

static void floats_come_back_bit_for_bit(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {17, 35}, {64, 16}, {3, 100}};
    for (int s = 0; s < 4; s++)
        for (int c = COHORT_COMPRESSION_ZIP; c <= COHORT_COMPRESSION_NONE; c++) {
            uint32_t w = sizes[s][0], h = sizes[s][1];
            size_t count = (size_t)w * h;
            float *pixels = malloc(count * 3 * sizeof *pixels);
            fill(pixels, count * 3);
            CohortError err = {0};
            assert_true(write_floats(path, w, h, pixels, (CohortCompression)c, &err));
            CohortImage image = {0};
            assert_true(cohort_exr_read(path, &image, &err));
            assert_int_equal(image.width, w);
            assert_int_equal(image.height, h);
            assert_int_equal(image.channel_count, 3);
            static const char *const names[] = {"R", "G", "layer.X"};
            for (int k = 0; k < 3; k++) {
                int index = cohort_image_channel(&image, names[k]);
                assert_true(index >= 0);
                for (size_t i = 0; i < count; i++)
                    assert_memory_equal(&image.pixels[(size_t)index * count + i],
                                        &pixels[3 * i + (size_t)k], sizeof(float));
            }
            assert_int_equal(cohort_image_channel(&image, "B"), -1);
            cohort_image_clear(&image);
            free(pixels);
        }
}

static void halves_and_integers(void **state)
{
    (void)state;
    const float values[8] = {0.0f,     -2.5f, 65504.0f,  0x1p-24f,
                             0x1p-14f, 1e6f,  -INFINITY, 1.0f / 3.0f};
    const float stored[8] = {0.0f,     -2.5f,    65504.0f,  0x1p-24f,
                             0x1p-14f, INFINITY, -INFINITY, 1365.0f / 4096.0f};
    const uint32_t ids[8] = {0, 1, 2, 255, 65535, 16777216, 3, 4294967295u};
    CohortChannel channels[2] = {{"half", COHORT_CHANNEL_HALF, values, 4},
                                 {"id", COHORT_CHANNEL_UINT, ids, 4}};
    CohortExrDesc desc = {.width = 4, .height = 2, .channels = channels, .channel_count = 2};
    CohortError err = {0};
    assert_true(cohort_exr_write(path, &desc, &err));
    CohortImage image = {0};
    assert_true(cohort_exr_read(path, &image, &err));
    for (int i = 0; i < 8; i++) {
        assert_true(image.pixels[i] == stored[i]);
        assert_true(image.pixels[8 + i] == (float)ids[i]);
    }
    cohort_image_clear(&image);
}

// The bytes of an attribute's value: name, type, size, value.
static const char *find(const char *bytes, size_t size, const char *name, const char *type,
                        uint32_t value_size)
{
    size_t n = strlen(name) + 1, k = strlen(type) + 1;
    for (size_t i = 0; i + n + k + 4 + value_size <= size; i++) {
        uint32_t stated;
        memcpy(&stated, bytes + i + n + k, 4);
        if (!memcmp(bytes + i, name, n) && !memcmp(bytes + i + n, type, k) && stated == value_size)
            return bytes + i + n + k + 4;
    }
    fail_msg("no attribute %s of type %s", name, type);
    return NULL;
}

static void attributes_are_in_the_header(void **state)
{
    (void)state;
    static const float pixel = 1.0f;
    CohortAttribute list[8] = {
        {.name = "text", .type = COHORT_ATTRIBUTE_STRING, .text = "gr\xc3\xbcn"},
        {.name = "none", .type = COHORT_ATTRIBUTE_STRING},
        {.name = "count", .type = COHORT_ATTRIBUTE_INT, .integer = -7},
        {.name = "number", .type = COHORT_ATTRIBUTE_FLOAT, .numbers = {0.1f}},
        {.name = "screenWindowWidth", .type = COHORT_ATTRIBUTE_FLOAT, .numbers = {0.5f}},
        {.name = "screenWindowCenter", .type = COHORT_ATTRIBUTE_V2F, .numbers = {0.25f, -1.0f}},
        {.name = "worldToCamera", .type = COHORT_ATTRIBUTE_M44F},
        {.name = "chromaticities", .type = COHORT_ATTRIBUTE_CHROMATICITIES}};
    for (int i = 0; i < 16; i++)
        list[6].numbers[i] = list[7].numbers[i] = (float)i;
    CohortChannel channel = {"Y", COHORT_CHANNEL_FLOAT, &pixel, 4};
    CohortExrDesc desc = {.width = 1,
                          .height = 1,
                          .pixel_aspect = 2.0f,
                          .channels = &channel,
                          .channel_count = 1,
                          .attributes = list,
                          .attribute_count = 8};
    CohortError err = {0};
    assert_true(cohort_exr_write(path, &desc, &err));
    size_t size;
    char *bytes = test_read_file(path, &size);
    int32_t integer;
    assert_memory_equal(find(bytes, size, "text", "string", 5), "gr\xc3\xbcn", 5);
    find(bytes, size, "none", "string", 0);
    memcpy(&integer, find(bytes, size, "count", "int", 4), 4);
    assert_int_equal(integer, -7);
    assert_memory_equal(find(bytes, size, "number", "float", 4), list[3].numbers, 4);
    assert_memory_equal(find(bytes, size, "screenWindowWidth", "float", 4), list[4].numbers, 4);
    assert_memory_equal(find(bytes, size, "screenWindowCenter", "v2f", 8), list[5].numbers, 8);
    assert_memory_equal(find(bytes, size, "worldToCamera", "m44f", 64), list[6].numbers, 64);
    assert_memory_equal(find(bytes, size, "chromaticities", "chromaticities", 32), list[7].numbers,
                        32);
    assert_memory_equal(find(bytes, size, "pixelAspectRatio", "float", 4), &(float){2.0f}, 4);
    free(bytes);
}

static void truncated_files_are_refused(void **state)
{
    (void)state;
    float pixels[16 * 40 * 3];
    fill(pixels, 16 * 40 * 3);
    CohortError err = {0};
    assert_true(write_floats(path, 16, 40, pixels, COHORT_COMPRESSION_ZIP, &err));
    size_t size;
    char *bytes = test_read_file(path, &size);
    for (size_t length = 0; length < size; length += length < 400 ? 7 : 97) {
        test_write_file("cut.exr", bytes, length);
        CohortError why = {0};
        CohortImage image = {0};
        assert_false(cohort_exr_read("cut.exr", &image, &why));
        assert_true(why.code != COHORT_OK && why.message[0]);
        assert_null(image.pixels);
    }
    unlink("cut.exr");
    free(bytes);
}

static void garbage_never_crashes(void **state)
{
    (void)state;
    float pixels[16 * 20 * 3];
    fill(pixels, 16 * 20 * 3);
    CohortError err = {0};
    assert_true(write_floats(path, 16, 20, pixels, COHORT_COMPRESSION_ZIP, &err));
    size_t size;
    char *bytes = test_read_file(path, &size), *changed = malloc(size);
    uint32_t x = 7;
    for (int round = 0; round < 400; round++) {
        memcpy(changed, bytes, size);
        for (int k = 0; k < 1 + round % 4; k++) {
            x = x * 1664525u + 1013904223u;
            // The header is where the damage counts: its bytes are hit more often.
            size_t where = (x >> 8) % (round % 2 ? 400 : size);
            changed[where] = (char)(x >> 3);
        }
        test_write_file("bent.exr", changed, size);
        CohortError why = {0};
        CohortImage image = {0};
        bool ok = cohort_exr_read("bent.exr", &image, &why);
        assert_true(ok == (why.code == COHORT_OK));
        assert_true(ok == (image.pixels != NULL));
        cohort_image_clear(&image);
    }
    unlink("bent.exr");
    free(changed);
    free(bytes);
}

static void what_is_no_picture_is_refused(void **state)
{
    (void)state;
    CohortImage image = {0};
    CohortError missing = {0}, empty = {0}, folder_err = {0};
    assert_false(cohort_exr_read("none.exr", &image, &missing));
    assert_int_equal(missing.code, COHORT_ERROR_FILE_NOT_FOUND);
    assert_string_equal(missing.file, "none.exr");
    fclose(fopen("empty.exr", "wb"));
    assert_false(cohort_exr_read("empty.exr", &image, &empty));
    assert_int_equal(empty.code, COHORT_ERROR_IMAGE);
    assert_false(cohort_exr_read(".", &image, &folder_err));
    assert_int_equal(folder_err.code, COHORT_ERROR_IMAGE);
    unlink("empty.exr");
}

static void writes_without_sense_are_refused(void **state)
{
    (void)state;
    float pixel[3] = {0};
    CohortError err = {0}, twice = {0};
    CohortChannel channels[2] = {{"R", COHORT_CHANNEL_FLOAT, pixel, 4},
                                 {"R", COHORT_CHANNEL_FLOAT, pixel, 4}};
    CohortExrDesc none = {.width = 1, .height = 1};
    assert_false(cohort_exr_write("no.exr", &none, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_false(write_floats("no.exr", 0, 4, pixel, COHORT_COMPRESSION_ZIP, &(CohortError){0}));
    assert_false(write_floats("no.exr", 4, 0, pixel, COHORT_COMPRESSION_ZIP, &(CohortError){0}));
    CohortExrDesc two = {.width = 1, .height = 1, .channels = channels, .channel_count = 2};
    assert_false(cohort_exr_write("no.exr", &two, &twice));
    assert_true(access("no.exr", F_OK) != 0);
}

static void failed_writes_leave_no_trace(void **state)
{
    (void)state;
    static float pixels[64 * 64 * 3];
    fill(pixels, sizeof pixels / sizeof pixels[0]);
    CohortError err = {0};
    assert_true(write_floats(path, 2, 2, pixels, COHORT_COMPRESSION_ZIP, &err));
    assert_false(write_floats("nofolder/a.exr", 2, 2, pixels, COHORT_COMPRESSION_ZIP, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    CohortError taken = {0}, full = {0};
    assert_int_equal(mkdir("taken.exr", 0777), 0);
    assert_false(write_floats("taken.exr", 2, 2, pixels, COHORT_COMPRESSION_ZIP, &taken));
    assert_non_null(strstr(taken.message, "irectory"));
    assert_int_equal(rmdir("taken.exr"), 0);
    int files = files_in_folder();
    struct rlimit limit, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    small = limit;
    signal(SIGXFSZ, SIG_IGN);
    alarm(60); // a library that waits for itself ends the test
    bool ok = false;
    rlim_t bytes = 0;
    for (; !ok; bytes += bytes < 1024 ? 1 : 509) { // ends in the header, the table, any chunk
        small.rlim_cur = bytes;
        full = (CohortError){0};
        CohortCompression compression =
            bytes % 2 ? COHORT_COMPRESSION_ZIP : COHORT_COMPRESSION_NONE;
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        ok = write_floats("full.exr", 64, 64, pixels, compression, &full);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
        assert_int_equal(full.code, ok ? COHORT_OK : COHORT_ERROR_FILE_WRITE);
        assert_true(ok || strstr(full.message, "too large"));
        assert_int_equal(files_in_folder(), files + ok);
    }
    alarm(0);
    assert_true(bytes > 20000);
    assert_int_equal(unlink("full.exr"), 0);
    small.rlim_cur = 4096;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    ok = write_floats(path, 64, 64, pixels, COHORT_COMPRESSION_ZIP, &full);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    assert_false(ok);
    // No part of the new picture, and the old one is still whole.
    assert_int_equal(files_in_folder(), files);
    CohortImage image = {0};
    assert_true(cohort_exr_read(path, &image, &(CohortError){0}));
    assert_int_equal(image.width, 2);
    cohort_image_clear(&image);
}

static void memory_that_fails_is_said(void **state)
{
    (void)state;
    static float pixels[12];
    CohortError err = {0};
    assert_true(write_floats(path, 2, 2, pixels, COHORT_COMPRESSION_ZIP, &err));
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CohortError why = {0};
        CohortImage image = {0};
        test_faults_begin(&faults);
        bool ok = cohort_exr_read(path, &image, &why);
        test_faults_end(&faults, ok, &why);
        cohort_image_clear(&image);
    }
    assert_int_equal(faults.count, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(floats_come_back_bit_for_bit),
        cmocka_unit_test(halves_and_integers),
        cmocka_unit_test(attributes_are_in_the_header),
        cmocka_unit_test(truncated_files_are_refused),
        cmocka_unit_test(garbage_never_crashes),
        cmocka_unit_test(what_is_no_picture_is_refused),
        cmocka_unit_test(writes_without_sense_are_refused),
        cmocka_unit_test(failed_writes_leave_no_trace),
        cmocka_unit_test(memory_that_fails_is_said),
    };
    return cmocka_run_group_tests(tests, test_folder_enter, test_folder_leave);
}
