// Files of tests: a folder of the program's own, whole files, all that lies below a folder.

#ifndef TEST_SUPPORT_FILES_H
#define TEST_SUPPORT_FILES_H

#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

// A folder that lasts as long as the test program: made and removed, with all in it, by a group's
// setup and teardown.
static char test_folder[64];

static inline int test_folder_make(void **state)
{
    (void)state;
    snprintf(test_folder, sizeof test_folder, "/tmp/cohort-test-XXXXXX");
    return mkdtemp(test_folder) ? 0 : -1;
}

static inline int test_folder_remove(void **state)
{
    char command[80];
    (void)state;
    snprintf(command, sizeof command, "rm -rf %s", test_folder);
    return system(command);
}

// The same, as the folder that the program works in.
static inline int test_folder_enter(void **state)
{
    return test_folder_make(state) || chdir(test_folder) ? -1 : 0;
}

static inline int test_folder_leave(void **state)
{
    return chdir("/") ? -1 : test_folder_remove(state);
}

// The path of a file in it; good until the fourth call after this one.
static inline const char *in_folder(const char *name)
{
    static char paths[4][320];
    static unsigned next;
    char *path = paths[next++ % 4];
    snprintf(path, 320, "%s/%s", test_folder, name);
    return path;
}

static inline void test_write_file(const char *path, const void *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline void test_write_text(const char *path, const char *text)
{
    test_write_file(path, text, strlen(text));
}

// All bytes of a file and a NUL behind them; NULL where there is none. Free it.
static inline void *test_read_file(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    struct stat info;
    *size = 0;
    if (!file)
        return NULL;
    assert_int_equal(fstat(fileno(file), &info), 0);
    size_t count = (size_t)info.st_size;
    char *bytes = malloc(count + 1);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, count, file), count);
    bytes[count] = '\0';
    fclose(file);
    *size = count;
    return bytes;
}

// Every file below a folder whose name does not begin with a dot; none where there is no such
// folder.
static inline void test_each_file(const char *folder, void (*each)(void *context, const char *path),
                                  void *context)
{
    DIR *dir = opendir(folder);
    for (struct dirent *entry; dir && (entry = readdir(dir)) != NULL;) {
        char path[4096];
        struct stat info;
        int length = snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (entry->d_name[0] == '.' || length >= (int)sizeof path || stat(path, &info) != 0)
            continue;
        if (S_ISDIR(info.st_mode))
            test_each_file(path, each, context);
        else
            each(context, path);
    }
    if (dir)
        closedir(dir);
}

// Whether a path ends in this.
static inline bool test_has_suffix(const char *path, const char *suffix)
{
    size_t length = strlen(path), end = strlen(suffix);
    return length >= end && strcmp(path + length - end, suffix) == 0;
}

#endif
