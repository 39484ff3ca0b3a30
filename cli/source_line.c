#include "source_line.h"

#include <stdbool.h>
#include <string.h>

enum {
    BEFORE_MAX = 60, // bytes shown left of the caret
    SHOWN_MAX = 96
};

// Leaves the file at the beginning of a line.
static bool seek_line(FILE *file, uint32_t line)
{
    char block[1 << 14];
    long offset = 0;
    while (line > 1) {
        size_t count = fread(block, 1, sizeof block, file);
        if (!count)
            return false;
        const char *at = block, *end = block + count;
        while (line > 1 && (at = memchr(at, '\n', (size_t)(end - at)))) {
            at++;
            line--;
        }
        offset += line > 1 ? (long)count : (long)(at - block);
    }
    return fseek(file, offset, SEEK_SET) == 0;
}

static bool is_inside_character(char c)
{
    return ((unsigned char)c & 0xc0) == 0x80;
}

static void print_clean(FILE *out, const char *text, size_t length)
{
    for (size_t i = 0; i < length; i++)
        fputc(text[i] == '\t'                                    ? ' '
              : (unsigned char)text[i] < 0x20 || text[i] == 0x7f ? '?'
                                                                 : text[i],
              out);
}

void source_line_print(FILE *out, const char *path, uint32_t line, uint32_t column)
{
    if (!path || !*path || !line || !column)
        return;
    FILE *file = fopen(path, "rb");
    if (!file)
        return;
    char text[SHOWN_MAX + 1];
    size_t skipped = column - 1 > BEFORE_MAX ? column - 1 - BEFORE_MAX : 0;
    if (seek_line(file, line) && fseek(file, (long)skipped, SEEK_CUR) == 0) {
        size_t length = fread(text, 1, sizeof text, file), before = column - 1 - skipped, begin = 0;
        const char *end = length ? memchr(text, '\n', length) : NULL;
        bool is_cut = !end && length == sizeof text;
        length = end ? (size_t)(end - text) : length;
        length -= length > 0 && (text[length - 1] == '\r' || is_cut);
        while (skipped && begin < length && is_inside_character(text[begin]))
            begin++;
        while (is_cut && length > begin && is_inside_character(text[length]))
            length--;
        fprintf(out, "    %s", skipped ? "..." : "");
        print_clean(out, text + begin, length - begin);
        fprintf(out, "%s\n    %s", is_cut ? "..." : "", skipped ? "   " : "");
        for (size_t i = begin; i < before && i < length; i++)
            if (!is_inside_character(text[i]))
                fputc(' ', out);
        fprintf(out, "^\n");
    }
    fclose(file);
}
