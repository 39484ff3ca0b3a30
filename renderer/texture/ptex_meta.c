// Metadata of a Ptex file: checked, so that what is broken is refused, and not kept.

#include "texture/ptex_open.h"

// Bytes of one element of each metadata type: string, int8, int16, int32, float, double.
static const uint32_t element_sizes[] = {1, 1, 2, 4, 4, 8};

typedef struct Entry {
    const char *key; // NUL-terminated
    uint8_t type;
    uint32_t size; // bytes of the value; strings count their NUL
} Entry;

// One entry up to its value: u8 key size, key with its NUL, u8 type, u32 value size. Returns the
// bytes read, 0 when the entry is broken.
static size_t read_key(const unsigned char *p, size_t left, Entry *out)
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

static bool check_entries(CoPtexOpening *opening, const unsigned char *data, size_t size)
{
    while (size > 0) {
        Entry entry;
        size_t used = read_key(data, size, &entry);
        CO_PTEX_CHECK(opening, used > 0, "its metadata have a broken key");
        CO_PTEX_CHECK(opening, entry.size <= size - used, "metadata %s are cut", entry.key);
        used += entry.size;
        CO_PTEX_CHECK(opening, entry.type != 0 || (entry.size > 0 && data[used - 1] == 0),
                      "metadata %s do not end in NUL", entry.key);
        data += used;
        size -= used;
    }
    return true;
}

static bool check_large(CoPtexOpening *opening, const unsigned char *headers, size_t size,
                        uint64_t items_size)
{
    while (size > 0) {
        Entry entry;
        size_t used = read_key(headers, size, &entry);
        CO_PTEX_CHECK(opening, used > 0 && size - used >= 4,
                      "its large metadata have a broken key");
        uint32_t packed = co_load_u32(headers + used);
        CO_PTEX_CHECK(opening, packed <= items_size && co_inflate_is_possible(packed, entry.size),
                      "large metadata %s: %u bytes in %u", entry.key, entry.size, packed);
        items_size -= packed;
        headers += used + 4;
        size -= used + 4;
    }
    return true;
}

bool co_ptex_meta_check(CoPtexOpening *opening, uint64_t offset, uint32_t packed, uint32_t size,
                        const uint64_t *items_size)
{
    const char *what = items_size ? "large metadata" : "metadata";
    if (!co_ptex_claim(opening, offset, packed, size, what))
        return false;
    size_t room = (size_t)size + 1; // a stream may hold nothing
    unsigned char *bytes = co_alloc(CO_MEMORY_TEXTURE, room);
    CO_CHECK_MEMORY(bytes, opening->err);
    bool ok = co_ptex_inflate_at(opening, offset, packed, bytes, size, what) &&
              (items_size ? check_large(opening, bytes, size, *items_size)
                          : check_entries(opening, bytes, size));
    co_free(CO_MEMORY_TEXTURE, bytes, room);
    return ok;
}
