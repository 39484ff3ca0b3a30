// Mapped and scratch files: what is there, what is not, what must not be opened at all.

#include "base/mapped_file.h"
#include "support/files.h"

#include <fcntl.h>

static char path[96];

static int make_folder(void **state)
{
    int failed = test_folder_make(state);
    snprintf(path, sizeof path, "%s/file", test_folder);
    return failed;
}

static void bytes_are_mapped(void **state)
{
    (void)state;
    char bytes[10000];
    for (size_t i = 0; i < sizeof bytes; i++)
        bytes[i] = (char)(i * 7);
    test_write_file(path, bytes, sizeof bytes);
    CoMappedFile file = {0};
    CohortError err = {0};
    assert_true(co_mapped_file_open(path, &file, &err));
    assert_int_equal(file.size, sizeof bytes);
    assert_memory_equal(file.data, bytes, sizeof bytes);
    // Given back and read again: the same.
    const char *data = file.data;
    co_mapped_file_release(data, data + sizeof bytes);
    co_mapped_file_release(data + 5000, data + 10);
    assert_memory_equal(file.data, bytes, sizeof bytes);
    co_mapped_file_close(&file);
    assert_null(file.data);
    assert_int_equal(file.size, 0);
    co_mapped_file_close(&file);
}

static void an_empty_file_is_no_failure(void **state)
{
    (void)state;
    test_write_file(path, "", 0);
    CoMappedFile file = {"x", 1};
    assert_true(co_mapped_file_open(path, &file, NULL));
    assert_null(file.data);
    assert_int_equal(file.size, 0);
    co_mapped_file_close(&file);
}

static void expect_failure(const char *name, CohortErrorCode code)
{
    CoMappedFile file = {"x", 1};
    CohortError err = {0};
    assert_false(co_mapped_file_open(name, &file, &err));
    assert_int_equal(err.code, code);
    assert_non_null(strstr(err.message, name));
    assert_string_equal(err.file, name);
    assert_int_equal(file.size, 1);
}

static void what_is_no_file_is_named(void **state)
{
    (void)state;
    char fifo[80];
    expect_failure("/nowhere/at/all", COHORT_ERROR_FILE_NOT_FOUND);
    expect_failure(test_folder, COHORT_ERROR_FILE_READ);
    expect_failure("/dev/null", COHORT_ERROR_FILE_READ);
    snprintf(fifo, sizeof fifo, "%s/file/below", test_folder);
    test_write_file(path, "a", 1);
    expect_failure(fifo, COHORT_ERROR_FILE_READ);
}

// No writer ever comes: opening a pipe to read must not wait for one.
static void a_pipe_is_refused_at_once(void **state)
{
    (void)state;
    unlink(path);
    assert_int_equal(mkfifo(path, 0600), 0);
    alarm(20);
    expect_failure(path, COHORT_ERROR_FILE_READ);
    alarm(0);
    unlink(path);
}

static void scratch_files_have_no_name(void **state)
{
    (void)state;
    CohortError err = {0};
    int fd = co_scratch_file(test_folder, 100000, &err);
    assert_true(fd >= 0);
    struct stat info;
    assert_int_equal(fstat(fd, &info), 0);
    assert_int_equal(info.st_size, 100000);
    assert_int_equal(info.st_nlink, 0);
    assert_int_equal(pwrite(fd, "end", 3, 99997), 3);
    close(fd);
    fd = co_scratch_file(test_folder, 0, &err);
    assert_true(fd >= 0);
    close(fd);
    assert_int_equal(err.code, COHORT_OK);
}

static void scratch_that_cannot_be_is_said(void **state)
{
    (void)state;
    CohortError err = {0};
    assert_int_equal(co_scratch_file("/nowhere", 100, &err), -1);
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    assert_non_null(strstr(err.message, "/nowhere"));
    err = (CohortError){0};
    assert_int_equal(co_scratch_file(test_folder, (size_t)1 << 60, &err), -1);
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    char longer[5000];
    memset(longer, 'd', sizeof longer - 1);
    longer[0] = '/';
    longer[sizeof longer - 1] = '\0';
    err = (CohortError){0};
    assert_int_equal(co_scratch_file(longer, 0, &err), -1);
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_mapped),
        cmocka_unit_test(an_empty_file_is_no_failure),
        cmocka_unit_test(what_is_no_file_is_named),
        cmocka_unit_test(a_pipe_is_refused_at_once),
        cmocka_unit_test(scratch_files_have_no_name),
        cmocka_unit_test(scratch_that_cannot_be_is_said),
    };
    return cmocka_run_group_tests(tests, make_folder, test_folder_remove);
}
