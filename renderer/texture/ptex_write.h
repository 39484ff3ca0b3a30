// Writing Ptex files of quads: faces in, a complete file out, with its coarser levels.
//
// Source: the Ptex format, version 1.4; decoded texels, levels, constants and tiling are those that
// the reference library 2.4 would have stored. Compressed bytes may differ.
//
//     CoPtexWriter *writer = co_ptex_writer_create("out.ptx", &desc, &err);
//     for (uint32_t face = 0; face < desc.face_count; face++)
//         co_ptex_writer_face(writer, face, &info[face], levels[face], 1, &err);
//     co_ptex_writer_finish(writer, &err);   // NULL-safe; frees the writer in any case

#ifndef CO_TEXTURE_PTEX_WRITE_H
#define CO_TEXTURE_PTEX_WRITE_H

#include "texture/ptex_file.h"

typedef struct CoPtexWriter CoPtexWriter;

// Zero is the default of every field but face_count and channels.
typedef struct CoPtexWriteDesc {
    uint32_t face_count;
    CoPtexType type;
    uint32_t channels;
    bool has_alpha; // alpha is channel `alpha`; coarser levels are then premultiplied, as Ptex has
                    // it
    uint32_t alpha;
    CoPtexBorder u_border, v_border;
    bool is_tangent; // edge filter mode tanvec
    bool no_levels;  // full resolution only
    int zlib_level;  // 1 to 12, 0 = 6
} CoPtexWriteDesc;

// Starts a file; nothing stands at `path` before it is finished. NULL with *err set.
CoPtexWriter *co_ptex_writer_create(const char *path, const CoPtexWriteDesc *desc,
                                    CohortError *err);

// Adds one face; each once, in any order. levels[0] holds 2^vlog2 rows from v = 0 of 2^ulog2
// pixels, interleaved, little-endian; levels[k] has half the sides of levels[k - 1]. Levels that
// the format stores and that are not given are averaged. Of info's flags only CO_PTEX_SUBFACE is
// used. Faces left out become one black texel without neighbors. After a failure the file will not
// be finished.
bool co_ptex_writer_face(CoPtexWriter *writer, uint32_t face, const CoPtexFace *info,
                         const void *const *levels, uint32_t level_count, CohortError *err);

// Writes the file and moves it to its path in one step; frees the writer. False when this or any
// earlier call failed.
bool co_ptex_writer_finish(CoPtexWriter *writer, CohortError *err);

#endif
