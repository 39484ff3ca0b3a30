// Runs a fuzz target over files, each also cut short and with bits flipped: what ctest does.

#include "fuzz.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

enum {
    BYTES_MAX = 1 << 16,
    VARIANTS = 6
};

// A block of exactly the size, so that a sanitizer sees what is read past it.
static void try_bytes(const uint8_t *bytes, size_t size)
{
    uint8_t *copy = malloc(size ? size : 1);
    fuzz_require(copy != NULL);
    memcpy(copy, bytes, size);
    LLVMFuzzerTestOneInput(copy, size);
    free(copy);
}

static void replay(const char *path)
{
    static uint8_t bytes[BYTES_MAX];
    FILE *file = fopen(path, "rb");
    fuzz_require(file != NULL);
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    try_bytes(bytes, size);
    uint32_t state = 1;
    for (int i = 0; i < VARIANTS && size; i++) {
        state = state * 1664525u + 1013904223u;
        size_t at = (state >> 8) % size;
        try_bytes(bytes, at);
        bytes[at] ^= (uint8_t)(1u << (state >> 29));
        try_bytes(bytes, size);
        bytes[at] ^= (uint8_t)(1u << (state >> 29));
    }
}

int main(int argc, char **argv)
{
    size_t count = 0;
    for (int i = 1; i < argc; i++) {
        DIR *folder = opendir(argv[i]);
        for (struct dirent *entry; folder && (entry = readdir(folder));) {
            char path[4096];
            struct stat info;
            snprintf(path, sizeof path, "%s/%s", argv[i], entry->d_name);
            if (entry->d_name[0] == '.' || stat(path, &info) != 0 || !S_ISREG(info.st_mode))
                continue;
            replay(path);
            count++;
        }
        if (folder)
            closedir(folder);
    }
    printf("%zu files replayed\n", count);
    return count ? 0 : 1;
}
