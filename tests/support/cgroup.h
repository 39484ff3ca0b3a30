// A memory cgroup (version 1) of a test's own, where the system lets one be made.

#ifndef TEST_SUPPORT_CGROUP_H
#define TEST_SUPPORT_CGROUP_H

#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static inline bool test_write_number(const char *folder, const char *file, long long number)
{
    char path[700];
    snprintf(path, sizeof path, "%s/%s", folder, file);
    FILE *f = fopen(path, "w");
    if (!f)
        return false;
    bool ok = fprintf(f, "%lld\n", number) > 0;
    return fclose(f) == 0 && ok;
}

// Makes a group with a limit beneath that of this process; *folder names it. False where there is
// no such thing.
static inline bool test_cgroup_make(char *folder, size_t size, long long bytes)
{
    FILE *f = fopen("/proc/self/cgroup", "r");
    char line[512];
    bool is_made = false;
    while (f && !is_made && fgets(line, sizeof line, f)) {
        char *path = strstr(line, ":memory:");
        if (!path)
            continue;
        path[strcspn(path, "\n")] = 0;
        snprintf(folder, size, "/sys/fs/cgroup/memory%s/cohort-test-%ld", path + 8, (long)getpid());
        is_made = mkdir(folder, 0755) == 0;
    }
    if (f)
        fclose(f);
    if (is_made && !test_write_number(folder, "memory.limit_in_bytes", bytes)) {
        rmdir(folder);
        is_made = false;
    }
    return is_made;
}

// For a child: enters the group before it uses memory.
static inline bool test_cgroup_enter(const char *folder)
{
    return test_write_number(folder, "cgroup.procs", (long long)getpid());
}

// A group empties a moment after its last process has ended.
static inline void test_cgroup_remove(const char *folder)
{
    for (int i = 0; i < 50 && rmdir(folder) != 0; i++)
        usleep(20000);
}

#endif
