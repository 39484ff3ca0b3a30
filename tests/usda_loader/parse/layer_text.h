// Text of a layer, put together piece by piece.

#ifndef TEST_LAYER_TEXT_H
#define TEST_LAYER_TEXT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

typedef struct Text {
    char *text; // free() it
    size_t length, capacity;
} Text;

static inline Text begin_text(size_t capacity)
{
    Text text = {malloc(capacity), 0, capacity};
    assert_non_null(text.text);
    return text;
}

static inline void add(Text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));

static inline void add(Text *text, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    int length = vsnprintf(text->text + text->length, text->capacity - text->length, format, args);
    va_end(args);
    assert_true(length >= 0 && text->length + (size_t)length < text->capacity);
    text->length += (size_t)length;
}

#endif
