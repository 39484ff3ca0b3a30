// Render buffers: every format and size, before the first round, mapped and not, and written upside
// down.

#include "delegate_fixture.h"
#include "fake_renderer.h"

#include "pass/render_buffer.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static int setup(void **state)
{
    fake_reset();
    return setup_delegate(state);
}

static const CohortFormat formats[] = {COHORT_FORMAT_FLOAT32, COHORT_FORMAT_FLOAT32_VEC3,
                                       COHORT_FORMAT_FLOAT32_VEC4, COHORT_FORMAT_INT32};
enum {
    FORMATS = sizeof formats / sizeof *formats
};

static CohortRenderBuffer *create(uint32_t width, uint32_t height, CohortFormat format)
{
    CohortError err = {0};
    CohortRenderBuffer *buffer = cohort_render_buffer_create(delegate, width, height, format, &err);
    if (!buffer)
        fail_msg("%s", err.message);
    return buffer;
}

static void test_every_format_begins_at_zero(void **state)
{
    (void)state;
    static const unsigned char zeros[3 * 5 * 16];
    for (int i = 0; i < FORMATS; i++) {
        CohortRenderBuffer *buffer = create(3, 5, formats[i]);
        assert_int_equal(cohort_render_buffer_width(buffer), 3);
        assert_int_equal(cohort_render_buffer_height(buffer), 5);
        assert_int_equal(cohort_render_buffer_format(buffer), formats[i]);
        cohort_render_buffer_resolve(buffer); // before the first round: nothing to resolve
        assert_memory_equal(cohort_render_buffer_map(buffer), zeros,
                            15 * cohort_format_size(formats[i]));
        assert_true(cohort_render_buffer_is_mapped(buffer));
        assert_false(cohort_render_buffer_is_converged(buffer));
        cohort_render_buffer_destroy(buffer); // also while it is mapped
    }
    cohort_render_buffer_destroy(NULL);
}

static void test_sizes_and_formats_are_checked(void **state)
{
    (void)state;
    static const struct {
        uint32_t width, height;
        CohortFormat format;
    } bad[] = {{0, 4, COHORT_FORMAT_FLOAT32},
               {4, 0, COHORT_FORMAT_FLOAT32},
               {0, 0, COHORT_FORMAT_FLOAT32},
               {65537, 1, COHORT_FORMAT_INT32},
               {1, UINT32_MAX, COHORT_FORMAT_INT32},
               {4, 4, COHORT_FORMAT_NONE},
               {4, 4, (CohortFormat)77}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        CohortError err = {0};
        assert_null(cohort_render_buffer_create(delegate, bad[i].width, bad[i].height,
                                                bad[i].format, &err));
        assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
        assert_true(err.message[0]);
    }
    cohort_render_buffer_destroy(create(65536, 1, COHORT_FORMAT_FLOAT32_VEC3));
}

static void test_failing_memory_makes_no_buffer(void **state)
{
    (void)state;
    size_t live = co_memory_live(CO_MEMORY_DELEGATE);
    for (uint64_t n = 1; n <= 3; n++) {
        CohortError err = {0};
        co_memory_fail_after(n);
        assert_null(cohort_render_buffer_create(delegate, 4, 4, COHORT_FORMAT_FLOAT32, &err));
        co_memory_fail_after(0);
        assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        assert_int_equal(co_memory_live(CO_MEMORY_DELEGATE), live);
    }
}

static void test_clearing_takes_the_value_of_the_aov(void **state)
{
    (void)state;
    const CohortAovDescriptor *aovs;
    size_t count = cohort_aov_descriptors(&aovs);
    for (size_t i = 0; i < count; i++) {
        CohortRenderBuffer *buffer = create(2, 3, aovs[i].format);
        co_render_buffer_clear(buffer, aovs[i].aov);
        const char *pixels = cohort_render_buffer_map(buffer);
        size_t size = cohort_format_size(aovs[i].format);
        const int32_t id = -1;
        const void *value =
            aovs[i].format == COHORT_FORMAT_INT32 ? (const void *)&id : (const void *)aovs[i].clear;
        for (size_t p = 0; p < 6; p++)
            assert_memory_equal(pixels + p * size, value, size);
        cohort_render_buffer_unmap(buffer);
        cohort_render_buffer_destroy(buffer);
    }
}

// ---- Written by a render ------------------------------------------------------------------------

static CohortRender *render_of(uint32_t width, uint32_t height)
{
    const CohortRenderSettings settings = {.width = width, .height = height};
    return cohort_render_create(NULL, &settings, NULL);
}

// The fake renderer's rows hold their number from the top; Hydra's first row is the lowest.
static void assert_flipped(const CohortRenderBuffer *buffer, const void *pixels)
{
    size_t size = cohort_format_size(buffer->format), row = size * buffer->width;
    for (uint32_t y = 0; y < buffer->height; y++)
        for (size_t i = 0; i < row; i += 4) {
            int32_t id;
            float value;
            memcpy(&id, (const char *)pixels + y * row + i, 4);
            memcpy(&value, &id, 4);
            float expected = (float)(buffer->height - 1 - y);
            assert_true(buffer->format == COHORT_FORMAT_INT32 ? (float)id == expected
                                                              : value == expected);
        }
}

static void test_rows_are_turned_over(void **state)
{
    (void)state;
    static const CohortAov aovs[FORMATS] = {COHORT_AOV_DEPTH, COHORT_AOV_NORMAL, COHORT_AOV_COLOR,
                                            COHORT_AOV_PRIM_ID};
    static const uint32_t sizes[][2] = {{1, 1}, {3, 1}, {1, 2}, {2, 5}, {7, 6}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int i = 0; i < FORMATS; i++) {
            CohortRender *render = render_of(sizes[s][0], sizes[s][1]);
            CohortRenderBuffer *buffer = create(sizes[s][0], sizes[s][1], formats[i]);
            assert_true(co_render_buffer_write(buffer, render, aovs[i], true));
            assert_flipped(buffer, cohort_render_buffer_map(buffer));
            assert_true(cohort_render_buffer_is_converged(buffer));
            co_render_buffer_clear(buffer, aovs[i]);
            assert_false(cohort_render_buffer_is_converged(buffer)); // it begins anew
            cohort_render_buffer_destroy(buffer);
            cohort_render_destroy(render);
        }
}

static void test_maps_keep_what_they_gave(void **state)
{
    (void)state;
    CohortRender *render = render_of(2, 2);
    CohortRenderBuffer *buffer = create(2, 2, COHORT_FORMAT_FLOAT32);
    const float *first = cohort_render_buffer_map(buffer);
    assert_true(co_render_buffer_write(buffer, render, COHORT_AOV_DEPTH, false));
    cohort_render_buffer_resolve(buffer);                      // not while it is mapped
    assert_ptr_equal(cohort_render_buffer_map(buffer), first); // nor by a second map
    assert_true(first[0] == 0.0f);
    cohort_render_buffer_unmap(buffer);
    assert_true(cohort_render_buffer_is_mapped(buffer));
    cohort_render_buffer_unmap(buffer);
    assert_false(cohort_render_buffer_is_mapped(buffer));
    cohort_render_buffer_resolve(buffer);
    const float *second = cohort_render_buffer_map(buffer);
    assert_true(second[0] == 1.0f && second[2] == 0.0f);
    cohort_render_buffer_resolve(buffer); // nothing newer
    assert_ptr_equal(cohort_render_buffer_map(buffer), second);
    cohort_render_destroy(render);
}

static void test_buffers_are_destroyed_in_any_order(void **state)
{
    (void)state;
    CohortRenderBuffer *buffers[5];
    static const int order[] = {2, 0, 4};
    for (int i = 0; i < 5; i++)
        buffers[i] = create(1, 1, COHORT_FORMAT_INT32);
    for (int i = 0; i < 3; i++)
        cohort_render_buffer_destroy(buffers[order[i]]);
    assert_int_equal(cohort_render_buffer_width(buffers[1]), 1); // the rest goes with the delegate
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_every_format_begins_at_zero, setup, teardown_delegate),
        cmocka_unit_test_setup_teardown(test_sizes_and_formats_are_checked, setup,
                                        teardown_delegate),
        cmocka_unit_test_setup_teardown(test_failing_memory_makes_no_buffer, setup,
                                        teardown_delegate),
        cmocka_unit_test_setup_teardown(test_clearing_takes_the_value_of_the_aov, setup,
                                        teardown_delegate),
        cmocka_unit_test_setup_teardown(test_rows_are_turned_over, setup, teardown_delegate),
        cmocka_unit_test_setup_teardown(test_maps_keep_what_they_gave, setup, teardown_delegate),
        cmocka_unit_test_setup_teardown(test_buffers_are_destroyed_in_any_order, setup,
                                        teardown_delegate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
