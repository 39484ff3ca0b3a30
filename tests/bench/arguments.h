// Arguments of the measuring programs: --help prints the usage and ends with 0; whatever is not
// understood is told in one line on stderr and ends with 2.

#ifndef BENCH_ARGUMENTS_H
#define BENCH_ARGUMENTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

// Of number, text and flag one is not NULL: where the value goes, which holds the default until
// then.
typedef struct BenchArgument {
    const char *name; // "--rays"; without dashes: known by its place among such, all of which may
                      // be left out
    double *number;   // a whole one
    double least, most;
    const char **text;
    const char
        *words; // what the text may be, with commas between, several of them too; NULL: anything
    bool *flag; // no value follows
} BenchArgument;

// Reads all of argv by the table; does not return when it cannot.
void bench_arguments_read(int argc, char **argv, const char *usage, const BenchArgument *table,
                          size_t count);

// Whether a list, words with commas between, has the word.
bool bench_is_listed(const char *list, const char *word);

// On stderr, where a program to stand beside Embree was built without it.
static inline void bench_tell_of_embree(void)
{
#ifndef BENCH_EMBREE
    fputs("built without Embree, so nothing is compared with it: install libembree-dev, then run "
          "cmake again\n",
          stderr);
#endif
}

// "PROGRAM: ...; see PROGRAM --help" on stderr, exit code 2.
_Noreturn void bench_refuse(const char *program, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif
