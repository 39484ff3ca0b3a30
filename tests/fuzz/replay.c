// Runs a fuzz target over files, each also cut short and with bits flipped: what ctest does.

#include "fuzz.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>

enum {
    BYTES_MAX = 1 << 16,
    VARIANTS = 6
};

static void replay(const char *path)
{
    static uint8_t bytes[BYTES_MAX], changed[BYTES_MAX];
    FILE *file = fopen(path, "rb");
    if (!file)
        return;
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    LLVMFuzzerTestOneInput(bytes, size);
    uint32_t state = 1;
    for (int i = 0; i < VARIANTS && size; i++) {
        state = state * 1664525u + 1013904223u;
        size_t at = (state >> 8) % size;
        LLVMFuzzerTestOneInput(bytes, at);
        memcpy(changed, bytes, size);
        changed[at] ^= (uint8_t)(1u << (state >> 29));
        LLVMFuzzerTestOneInput(changed, size);
    }
}

int main(int argc, char **argv)
{
    size_t count = 0;
    for (int i = 1; i < argc; i++) {
        DIR *folder = opendir(argv[i]);
        for (struct dirent *entry; folder && (entry = readdir(folder));) {
            char path[4096];
            snprintf(path, sizeof path, "%s/%s", argv[i], entry->d_name);
            if (entry->d_name[0] == '.')
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
