// Film files: round trip, going on after a load, and refusing everything else by name.

#include "base/hash.h"
#include "base/memory.h"
#include "film/film.h"
#include "support/files.h"

#define AOVS (COHORT_AOV_NORMAL | COHORT_AOV_PRIM_ID)
#define WIDTH 190u // several chunks, the last one not full
#define HEIGHT 130u
#define KEY 0x1234u

static char path[96];

static int make_folder(void **state)
{
    int failed = test_folder_make(state);
    snprintf(path, sizeof path, "%s/film.cohort", test_folder);
    return failed;
}

// Fails if a temporary file was left behind.
static int remove_folder(void **state)
{
    (void)state;
    unlink(path);
    return rmdir(test_folder);
}

static void add_sample(CoFilm *film, uint32_t width, uint32_t height, uint32_t sample)
{
    for (uint32_t pixel = 0; pixel < width * height; pixel++) {
        float v = (float)(co_hash32(pixel * 31 + sample) >> 8) * 0x1p-24f;
        co_film_add_color(film, pixel, sample, co_vec3(v, 1.0f - v, -v));
        co_film_add_alpha(film, pixel, sample, v);
        CoFirstHit hit = {.normal = {v, 0, 0}, .prim_id = (int32_t)sample};
        co_film_add_first(film, pixel, sample, &hit);
    }
}

static CoFilm *make_film(uint32_t samples)
{
    CoFilm *film = co_film_create(WIDTH, HEIGHT, AOVS, 3, NULL);
    assert_non_null(film);
    for (uint32_t sample = 0; sample < samples; sample++)
        add_sample(film, WIDTH, HEIGHT, sample);
    assert_true(co_film_complete(film, samples, NULL));
    return film;
}

static uint64_t film_hash(const CoFilm *film)
{
    static float out[WIDTH * HEIGHT * 4];
    assert_true(co_film_resolve(film, COHORT_AOV_COLOR, out));
    uint64_t hash = co_hash_bytes(out, sizeof out, co_film_samples(film));
    assert_true(co_film_resolve(film, COHORT_AOV_NORMAL, out));
    return co_hash_bytes(out, WIDTH * HEIGHT * 12, hash);
}

static void a_loaded_film_goes_on_like_the_saved_one(void **state)
{
    (void)state;
    CohortError err = {0};
    CoFilm *whole = make_film(5), *part = make_film(3), *other = make_film(1);
    add_sample(part, WIDTH, HEIGHT, 3); // an open round is not saved
    assert_true(co_film_save(part, path, KEY, &err));
    assert_true(co_film_load(other, path, KEY, &err));
    assert_int_equal(co_film_samples(other), 3);
    add_sample(other, WIDTH, HEIGHT, 3);
    add_sample(other, WIDTH, HEIGHT, 4);
    assert_true(co_film_complete(other, 5, NULL));
    assert_true(film_hash(other) == film_hash(whole));
    assert_true(co_film_save(other, path, KEY, &err)); // replaces the file
    assert_true(co_film_load(part, path, KEY, &err));
    assert_true(film_hash(part) == film_hash(whole));
    co_film_destroy(whole);
    co_film_destroy(part);
    co_film_destroy(other);
    assert_int_equal(co_memory_live(CO_MEMORY_FILM), 0);
}

static void refused(CoFilm *film, uint64_t key, const char *text)
{
    CohortError err = {0};
    uint64_t before = film_hash(film);
    assert_false(co_film_load(film, path, key, &err));
    if (!strstr(err.message, text))
        print_message("\"%s\" does not say \"%s\"\n", err.message, text);
    assert_non_null(strstr(err.message, text));
    assert_string_equal(err.file, path);
    assert_true(film_hash(film) == before);
}

static void films_of_something_else_are_refused_by_name(void **state)
{
    (void)state;
    CoFilm *film = make_film(1);
    const struct {
        uint32_t width, height, aovs;
        int unit;
        uint64_t key;
        const char *text;
    } others[] = {
        {WIDTH, HEIGHT, AOVS, 3, KEY + 1, "another stage"},
        {WIDTH, HEIGHT, AOVS, 4, KEY, "units of 2^4"},
        {WIDTH, HEIGHT, COHORT_AOV_NORMAL, 3, KEY, "AOVs"},
        {HEIGHT, WIDTH, AOVS, 3, KEY, "130 x 190 pixels"},
    };
    for (int i = 0; i < 4; i++) {
        CoFilm *other =
            co_film_create(others[i].width, others[i].height, others[i].aovs, others[i].unit, NULL);
        assert_true(co_film_save(other, path, others[i].key, NULL));
        refused(film, KEY, others[i].text);
        co_film_destroy(other);
    }
    co_film_destroy(film);
}

static void damaged_truncated_and_foreign_files_are_refused(void **state)
{
    (void)state;
    CoFilm *film = make_film(2);
    size_t size;
    assert_true(co_film_save(film, path, KEY, NULL));
    unsigned char *bytes = test_read_file(path, &size);
    bytes[size] = 0;
    for (size_t length = 0; length < size; length += length < 80 ? 1 : size / 13) {
        test_write_file(path, bytes, length);
        refused(film, KEY, "truncated");
    }
    for (size_t at = 0; at < size; at += at < 80 ? 1 : size / 17) {
        bytes[at] ^= 0x10;
        test_write_file(path, bytes, size);
        refused(film, KEY, at < 8 ? "no film file" : "");
        bytes[at] ^= 0x10;
    }
    test_write_file(path, bytes, size + 1);
    refused(film, KEY, "after its end");
    free(bytes);
    unlink(path);
    refused(film, KEY, "No such file");
    co_film_destroy(film);
}

static void a_save_that_fails_leaves_the_old_file(void **state)
{
    (void)state;
    CohortError err = {0};
    CoFilm *film = make_film(1);
    uint64_t hash = film_hash(film);
    assert_true(co_film_save(film, path, KEY, &err));
    add_sample(film, WIDTH, HEIGHT, 1);
    co_film_complete(film, 2, NULL);
    co_memory_fail_after(1);
    assert_false(co_film_save(film, path, KEY, &err));
    co_memory_fail_after(0);
    assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
    for (uint64_t n = 1; n <= 2; n++) {
        co_memory_fail_after(n);
        assert_false(co_film_load(film, path, KEY, NULL));
        co_memory_fail_after(0);
    }
    assert_true(co_film_load(film, path, KEY, NULL));
    assert_true(film_hash(film) == hash);
    err = (CohortError){0};
    assert_false(co_film_save(film, "/nonexistent/folder/film", KEY, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    err = (CohortError){0};
    assert_false(co_film_save(film, test_folder, KEY, &err)); // a folder is in the way
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    co_film_destroy(film);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_loaded_film_goes_on_like_the_saved_one),
        cmocka_unit_test(films_of_something_else_are_refused_by_name),
        cmocka_unit_test(damaged_truncated_and_foreign_files_are_refused),
        cmocka_unit_test(a_save_that_fails_leaves_the_old_file),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
