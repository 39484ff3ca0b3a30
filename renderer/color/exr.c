// Scene-linear pictures through OpenEXR's C API.

#include "cohort/image.h"

#include "base/error.h"
#include "base/memory.h"

#include <openexr.h>

#include <errno.h>
#include <string.h>
#include <unistd.h>

#define TAG CO_MEMORY_COLOR

// Where the library's own words for what went wrong go. The handler is called with the context
// locked: it must not ask the context for its user data, or it waits for itself.
static _Thread_local CohortError *exr_said;

static void exr_error(exr_const_context_t ctx, exr_result_t code, const char *message)
{
    (void)ctx;
    (void)code;
    if (exr_said && !exr_said->message[0])
        snprintf(exr_said->message, sizeof exr_said->message, "%s", message);
}

static bool exr_failed(const char *path, const CohortError *said, CohortErrorCode code,
                       const char *doing, exr_result_t result, CohortError *err)
{
    const char *why = said->message[0] ? said->message : exr_get_default_error_message(result);
    co_error_set(err, CO_HERE, code, "cannot %s %.100s: %.120s", doing, path, why);
    co_error_place(err, path, 0, 0, NULL);
    return false;
}

static exr_result_t set_attribute(exr_context_t ctx, const CohortAttribute *a)
{
    switch (a->type) {
    case COHORT_ATTRIBUTE_STRING:
        return exr_attr_set_string(ctx, 0, a->name, a->text ? a->text : "");
    case COHORT_ATTRIBUTE_INT:
        return exr_attr_set_int(ctx, 0, a->name, a->integer);
    case COHORT_ATTRIBUTE_FLOAT:
        return exr_attr_set_float(ctx, 0, a->name, a->numbers[0]);
    case COHORT_ATTRIBUTE_M44F: {
        exr_attr_m44f_t m;
        memcpy(m.m, a->numbers, sizeof m.m);
        return exr_attr_set_m44f(ctx, 0, a->name, &m);
    }
    case COHORT_ATTRIBUTE_V2F: {
        exr_attr_v2f_t v = {.x = a->numbers[0], .y = a->numbers[1]};
        return exr_attr_set_v2f(ctx, 0, a->name, &v);
    }
    case COHORT_ATTRIBUTE_CHROMATICITIES: {
        const float *n = a->numbers;
        exr_attr_chromaticities_t c = {n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7]};
        return exr_attr_set_chromaticities(ctx, 0, a->name, &c);
    }
    }
    return EXR_ERR_INVALID_ARGUMENT;
}

static exr_compression_t exr_compression(CohortCompression compression)
{
    switch (compression) {
    case COHORT_COMPRESSION_ZIP:
        return EXR_COMPRESSION_ZIP;
    case COHORT_COMPRESSION_ZIPS:
        return EXR_COMPRESSION_ZIPS;
    case COHORT_COMPRESSION_PIZ:
        return EXR_COMPRESSION_PIZ;
    case COHORT_COMPRESSION_RLE:
        return EXR_COMPRESSION_RLE;
    case COHORT_COMPRESSION_NONE:
        break;
    }
    return EXR_COMPRESSION_NONE;
}

static exr_result_t write_header(exr_context_t ctx, const CohortExrDesc *desc)
{
    int part;
    exr_result_t r = exr_add_part(ctx, "", EXR_STORAGE_SCANLINE, &part);
    exr_attr_box2i_t window = {{.x = 0, .y = 0},
                               {.x = (int32_t)desc->width - 1, .y = (int32_t)desc->height - 1}};
    exr_attr_v2f_t center = {.x = 0.0f, .y = 0.0f};
    if (r == EXR_ERR_SUCCESS)
        r = exr_initialize_required_attr(
            ctx, 0, &window, &window, desc->pixel_aspect > 0.0f ? desc->pixel_aspect : 1.0f,
            &center, 1.0f, EXR_LINEORDER_INCREASING_Y, exr_compression(desc->compression));
    for (size_t i = 0; i < desc->channel_count && r == EXR_ERR_SUCCESS; i++) {
        static const exr_pixel_type_t types[] = {EXR_PIXEL_FLOAT, EXR_PIXEL_HALF, EXR_PIXEL_UINT};
        const CohortChannel *c = &desc->channels[i];
        r = exr_add_channel(ctx, 0, c->name, types[c->type], EXR_PERCEPTUALLY_LINEAR, 1, 1);
    }
    for (size_t i = 0; i < desc->attribute_count && r == EXR_ERR_SUCCESS; i++)
        r = set_attribute(ctx, &desc->attributes[i]);
    return r == EXR_ERR_SUCCESS ? exr_write_header(ctx) : r;
}

static const CohortChannel *find_channel(const CohortExrDesc *desc, const char *name)
{
    for (size_t i = 0; i < desc->channel_count; i++)
        if (!strcmp(desc->channels[i].name, name))
            return &desc->channels[i];
    return NULL;
}

// Points the encoder at the rows of one chunk; it reads our floats and converts them itself.
static void aim_encoder(exr_encode_pipeline_t *encoder, const CohortExrDesc *desc, size_t row)
{
    for (int c = 0; c < encoder->channel_count; c++) {
        exr_coding_channel_info_t *info = &encoder->channels[c];
        const CohortChannel *channel = find_channel(desc, info->channel_name);
        size_t line = channel->stride * desc->width;
        info->encode_from_ptr = (const uint8_t *)channel->pixels + row * line;
        info->user_pixel_stride = (int32_t)channel->stride;
        info->user_line_stride = (int32_t)line;
        info->user_bytes_per_element = 4;
        info->user_data_type =
            (uint16_t)(channel->type == COHORT_CHANNEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT);
    }
}

static exr_result_t write_rows(exr_context_t ctx, const CohortExrDesc *desc)
{
    int32_t rows = 1;
    exr_result_t r = exr_get_scanlines_per_chunk(ctx, 0, &rows);
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    bool is_first = true;
    for (int32_t y = 0; y < (int32_t)desc->height && r == EXR_ERR_SUCCESS; y += rows) {
        exr_chunk_info_t chunk = {0};
        r = exr_write_scanline_chunk_info(ctx, 0, y, &chunk);
        if (r == EXR_ERR_SUCCESS)
            r = is_first ? exr_encoding_initialize(ctx, 0, &chunk, &encoder)
                         : exr_encoding_update(ctx, 0, &chunk, &encoder);
        if (r != EXR_ERR_SUCCESS)
            break;
        aim_encoder(&encoder, desc, (size_t)y);
        if (is_first)
            r = exr_encoding_choose_default_routines(ctx, 0, &encoder);
        is_first = false;
        if (r == EXR_ERR_SUCCESS)
            r = exr_encoding_run(ctx, 0, &encoder);
    }
    if (!is_first)
        exr_encoding_destroy(ctx, &encoder);
    return r;
}

// The library must not find these out: it hangs on its own lock after refusing a channel.
static bool check_desc(const CohortExrDesc *desc, CohortError *err)
{
    CO_CHECK(desc->width > 0 && desc->height > 0 && desc->channel_count > 0, err,
             COHORT_ERROR_ARGUMENT, "an EXR needs pixels and channels");
    for (size_t i = 0; i < desc->channel_count; i++) {
        const char *name = desc->channels[i].name;
        CO_CHECK(name[0] && strlen(name) < 32, err, COHORT_ERROR_ARGUMENT,
                 "channel name \"%.64s\" must have 1 to 31 letters", name);
        for (size_t k = 0; k < i; k++)
            CO_CHECK(strcmp(name, desc->channels[k].name) != 0, err, COHORT_ERROR_ARGUMENT,
                     "an EXR cannot have two channels named %.64s", name);
    }
    return true;
}

bool cohort_exr_write(const char *path, const CohortExrDesc *desc, CohortError *err)
{
    if (!check_desc(desc, err))
        return false;
    char partial[4096];
    int length = snprintf(partial, sizeof partial, "%s.partial-%ld", path, (long)getpid());
    CO_CHECK(length > 0 && (size_t)length < sizeof partial, err, COHORT_ERROR_FILE_WRITE,
             "the path of the output file is too long");
    CohortError said = {0};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = exr_error;
    exr_said = &said;
    exr_context_t ctx = NULL;
    exr_result_t r = exr_start_write(&ctx, partial, EXR_WRITE_FILE_DIRECTLY, &init);
    if (r != EXR_ERR_SUCCESS)
        return exr_failed(path, &said, COHORT_ERROR_FILE_WRITE, "write", r, err);
    r = write_header(ctx, desc);
    if (r == EXR_ERR_SUCCESS)
        r = write_rows(ctx, desc);
    exr_result_t closed = exr_finish(&ctx);
    r = r == EXR_ERR_SUCCESS ? closed : r;
    if (r == EXR_ERR_SUCCESS && rename(partial, path) == 0)
        return true;
    if (r == EXR_ERR_SUCCESS)
        snprintf(said.message, sizeof said.message, "%s", strerror(errno));
    unlink(partial);
    return exr_failed(path, &said, COHORT_ERROR_FILE_WRITE, "write", r, err);
}

void cohort_image_clear(CohortImage *image)
{
    size_t pixels = (size_t)image->width * image->height;
    co_free(TAG, image->names, image->channel_count * sizeof *image->names);
    co_free(TAG, image->pixels, image->channel_count * pixels * sizeof(float));
    memset(image, 0, sizeof *image);
}

int cohort_image_channel(const CohortImage *image, const char *name)
{
    for (size_t i = 0; i < image->channel_count; i++)
        if (!strcmp(image->names[i], name))
            return (int)i;
    return -1;
}

static bool alloc_image(const char *path, CohortImage *out, const exr_attr_chlist_t *channels,
                        CohortError *err)
{
    size_t pixels = (size_t)out->width * out->height, bytes;
    out->channel_count = (size_t)channels->num_channels;
    CO_CHECK(out->channel_count > 0 && out->channel_count <= 1024 && pixels <= (size_t)1 << 32 &&
                 co_size_mul(pixels * sizeof(float), out->channel_count, &bytes),
             err, COHORT_ERROR_LIMIT, "%s: %u x %u pixels with %zu channels is too large", path,
             out->width, out->height, out->channel_count);
    out->names = co_alloc_zero(TAG, out->channel_count * sizeof *out->names);
    out->pixels = co_alloc(TAG, bytes);
    CO_CHECK(out->names && out->pixels, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for %s",
             path);
    for (size_t i = 0; i < out->channel_count; i++) {
        const exr_attr_chlist_entry_t *e = &channels->entries[i];
        CO_CHECK(e->x_sampling == 1 && e->y_sampling == 1, err, COHORT_ERROR_IMAGE,
                 "%s: channel %s is subsampled", path, e->name.str);
        snprintf(out->names[i], sizeof out->names[i], "%s", e->name.str);
    }
    return true;
}

static void aim_decoder(exr_decode_pipeline_t *decoder, CohortImage *out, size_t x, size_t row,
                        size_t row_stride)
{
    for (int c = 0; c < decoder->channel_count; c++) {
        exr_coding_channel_info_t *info = &decoder->channels[c];
        int index = cohort_image_channel(out, info->channel_name);
        float *plane = out->pixels + (size_t)index * out->width * out->height;
        info->decode_to_ptr = (uint8_t *)(plane + row * out->width + x);
        info->user_pixel_stride = 4;
        info->user_line_stride = (int32_t)row_stride;
        info->user_bytes_per_element = 4;
        info->user_data_type = EXR_PIXEL_FLOAT;
    }
}

static exr_result_t read_rows(exr_context_t ctx, CohortImage *out, int32_t first)
{
    int32_t rows = 1;
    exr_result_t r = exr_get_scanlines_per_chunk(ctx, 0, &rows);
    exr_decode_pipeline_t decoder = EXR_DECODE_PIPELINE_INITIALIZER;
    bool is_first = true;
    for (int32_t y = 0; y < (int32_t)out->height && r == EXR_ERR_SUCCESS; y += rows) {
        exr_chunk_info_t chunk = {0};
        r = exr_read_scanline_chunk_info(ctx, 0, first + y, &chunk);
        if (r == EXR_ERR_SUCCESS)
            r = is_first ? exr_decoding_initialize(ctx, 0, &chunk, &decoder)
                         : exr_decoding_update(ctx, 0, &chunk, &decoder);
        if (r != EXR_ERR_SUCCESS)
            break;
        aim_decoder(&decoder, out, 0, (size_t)y, out->width * sizeof(float));
        if (is_first)
            r = exr_decoding_choose_default_routines(ctx, 0, &decoder);
        is_first = false;
        if (r == EXR_ERR_SUCCESS)
            r = exr_decoding_run(ctx, 0, &decoder);
    }
    if (!is_first)
        exr_decoding_destroy(ctx, &decoder);
    return r;
}

static bool read_part(exr_context_t ctx, const char *path, const CohortError *said,
                      CohortImage *out, CohortError *err)
{
    exr_storage_t storage;
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *channels = NULL;
    exr_result_t r = exr_get_storage(ctx, 0, &storage);
    r = r == EXR_ERR_SUCCESS ? exr_get_data_window(ctx, 0, &window) : r;
    r = r == EXR_ERR_SUCCESS ? exr_get_channels(ctx, 0, &channels) : r;
    if (r != EXR_ERR_SUCCESS)
        return exr_failed(path, said, COHORT_ERROR_IMAGE, "read", r, err);
    CO_CHECK(storage == EXR_STORAGE_SCANLINE, err, COHORT_ERROR_IMAGE,
             "%s: only scanline EXR files can be compared", path);
    int64_t width = (int64_t)window.max.x - window.min.x + 1;
    int64_t height = (int64_t)window.max.y - window.min.y + 1;
    CO_CHECK(width > 0 && height > 0 && width <= 1 << 20 && height <= 1 << 20, err,
             COHORT_ERROR_IMAGE, "%s: its data window is empty or absurd", path);
    out->width = (uint32_t)width;
    out->height = (uint32_t)height;
    if (!alloc_image(path, out, channels, err))
        return false;
    r = read_rows(ctx, out, window.min.y);
    return r == EXR_ERR_SUCCESS || exr_failed(path, said, COHORT_ERROR_IMAGE, "read", r, err);
}

bool cohort_exr_read(const char *path, CohortImage *out, CohortError *err)
{
    CohortError said = {0};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = exr_error;
    exr_said = &said;
    exr_context_t ctx = NULL;
    CohortImage image = {0};
    exr_result_t r = exr_start_read(&ctx, path, &init);
    if (r != EXR_ERR_SUCCESS)
        return exr_failed(path, &said,
                          access(path, F_OK) ? COHORT_ERROR_FILE_NOT_FOUND : COHORT_ERROR_IMAGE,
                          "read", r, err);
    bool ok = read_part(ctx, path, &said, &image, err);
    exr_finish(&ctx);
    if (ok)
        *out = image;
    else
        cohort_image_clear(&image);
    return ok;
}

const char *cohort_exr_library_version(void)
{
    return OPENEXR_VERSION_STRING;
}
