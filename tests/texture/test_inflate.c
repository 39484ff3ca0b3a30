// Inflating: exactly what was asked for or nothing; blocks are counted.

#include "texture/inflate.h"

#include <libdeflate.h>
#include <stdlib.h>
#include <string.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum {
    SIZE = 5000
};

static size_t pack(unsigned char plain[SIZE], unsigned char *packed, size_t room)
{
    for (int i = 0; i < SIZE; i++)
        plain[i] = (unsigned char)(i * i >> 5);
    struct libdeflate_compressor *compressor = libdeflate_alloc_compressor(6);
    size_t length = libdeflate_zlib_compress(compressor, plain, SIZE, packed, room);
    libdeflate_free_compressor(compressor);
    assert_true(length > 0);
    return length;
}

static void only_the_right_size_will_do(void **state)
{
    (void)state;
    unsigned char plain[SIZE], packed[2 * SIZE], out[SIZE + 8];
    size_t length = pack(plain, packed, sizeof packed);
    CoInflate inflate = {0};
    assert_true(co_inflate(&inflate, packed, length, out, SIZE, NULL, NULL));
    assert_memory_equal(out, plain, SIZE);
    assert_false(co_inflate(&inflate, packed, length, out, SIZE - 1, NULL, NULL));
    assert_false(co_inflate(&inflate, packed, length, out, SIZE + 1, NULL, NULL));
    assert_false(co_inflate(&inflate, packed, length, out, 0, NULL, NULL));
    assert_true(co_inflate(&inflate, packed, length, out, SIZE, NULL, NULL));
    co_inflate_clear(&inflate);
    assert_null(inflate.state);
    co_inflate_clear(&inflate);
}

static void damage_is_noticed(void **state)
{
    (void)state;
    unsigned char plain[SIZE], packed[2 * SIZE], *cut, out[SIZE];
    size_t length = pack(plain, packed, sizeof packed);
    CoInflate inflate = {0};
    size_t unread = 0;
    for (size_t i = 0; i < length; i++) {
        packed[i] ^= 0x10;
        bool is_read = co_inflate(&inflate, packed, length, out, SIZE, NULL, NULL);
        packed[i] ^= 0x10;
        // The sum at the end covers all but a few bits that do not matter.
        assert_true(!is_read || memcmp(out, plain, SIZE) == 0);
        unread += !is_read;
    }
    assert_true(unread + 3 > length);
    for (size_t size = 0; size < length; size += 1 + size / 7) {
        cut = malloc(size + 1); // so that reading beyond is seen
        memcpy(cut, packed, size);
        assert_false(co_inflate(&inflate, cut, size, out, SIZE, NULL, NULL));
        free(cut);
    }
    co_inflate_clear(&inflate);
}

static void impossible_sizes_are_told_before(void **state)
{
    (void)state;
    assert_true(co_inflate_is_possible(10, 10320));
    assert_false(co_inflate_is_possible(10, 10321));
    assert_true(co_inflate_is_possible(0, 0));
    assert_false(co_inflate_is_possible(0, 1));
    assert_false(co_inflate_is_possible(1000, UINT64_MAX));
}

static void blocks_are_counted_once_a_batch(void **state)
{
    (void)state;
    unsigned char plain[SIZE], packed[2 * SIZE], out[SIZE];
    size_t length = pack(plain, packed, sizeof packed);
    CoInflate inflate = {0};
    CoBlockCount count = {.batch = 1};
    CoBlockStamp stamps[2] = {0};
    for (int i = 0; i < 2; i++)
        assert_true(co_inflate(&inflate, packed, length, out, SIZE, &count, &stamps[i]));
    assert_int_equal(count.read, 2);
    assert_int_equal(count.twice, 0);
    assert_int_equal(count.bytes, 2 * length);
    assert_true(co_inflate(&inflate, packed, length, out, SIZE, &count, &stamps[0]));
    assert_int_equal(count.twice, 1);
    count.batch = 2; // another batch may read it again
    assert_true(co_inflate(&inflate, packed, length, out, SIZE, &count, &stamps[0]));
    assert_int_equal(count.read, 4);
    assert_int_equal(count.twice, 1);
    co_inflate_clear(&inflate);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_the_right_size_will_do),
        cmocka_unit_test(damage_is_noticed),
        cmocka_unit_test(impossible_sizes_are_told_before),
        cmocka_unit_test(blocks_are_counted_once_a_batch),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
