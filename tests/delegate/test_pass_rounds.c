// What complete rounds give: a callback, films to go on from, pixels that stay while they are
// mapped.

#include "pass_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <string.h>

#include <cmocka.h>

static atomic_int rounds_seen, done_seen;
static bool saved_from_callback;

static void on_round(void *cookie, const CohortRoundInfo *info)
{
    (void)cookie;
    atomic_fetch_add(&rounds_seen, 1);
    if (info->is_done)
        atomic_fetch_add(&done_seen, 1);
    const float *pixels = cohort_render_buffer_map(color);
    if (pixels[0] != 2.0f + 100.0f * (float)info->round)
        atomic_fetch_add(&done_seen, 100);
    cohort_render_buffer_unmap(color);
    if (info->round == 2)
        saved_from_callback = cohort_render_pass_save(pass, "/film", 7, NULL);
}

static void test_round_callback(void **state)
{
    (void)state;
    atomic_store(&rounds_seen, 0);
    atomic_store(&done_seen, 0);
    saved_from_callback = false;
    cohort_delegate_set_round_callback(delegate, on_round, NULL);
    execute_pass();
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_int_equal(atomic_load(&rounds_seen), 3);
    assert_int_equal(atomic_load(&done_seen), 1);
    assert_true(saved_from_callback);
}

static void test_save_and_resume_from_file(void **state)
{
    (void)state;
    CohortError err = {0};
    assert_false(cohort_render_pass_save(pass, "/film", 7, &err));
    fake.round_nanoseconds = 10000000;
    execute_pass();
    assert_true(cohort_render_pass_save(pass, "/film", 7, NULL)); // waits for the round
    assert_false(cohort_render_pass_save(pass, "film", 7, &err));
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_true(cohort_render_pass_save(pass, "/film", 7, NULL));
    assert_int_equal(fake.saves, 2);
    pass_state.resume_file = "/film";
    pass_state.stage_hash = 6;
    err = (CohortError){0};
    assert_false(cohort_render_pass_execute(pass, &pass_state, &err));
    assert_int_equal(err.code, COHORT_ERROR_SCENE);
    pass_state.stage_hash = 7;
    execute_pass();
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_int_equal(fake.resumes, 1);
}

static bool goes_on(void)
{
    bool ok = cohort_render_pass_execute(pass, &pass_state, NULL);
    cohort_render_pass_wait(pass, 10.0);
    return ok;
}

static void test_films_of_other_settings_are_refused(void **state)
{
    (void)state;
    execute_pass();
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_true(cohort_render_pass_save(pass, "/film", 0, NULL));
    pass_state.resume_file = "/film";
    assert_true(goes_on());
    const struct {
        const char *key;
        int64_t other, same;
    } numbers[] = {{"cohort:complexity", 3, 2},
                   {"cohort:ptexReductionsAuthored", 1, 0},
                   {"enableSceneLights", 0, 1}};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        assert_true(cohort_delegate_set_int(delegate, numbers[i].key, numbers[i].other, NULL));
        assert_false(goes_on());
        assert_true(cohort_delegate_set_int(delegate, numbers[i].key, numbers[i].same, NULL));
        assert_true(goes_on());
    }
    const char *const texts[] = {"cohort:renderingColorSpace", "cohort:ocioConfig"};
    for (size_t i = 0; i < 2; i++) {
        assert_true(cohort_delegate_set_string(delegate, texts[i], "other", NULL));
        assert_false(goes_on());
        assert_true(cohort_delegate_set_string(delegate, texts[i], "", NULL));
        assert_true(goes_on());
    }
    pass_state.conform = COHORT_CONFORM_CROP_APERTURE;
    assert_false(goes_on());
    pass_state.conform = COHORT_CONFORM_EXPAND_APERTURE;
    pass_state.pixel_aspect_ratio = 2.0;
    assert_false(goes_on());
    pass_state.pixel_aspect_ratio = 0.0;
    pass_state.disable_depth_of_field = true;
    assert_false(goes_on());
    pass_state.disable_depth_of_field = false;
    // When to stop, and how, is not in the film.
    assert_true(cohort_delegate_set_int(delegate, "cohort:spp", 99, NULL));
    assert_true(cohort_delegate_set_double(delegate, "cohort:noise", 0.5, NULL));
    assert_true(cohort_delegate_set_double(delegate, "cohort:timeLimit", 9.0, NULL));
    assert_true(cohort_delegate_set_int(delegate, "cohort:batch", 1024, NULL));
    assert_true(goes_on());
}

static void test_mapped_pixels_stay(void **state)
{
    (void)state;
    fake.round_nanoseconds = 3000000;
    execute_pass();
    const float *pixels = cohort_render_buffer_map(color);
    float before = pixels[0];
    assert_true(cohort_render_buffer_is_mapped(color));
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_true(pixels[0] == before);
    assert_ptr_equal(cohort_render_buffer_map(color), pixels); // nested: still the same image
    cohort_render_buffer_unmap(color);
    cohort_render_buffer_unmap(color);
    cohort_render_buffer_unmap(color); // one too many is harmless
    cohort_render_buffer_resolve(color);
    pixels = cohort_render_buffer_map(color);
    assert_true(pixels[0] == 302.0f);
    cohort_render_buffer_unmap(color);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_round_callback, setup_pass, teardown_pass),
        cmocka_unit_test_setup_teardown(test_save_and_resume_from_file, setup_pass, teardown_pass),
        cmocka_unit_test_setup_teardown(test_films_of_other_settings_are_refused, setup_pass,
                                        teardown_pass),
        cmocka_unit_test_setup_teardown(test_mapped_pixels_stay, setup_pass, teardown_pass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
