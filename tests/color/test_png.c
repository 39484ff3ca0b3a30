// PNG files: read back by another program's library, in every shape; and disks that refuse them.

#include "color/png.h"

#include "base/hash.h"
#include "base/memory.h"
#include "shims/oiio.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static const char path[] = "test_png.tmp.png";

static int remove_file(void **state)
{
    (void)state;
    unlink(path);
    return 0;
}

typedef uint8_t ByteFn(uint32_t x, uint32_t y, uint32_t c);

static uint8_t noise(uint32_t x, uint32_t y, uint32_t c)
{
    return (uint8_t)co_hash_combine(co_hash_combine(x, y), c);
}

// Smooth, with steps that wrap around: where each filter is the best somewhere.
static uint8_t ramps(uint32_t x, uint32_t y, uint32_t c)
{
    return (uint8_t)(c == 0 ? 7 * x : c == 1 ? 9 * y : c == 2 ? 3 * x + 5 * y : 255);
}

static uint8_t flat(uint32_t x, uint32_t y, uint32_t c)
{
    (void)x, (void)y;
    return (uint8_t)(50 * c);
}

static void assert_comes_back(uint32_t width, uint32_t height, ByteFn *fn)
{
    size_t count = (size_t)width * height * 4;
    uint8_t *bytes = co_alloc(CO_MEMORY_BASE, count);
    float *back = co_alloc(CO_MEMORY_BASE, count * sizeof *back);
    for (size_t i = 0; i < count; i++)
        bytes[i] = fn((uint32_t)(i / 4) % width, (uint32_t)(i / 4) / width, (uint32_t)i % 4);
    CohortError err = {0};
    CoOiioInfo info;
    if (!co_png_write(path, width, height, bytes, &err) || !co_oiio_info(path, &info, &err) ||
        !co_oiio_read(path, &info, back, &err))
        fail_msg("%ux%u: %s", (unsigned)width, (unsigned)height, err.message);
    assert_int_equal(info.width, width);
    assert_int_equal(info.height, height);
    assert_int_equal(info.channels, 4);
    assert_true(info.is_8bit);
    assert_string_equal(info.color_space, "sRGB");
    for (size_t i = 0; i < count; i++)
        if (lrintf(back[i] * 255.0f) != bytes[i])
            fail_msg("%ux%u: byte %zu is %ld, was %d", (unsigned)width, (unsigned)height, i,
                     lrintf(back[i] * 255.0f), bytes[i]);
    co_free(CO_MEMORY_BASE, bytes, count);
    co_free(CO_MEMORY_BASE, back, count * sizeof *back);
}

static void every_shape_comes_back(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {1, 300}, {300, 1}, {2, 3}, {257, 129}};
    ByteFn *const fns[] = {noise, ramps, flat};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        for (size_t k = 0; k < sizeof fns / sizeof *fns; k++)
            assert_comes_back(sizes[i][0], sizes[i][1], fns[k]);
}

static long size_of(uint32_t side, ByteFn *fn)
{
    assert_comes_back(side, side, fn);
    FILE *file = fopen(path, "rb");
    fseek(file, 0, SEEK_END);
    long size = ftell(file);
    fclose(file);
    return size;
}

static void what_is_smooth_is_small(void **state)
{
    (void)state;
    const long pixels = 256 * 256;
    assert_in_range(size_of(256, noise), 4 * pixels, 4 * pixels + pixels / 16);
    assert_true(size_of(256, ramps) < pixels / 16);
    assert_true(size_of(256, flat) < pixels / 64);
}

static void what_is_no_picture_is_refused(void **state)
{
    (void)state;
    const uint8_t pixel[4] = {0};
    const uint32_t sizes[][2] = {{0, 1}, {1, 0}, {UINT32_MAX, 1}, {1, UINT32_MAX}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        CohortError err = {0};
        assert_false(co_png_write(path, sizes[i][0], sizes[i][1], pixel, &err));
        assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    }
    assert_int_not_equal(access(path, F_OK), 0);
}

static void disks_that_refuse_are_reasons(void **state)
{
    (void)state;
    static uint8_t pixels[64 * 64 * 4];
    CohortError missing = {0}, full = {0};
    assert_false(co_png_write("no/such/folder/x.png", 64, 64, pixels, &missing));
    assert_int_equal(missing.code, COHORT_ERROR_FILE_WRITE);
    assert_non_null(strstr(missing.message, "No such file"));
    if (access("/dev/full", W_OK) != 0)
        skip();
    for (size_t i = 0; i < sizeof pixels; i++)
        pixels[i] = noise(0, (uint32_t)i, 0);
    for (uint32_t side = 1; side <= 64; side *= 8) { // full at the end, and in the middle
        full = (CohortError){0};
        assert_false(co_png_write("/dev/full", side, side, pixels, &full));
        assert_int_equal(full.code, COHORT_ERROR_FILE_WRITE);
        assert_non_null(strstr(full.message, "No space"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(every_shape_comes_back, remove_file),
        cmocka_unit_test_teardown(what_is_smooth_is_small, remove_file),
        cmocka_unit_test_teardown(what_is_no_picture_is_refused, remove_file),
        cmocka_unit_test(disks_that_refuse_are_reasons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
