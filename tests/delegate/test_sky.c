// The built-in sky: a picture that any reader of Radiance files takes, and that needs no exposure.

#include "stage_adapter/adapter.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static double brightness(const unsigned char *pixel)
{
    return ldexp((double)pixel[1], (int)pixel[3] - 136);
}

// Pictures need no exposure: a white floor sends back less than 1, only the sun is brighter.
static void assert_exposed(unsigned char pixels[256][512][4])
{
    const double step = 3.14159265358979 / 256.0;
    double floor_light = 0.0;
    unsigned bright = 0;
    for (int y = 0; y < 128; y++)
        for (int x = 0; x < 512; x++) {
            double polar = step * (y + 0.5), value = brightness(pixels[y][x]);
            floor_light += value * cos(polar) * sin(polar) * step * step;
            bright += value > 1.0;
        }
    assert_true(floor_light / 3.14159265358979 > 0.6 && floor_light / 3.14159265358979 < 1.0);
    assert_true(bright < 256 * 512 / 100);
}

static void test_sky_is_bright_above(void **state)
{
    (void)state;
    char path[] = "/tmp/cohort_sky_XXXXXX";
    close(mkstemp(path));
    assert_true(co_sky_write(path, NULL));
    FILE *file = fopen(path, "rb");
    char line[64];
    for (int i = 0; i < 4; i++)
        assert_non_null(fgets(line, sizeof line, file));
    assert_string_equal(line, "-Y 256 +X 512\n");
    static unsigned char pixels[256][512][4];
    assert_int_equal(fread(pixels, 1, sizeof pixels, file), sizeof pixels);
    assert_int_equal(fgetc(file), EOF);
    fclose(file);
    unlink(path);
    assert_true(brightness(pixels[100][400]) > 1.5 * brightness(pixels[200][400]));
    // The sun is where the framing camera is, in front (+Z), to its right and 40 degrees up.
    assert_true(brightness(pixels[71][201]) > 100.0);
    assert_true(brightness(pixels[71][457]) < 1.0);
    assert_exposed(pixels);
    CohortError err = {0};
    assert_false(co_sky_write("/nowhere/sky.hdr", &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
}

// A disk without room: the error says so.
static void test_a_full_disk(void **state)
{
    (void)state;
    CohortError err = {0};
    if (access("/dev/full", W_OK) != 0)
        skip();
    assert_false(co_sky_write("/dev/full", &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sky_is_bright_above),
        cmocka_unit_test(test_a_full_disk),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
