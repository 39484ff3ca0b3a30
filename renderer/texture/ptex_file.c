#include "texture/ptex_open.h"

typedef struct Header {
    uint32_t ext_size, info_size, constant_size, level_info_size;
    uint64_t level_data_size;
    uint32_t meta_packed, meta_size;
    uint32_t large_packed, large_size; // headers of large metadata
    uint64_t large_data, edit_size, edit_offset;
} Header;

void *co_ptex_keep(CoPtexFile *file, size_t size)
{
    CoPtexBytes *kept = co_alloc_zero(CO_MEMORY_TEXTURE, sizeof *kept + size);
    if (!kept)
        return NULL;
    kept->size = sizeof *kept + size;
    kept->next = file->owned;
    file->owned = kept;
    return kept->bytes;
}

bool co_ptex_claim(CoPtexOpening *opening, uint64_t offset, uint64_t packed, uint64_t size,
                   const char *what)
{
    CO_PTEX_CHECK(opening, offset <= opening->size && packed <= opening->size - offset,
                  "the %s lies outside the file", what);
    CO_PTEX_CHECK(opening, co_inflate_is_possible((size_t)packed, size) && size <= 1ull << 36,
                  "%llu bytes of %s in %llu", (unsigned long long)size, what,
                  (unsigned long long)packed);
    return true;
}

bool co_ptex_inflate_at(CoPtexOpening *opening, uint64_t offset, uint64_t packed, void *out,
                        size_t size, const char *what)
{
    CO_PTEX_CHECK(opening, offset <= opening->size && packed <= opening->size - offset,
                  "the %s lies outside the file", what);
    CO_PTEX_CHECK(opening,
                  co_inflate(&opening->inflate, opening->data + offset, (size_t)packed, out, size,
                             NULL, NULL),
                  "the %s does not decompress to %zu bytes", what, size);
    return true;
}

static bool read_ext_header(CoPtexOpening *opening, Header *header)
{
    CoPtexFile *file = opening->file;
    CO_PTEX_CHECK(opening, header->ext_size <= opening->size - 64, "its header is cut");
    unsigned char ext[40] = {0};
    memcpy(ext, opening->data + 64, header->ext_size < 40 ? header->ext_size : 40);
    uint32_t u_border = co_load_u16(ext), v_border = co_load_u16(ext + 4);
    uint32_t edge_filter = co_load_u16(ext + 6);
    CO_PTEX_CHECK(opening, u_border <= CO_PTEX_PERIODIC && v_border <= CO_PTEX_PERIODIC,
                  "border modes %u and %u", u_border, v_border);
    CO_PTEX_CHECK(opening, edge_filter <= 1, "edge filter mode %u", edge_filter);
    file->u_border = (CoPtexBorder)u_border;
    file->v_border = (CoPtexBorder)v_border;
    file->is_tangent = edge_filter == 1;
    header->large_packed = co_load_u32(ext + 8);
    header->large_size = co_load_u32(ext + 12);
    header->large_data = co_load_u64(ext + 16);
    header->edit_size = co_load_u64(ext + 24);
    header->edit_offset = co_load_u64(ext + 32);
    return true;
}

static bool read_header(CoPtexOpening *opening, Header *header)
{
    CoPtexFile *file = opening->file;
    const unsigned char *p = opening->data;
    CO_PTEX_CHECK(opening, opening->size >= 64 && memcmp(p, "Ptex", 4) == 0,
                  "it does not start as one");
    CO_PTEX_CHECK(opening, co_load_u32(p + 4) == 1, "version %u, expected 1", co_load_u32(p + 4));
    uint32_t mesh = co_load_u32(p + 8), type = co_load_u32(p + 12);
    CO_PTEX_CHECK(opening, mesh < 2, "mesh type %u", mesh);
    CO_PTEX_CHECK(opening, type <= CO_PTEX_F32, "data type %u", type);
    file->is_triangle = mesh == 0;
    file->type = (CoPtexType)type;
    file->alpha = (int32_t)co_load_u32(p + 16);
    file->channels = co_load_u16(p + 20);
    file->levels = co_load_u16(p + 22);
    file->faces_count = co_load_u32(p + 24);
    CO_PTEX_CHECK(opening, file->channels >= 1, "no channels");
    CO_PTEX_CHECK(opening, file->alpha >= -1 && file->alpha < (int32_t)file->channels,
                  "alpha channel %d of %u", file->alpha, file->channels);
    CO_PTEX_CHECK(opening, file->levels >= 1 && file->levels <= CO_PTEX_LEVELS, "%u levels",
                  file->levels);
    CO_PTEX_CHECK(opening, file->faces_count >= 1 && file->faces_count <= INT32_MAX, "%u faces",
                  file->faces_count);
    header->ext_size = co_load_u32(p + 28);
    header->info_size = co_load_u32(p + 32);
    header->constant_size = co_load_u32(p + 36);
    header->level_info_size = co_load_u32(p + 40);
    header->level_data_size = co_load_u64(p + 48);
    header->meta_packed = co_load_u32(p + 56);
    header->meta_size = co_load_u32(p + 60);
    CO_PTEX_CHECK(opening, header->level_info_size == CO_PTEX_LEVEL_INFO * (uint32_t)file->levels,
                  "%u bytes of level info for %u levels", header->level_info_size, file->levels);
    return read_ext_header(opening, header);
}

bool co_ptex_face_read(CoPtexOpening *opening, const unsigned char *bytes, CoPtexFace *out)
{
    const CoPtexFile *file = opening->file;
    CoPtexFace face = {.ulog2 = (int8_t)bytes[0],
                       .vlog2 = (int8_t)bytes[1],
                       .adjedges = bytes[2],
                       .flags = bytes[3]};
    CO_PTEX_CHECK(opening,
                  face.ulog2 >= 0 && face.vlog2 >= 0 && face.ulog2 <= CO_PTEX_LOG2 &&
                      face.vlog2 <= CO_PTEX_LOG2,
                  "a face of resolution 2^%d x 2^%d", face.ulog2, face.vlog2);
    CO_PTEX_CHECK(opening, !file->is_triangle || face.ulog2 == face.vlog2,
                  "a triangle of resolution 2^%d x 2^%d", face.ulog2, face.vlog2);
    uint64_t size = (uint64_t)co_ptex_pixel_size(file) << (face.ulog2 + face.vlog2);
    CO_PTEX_CHECK(opening, size <= 1u << 30, "a face of %llu bytes", (unsigned long long)size);
    for (int edge = 0; edge < 4; edge++) {
        face.adjfaces[edge] = (int32_t)co_load_u32(bytes + 4 + 4 * edge);
        CO_PTEX_CHECK(opening, face.adjfaces[edge] < (int64_t)file->faces_count,
                      "a face beside face %d of %u", face.adjfaces[edge], file->faces_count);
    }
    *out = face;
    return true;
}

static bool read_faces(CoPtexOpening *opening, const Header *header, uint64_t *offset)
{
    CoPtexFile *file = opening->file;
    size_t count = file->faces_count, pixel = co_ptex_pixel_size(file);
    if (!co_ptex_claim(opening, *offset, header->info_size, 20 * (uint64_t)count, "face info") ||
        !co_ptex_claim(opening, *offset + header->info_size, header->constant_size,
                       pixel * (uint64_t)count, "constant data"))
        return false;
    file->faces = co_ptex_keep(file, count * sizeof *file->faces);
    file->constants = co_ptex_keep(file, count * pixel);
    unsigned char *packed = co_alloc(CO_MEMORY_TEXTURE, 20 * count);
    bool ok = packed && file->faces && file->constants;
    if (!ok)
        CO_FAIL(opening->err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    ok = ok &&
         co_ptex_inflate_at(opening, *offset, header->info_size, packed, 20 * count, "face info");
    for (size_t i = 0; ok && i < count; i++)
        ok = co_ptex_face_read(opening, packed + 20 * i, &file->faces[i]);
    co_free(CO_MEMORY_TEXTURE, packed, 20 * count);
    *offset += header->info_size;
    ok = ok && co_ptex_inflate_at(opening, *offset, header->constant_size, file->constants,
                                  count * pixel, "constant data");
    *offset += header->constant_size;
    return ok;
}

static bool check_meta(CoPtexOpening *opening, const Header *header, uint64_t *offset)
{
    CO_PTEX_CHECK(opening, header->meta_packed || header->meta_size == 0,
                  "%u bytes of metadata in none", header->meta_size);
    if (header->meta_packed &&
        !co_ptex_meta_check(opening, *offset, header->meta_packed, header->meta_size, NULL))
        return false;
    *offset += header->meta_packed;
    if (header->large_packed == 0) {
        CO_PTEX_CHECK(opening, header->large_size == 0 && header->large_data == 0,
                      "large metadata without a header");
        return true;
    }
    *offset += 8; // the barrier
    if (!co_ptex_meta_check(opening, *offset, header->large_packed, header->large_size,
                            &header->large_data))
        return false;
    *offset += header->large_packed;
    CO_PTEX_CHECK(opening, header->large_data <= opening->size - *offset,
                  "its large metadata lie outside the file");
    *offset += header->large_data;
    return true;
}

static bool read_edits(CoPtexOpening *opening, const Header *header, uint64_t offset)
{
    uint64_t begin = header->edit_offset;
    if (begin == 0) {
        // Old files: whatever follows, after the barrier of eight zero bytes where there is one.
        static const unsigned char barrier[8];
        uint64_t rest = opening->size - offset;
        if (rest >= 8 && memcmp(opening->data + offset, barrier, 8) == 0)
            offset += 8;
        return co_ptex_edits_read(opening, offset, opening->size, true);
    }
    CO_PTEX_CHECK(opening,
                  begin >= offset && begin <= opening->size &&
                      header->edit_size <= opening->size - begin,
                  "its edits lie outside the file or on other data");
    return co_ptex_edits_read(opening, begin, begin + header->edit_size, false);
}

static bool read_all(CoPtexOpening *opening)
{
    Header header = {0};
    if (!read_header(opening, &header))
        return false;
    uint64_t offset = 64 + (uint64_t)header.ext_size;
    if (!read_faces(opening, &header, &offset) ||
        !co_ptex_levels_read(opening, header.level_data_size, &offset) ||
        !check_meta(opening, &header, &offset) || !read_edits(opening, &header, offset))
        return false;
    CoPtexFile *file = opening->file;
    file->stamps = co_ptex_keep(file, file->block_count * sizeof *file->stamps);
    CO_CHECK_MEMORY(file->stamps, opening->err);
    return true;
}

CoPtexFile *co_ptex_open(const char *path, CohortError *err)
{
    CoPtexFile *file = co_alloc_zero(CO_MEMORY_TEXTURE, sizeof *file);
    CO_CHECK_NULL(file, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    CohortError local = {0};
    bool ok = co_mapped_file_open(path, &file->map, &local);
    if (ok) {
        CoPtexOpening opening = {file, file->map.data, file->map.size, {0}, &local};
        ok = read_all(&opening);
        co_inflate_clear(&opening.inflate);
        if (!ok)
            co_error_place(&local, path, 0, 0, NULL);
    }
    if (!ok) {
        co_ptex_close(file);
        if (err && err->code == COHORT_OK)
            *err = local;
        return NULL;
    }
    return file;
}

void co_ptex_close(CoPtexFile *file)
{
    if (!file)
        return;
    while (file->owned) {
        CoPtexBytes *next = file->owned->next;
        co_free(CO_MEMORY_TEXTURE, file->owned, file->owned->size);
        file->owned = next;
    }
    co_free(CO_MEMORY_TEXTURE, file->blocks, file->block_capacity * sizeof *file->blocks);
    co_free(CO_MEMORY_TEXTURE, file->tilings, file->tiling_capacity * sizeof *file->tilings);
    co_mapped_file_close(&file->map);
    co_free(CO_MEMORY_TEXTURE, file, sizeof *file);
}

static bool stored_block(const CoPtexFile *file, uint32_t face, int level, uint32_t *block)
{
    bool is_edited = file->faces[face].flags & CO_PTEX_EDITED;
    if (is_edited && level > 0)
        return false;
    if (is_edited)
        *block = file->edit_blocks[face];
    else if (level == 0)
        *block = file->level_block[0] + face;
    else if (level < (int)file->levels && file->ranks[face] < file->level_faces[level])
        *block = file->level_block[level] + file->ranks[face];
    else
        return false;
    return true;
}

bool co_ptex_locate(const CoPtexFile *file, uint32_t face, int ulog2, int vlog2, CoPtexSource *out)
{
    const CoPtexFace *info = &file->faces[face];
    int du = info->ulog2 - ulog2, dv = info->vlog2 - vlog2;
    if (ulog2 < 0 || vlog2 < 0 || du < 0 || dv < 0 || (file->is_triangle && du != dv))
        return false;
    *out =
        (CoPtexSource){.block = CO_PTEX_NO_BLOCK, .ulog2 = (int8_t)ulog2, .vlog2 = (int8_t)vlog2};
    out->pixel = file->constants + (size_t)face * co_ptex_pixel_size(file);
    if (info->flags & CO_PTEX_CONSTANT || ulog2 + vlog2 == 0)
        return true;
    uint32_t axes = 0;
    while (du != dv || !stored_block(file, face, du, &out->block)) {
        if (file->is_triangle) {
            du--, dv--;
        } else {
            bool in_u = du != dv ? du > dv : ((info->ulog2 - du) & 1) != 0;
            in_u ? du-- : dv--;
            axes = axes << 1 | !in_u; // the last step found is the first one made
        }
        out->steps++;
    }
    out->axes = axes;
    out->ulog2 = (int8_t)(info->ulog2 - du);
    out->vlog2 = (int8_t)(info->vlog2 - dv);
    const CoPtexBlock *block = &file->blocks[out->block];
    if (co_ptex_encoding(block) == CO_PTEX_PLAIN) {
        out->pixel = (const unsigned char *)file->map.data + block->offset;
        out->block = CO_PTEX_NO_BLOCK;
    }
    return true;
}
