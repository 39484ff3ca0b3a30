// Showing the place in a text file that a message is about.

#ifndef COHORT_CLI_SOURCE_LINE_H
#define COHORT_CLI_SOURCE_LINE_H

#include <stdint.h>
#include <stdio.h>

// Prints the line with a caret under the column (both 1-based, columns in bytes), cut to what fits
// on a terminal. Nothing when there is no such place.
void source_line_print(FILE *out, const char *path, uint32_t line, uint32_t column);

// The path from the current folder on where it lies below it, else all of it.
const char *path_from_here(const char *path);

#endif
