// What memory is left: less than the machine has, and no more than a control group gives.

#include "support/cgroup.h"

#include "base/memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/wait.h>

#include <cmocka.h>

static void less_is_available_than_there_is(void **state)
{
    (void)state;
    uint64_t pages = (uint64_t)sysconf(_SC_PHYS_PAGES), page = (uint64_t)sysconf(_SC_PAGESIZE);
    uint64_t available = co_memory_available();
    if (!available)
        skip();
    assert_true(available > (uint64_t)1 << 20);
    assert_true(available < pages * page);
}

// Asked in a child, whose group it is; what the child holds already is taken off.
static void a_control_group_limits_it(void **state)
{
    (void)state;
    const uint64_t limit = (uint64_t)64 << 20;
    char folder[600];
    if (!test_cgroup_make(folder, sizeof folder, (long long)limit))
        skip();
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        if (!test_cgroup_enter(folder))
            _exit(2);
        uint64_t available = co_memory_available();
        _exit(available > 0 && available < limit ? 0 : 1);
    }
    int status = 0;
    waitpid(child, &status, 0);
    test_cgroup_remove(folder);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(less_is_available_than_there_is),
        cmocka_unit_test(a_control_group_limits_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
