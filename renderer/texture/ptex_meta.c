// Metadata of a Ptex file.

#include "texture/ptex_open.h"

// Bytes of one element of each metadata type.
static const uint32_t element_sizes[] = {1, 1, 2, 4, 4, 8};

static bool push(CoPtexOpening *opening, const CoPtexMeta *meta)
{
    CoPtexFile *file = opening->file;
    void *entries = file->meta;
    bool ok = co_grow(CO_MEMORY_TEXTURE, &entries, file->meta_count, &file->meta_capacity,
                      sizeof *file->meta);
    CO_CHECK(ok, opening->err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    file->meta = entries;
    file->meta[file->meta_count] = *meta;
    file->meta[file->meta_count].order = file->meta_count;
    file->meta_count++;
    return true;
}

// One entry up to its value: u8 key size, key with its NUL, u8 type, u32 value size. Returns the
// bytes read, 0 when the entry is broken.
static size_t read_key(const unsigned char *p, size_t left, CoPtexMeta *out)
{
    if (left < 1 || p[0] < 1 || left < (size_t)p[0] + 6 || p[p[0]] != 0)
        return 0;
    size_t key_size = p[0];
    out->key = (const char *)p + 1;
    out->type = p[1 + key_size];
    out->size = co_load_u32(p + 2 + key_size);
    if (out->type >= sizeof element_sizes / sizeof *element_sizes ||
        out->size % element_sizes[out->type] != 0)
        return 0;
    return key_size + 6;
}

bool co_ptex_meta_parse(CoPtexOpening *opening, const unsigned char *data, size_t size)
{
    while (size > 0) {
        CoPtexMeta meta = {0};
        size_t used = read_key(data, size, &meta);
        CO_PTEX_CHECK(opening, used > 0, "its metadata have a broken key");
        CO_PTEX_CHECK(opening, meta.size <= size - used, "metadata %s are cut", meta.key);
        meta.data = data + used;
        CO_PTEX_CHECK(opening, meta.type != 0 || (meta.size > 0 && data[used + meta.size - 1] == 0),
                      "metadata %s do not end in NUL", meta.key);
        if (!push(opening, &meta))
            return false;
        data += used + meta.size;
        size -= used + meta.size;
    }
    return true;
}

bool co_ptex_meta_large(CoPtexOpening *opening, const unsigned char *headers, size_t size,
                        uint64_t items, uint64_t items_size)
{
    while (size > 0) {
        CoPtexMeta meta = {0};
        size_t used = read_key(headers, size, &meta);
        CO_PTEX_CHECK(opening, used > 0 && size - used >= 4,
                      "its large metadata have a broken key");
        meta.packed = items;
        meta.packed_size = co_load_u32(headers + used);
        CO_PTEX_CHECK(opening,
                      meta.packed_size <= items_size &&
                          co_inflate_is_possible(meta.packed_size, meta.size),
                      "large metadata %s: %u bytes in %u", meta.key, meta.size, meta.packed_size);
        if (!push(opening, &meta))
            return false;
        items += meta.packed_size;
        items_size -= meta.packed_size;
        headers += used + 4;
        size -= used + 4;
    }
    return true;
}

static int by_key(const void *left, const void *right)
{
    const CoPtexMeta *a = left, *b = right;
    int order = strcmp(a->key, b->key);
    return order ? order : (a->order > b->order) - (a->order < b->order);
}

void co_ptex_meta_finish(CoPtexFile *file)
{
    if (file->meta_count == 0)
        return;
    qsort(file->meta, file->meta_count, sizeof *file->meta, by_key);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < file->meta_count; i++)
        if (i + 1 == file->meta_count || strcmp(file->meta[i].key, file->meta[i + 1].key) != 0)
            file->meta[kept++] = file->meta[i];
    file->meta_count = kept;
}

bool co_ptex_meta_value(const CoPtexFile *file, uint32_t index, void *out, CohortError *err)
{
    const CoPtexMeta *meta = &file->meta[index];
    if (meta->data) {
        memcpy(out, meta->data, meta->size);
        return true;
    }
    CoInflate inflate = {0};
    bool ok = co_inflate(&inflate, (const unsigned char *)file->map.data + meta->packed,
                         meta->packed_size, out, meta->size, NULL, NULL);
    co_inflate_clear(&inflate);
    CO_CHECK(ok, err, COHORT_ERROR_TEXTURE,
             "broken Ptex file: metadata %s do not decompress to %u bytes", meta->key, meta->size);
    return true;
}
