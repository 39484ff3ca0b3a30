// The adapter's small parts: numbers of all precisions, texts for the report, the built-in sky.

#include "stage_adapter/adapter.h"

#include "index/index.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static void test_halves(void **state)
{
    (void)state;
    CohortPull pull = {.arena = {.tag = CO_MEMORY_DELEGATE}};
    const uint16_t halves[] = {0x3c00, 0xc000, 0x0001, 0x7bff, 0x7c00, 0x7e00};
    CohortValue value = {.type = COHORT_TYPE_HALF3, .is_array = true, .count = 2, .data = halves};
    CoFloats out;
    assert_true(co_values_floats(&value, &pull, &out));
    assert_int_equal(out.components, 3);
    assert_true(out.values[0] == 1.0f && out.values[1] == -2.0f);
    assert_true(out.values[2] == 0x1p-24f && out.values[3] == 65504.0f);
    assert_true(isinf(out.values[4]) && isnan(out.values[5]));
    co_arena_clear(&pull.arena);
}

static void test_other_numbers(void **state)
{
    (void)state;
    CohortPull pull = {.arena = {.tag = CO_MEMORY_DELEGATE}};
    const double doubles[] = {1.5, -2.5};
    const int32_t ints[] = {7};
    const float floats[] = {3.0f};
    CohortValue value = {.type = COHORT_TYPE_DOUBLE2, .count = 1, .data = doubles};
    CoFloats out;
    assert_true(co_values_floats(&value, &pull, &out) && out.values[1] == -2.5f);
    value = (CohortValue){.type = COHORT_TYPE_INT, .count = 1, .data = ints};
    assert_true(co_values_floats(&value, &pull, &out) && out.values[0] == 7.0f);
    value = (CohortValue){.type = COHORT_TYPE_FLOAT, .count = 1, .data = floats};
    assert_true(co_values_floats(&value, &pull, &out) && out.values == floats); // not copied
    value = (CohortValue){.type = COHORT_TYPE_TOKEN, .count = 1};
    assert_false(co_values_floats(&value, &pull, &out));
    value = (CohortValue){.type = COHORT_TYPE_DOUBLE4, .count = SIZE_MAX / 2, .data = doubles};
    assert_false(co_values_floats(&value, &pull, &out));
    co_arena_clear(&pull.arena);
}

static void test_descriptions(void **state)
{
    (void)state;
    char text[32];
    const float color[] = {1.0f, 0.5f, 0.25f, 0.0f, 0.0f, 0.0f};
    CohortValue value = {.type = COHORT_TYPE_COLOR3F, .count = 1, .data = color};
    co_values_describe(&value, text, sizeof text);
    assert_string_equal(text, "1, 0.5, 0.25");
    value.is_array = true;
    value.count = 2;
    co_values_describe(&value, text, sizeof text);
    assert_string_equal(text, "2 elements");
    const CohortString token = {"none", 4};
    value = (CohortValue){.type = COHORT_TYPE_TOKEN, .count = 1, .data = &token};
    co_values_describe(&value, text, sizeof text);
    assert_string_equal(text, "none");
    char tiny[4];
    value = (CohortValue){.type = COHORT_TYPE_COLOR3F, .count = 1, .data = color};
    co_values_describe(&value, tiny, sizeof tiny);
    assert_true(strlen(tiny) < sizeof tiny);
}

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_halves),
        cmocka_unit_test(test_other_numbers),
        cmocka_unit_test(test_descriptions),
        cmocka_unit_test(test_sky_is_bright_above),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
