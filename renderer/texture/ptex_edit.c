// Edits at the end of a Ptex file: faces and metadata that replace earlier ones.

#include "texture/ptex_open.h"

static bool edit_face(CoPtexOpening *opening, uint64_t offset, uint32_t size)
{
    CoPtexFile *file = opening->file;
    const unsigned char *p = opening->data + offset;
    uint32_t pixel = co_ptex_pixel_size(file);
    CO_PTEX_CHECK(opening, size >= 28 + (uint64_t)pixel, "an edit of %u bytes", size);
    uint32_t face = co_load_u32(p);
    CO_PTEX_CHECK(opening, face < file->faces_count, "an edit of face %u of %u", face,
                  file->faces_count);
    CoPtexFace info;
    if (!co_ptex_face_read(opening, p + 4, &info))
        return false;
    info.flags |= CO_PTEX_EDITED;
    if (!file->edit_blocks) {
        file->edit_blocks = co_ptex_keep(file, file->faces_count * sizeof *file->edit_blocks);
        CO_CHECK_MEMORY(file->edit_blocks, opening->err);
    }
    CoPtexBlock block = {.offset = offset + 28 + pixel, .header = co_load_u32(p + 24)};
    if (!(info.flags & CO_PTEX_CONSTANT)) {
        CO_PTEX_CHECK(opening, co_ptex_stored_size(&block) <= size - 28 - pixel,
                      "an edit's block of %u bytes", co_ptex_stored_size(&block));
        if (info.ulog2 + info.vlog2 > 0 &&
            !co_ptex_block_add(opening, &block, info.ulog2, info.vlog2, CO_PTEX_NO_BLOCK,
                               &file->edit_blocks[face]))
            return false;
    }
    file->faces[face] = info;
    memcpy(file->constants + (size_t)face * pixel, p + 28, pixel);
    return true;
}

static bool edit_meta(CoPtexOpening *opening, uint64_t offset, uint32_t size)
{
    CO_PTEX_CHECK(opening, size >= 8, "a metadata edit of %u bytes", size);
    uint32_t packed = co_load_u32(opening->data + offset);
    uint32_t full = co_load_u32(opening->data + offset + 4);
    CO_PTEX_CHECK(opening, packed <= size - 8, "a metadata edit of %u bytes in %u", packed, size);
    return co_ptex_meta_check(opening, offset + 8, packed, full, NULL);
}

bool co_ptex_edits_read(CoPtexOpening *opening, uint64_t begin, uint64_t end, bool to_end)
{
    while (end - begin >= 5) {
        uint8_t type = opening->data[begin];
        uint32_t size = co_load_u32(opening->data + begin + 1);
        begin += 5;
        if (size == 0)
            return true;
        if (to_end && size > end - begin)
            return true;
        CO_PTEX_CHECK(opening, size <= end - begin, "an edit of %u bytes overruns its data", size);
        if (type == 0 && !edit_face(opening, begin, size))
            return false;
        if (type == 1 && !edit_meta(opening, begin, size))
            return false;
        begin += size;
    }
    CO_PTEX_CHECK(opening, to_end || begin == end, "its last edit is cut");
    return true;
}
