#include "simd/stream_copy.h"

#include <stdint.h>
#include <string.h>

#if defined(__x86_64__)

#include <emmintrin.h>

#define LINE 64

void co_stream_copy(void *to, const void *from, size_t bytes)
{
    char *out = to;
    const char *in = from;
    size_t head = -(uintptr_t)out % LINE;
    head = head < bytes ? head : bytes;
    memcpy(out, in, head);
    for (out += head, in += head, bytes -= head; bytes >= LINE; bytes -= LINE) {
        for (size_t i = 0; i < LINE; i += sizeof(__m128i)) {
            __m128i part = _mm_loadu_si128((const __m128i *)(const void *)(in + i));
            _mm_stream_si128((__m128i *)(void *)(out + i), part);
        }
        out += LINE;
        in += LINE;
    }
    memcpy(out, in, bytes);
    _mm_sfence(); // such stores are ordered by nothing else
}

#else

void co_stream_copy(void *to, const void *from, size_t bytes)
{
    memcpy(to, from, bytes);
}

#endif
