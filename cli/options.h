// Options of a sub-command as one table: parsing and help come from it.

#ifndef COHORT_CLI_OPTIONS_H
#define COHORT_CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum OptionType {
    OPTION_FLAG = 0, // bool
    OPTION_INT,      // int64_t
    OPTION_NUMBER,   // double
    OPTION_BYTES,    // int64_t, 0 or more, with K, M, G, T
    OPTION_TEXT,     // const char *
    OPTION_LIST      // OptionList, may be given again
} OptionType;

enum {
    OPTION_LIST_MAX = 64
};
typedef struct OptionList {
    const char *items[OPTION_LIST_MAX];
    size_t count;
} OptionList;

typedef struct Option {
    const char *name; // long name without dashes
    char letter;      // 0: none
    OptionType type;
    void *target;
    double least, most;   // of numbers; both 0: any
    const char *argument; // in the help: "N", "FILE"; NULL for flags
    const char *choices;  // "a|b|c" or NULL
    const char *help;
} Option;

// Parses argv into the targets; *first becomes the index of the first positional argument (they are
// moved to the end). Returns 0, or EXIT_USAGE after saying what is wrong.
int options_parse(const char *command, const Option *table, size_t count, int argc, char **argv,
                  int *first);

// Prints the table to standard output.
void options_help(const Option *table, size_t count);

// What a sub-command says of itself, and what it takes beside options.
typedef struct CommandHead {
    const char *name;
    const char *about, *notes; // in its help, above and below the options; notes may be NULL
    int operands;
    const char *what; // they are: "one stage"
} CommandHead;

// Parses, shows the help where *wants_help became true, and counts the operands. Returns -1 to go
// on with argv[*first], else the exit code.
int options_begin(const CommandHead *head, const Option *table, size_t count,
                  const bool *wants_help, int argc, char **argv, int *first);

#endif
