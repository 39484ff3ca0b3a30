// A memory cgroup (version 1) of a test's own, where the system lets one be made, and a child in
// it.

#ifndef TEST_SUPPORT_CGROUP_H
#define TEST_SUPPORT_CGROUP_H

#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
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

// Does some work in a child, whose peak of memory is its own: `work` fills `size` bytes at `out`,
// which come back. folder: of a cgroup that the child enters first, NULL: none. peak_bytes: most
// that was resident; may be NULL. False when the child did not end well. The parent must have
// started no threads: they do not survive a fork.
static inline bool test_in_child(const char *folder, void (*work)(const void *context, void *out),
                                 const void *context, void *out, size_t size, size_t *peak_bytes)
{
    int ends[2], status = 0;
    struct rusage usage = {0};
    if (pipe(ends) != 0)
        return false;
    pid_t child = fork();
    if (child == 0) {
        if (folder && !test_cgroup_enter(folder))
            _exit(2);
        work(context, out);
        _exit(write(ends[1], out, size) == (ssize_t)size ? 0 : 1);
    }
    close(ends[1]);
    bool is_whole = child > 0 && read(ends[0], out, size) == (ssize_t)size;
    close(ends[0]);
    if (child < 0 || wait4(child, &status, 0, &usage) != child)
        return false;
    if (peak_bytes)
        *peak_bytes = (size_t)usage.ru_maxrss * 1024;
    return is_whole && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

#endif
