// Converted images: levels, numbers of tiles, texels of a tile, and what is refused.

#include "texture_support.h"

#include "base/memory.h"
#include "shims/oiio.h"
#include "texture/image_file.h"

enum {
    WIDTH = 150,
    HEIGHT = 70,
    CHANNELS = 3
};

static void write_random(const char *path, uint64_t seed, uint32_t tile)
{
    static float texels[HEIGHT * WIDTH * CHANNELS];
    CohortError err = {0};
    for (uint32_t i = 0; i < HEIGHT * WIDTH * CHANNELS; i++)
        texels[i] = random_at(seed, i);
    const CoOiioInfo info = {.width = WIDTH, .height = HEIGHT, .channels = CHANNELS};
    if (!co_oiio_write_mips(path, &info, texels, tile, &err))
        fail_msg("%s", err.message);
}

static void tiles_are_numbered_level_after_level(void **state)
{
    (void)state;
    CohortError err = {0};
    write_random(in_folder("a.exr"), 1, CO_IMAGE_TILE);
    CoImageFile *image = co_image_open(in_folder("a.exr"), &err);
    assert_non_null(image);
    assert_int_equal(image->channels, CHANNELS);
    assert_int_equal(image->level_count, 8); // 150, 75, 37, 18, 9, 4, 2, 1
    assert_int_equal(image->levels[0].across, 3);
    assert_int_equal(image->levels[0].down, 2);
    uint32_t first = 0;
    for (uint32_t i = 0; i < image->level_count; i++) {
        const CoImageLevel *level = &image->levels[i];
        assert_int_equal(level->first, first);
        assert_int_equal(level->width, WIDTH >> i ? WIDTH >> i : 1);
        assert_int_equal(level->height, HEIGHT >> i ? HEIGHT >> i : 1);
        first += level->across * level->down;
    }
    assert_int_equal(image->tile_count, first);
    co_image_close(image);
}

static void a_tile_holds_its_texels(void **state)
{
    (void)state;
    static float out[CO_IMAGE_TILE][CO_IMAGE_TILE][CHANNELS];
    CoImageFile *image = co_image_open(in_folder("a.exr"), NULL);
    CoImageReader reader = {0};
    CoBlockCount count = {.batch = 1};
    for (uint32_t tile = 0; tile < 6; tile++) {
        assert_true(co_image_tile_read(&reader, image, tile, &count, out[0][0]));
        uint32_t x0 = tile % 3 * CO_IMAGE_TILE, y0 = tile / 3 * CO_IMAGE_TILE;
        for (uint32_t y = 0; y < CO_IMAGE_TILE && y0 + y < HEIGHT; y++)
            for (uint32_t x = 0; x < CO_IMAGE_TILE && x0 + x < WIDTH; x++)
                for (uint32_t c = 0; c < CHANNELS; c++)
                    assert_true(out[y][x][c] ==
                                random_at(1, ((y0 + y) * WIDTH + x0 + x) * CHANNELS + c));
    }
    // The last level is the mean of all, each row and column once.
    double mean = 0.0;
    for (uint32_t i = 0; i < HEIGHT * WIDTH; i++)
        mean += (double)random_at(1, i * CHANNELS) / (HEIGHT * WIDTH);
    assert_true(co_image_tile_read(&reader, image, image->tile_count - 1, &count, out[0][0]));
    assert_true((double)out[0][0][0] > mean - .03 && (double)out[0][0][0] < mean + .03);
    assert_int_equal(count.read, 7);
    assert_int_equal(count.twice, 0);
    assert_true(co_image_tile_read(&reader, image, 0, &count, out[0][0]));
    assert_int_equal(count.twice, 1);
    co_image_reader_clear(&reader);
    co_image_close(image);
}

// More files than handles: what was closed for others is opened again.
static void handles_are_shared_by_many_files(void **state)
{
    (void)state;
    enum {
        FILES = CO_IMAGE_HANDLES + 3
    };
    static float out[CO_IMAGE_TILE * CO_IMAGE_TILE * CHANNELS];
    CoImageFile *images[FILES];
    CoImageReader reader = {0};
    char name[16];
    for (uint64_t i = 0; i < FILES; i++) {
        snprintf(name, sizeof name, "h%d.exr", (int)i);
        write_random(in_folder(name), 100 + i, CO_IMAGE_TILE);
        images[i] = co_image_open(in_folder(name), NULL);
        assert_non_null(images[i]);
    }
    for (int round = 0; round < 2; round++)
        for (uint64_t i = 0; i < FILES; i++) {
            assert_true(co_image_tile_read(&reader, images[i], 0, NULL, out));
            assert_true(out[1] == random_at(100 + i, 1));
        }
    co_image_reader_clear(&reader);
    for (int i = 0; i < FILES; i++)
        co_image_close(images[i]);
    assert_int_equal(co_memory_live(CO_MEMORY_TEXTURE), 0);
}

static void other_files_are_refused(void **state)
{
    (void)state;
    CohortError err = {0}, missing = {0}, text = {0};
    write_random(in_folder("tiles.exr"), 2, 32);
    assert_null(co_image_open(in_folder("tiles.exr"), &err));
    assert_int_equal(err.code, COHORT_ERROR_TEXTURE);
    assert_non_null(strstr(err.message, "tiles of 32"));
    assert_null(co_image_open(in_folder("none.exr"), &missing));
    assert_int_equal(missing.code, COHORT_ERROR_TEXTURE);
    FILE *file = fopen(in_folder("text.exr"), "w");
    fputs("text", file);
    fclose(file);
    assert_null(co_image_open(in_folder("text.exr"), &text));
    assert_int_equal(text.code, COHORT_ERROR_TEXTURE);
    co_image_close(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiles_are_numbered_level_after_level),
        cmocka_unit_test(a_tile_holds_its_texels),
        cmocka_unit_test(handles_are_shared_by_many_files),
        cmocka_unit_test(other_files_are_refused),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
