// The folder of converted textures: names, room, publishing; colors on their way in.

#define _GNU_SOURCE // fallocate
#include "texture_support.h"

#include "base/memory.h"
#include "texture/converted.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <time.h>

static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void the_curve_is_that_of_srgb(void **state)
{
    (void)state;
    for (double x = -3; x < 20; x += .01) {
        double linear =
            copysign(fabs(x) <= .04045 ? fabs(x) / 12.92 : pow((fabs(x) + .055) / 1.055, 2.4), x);
        assert_true(fabs((double)co_srgb_decode((float)x) - linear) <= 3e-7 * fabs(linear) + 1e-9);
    }
}

static void colors_are_converted_and_the_rest_is_kept(void **state)
{
    (void)state;
    const CoTexturesOptions options = {0};
    const CoTextureColor srgb = {.space = "sRGB", .options = &options};
    const CoTextureColor raw = {.is_raw = true, .options = &options};
    const CoTextureColor unknown = {.space = "film", .options = &options};
    const float half = co_srgb_decode(.5f);
    for (uint32_t channels = 1; channels <= 6; channels++) {
        float texels[2][6] = {{.5f, .5f, .5f, .5f, .5f, .5f}};
        assert_true(co_texture_to_linear(&srgb, texels[0], 1, channels, NULL));
        uint32_t colors = channels < 3 ? 1 : 3;
        for (uint32_t c = 0; c < 6; c++)
            assert_true(texels[0][c] == (c < colors ? half : .5f));
    }
    float odd[4] = {NAN, INFINITY, -INFINITY, 2};
    assert_true(co_texture_to_linear(&raw, odd, 4, 1, NULL));
    assert_true(odd[0] == 0 && odd[1] == 0 && odd[2] == 0 && odd[3] == 2);
    CohortError err = {0};
    assert_false(co_texture_to_linear(&unknown, odd, 1, 3, &err));
    assert_int_equal(err.code, COHORT_ERROR_COLOR);
    assert_non_null(strstr(err.message, "film"));
}

static void assert_other(const char *a, const CoTextureColor *color, const char *source,
                         uint64_t settings, const char *extension, bool is_other)
{
    char *b;
    CohortError err = {0};
    assert_true(co_converted_path(color, source, settings, extension, &b, &err));
    assert_int_equal(strcmp(a, b) != 0, is_other);
    co_path_free(b);
}

// A name follows from bytes, colors and settings, not from where the source lies.
static void names_tell_what_a_file_was_made_from(void **state)
{
    (void)state;
    const CoTexturesOptions options = {.converted_folder = in_folder("deep/er")};
    const CoTextureColor srgb = {.space = "sRGB", .options = &options};
    const CoTextureColor raw = {.is_raw = true, .options = &options};
    CohortError err = {0};
    char *name, *source = co_path_copy(in_folder("a")), *other = co_path_copy(in_folder("b"));
    write_text(source, "the same");
    write_text(other, "the same");
    assert_true(co_converted_path(&srgb, source, 1, ".exr", &name, &err));
    assert_int_equal(access(options.converted_folder, W_OK), 0);
    assert_other(name, &srgb, source, 1, ".exr", false);
    assert_other(name, &srgb, other, 1, ".exr", false);
    assert_other(name, &raw, source, 1, ".exr", true);
    assert_other(name, &srgb, source, 2, ".exr", true);
    assert_other(name, &srgb, source, 1, ".ptx", true);
    write_text(other, "another");
    assert_other(name, &srgb, other, 1, ".exr", true);
    char *missing;
    assert_false(co_converted_path(&srgb, "/nonexistent", 1, ".exr", &missing, &err));
    co_path_free(name);
    co_path_free(source);
    co_path_free(other);
    rmdir(options.converted_folder);
    rmdir(in_folder("deep"));
}

static void touch_hours_ago(const char *path, int hours)
{
    write_text(path, "");
    const struct timespec past = {.tv_sec = time(NULL) - 3600 * hours};
    const struct timespec times[2] = {past, past};
    assert_int_equal(utimensat(AT_FDCWD, path, times, 0), 0);
}

// What a killed process left goes; finished files, those being written and those of others stay.
static void what_was_left_behind_is_swept(void **state)
{
    (void)state;
    static const char *const names[] = {"0123456789abcdef0123456789abcdef-77-000000001.exr",
                                        "0123456789abcdef0123456789abcdef-78-000000001.exr",
                                        "0123456789abcdef0123456789abcdef.exr",
                                        "mine-77-000000001.exr"};
    static const int hours[] = {2, 0, 2, 2};
    for (int i = 0; i < 4; i++)
        touch_hours_ago(in_folder(names[i]), hours[i]);
    char *temporary;
    assert_true(co_converted_temporary(in_folder("x.exr"), &temporary, NULL));
    co_path_free(temporary);
    for (int i = 0; i < 4; i++)
        assert_int_equal(access(in_folder(names[i]), F_OK) == 0, i > 0);
}

// Root may write into any folder but those of the kernel.
static void folders_that_take_no_files_are_named(void **state)
{
    (void)state;
    char *temporary = NULL;
    CohortError err = {0};
    assert_false(co_converted_temporary("/proc/x.exr", &temporary, &err));
    assert_null(temporary);
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    assert_non_null(strstr(err.message, "folder /proc for"));
    assert_non_null(strstr(err.message, "--converted"));
}

static void files_are_published_in_one_step(void **state)
{
    (void)state;
    char *path = co_path_copy(in_folder("done.exr")), *first, *second;
    CohortError err = {0};
    assert_true(co_converted_temporary(path, &first, &err));
    assert_true(co_converted_temporary(path, &second, &err));
    assert_string_not_equal(first, second);
    write_text(first, "made");
    assert_true(access(path, F_OK) != 0);
    assert_true(co_converted_publish(first, path, &err));
    assert_int_equal(access(path, F_OK), 0);
    assert_true(access(first, F_OK) != 0);
    // Of one that cannot be moved nothing stays.
    write_text(second, "made");
    assert_false(co_converted_publish(second, "/nonexistent/done.exr", &err));
    assert_true(access(second, F_OK) != 0);
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    co_path_free(path);
    co_path_free(first);
    co_path_free(second);
}

// The disk's answer to who asks for blocks, in place of the C library's: 0 lets them be had.
static int answer_of_disk;

int fallocate(int file, int mode, off_t offset, off_t size)
{
    (void)file, (void)mode, (void)offset, (void)size;
    errno = answer_of_disk;
    return answer_of_disk ? -1 : 0;
}

static void room_is_asked_of_disks_that_know(void **state)
{
    (void)state;
    static const int refusals[] = {ENOSPC, EDQUOT, EFBIG};
    for (size_t i = 0; i < sizeof refusals / sizeof refusals[0]; i++) {
        CohortError refused = {0};
        answer_of_disk = refusals[i];
        assert_false(co_converted_room(in_folder("x.exr"), 1000, &refused));
        assert_int_equal(refused.code, COHORT_ERROR_FILE_WRITE);
    }
    answer_of_disk = EOPNOTSUPP; // says nothing
    assert_true(co_converted_room(in_folder("x.exr"), 1000, NULL));
    answer_of_disk = 0;
    CohortError err = {0};
    assert_true(co_converted_room(in_folder("x.exr"), 1000, &err));
    assert_false(co_converted_room(in_folder("x.exr"), SIZE_MAX / 2, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    assert_non_null(strstr(err.message, "--converted"));
    struct statvfs disk;
    if (statvfs("/proc", &disk) || disk.f_blocks > 0)
        skip(); // this system has none that says nothing
    assert_true(co_converted_room("/proc/x.exr", 1000, NULL));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_curve_is_that_of_srgb),
        cmocka_unit_test(colors_are_converted_and_the_rest_is_kept),
        cmocka_unit_test(names_tell_what_a_file_was_made_from),
        cmocka_unit_test(what_was_left_behind_is_swept),
        cmocka_unit_test(folders_that_take_no_files_are_named),
        cmocka_unit_test(files_are_published_in_one_step),
        cmocka_unit_test(room_is_asked_of_disks_that_know),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
