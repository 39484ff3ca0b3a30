#include "stage_fixture.h"

#include "base/error.h"
#include "base/memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

bool stage_fixture_open(StageFixture *f, const char *body, const CohortAdapterOptions *options,
                        CohortError *err)
{
    memset(f, 0, sizeof *f);
    fake_reset();
    strcpy(f->path, "/tmp/cohort_test_XXXXXX.usda");
    int file = mkstemps(f->path, 5);
    assert_true(file >= 0);
    FILE *out = fdopen(file, "w");
    fputs("#usda 1.0\n", out);
    for (; *body; body++) {
        if (*body == '}')
            fputc('\n', out); // a statement ends at a line end, also before a brace
        fputc(*body, out);
    }
    fclose(out);
    f->delegate = cohort_delegate_create(err);
    f->index = cohort_render_index_create(f->delegate, err);
    f->adapter = cohort_adapter_open(f->delegate, f->path, options, err);
    return f->adapter && cohort_adapter_populate(f->adapter, err) &&
           cohort_render_index_sync(f->index, err);
}

void stage_fixture_close(StageFixture *f)
{
    cohort_adapter_destroy(f->adapter);
    cohort_delegate_destroy(f->delegate);
    unlink(f->path);
    assert_int_equal(co_memory_live(CO_MEMORY_DELEGATE), 0);
}

void stage_fixture_render(StageFixture *f, uint32_t width, uint32_t height)
{
    CohortRenderBuffer *buffer =
        cohort_render_buffer_create(f->delegate, width, height, COHORT_FORMAT_FLOAT32_VEC4, NULL);
    CohortRenderPass *pass = cohort_render_pass_create(f->index, NULL);
    CohortAovBinding binding = {"color", buffer};
    CohortRenderPassState state = cohort_adapter_pass_state(f->adapter);
    state.bindings = &binding;
    state.binding_count = 1;
    assert_true(cohort_render_pass_execute(pass, &state, NULL));
    assert_true(cohort_render_pass_wait(pass, 10.0));
    cohort_render_pass_destroy(pass);
    cohort_render_buffer_destroy(buffer);
}

const FakeObject *fake_mesh(const char *path)
{
    for (uint32_t i = 0; i < fake.object_count && i < FAKE_MAX; i++)
        if (fake.objects[i].is_mesh && strcmp(fake.objects[i].path, path) == 0)
            return &fake.objects[i];
    return NULL;
}

bool stage_fixture_reports(StageFixture *f, const char *prim_path, const char *name)
{
    const CohortReportEntry *entries;
    size_t count = cohort_adapter_report(f->adapter, &entries);
    for (size_t i = 0; i < count; i++)
        if (strcmp(entries[i].prim_path, prim_path) == 0 && strcmp(entries[i].name, name) == 0)
            return true;
    return false;
}
