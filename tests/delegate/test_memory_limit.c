// A limit of memory holds for the whole process: resident at its peak, and in a cgroup of that
// size.

#include "cohort/stage_adapter.h"

#include "base/hash.h"
#include "support/cgroup.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

// Sanitizers have memory of their own, which no limit of ours covers.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define IS_SANITIZED true
#elif defined(__has_feature)
#define IS_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define IS_SANITIZED false
#endif

enum {
    WIDTH = 64,
    HEIGHT = 48
};

typedef struct Outcome {
    bool is_done;
    uint64_t hash;
    char message[256];
    size_t peak_bytes; // as the parent sees it
} Outcome;

static const char *stage_path;

static bool run_pass(CohortDelegate *delegate, CohortRenderIndex *index, CohortAdapter *adapter,
                     Outcome *out, CohortError *err)
{
    CohortRenderBuffer *color =
        cohort_render_buffer_create(delegate, WIDTH, HEIGHT, COHORT_FORMAT_FLOAT32_VEC4, err);
    CohortRenderPass *pass = cohort_render_pass_create(index, err);
    CohortAovBinding binding = {"color", color};
    CohortRenderPassState state = cohort_adapter_pass_state(adapter);
    state.bindings = &binding;
    state.binding_count = 1;
    if (!cohort_render_pass_execute(pass, &state, err) || !cohort_render_pass_wait(pass, -1.0) ||
        cohort_render_pass_error(pass, err))
        return false;
    const void *pixels = cohort_render_buffer_map(color);
    out->hash = co_hash_bytes(pixels, WIDTH * HEIGHT * 4 * sizeof(float), 0);
    cohort_render_buffer_unmap(color);
    return true;
}

static void render(const void *context, void *result)
{
    const int64_t memory = *(const int64_t *)context;
    Outcome out = {0};
    CohortError err = {0};
    CohortDelegate *delegate = cohort_delegate_create(&err);
    CohortRenderIndex *index = cohort_render_index_create(delegate, &err);
    cohort_delegate_set_int(delegate, "cohort:spp", 8, &err);
    cohort_delegate_set_int(delegate, "cohort:threads", 2, &err);
    cohort_delegate_set_int(delegate, "cohort:memory", memory, &err);
    CohortAdapter *adapter = cohort_adapter_open(delegate, stage_path, NULL, &err);
    out.is_done = adapter && cohort_adapter_populate(adapter, &err) &&
                  run_pass(delegate, index, adapter, &out, &err);
    memcpy(out.message, err.message, sizeof out.message);
    cohort_adapter_destroy(adapter);
    cohort_delegate_destroy(delegate);
    memcpy(result, &out, sizeof out);
}

// In a child, for its peak is its own; `folder`: the cgroup it enters, or NULL.
static Outcome render_in_child(int64_t memory, const char *folder)
{
    Outcome out = {0};
    size_t peak = 0;
    bool is_sound = test_in_child(folder, render, &memory, &out, sizeof out, &peak);
    out.is_done = out.is_done && is_sound;
    out.peak_bytes = peak;
    return out;
}

// What a render refused for lack of memory says it needs.
static int64_t needed(void)
{
    Outcome refused = render_in_child(1 << 20, NULL);
    assert_false(refused.is_done);
    const char *number = strstr(refused.message, "at least ");
    if (!number)
        fail_msg("\"%s\" does not say what is needed", refused.message);
    return (int64_t)strtol(number + 9, NULL, 10) << 20;
}

static void a_limit_holds_and_changes_no_pixel(void **state)
{
    (void)state;
    if (IS_SANITIZED)
        skip();
    int64_t limit = needed() + (4 << 20);
    Outcome free_run = render_in_child(0, NULL), tight = render_in_child(limit, NULL);
    assert_true(free_run.is_done && tight.is_done);
    assert_int_equal(tight.hash, free_run.hash);
    if (tight.peak_bytes > (size_t)limit)
        fail_msg("%zu MB resident of %lld allowed", tight.peak_bytes >> 20,
                 (long long)(limit >> 20));
}

static void a_limit_holds_in_a_cgroup(void **state)
{
    (void)state;
    char folder[600];
    if (IS_SANITIZED)
        skip();
    int64_t limit = needed() + (4 << 20);
    if (!test_cgroup_make(folder, sizeof folder, (long long)limit))
        skip();
    Outcome tight = render_in_child(limit, folder);
    test_cgroup_remove(folder);
    assert_true(tight.is_done);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_limit_holds_and_changes_no_pixel),
        cmocka_unit_test(a_limit_holds_in_a_cgroup),
    };
    stage_path = COHORT_EXAMPLES_DIR "/stages/everything.usda";
    return cmocka_run_group_tests(tests, NULL, NULL);
}
