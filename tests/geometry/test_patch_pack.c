// Packed words (patch_pack.h, patch_pack.c) are the words, in the bytes that neighbors need.

#include "geometry/patch.h"

#include "base/hash.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

typedef struct Packed {
    CoPatchPack *packs;
    unsigned char *bits;
    size_t bytes;
} Packed;

// In just the memory that it asks for.
static Packed pack(const uint32_t *words, uint32_t count, uint32_t stride)
{
    Packed p = {calloc(count / CO_PATCH_PACKED + 1, sizeof *p.packs), NULL, 0};
    assert_non_null(p.packs);
    p.bytes = co_patch_pack_measure(words, count, stride, p.packs);
    p.bits = calloc(p.bytes, 1);
    assert_non_null(p.bits);
    co_patch_pack_write(words, count, stride, p.packs, p.bits);
    return p;
}

static void drop(Packed *p)
{
    free(p->packs);
    free(p->bits);
}

static void assert_words(const Packed *p, const uint32_t *words, uint32_t count, uint32_t stride)
{
    for (uint32_t k = 0; k < count; k++) {
        uint32_t got[CO_PATCH_PACK_WORDS];
        co_patch_unpack(p->packs, p->bits, k, got);
        for (uint32_t c = 0; c < stride; c++)
            assert_int_equal(got[c], words[k * stride + c]);
    }
}

// Numbers of up to 31 bits, and no fourth point here and there.
static void words_come_back(void **state)
{
    (void)state;
    const uint32_t counts[] = {1, 63, 64, 65, 700};
    static uint32_t words[700 * 4];
    for (uint32_t round = 0; round < 5 * 32 * 2; round++) {
        const uint32_t count = counts[round % 5], bits = round / 5 % 32, stride = 3 + round / 160;
        for (uint32_t k = 0; k < count * stride; k++) {
            words[k] = co_hash32(k + 7919 * round) & ((1u << bits) - 1u);
            if (k % 4 == 3 && stride == 4 && co_hash32(k) % 64 < round % 3)
                words[k] = CO_PATCH_NONE;
        }
        Packed p = pack(words, count, stride);
        assert_words(&p, words, count, stride);
        drop(&p);
    }
}

// Quads row by row: 6 bits for which of 64, none for what is always as far.
static void neighbors_take_few_bytes(void **state)
{
    (void)state;
    enum {
        SIDE = 1 << 11,
        COUNT = 64 * 64
    };
    static uint32_t words[COUNT * 4];
    for (uint32_t k = 0; k < COUNT; k++) {
        const uint32_t quad[4] = {k, k + 1, k + 1 + SIDE, k + SIDE};
        memcpy(words + 4 * (size_t)k, quad, sizeof quad);
    }
    Packed p = pack(words, COUNT, 4);
    assert_int_equal(p.bytes, COUNT * 6 / 8 + CO_PATCH_PACK_TAIL);
    assert_words(&p, words, COUNT, 4);
    drop(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words_come_back),
        cmocka_unit_test(neighbors_take_few_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
