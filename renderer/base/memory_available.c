// What memory is left: of the machine, and within the control groups around the process.

#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// The number a file begins with; UINT64_MAX where it has none ("max": no limit) or is not there.
static uint64_t number_of(const char *path)
{
    FILE *f = fopen(path, "r");
    unsigned long long number;
    bool is_read = f && fscanf(f, "%llu", &number) == 1;
    if (f)
        fclose(f);
    return is_read ? number : UINT64_MAX;
}

// The least limit of a group and the groups around it. Within a container the outer ones do not
// show, and its own stands at the root.
static uint64_t limit_of(const char *root, char *group, const char *file)
{
    uint64_t least = UINT64_MAX;
    for (bool is_root = false; !is_root;) {
        char path[1024], *last = strrchr(group, '/');
        int length = snprintf(path, sizeof path, "%s%s/%s", root, group, file);
        uint64_t limit = length > 0 && (size_t)length < sizeof path ? number_of(path) : UINT64_MAX;
        least = limit < least ? limit : least;
        is_root = !group[0] || !last;
        if (last)
            *last = '\0';
    }
    return least;
}

// Of the control groups of this process, version 1 and 2.
static uint64_t limit_of_groups(void)
{
    FILE *f = fopen("/proc/self/cgroup", "r");
    char line[768];
    uint64_t least = UINT64_MAX;
    while (f && fgets(line, sizeof line, f)) {
        char *group = strstr(line, ":memory:");
        line[strcspn(line, "\n")] = '\0';
        uint64_t limit = UINT64_MAX;
        if (group)
            limit = limit_of("/sys/fs/cgroup/memory", group + 8, "memory.limit_in_bytes");
        else if (strncmp(line, "0::", 3) == 0)
            limit = limit_of("/sys/fs/cgroup", line + 3, "memory.max");
        least = limit < least ? limit : least;
    }
    if (f)
        fclose(f);
    return least;
}

static uint64_t available_to_system(void)
{
    FILE *f = fopen("/proc/meminfo", "r");
    char line[256];
    unsigned long long kilobytes = 0;
    while (f && !kilobytes && fgets(line, sizeof line, f))
        if (sscanf(line, "MemAvailable: %llu", &kilobytes) != 1)
            kilobytes = 0;
    if (f)
        fclose(f);
    return (uint64_t)kilobytes << 10;
}

uint64_t co_memory_available(void)
{
    uint64_t limit = limit_of_groups(), available = available_to_system();
    if (limit == UINT64_MAX)
        return available;
    uint64_t resident = co_memory_resident(), left = limit > resident ? limit - resident : 0;
    return left < available ? left : available;
}
