#include "source_line.h"

#include <stdbool.h>
#include <string.h>
#include <unistd.h>

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

// What was read of a line from byte `skipped` on; `column` counts from the line's beginning.
typedef struct SourceLine {
    char text[SHOWN_MAX + 1];
    size_t length, skipped, column;
    bool is_cut;
} SourceLine;

static bool read_line(FILE *file, uint32_t line, uint32_t column, SourceLine *out)
{
    out->column = column;
    out->skipped = column - 1 > BEFORE_MAX ? column - 1 - BEFORE_MAX : 0;
    if (!seek_line(file, line) || fseek(file, (long)out->skipped, SEEK_CUR) != 0)
        return false;
    out->length = fread(out->text, 1, sizeof out->text, file);
    const char *end = out->length ? memchr(out->text, '\n', out->length) : NULL;
    out->is_cut = !end && out->length == sizeof out->text;
    if (end)
        out->length = (size_t)(end - out->text);
    if (out->length && (out->text[out->length - 1] == '\r' || out->is_cut))
        out->length--;
    // Neither an empty line nor a binary file has anything to show.
    return out->length && !memchr(out->text, 0, out->length);
}

static void print_line(FILE *out, const SourceLine *line)
{
    size_t begin = 0, end = line->length;
    while (line->skipped && begin < end && is_inside_character(line->text[begin]))
        begin++;
    while (line->is_cut && end > begin && is_inside_character(line->text[end]))
        end--;
    fprintf(out, "    %s", line->skipped ? "..." : "");
    print_clean(out, line->text + begin, end - begin);
    fprintf(out, "%s\n    %s", line->is_cut ? "..." : "", line->skipped ? "   " : "");
    for (size_t i = begin; i < line->column - 1 - line->skipped && i < end; i++)
        if (!is_inside_character(line->text[i]))
            fputc(' ', out);
    fprintf(out, "^\n");
}

void source_line_print(FILE *out, const char *path, uint32_t line, uint32_t column)
{
    if (!path || !*path || !line || !column)
        return;
    FILE *file = fopen(path, "rb");
    SourceLine shown;
    if (file && read_line(file, line, column, &shown))
        print_line(out, &shown);
    if (file)
        fclose(file);
}

const char *path_from_here(const char *path)
{
    char folder[4096];
    size_t length = getcwd(folder, sizeof folder) ? strlen(folder) : 0;
    bool is_below = length > 1 && !strncmp(path, folder, length) && path[length] == '/';
    return is_below ? path + length + 1 : path;
}
