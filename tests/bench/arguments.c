#include "arguments.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *name_of(const char *program)
{
    const char *slash = strrchr(program, '/');
    return slash ? slash + 1 : program;
}

void bench_refuse(const char *program, const char *format, ...)
{
    va_list values;
    fprintf(stderr, "%s: ", name_of(program));
    va_start(values, format);
    vfprintf(stderr, format, values);
    va_end(values);
    fprintf(stderr, "; see %s --help\n", name_of(program));
    exit(2);
}

// Whether a list begins with the word, of that length.
static bool begins_with(const char *list, const char *word, size_t length)
{
    return strncmp(list, word, length) == 0 && (list[length] == '\0' || list[length] == ',');
}

static bool has_word(const char *list, const char *word, size_t length)
{
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL)
        if (begins_with(at, word, length))
            return true;
    return false;
}

bool bench_is_listed(const char *list, const char *word)
{
    return has_word(list, word, strlen(word));
}

static void read_text(const char *program, const BenchArgument *argument, const char *value)
{
    for (const char *at = value; argument->words && at;
         at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL) {
        int length = (int)strcspn(at, ",");
        if (!has_word(argument->words, at, (size_t)length))
            bench_refuse(program, "%s takes %s, not '%.*s'", argument->name, argument->words,
                         length, at);
    }
    *argument->text = value;
}

static void read_number(const char *program, const BenchArgument *argument, const char *value)
{
    char *end;
    double number = strtod(value, &end);
    if (end == value || *end || floor(number) != number || !(number >= argument->least) ||
        !(number <= argument->most))
        bench_refuse(program, "%s takes a whole number from %.0f to %.0f, not '%s'", argument->name,
                     argument->least, argument->most, value);
    *argument->number = number;
}

static void read_value(const char *program, const BenchArgument *argument, const char *value)
{
    if (!value)
        bench_refuse(program, "%s wants a value", argument->name);
    if (argument->number)
        read_number(program, argument, value);
    else
        read_text(program, argument, value);
}

// The argument of that name or, for a word without dashes, the one of that place; NULL: none.
static const BenchArgument *find(const BenchArgument *table, size_t count, const char *word,
                                 size_t place)
{
    bool is_option = strncmp(word, "--", 2) == 0;
    for (size_t i = 0; i < count; i++) {
        if (strncmp(table[i].name, "--", 2) == 0) {
            if (strcmp(table[i].name, word) == 0)
                return &table[i];
        } else if (!is_option && place-- == 0) {
            return &table[i];
        }
    }
    return NULL;
}

void bench_arguments_read(int argc, char **argv, const char *usage, const BenchArgument *table,
                          size_t count)
{
    size_t places = 0;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) {
            fputs(usage, stdout);
            exit(0);
        }
    }
    for (int i = 1; i < argc; i++) {
        const BenchArgument *argument = find(table, count, argv[i], places);
        if (!argument)
            bench_refuse(argv[0],
                         strncmp(argv[i], "--", 2) == 0 ? "there is no option '%s'"
                                                        : "'%s' is one argument too many",
                         argv[i]);
        else if (argument->flag)
            *argument->flag = true;
        else if (strncmp(argument->name, "--", 2) == 0)
            i++, read_value(argv[0], argument, i < argc ? argv[i] : NULL);
        else
            places++, read_value(argv[0], argument, argv[i]);
    }
}
