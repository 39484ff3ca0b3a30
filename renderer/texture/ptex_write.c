#include "texture/ptex_write.h"

#include "base/error.h"
#include "base/memory.h"
#include "texture/converted.h"
#include "texture/ptex_encode.h"

#include <string.h>
#include <unistd.h>

// What is stored of one face: blocks of levels 0 .. level_count - 1.
typedef struct Stored {
    uint64_t offset[CO_PTEX_LEVELS]; // in the scratch file
    uint32_t header[CO_PTEX_LEVELS]; // size and encoding
    uint8_t level_count;
    bool is_written;
} Stored;

struct CoPtexWriter {
    CoPtexWriteDesc desc;
    char *path;
    CoPtexFace *faces;
    unsigned char *constants;
    Stored *stored;
    FILE *scratch; // blocks, in the order of the calls
    uint64_t scratch_size;
    CoPtexEncoder encoder;
    bool has_failed;
};

static size_t pixel_size(const CoPtexWriteDesc *desc)
{
    return (size_t)co_ptex_type_size(desc->type) * desc->channels;
}

static void destroy(CoPtexWriter *writer)
{
    size_t count = writer->desc.face_count;
    co_free(CO_MEMORY_TEXTURE, writer->faces, count * sizeof *writer->faces);
    co_free(CO_MEMORY_TEXTURE, writer->constants, count * pixel_size(&writer->desc));
    co_free(CO_MEMORY_TEXTURE, writer->stored, count * sizeof *writer->stored);
    co_ptex_encoder_clear(&writer->encoder);
    co_path_free(writer->path);
    if (writer->scratch)
        fclose(writer->scratch);
    co_free(CO_MEMORY_TEXTURE, writer, sizeof *writer);
}

CoPtexWriter *co_ptex_writer_create(const char *path, const CoPtexWriteDesc *desc, CohortError *err)
{
    CO_CHECK_NULL(desc->face_count >= 1 && desc->face_count <= INT32_MAX && desc->channels >= 1 &&
                      desc->channels <= UINT16_MAX && desc->type <= CO_PTEX_F32 &&
                      (!desc->has_alpha || desc->alpha < desc->channels) && desc->zlib_level <= 12,
                  err, COHORT_ERROR_ARGUMENT, "a Ptex file of %u faces and %u channels",
                  desc->face_count, desc->channels);
    CoPtexWriter *writer = co_alloc_zero(CO_MEMORY_TEXTURE, sizeof *writer);
    CO_CHECK_NULL(writer, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    writer->desc = *desc;
    size_t count = desc->face_count;
    writer->path = co_path_copy(path);
    writer->faces = co_alloc_zero(CO_MEMORY_TEXTURE, count * sizeof *writer->faces);
    writer->constants = co_alloc_zero(CO_MEMORY_TEXTURE, count * pixel_size(desc));
    writer->stored = co_alloc_zero(CO_MEMORY_TEXTURE, count * sizeof *writer->stored);
    writer->scratch = tmpfile();
    bool ok = writer->path && writer->faces && writer->constants && writer->stored;
    if (!ok)
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    else if (!writer->scratch)
        ok = CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "cannot create a scratch file");
    ok = ok && co_ptex_encoder_init(&writer->encoder, desc, err);
    if (!ok) {
        destroy(writer);
        return NULL;
    }
    for (size_t i = 0; i < count; i++) {
        writer->faces[i].flags = CO_PTEX_CONSTANT;
        for (int edge = 0; edge < 4; edge++)
            writer->faces[i].adjfaces[edge] = -1;
    }
    return writer;
}

static bool store_block(CoPtexWriter *writer, Stored *stored, int ulog2, int vlog2,
                        const void *planes, CohortError *err)
{
    uint32_t header;
    if (!co_ptex_encode(&writer->encoder, planes, ulog2, vlog2, &header, err))
        return false;
    size_t size = writer->encoder.out.size;
    CO_CHECK(fwrite(writer->encoder.out.bytes, 1, size, writer->scratch) == size, err,
             COHORT_ERROR_FILE_WRITE, "cannot write scratch space for %s: the disk may be full",
             writer->path);
    stored->offset[stored->level_count] = writer->scratch_size;
    stored->header[stored->level_count++] = header;
    writer->scratch_size += size;
    return true;
}

static bool write_levels(CoPtexWriter *writer, uint32_t face, const void *const *levels,
                         uint32_t level_count, CohortError *err)
{
    const CoPtexWriteDesc *desc = &writer->desc;
    const CoPtexFace *info = &writer->faces[face];
    Stored *stored = &writer->stored[face];
    size_t size = pixel_size(desc) << (info->ulog2 + info->vlog2);
    unsigned char *planes = co_alloc(CO_MEMORY_TEXTURE, size);
    CO_CHECK_MEMORY(planes, err);
    co_ptex_to_planes(desc, levels[0], info->ulog2, info->vlog2, planes);
    bool ok = store_block(writer, stored, info->ulog2, info->vlog2, planes, err);
    int least = info->ulog2 < info->vlog2 ? info->ulog2 : info->vlog2, level = 0;
    if (desc->has_alpha)
        co_ptex_premultiply(desc, planes, info->ulog2, info->vlog2);
    while (ok && !desc->no_levels && least >= level + 3) {
        int ulog2 = info->ulog2 - level, vlog2 = info->vlog2 - level;
        level++;
        if (level < (int)level_count && levels[level])
            co_ptex_to_planes(desc, levels[level], ulog2 - 1, vlog2 - 1, planes);
        else
            co_ptex_quarter(desc, planes, ulog2, vlog2);
        ok = store_block(writer, stored, ulog2 - 1, vlog2 - 1, planes, err);
    }
    if (ok)
        co_ptex_average(desc, planes, info->ulog2 - level, info->vlog2 - level,
                        writer->constants + face * pixel_size(desc));
    co_free(CO_MEMORY_TEXTURE, planes, size);
    return ok;
}

static bool add_face(CoPtexWriter *writer, uint32_t face, const CoPtexFace *info,
                     const void *const *levels, uint32_t level_count, CohortError *err)
{
    const CoPtexWriteDesc *desc = &writer->desc;
    CO_CHECK(face < desc->face_count && !writer->stored[face].is_written, err,
             COHORT_ERROR_ARGUMENT, "face %u of %u is written twice or is none", face,
             desc->face_count);
    CO_CHECK(info->ulog2 >= 0 && info->vlog2 >= 0 && info->ulog2 <= CO_PTEX_LOG2 &&
                 info->vlog2 <= CO_PTEX_LOG2 &&
                 (uint64_t)pixel_size(desc) << (info->ulog2 + info->vlog2) <= 1u << 29,
             err, COHORT_ERROR_ARGUMENT, "a face of 2^%d x 2^%d texels", info->ulog2, info->vlog2);
    for (int edge = 0; edge < 4; edge++)
        CO_CHECK(info->adjfaces[edge] < (int64_t)desc->face_count, err, COHORT_ERROR_ARGUMENT,
                 "face %u lies beside face %d of %u", face, info->adjfaces[edge], desc->face_count);
    writer->stored[face].is_written = true;
    writer->faces[face] = *info;
    writer->faces[face].flags = info->flags & CO_PTEX_SUBFACE;
    size_t pixel = pixel_size(desc), count = (size_t)1 << (info->ulog2 + info->vlog2);
    const unsigned char *texels = levels[0];
    // All texels equal the first when each equals the one before it.
    if (memcmp(texels, texels + pixel, (count - 1) * pixel) != 0)
        return write_levels(writer, face, levels, level_count, err);
    writer->faces[face].flags |= CO_PTEX_CONSTANT;
    memcpy(writer->constants + face * pixel, texels, pixel);
    return true;
}

bool co_ptex_writer_face(CoPtexWriter *writer, uint32_t face, const CoPtexFace *info,
                         const void *const *levels, uint32_t level_count, CohortError *err)
{
    bool ok = add_face(writer, face, info, levels, level_count, err);
    writer->has_failed |= !ok;
    return ok;
}

// ---- The file --------------------------------------------------------------------------------

static void store_u32(unsigned char *p, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        p[i] = (unsigned char)(value >> 8 * i);
}

static void store_u64(unsigned char *p, uint64_t value)
{
    store_u32(p, (uint32_t)value);
    store_u32(p + 4, (uint32_t)(value >> 32));
}

// Faces by decreasing shorter side, constant ones as if it were 2: the order of coarser levels.
static bool order_faces(const CoPtexWriter *writer, uint32_t *order)
{
    uint32_t at = 0;
    for (int key = CO_PTEX_LOG2; key >= 0; key--) {
        for (uint32_t i = 0; i < writer->desc.face_count; i++) {
            const CoPtexFace *face = &writer->faces[i];
            int least = face->ulog2 < face->vlog2 ? face->ulog2 : face->vlog2;
            if ((face->flags & CO_PTEX_CONSTANT ? 1 : least) == key)
                order[at++] = i;
        }
    }
    return at == writer->desc.face_count;
}

typedef struct Output {
    CoPtexWriter *writer;
    FILE *file;
    uint64_t size; // written so far
    CohortError *err;
} Output;

static bool put(Output *out, const void *bytes, size_t size)
{
    CO_CHECK(fwrite(bytes, 1, size, out->file) == size, out->err, COHORT_ERROR_FILE_WRITE,
             "cannot write %s: the disk may be full", out->writer->path);
    out->size += size;
    return true;
}

static bool put_zipped(Output *out, const void *bytes, size_t size, uint32_t *packed)
{
    CoPtexEncoder *encoder = &out->writer->encoder;
    encoder->out.size = 0;
    if (!co_ptex_zip(encoder, bytes, size, out->err))
        return false;
    *packed = (uint32_t)encoder->out.size;
    return put(out, encoder->out.bytes, encoder->out.size);
}

static bool copy_block(Output *out, const Stored *stored, uint32_t level)
{
    CoPtexWriter *writer = out->writer;
    char bytes[65536];
    size_t left = stored->header[level] & 0x3fffffff;
    if (left && fseeko(writer->scratch, (off_t)stored->offset[level], SEEK_SET))
        left = 0;
    while (left > 0) {
        size_t part = left < sizeof bytes ? left : sizeof bytes;
        CO_CHECK(fread(bytes, 1, part, writer->scratch) == part, out->err, COHORT_ERROR_FILE_READ,
                 "cannot read scratch space for %s", writer->path);
        if (!put(out, bytes, part))
            return false;
        left -= part;
    }
    return true;
}

static bool put_level(Output *out, uint32_t level, const uint32_t *order, uint32_t count,
                      unsigned char *info)
{
    CoPtexWriter *writer = out->writer;
    unsigned char *headers = co_alloc(CO_MEMORY_TEXTURE, 4 * (size_t)count);
    CO_CHECK_MEMORY(headers, out->err);
    for (uint32_t i = 0; i < count; i++) {
        const Stored *stored = &writer->stored[level ? order[i] : i];
        store_u32(headers + 4 * (size_t)i, level < stored->level_count ? stored->header[level] : 0);
    }
    uint64_t begin = out->size;
    uint32_t packed = 0;
    bool ok = put_zipped(out, headers, 4 * (size_t)count, &packed);
    co_free(CO_MEMORY_TEXTURE, headers, 4 * (size_t)count);
    for (uint32_t i = 0; ok && i < count; i++) {
        const Stored *stored = &writer->stored[level ? order[i] : i];
        ok = level >= stored->level_count || copy_block(out, stored, level);
    }
    store_u64(info, out->size - begin);
    store_u32(info + 8, packed);
    store_u32(info + 12, count);
    return ok;
}

static bool put_faces(Output *out, unsigned char *header)
{
    CoPtexWriter *writer = out->writer;
    size_t count = writer->desc.face_count;
    unsigned char *bytes = co_alloc(CO_MEMORY_TEXTURE, 20 * count);
    CO_CHECK_MEMORY(bytes, out->err);
    for (size_t i = 0; i < count; i++) {
        const CoPtexFace *face = &writer->faces[i];
        unsigned char *p = bytes + 20 * i;
        p[0] = (unsigned char)face->ulog2;
        p[1] = (unsigned char)face->vlog2;
        p[2] = face->adjedges;
        p[3] = face->flags;
        for (int edge = 0; edge < 4; edge++)
            store_u32(p + 4 + 4 * edge,
                      (uint32_t)(face->adjfaces[edge] < 0 ? -1 : face->adjfaces[edge]));
    }
    uint32_t packed = 0;
    bool ok = put_zipped(out, bytes, 20 * count, &packed);
    co_free(CO_MEMORY_TEXTURE, bytes, 20 * count);
    store_u32(header + 32, packed);
    ok = ok && put_zipped(out, writer->constants, count * pixel_size(&writer->desc), &packed);
    store_u32(header + 36, packed);
    return ok;
}

static bool put_levels(Output *out, unsigned char *header, const uint32_t *order)
{
    const CoPtexWriter *writer = out->writer;
    uint32_t counts[CO_PTEX_LEVELS] = {writer->desc.face_count}, levels = 1;
    for (uint32_t i = 0; i < writer->desc.face_count; i++)
        for (uint32_t level = 1; level < writer->stored[i].level_count; level++)
            counts[level]++;
    while (levels < CO_PTEX_LEVELS && counts[levels])
        levels++;
    unsigned char info[16 * CO_PTEX_LEVELS] = {0};
    uint64_t info_at = out->size;
    if (!put(out, info, 16 * levels))
        return false;
    uint64_t begin = out->size;
    for (uint32_t level = 0; level < levels; level++)
        if (!put_level(out, level, order, counts[level], info + 16 * level))
            return false;
    header[22] = (unsigned char)levels;
    store_u32(header + 40, 16 * levels);
    store_u64(header + 48, out->size - begin);
    CO_CHECK(fseeko(out->file, (off_t)info_at, SEEK_SET) == 0 &&
                 fwrite(info, 16, levels, out->file) == levels &&
                 fseeko(out->file, 0, SEEK_END) == 0,
             out->err, COHORT_ERROR_FILE_WRITE, "cannot write %s", writer->path);
    return true;
}

static bool put_all(Output *out, const uint32_t *order)
{
    const CoPtexWriteDesc *desc = &out->writer->desc;
    unsigned char header[64 + 40] = {'P', 't', 'e', 'x', 1, 0, 0, 0, 1};
    static const unsigned char barrier[8];
    store_u32(header + 12, (uint32_t)desc->type);
    store_u32(header + 16, desc->has_alpha ? desc->alpha : UINT32_MAX);
    header[20] = (unsigned char)desc->channels;
    header[21] = (unsigned char)(desc->channels >> 8);
    store_u32(header + 24, desc->face_count);
    store_u32(header + 28, 40);
    store_u32(header + 44, 4);
    header[64] = (unsigned char)desc->u_border;
    header[68] = (unsigned char)desc->v_border;
    header[70] = desc->is_tangent;
    if (!put(out, header, sizeof header) || !put_faces(out, header) ||
        !put_levels(out, header, order) || !put(out, barrier, sizeof barrier))
        return false;
    store_u64(header + 64 + 32, out->size);
    CO_CHECK(fseeko(out->file, 0, SEEK_SET) == 0 &&
                 fwrite(header, 1, sizeof header, out->file) == sizeof header,
             out->err, COHORT_ERROR_FILE_WRITE, "cannot write %s", out->writer->path);
    return true;
}

static bool write_file(CoPtexWriter *writer, const char *temporary, CohortError *err)
{
    size_t size = writer->desc.face_count * sizeof(uint32_t);
    uint32_t *order = co_alloc(CO_MEMORY_TEXTURE, size);
    CO_CHECK_MEMORY(order, err);
    Output out = {writer, fopen(temporary, "wb"), 0, err};
    bool ok = out.file && order_faces(writer, order) && put_all(&out, order);
    if (out.file && fclose(out.file) != 0)
        ok = false;
    co_free(CO_MEMORY_TEXTURE, order, size);
    if (ok)
        return co_converted_publish(temporary, writer->path, err);
    unlink(temporary);
    return CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "cannot write %s", writer->path);
}

bool co_ptex_writer_finish(CoPtexWriter *writer, CohortError *err)
{
    if (!writer)
        return false;
    char *temporary = NULL;
    bool ok = !writer->has_failed && co_converted_temporary(writer->path, &temporary, err) &&
              write_file(writer, temporary, err);
    co_path_free(temporary);
    destroy(writer);
    return ok;
}
