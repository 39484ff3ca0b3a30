#include "stage_fixture.h"

#include "base/error.h"
#include "base/memory.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

StageFixture stage;

static bool skip_word(const char **text, const char *word)
{
    size_t length = strlen(word);
    if (strncmp(*text, word, length) != 0)
        return false;
    *text += length;
    return true;
}

static void write_body(const char *body, FILE *out)
{
    while (*body) {
        if (skip_word(&body, "$triangle")) {
            fputs("int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0,1,2]\n"
                  "point3f[] points = [(0,0,0),(1,0,0),(0,1,0)]\n",
                  out);
        } else if (skip_word(&body, "$at")) {
            int length = (int)strcspn(body, ")") + 1;
            fprintf(out,
                    "double3 xformOp:translate = %.*s\n"
                    "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n",
                    length, body);
            body += length;
        } else {
            // A statement ends at a line's end, also before a brace.
            bool ends = *body == ';' || *body == '}';
            if (ends)
                fputc('\n', out);
            if (*body != ';')
                fputc(*body, out);
            if (*body == '}')
                fputc('\n', out);
            body++;
        }
    }
}

bool try_stage(const char *body, const CohortAdapterOptions *options, CohortError *err)
{
    memset(&stage, 0, sizeof stage);
    fake_reset();
    strcpy(stage.path, "/tmp/cohort_test_XXXXXX.usda");
    int file = mkstemps(stage.path, 5);
    assert_true(file >= 0);
    FILE *out = fdopen(file, "w");
    fputs("#usda 1.0\n", out);
    write_body(body, out);
    fclose(out);
    stage.delegate = cohort_delegate_create(err);
    stage.index = cohort_render_index_create(stage.delegate, err);
    stage.adapter = cohort_adapter_open(stage.delegate, stage.path, options, err);
    return stage.adapter && cohort_adapter_populate(stage.adapter, err) &&
           cohort_render_index_sync(stage.index, err);
}

void open_stage_with(const char *body, const CohortAdapterOptions *options)
{
    CohortError err = {0};
    if (!try_stage(body, options, &err))
        fail_msg("%s", err.message);
}

void open_stage(const char *body)
{
    open_stage_with(body, NULL);
}

int close_stage(void **state)
{
    (void)state;
    cohort_adapter_destroy(stage.adapter);
    cohort_delegate_destroy(stage.delegate);
    unlink(stage.path);
    assert_int_equal(co_memory_live(CO_MEMORY_DELEGATE), 0);
    return 0;
}

void render_stage(uint32_t width, uint32_t height)
{
    CohortRenderBuffer *buffer = cohort_render_buffer_create(stage.delegate, width, height,
                                                             COHORT_FORMAT_FLOAT32_VEC4, NULL);
    CohortRenderPass *pass = cohort_render_pass_create(stage.index, NULL);
    CohortAovBinding binding = {"color", buffer};
    CohortRenderPassState state = cohort_adapter_pass_state(stage.adapter);
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

const CohortInstanceDesc *root_instance(const char *path)
{
    const FakeObject *root = &fake.objects[0], *mesh = fake_mesh(path);
    for (size_t i = 0; mesh && i < root->instance_count; i++)
        if (&fake.objects[root->instances[i].object] == mesh)
            return &root->instances[i];
    return NULL;
}

bool is_at(const CohortInstanceDesc *instance, double x, double y, double z)
{
    const double *origin = instance ? instance->transform[3] : NULL;
    return origin && fabs(origin[0] - x) < 1e-9 && fabs(origin[1] - y) < 1e-9 &&
           fabs(origin[2] - z) < 1e-9;
}

bool is_reported(const char *prim_path, const char *name)
{
    const CohortReportEntry *entries;
    size_t count = cohort_adapter_report(stage.adapter, &entries);
    for (size_t i = 0; i < count; i++)
        if (strcmp(entries[i].prim_path, prim_path) == 0 && strcmp(entries[i].name, name) == 0)
            return true;
    return false;
}
