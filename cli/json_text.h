// Text as JSON has it.

#ifndef COHORT_CLI_JSON_TEXT_H
#define COHORT_CLI_JSON_TEXT_H

#include <stdio.h>

// Prints a quoted text (NULL: an empty one). Names of files may be any bytes: what is no UTF-8
// becomes U+FFFD, so that every reader takes the rest.
void json_print_text(const char *text, FILE *out);

#endif
