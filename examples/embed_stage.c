// Renders a stage through the delegate, as a host would: the stage's own camera and resolution, one
// buffer, one call that starts the render and none that drives it.
//
// cc embed_stage.c $(pkg-config --cflags --libs cohort); base.h says how the module that reads
// images is found. usage: embed_stage STAGE.usda OUT.exr [SAMPLES]

#include "cohort/image.h"
#include "cohort/stage_adapter.h"

#include <stdio.h>
#include <stdlib.h>

// Buffers have row 0 at the bottom, pictures at the top: the rows are written in reverse.
static bool write_picture(const char *path, CohortRenderBuffer *buffer, CohortError *err)
{
    size_t width = cohort_render_buffer_width(buffer), height = cohort_render_buffer_height(buffer);
    size_t row = width * 4;
    const float *from = cohort_render_buffer_map(buffer);
    float *pixels = malloc(row * height * sizeof *pixels);
    for (size_t i = 0; pixels && i < row * height; i++)
        pixels[i] = from[(height - 1 - i / row) * row + i % row];
    cohort_render_buffer_unmap(buffer);
    if (!pixels)
        return false;
    const CohortChannel channels[] = {{"R", COHORT_CHANNEL_HALF, pixels, 4 * sizeof *pixels},
                                      {"G", COHORT_CHANNEL_HALF, pixels + 1, 4 * sizeof *pixels},
                                      {"B", COHORT_CHANNEL_HALF, pixels + 2, 4 * sizeof *pixels},
                                      {"A", COHORT_CHANNEL_HALF, pixels + 3, 4 * sizeof *pixels}};
    CohortExrDesc desc = {.width = (uint32_t)width,
                          .height = (uint32_t)height,
                          .channels = channels,
                          .channel_count = 4};
    bool ok = cohort_exr_write(path, &desc, err);
    free(pixels);
    return ok;
}

static bool render(CohortDelegate *delegate, CohortAdapter *adapter, CohortRenderIndex *index,
                   const char *out, CohortError *err)
{
    CohortResolvedSettings settings;
    if (!cohort_adapter_populate(adapter, err))
        return false;
    cohort_adapter_settings(adapter, &settings);
    CohortRenderBuffer *color = cohort_render_buffer_create(
        delegate, settings.width, settings.height, COHORT_FORMAT_FLOAT32_VEC4, err);
    CohortRenderPass *pass = cohort_render_pass_create(index, err);
    CohortAovBinding binding = {"color", color};
    CohortRenderPassState state = cohort_adapter_pass_state(adapter);
    state.bindings = &binding;
    state.binding_count = 1;
    return color && pass && cohort_render_pass_execute(pass, &state, err) &&
           cohort_render_pass_wait(pass, -1.0) && !cohort_render_pass_error(pass, err) &&
           write_picture(out, color, err);
}

int main(int argc, char **argv)
{
    if (argc < 3) {
        fprintf(stderr, "usage: %s STAGE.usda OUT.exr [SAMPLES]\n", argv[0]);
        return 2;
    }
    CohortError err = {0};
    CohortDelegate *delegate = cohort_delegate_create(&err);
    CohortRenderIndex *index = delegate ? cohort_render_index_create(delegate, &err) : NULL;
    CohortAdapter *adapter = index ? cohort_adapter_open(delegate, argv[1], NULL, &err) : NULL;
    bool ok = adapter &&
              cohort_delegate_set_int(delegate, "cohort:spp", argc > 3 ? atoi(argv[3]) : 16, &err);
    ok = ok && render(delegate, adapter, index, argv[2], &err);
    if (!ok)
        fprintf(stderr, "%s: %s\n", argv[1], err.message);
    if (adapter)
        cohort_adapter_destroy(adapter);
    if (delegate)
        cohort_delegate_destroy(delegate);
    return ok ? 0 : 1;
}
