#include "base/mapped_file.h"

#include "base/error.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    NO_FILE = -1
}; // in place of an errno

static bool fail(const char *path, int cause, CohortError *err)
{
    CohortErrorCode code = cause == ENOENT ? COHORT_ERROR_FILE_NOT_FOUND : COHORT_ERROR_FILE_READ;
    co_error_set(err, CO_HERE, code, "cannot open %s: %s", path,
                 cause == NO_FILE ? "it is a pipe or a device, not a file" : strerror(cause));
    co_error_place(err, path, 0, 0, NULL);
    return false;
}

bool co_mapped_file_open(const char *path, CoMappedFile *out, CohortError *err)
{
    // Without waiting: a pipe, which is refused below, may never get a writer.
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return fail(path, errno, err);
    struct stat info;
    int cause = fstat(fd, &info) ? errno : S_ISDIR(info.st_mode) ? EISDIR : 0;
    void *data = NULL;
    if (!cause && !S_ISREG(info.st_mode))
        cause = NO_FILE;
    if (!cause && info.st_size > 0) {
        data = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, fd, 0);
        if (data == MAP_FAILED)
            cause = errno;
    }
    close(fd);
    if (cause)
        return fail(path, cause, err);
    *out = (CoMappedFile){data, (size_t)info.st_size};
    return true;
}

void co_mapped_file_close(CoMappedFile *file)
{
    if (file->data)
        munmap((void *)(uintptr_t)file->data, file->size);
    *file = (CoMappedFile){NULL, 0};
}

void co_mapped_file_release(const void *begin, const void *stop)
{
    uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE);
    uintptr_t from = (uintptr_t)begin & ~(page - 1), to = (uintptr_t)stop & ~(page - 1);
    if (to > from)
        madvise((void *)from, to - from, MADV_DONTNEED);
}

int co_scratch_file(const char *folder, size_t bytes, CohortError *err)
{
    if (!folder || !folder[0])
        folder = getenv("TMPDIR");
    if (!folder || !folder[0])
        folder = "/tmp";
    char path[4096];
    int length = snprintf(path, sizeof path, "%s/cohort-scratch-XXXXXX", folder);
    int fd = length > 0 && (size_t)length < sizeof path ? mkstemp(path) : -1;
    if (fd < 0) {
        CO_FAIL(err, COHORT_ERROR_FILE_WRITE,
                "cannot create a scratch file in %s: %s; name a writable folder with --scratch",
                folder, strerror(errno));
        return -1;
    }
    unlink(path);
    int cause = bytes ? posix_fallocate(fd, 0, (off_t)bytes) : 0;
    if (cause) {
        close(fd);
        CO_FAIL(err, COHORT_ERROR_FILE_WRITE,
                "cannot reserve %zu MB of scratch space in %s: %s; free some or use --scratch",
                bytes >> 20, folder, strerror(cause));
        return -1;
    }
    return fd;
}
