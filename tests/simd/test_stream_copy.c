// Copies around the caches: every byte, and no other, whatever the alignment and length.

#include "simd/stream_copy.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum {
    ROOM = 640,
    MARK = 0xa5
};

static void only_what_is_asked_for_is_copied(void **state)
{
    (void)state;
    _Alignas(64) unsigned char from[ROOM], to[ROOM];
    for (size_t i = 0; i < ROOM; i++)
        from[i] = (unsigned char)(i * 7 + i / 256);
    const size_t lengths[] = {0, 1, 15, 63, 64, 65, 127, 128, 200, 512};
    for (size_t n = 0; n < sizeof lengths / sizeof *lengths; n++)
        for (size_t at = 0; at < 64; at += n % 2 ? 1 : 4)
            for (size_t source = 0; source < 64; source += 9) {
                memset(to, MARK, ROOM);
                co_stream_copy(to + at, from + source, lengths[n]);
                assert_memory_equal(to + at, from + source, lengths[n]);
                for (size_t i = 0; i < at; i++)
                    assert_int_equal(to[i], MARK);
                for (size_t i = at + lengths[n]; i < ROOM; i++)
                    assert_int_equal(to[i], MARK);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_what_is_asked_for_is_copied),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
