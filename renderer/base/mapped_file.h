// A whole file mapped read-only, and unlinked scratch files mapped read-write.

#ifndef CO_BASE_MAPPED_FILE_H
#define CO_BASE_MAPPED_FILE_H

#include "cohort/base.h"

typedef struct CoMappedFile {
    const void *data; // valid until co_mapped_file_close; NULL for an empty file
    size_t size;      // bytes
} CoMappedFile;

// Maps `path`; directories, missing and unreadable files give a clear error with the file named.
bool co_mapped_file_open(const char *path, CoMappedFile *out, CohortError *err);
void co_mapped_file_close(CoMappedFile *file);

// Gives the memory of what was read between two places of a mapped file back; the page of `stop`
// stays. Reading there again reads the file.
void co_mapped_file_release(const void *begin, const void *stop);

// Creates a file in `folder` (NULL: $TMPDIR or /tmp) that has no name any more, so that it never
// outlives the process. `bytes` are allocated at once: a full disk is reported here, not as a
// signal later. Returns the descriptor, or -1.
int co_scratch_file(const char *folder, size_t bytes, CohortError *err);

#endif
