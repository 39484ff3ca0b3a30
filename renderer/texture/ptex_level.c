// Levels of a Ptex file: which faces each has, and where their blocks and tiles lie.

#include "texture/ptex_open.h"

static int rank_key(const CoPtexFace *face)
{
    if (face->flags & CO_PTEX_CONSTANT)
        return 1;
    return face->ulog2 < face->vlog2 ? face->ulog2 : face->vlog2;
}

// Coarser levels store the first faces of this order: by decreasing shorter side, stable.
static bool rank_faces(CoPtexOpening *opening)
{
    CoPtexFile *file = opening->file;
    file->ranks = co_ptex_keep(file, file->faces_count * sizeof *file->ranks);
    CO_CHECK_MEMORY(file->ranks, opening->err);
    uint32_t first[CO_PTEX_LOG2 + 2] = {0};
    for (uint32_t i = 0; i < file->faces_count; i++)
        first[CO_PTEX_LOG2 - rank_key(&file->faces[i]) + 1]++;
    for (int key = 1; key <= CO_PTEX_LOG2; key++)
        first[key] += first[key - 1];
    for (uint32_t i = 0; i < file->faces_count; i++)
        file->ranks[i] = first[CO_PTEX_LOG2 - rank_key(&file->faces[i])]++;
    return true;
}

// Makes room for `count` more blocks.
static bool reserve_blocks(CoPtexOpening *opening, uint64_t count)
{
    CoPtexFile *file = opening->file;
    uint64_t need = file->block_count + count;
    CO_PTEX_CHECK(opening, need < CO_PTEX_NO_BLOCK, "too many blocks");
    if (need <= file->block_capacity)
        return true;
    uint64_t capacity = need + need / 2;
    if (capacity >= CO_PTEX_NO_BLOCK)
        capacity = need;
    void *blocks =
        co_realloc(CO_MEMORY_TEXTURE, file->blocks, file->block_capacity * sizeof *file->blocks,
                   (size_t)capacity * sizeof *file->blocks);
    CO_CHECK_MEMORY(blocks, opening->err);
    file->blocks = blocks;
    file->block_capacity = (uint32_t)capacity;
    return true;
}

static bool reserve_tiling(CoPtexOpening *opening)
{
    CoPtexFile *file = opening->file;
    void *tilings = file->tilings;
    bool ok = co_grow(CO_MEMORY_TEXTURE, &tilings, file->tiling_count, &file->tiling_capacity,
                      sizeof *file->tilings);
    CO_CHECK(ok, opening->err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    file->tilings = tilings;
    return true;
}

static bool check_block(CoPtexOpening *opening, const CoPtexBlock *block, int ulog2, int vlog2)
{
    size_t pixel = co_ptex_pixel_size(opening->file);
    if (co_ptex_encoding(block) == CO_PTEX_PLAIN)
        CO_PTEX_CHECK(opening, co_ptex_stored_size(block) >= pixel, "a constant block of %u bytes",
                      co_ptex_stored_size(block));
    else
        CO_PTEX_CHECK(
            opening,
            co_inflate_is_possible(co_ptex_stored_size(block), (uint64_t)pixel << (ulog2 + vlog2)),
            "2^%d x 2^%d texels in a block of %u bytes", ulog2, vlog2, co_ptex_stored_size(block));
    return true;
}

static bool add_tiles(CoPtexOpening *opening, const CoPtexBlock *block, int ulog2, int vlog2)
{
    CoPtexFile *file = opening->file;
    const unsigned char *p = opening->data + block->offset;
    CO_PTEX_CHECK(opening, co_ptex_stored_size(block) >= 6, "a tiled block of %u bytes",
                  co_ptex_stored_size(block));
    int tile_u = (int8_t)p[0], tile_v = (int8_t)p[1];
    uint32_t header = co_load_u32(p + 2);
    CO_PTEX_CHECK(opening, tile_u >= 0 && tile_v >= 0 && tile_u <= ulog2 && tile_v <= vlog2,
                  "tiles of 2^%d x 2^%d in a face of 2^%d x 2^%d", tile_u, tile_v, ulog2, vlog2);
    CO_PTEX_CHECK(opening, header <= co_ptex_stored_size(block) - 6, "a tile header of %u bytes",
                  header);
    size_t count = (size_t)1 << (ulog2 - tile_u + vlog2 - tile_v);
    CO_PTEX_CHECK(opening, co_inflate_is_possible(header, 4 * (uint64_t)count),
                  "%zu tiles in a header of %u bytes", count, header);
    if (!reserve_tiling(opening) || !reserve_blocks(opening, count))
        return false;
    unsigned char *words = co_alloc(CO_MEMORY_TEXTURE, 4 * count);
    CO_CHECK_MEMORY(words, opening->err);
    bool ok =
        co_ptex_inflate_at(opening, block->offset + 6, header, words, 4 * count, "tile header");
    uint64_t offset = block->offset + 6 + header, end = block->offset + co_ptex_stored_size(block);
    for (size_t i = 0; ok && i < count; i++) {
        CoPtexBlock tile = {.offset = offset, .header = co_load_u32(words + 4 * i)};
        if (co_ptex_encoding(&tile) == CO_PTEX_TILED || co_ptex_stored_size(&tile) > end - offset)
            ok = CO_FAIL(opening->err, COHORT_ERROR_TEXTURE,
                         "broken Ptex file: tile %zu is tiled itself or overruns its face", i);
        ok = ok && check_block(opening, &tile, tile_u, tile_v);
        offset += co_ptex_stored_size(&tile);
        file->blocks[file->block_count + i] = tile;
    }
    co_free(CO_MEMORY_TEXTURE, words, 4 * count);
    if (!ok)
        return false;
    file->tilings[file->tiling_count++] =
        (CoPtexTiling){(int8_t)tile_u, (int8_t)tile_v, file->block_count};
    file->block_count += (uint32_t)count;
    return true;
}

bool co_ptex_block_add(CoPtexOpening *opening, const CoPtexBlock *block, int ulog2, int vlog2,
                       uint32_t index, uint32_t *out)
{
    CoPtexFile *file = opening->file;
    if (index == CO_PTEX_NO_BLOCK) {
        if (!reserve_blocks(opening, 1))
            return false;
        index = file->block_count++;
        *out = index;
    }
    CoPtexBlock added = *block;
    if (co_ptex_encoding(block) == CO_PTEX_TILED) {
        added.tiling = file->tiling_count;
        if (!add_tiles(opening, block, ulog2, vlog2))
            return false;
    } else if (!check_block(opening, block, ulog2, vlog2)) {
        return false;
    }
    file->blocks[index] = added;
    return true;
}

// One level: its header, then its blocks. `order` gives the face of each place.
static bool read_level(CoPtexOpening *opening, uint32_t level, uint64_t offset,
                       const uint32_t *order)
{
    CoPtexFile *file = opening->file;
    uint32_t count = file->level_faces[level], header = file->level_header_bytes[level];
    CO_PTEX_CHECK(opening, header <= file->level_bytes[level], "level %u has a header of %u bytes",
                  level, header);
    CO_PTEX_CHECK(opening, co_inflate_is_possible(header, 4 * (uint64_t)count),
                  "level %u has %u faces in %u bytes", level, count, header);
    if (!reserve_blocks(opening, count))
        return false;
    file->level_block[level] = file->block_count;
    file->block_count += count;
    unsigned char *words = co_alloc(CO_MEMORY_TEXTURE, 4 * (size_t)count);
    CO_CHECK_MEMORY(words, opening->err);
    bool ok = co_ptex_inflate_at(opening, offset, header, words, 4 * (size_t)count, "level header");
    uint64_t at = offset + header, end = offset + file->level_bytes[level];
    for (uint32_t i = 0; ok && i < count; i++) {
        const CoPtexFace *face = &file->faces[level ? order[i] : i];
        int ulog2 = face->ulog2 - (int)level, vlog2 = face->vlog2 - (int)level;
        CoPtexBlock block = {.offset = at, .header = co_load_u32(words + 4 * (size_t)i)};
        if (ulog2 < 0 || vlog2 < 0 || co_ptex_stored_size(&block) > end - at)
            ok = CO_FAIL(opening->err, COHORT_ERROR_TEXTURE,
                         "broken Ptex file: face %u of level %u is too small or overruns its level",
                         i, level);
        at += co_ptex_stored_size(&block);
        file->blocks[file->level_block[level] + i] = block;
        // The value of a constant face, and of one texel, stands in the constant block.
        if (ok && !(face->flags & CO_PTEX_CONSTANT) && ulog2 + vlog2 > 0)
            ok = co_ptex_block_add(opening, &block, ulog2, vlog2, file->level_block[level] + i,
                                   NULL);
    }
    co_free(CO_MEMORY_TEXTURE, words, 4 * (size_t)count);
    return ok;
}

// Sizes of all levels, which must add up to `left` bytes of data.
static bool read_level_info(CoPtexOpening *opening, const unsigned char *info, uint64_t left)
{
    CoPtexFile *file = opening->file;
    for (uint32_t level = 0; level < file->levels; level++, info += CO_PTEX_LEVEL_INFO) {
        file->level_bytes[level] = co_load_u64(info);
        file->level_header_bytes[level] = co_load_u32(info + 8);
        file->level_faces[level] = co_load_u32(info + 12);
        CO_PTEX_CHECK(opening, file->level_bytes[level] <= left, "level %u overruns its data",
                      level);
        left -= file->level_bytes[level];
        uint32_t most = level ? file->level_faces[level - 1] : file->faces_count;
        CO_PTEX_CHECK(opening,
                      file->level_faces[level] >= 1 && file->level_faces[level] <= most &&
                          (level || file->level_faces[0] == file->faces_count),
                      "level %u lists %u faces", level, file->level_faces[level]);
    }
    CO_PTEX_CHECK(opening, left == 0, "its level sizes do not add up");
    return true;
}

bool co_ptex_levels_read(CoPtexOpening *opening, uint64_t data_size, uint64_t *offset)
{
    CoPtexFile *file = opening->file;
    uint64_t info = *offset, info_size = CO_PTEX_LEVEL_INFO * (uint64_t)file->levels;
    CO_PTEX_CHECK(opening, info_size <= opening->size - info, "its level info is cut");
    *offset += info_size;
    CO_PTEX_CHECK(opening, data_size <= opening->size - *offset,
                  "its level data lie outside the file");
    if (!read_level_info(opening, opening->data + info, data_size) || !rank_faces(opening))
        return false;
    size_t order_size = file->faces_count * sizeof(uint32_t);
    uint32_t *order = co_alloc(CO_MEMORY_TEXTURE, order_size);
    CO_CHECK_MEMORY(order, opening->err);
    for (uint32_t face = 0; face < file->faces_count; face++)
        order[file->ranks[face]] = face;
    bool ok = true;
    for (uint32_t level = 0; ok && level < file->levels; level++) {
        ok = read_level(opening, level, *offset, order);
        *offset += file->level_bytes[level];
    }
    co_free(CO_MEMORY_TEXTURE, order, order_size);
    return ok;
}
