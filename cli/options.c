#include "options.h"

#include "cli.h"

#include <ctype.h>
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    OPTIONS_MAX = 64,
    HELP_LEFT = 34,  // columns between which
    HELP_RIGHT = 100 // options are explained
};

static bool is_choice(const char *choices, const char *text)
{
    size_t length = strlen(text);
    for (const char *c = choices; c; c = strchr(c, '|') ? strchr(c, '|') + 1 : NULL) {
        size_t n = strcspn(c, "|");
        if (n == length && !strncmp(c, text, n))
            return true;
    }
    return false;
}

static bool parse_number(const char *text, const char **end, double *out)
{
    char *stop = NULL;
    errno = 0;
    *out = strtod(text, &stop);
    *end = stop;
    return stop != text && errno == 0;
}

static bool store_number(const Option *o, const char *text)
{
    double value;
    const char *end;
    if (!parse_number(text, &end, &value))
        return false;
    if (o->type == OPTION_BYTES) {
        static const char units[] = "KMGT";
        const char *unit =
            isalpha((unsigned char)*end) ? strchr(units, toupper((unsigned char)*end)) : NULL;
        for (long i = unit ? unit - units + 1 : 0; i > 0; i--)
            value *= 1024.0;
        end += unit != NULL;
        end += unit && *end == 'i';
        end += *end == 'B' || *end == 'b';
    }
    if (*end || !isfinite(value) ||
        ((o->least != 0.0 || o->most != 0.0) && (value < o->least || value > o->most)))
        return false;
    if (o->type == OPTION_NUMBER) {
        *(double *)o->target = value;
        return true;
    }
    if (value < -9e18 || value > 9e18 || value != (double)(int64_t)value)
        return false;
    if (o->type == OPTION_BYTES && value < 0.0)
        return false;
    *(int64_t *)o->target = (int64_t)value;
    return true;
}

static int store(const char *command, const Option *o, const char *text)
{
    // A variable of a script that is not set: nobody means the default by that.
    if (text && !text[0])
        return usage_error(command, "--%s has an empty value", o->name);
    switch (o->type) {
    case OPTION_FLAG:
        *(bool *)o->target = true;
        return 0;
    case OPTION_TEXT:
        if (o->choices && !is_choice(o->choices, text))
            return usage_error(command, "--%s %s: expected one of %s", o->name, text, o->choices);
        *(const char **)o->target = text;
        return 0;
    case OPTION_LIST: {
        OptionList *list = o->target;
        if (list->count == OPTION_LIST_MAX)
            return usage_error(command, "--%s is given more than %d times", o->name,
                               OPTION_LIST_MAX);
        list->items[list->count++] = text;
        return 0;
    }
    case OPTION_INT:
    case OPTION_NUMBER:
    case OPTION_BYTES:
        break;
    }
    if (store_number(o, text))
        return 0;
    if (o->type == OPTION_BYTES)
        return usage_error(command, "--%s %s: expected bytes, such as 800M or 4G", o->name, text);
    const char *kind = o->type == OPTION_INT ? "whole number" : "number";
    if (o->least != 0.0 || o->most != 0.0)
        return usage_error(command, "--%s %s: expected a %s from %.10g to %.10g", o->name, text,
                           kind, o->least, o->most);
    return usage_error(command, "--%s %s: expected a %s", o->name, text, kind);
}

int options_parse(const char *command, const Option *table, size_t count, int argc, char **argv,
                  int *first)
{
    struct option longs[OPTIONS_MAX + 1] = {{0}};
    char shorts[3 * OPTIONS_MAX + 2] = ":";
    for (size_t i = 0; i < count && i < OPTIONS_MAX; i++) {
        bool takes = table[i].type != OPTION_FLAG;
        longs[i].name = table[i].name;
        longs[i].has_arg = takes ? required_argument : no_argument;
        longs[i].val = 256 + (int)i;
        if (table[i].letter) {
            char spec[3] = {table[i].letter, takes ? ':' : 0, 0};
            strcat(shorts, spec);
        }
    }
    optind = 0; // glibc's way to begin anew
    opterr = 0;
    for (int c; (c = getopt_long(argc, argv, shorts, longs, NULL)) != -1;) {
        const Option *o = c >= 256 ? &table[c - 256] : NULL;
        for (size_t i = 0; !o && i < count; i++)
            if (table[i].letter && table[i].letter == c)
                o = &table[i];
        if (c == ':')
            return usage_error(command, "%s needs a value", argv[optind - 1]);
        if (!o)
            return usage_error(command, "%s is not an option", argv[optind - 1]);
        int code = store(command, o, optarg);
        if (code)
            return code;
    }
    *first = optind;
    return 0;
}

// Words from a column on, which the cursor is in.
static void print_wrapped(const char *text)
{
    size_t at = HELP_LEFT;
    for (size_t word; (word = strcspn(text, " ")) > 0; text += word + strspn(text + word, " ")) {
        if (at > HELP_LEFT && at + 1 + word > HELP_RIGHT) {
            printf("\n%*s", HELP_LEFT, "");
            at = HELP_LEFT;
        }
        at += word + (at > HELP_LEFT);
        printf("%s%.*s", at > HELP_LEFT + word ? " " : "", (int)word, text);
    }
    putchar('\n');
}

void options_help(const Option *table, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const Option *o = &table[i];
        char left[96];
        int n = o->letter ? snprintf(left, sizeof left, "  -%c, --%s", o->letter, o->name)
                          : snprintf(left, sizeof left, "      --%s", o->name);
        if (o->type != OPTION_FLAG && n > 0)
            snprintf(left + n, sizeof left - (size_t)n, " %s",
                     o->choices    ? o->choices
                     : o->argument ? o->argument
                                   : "VALUE");
        bool is_long = strlen(left) + 2 > HELP_LEFT;
        printf("%s%s%*s", left, is_long ? "\n" : "", HELP_LEFT - (is_long ? 0 : (int)strlen(left)),
               "");
        print_wrapped(o->help);
    }
}

int options_begin(const CommandHead *head, const Option *table, size_t count,
                  const bool *wants_help, int argc, char **argv, int *first)
{
    int code = options_parse(head->name, table, count, argc, argv, first);
    if (code)
        return code;
    if (*wants_help) {
        fputs(head->about, stdout);
        options_help(table, count);
        fputs(head->notes ? head->notes : "", stdout);
        return EXIT_WRITTEN;
    }
    if (argc - *first != head->operands)
        return usage_error(head->name, "expected %s, got %d", head->what, argc - *first);
    return -1;
}
