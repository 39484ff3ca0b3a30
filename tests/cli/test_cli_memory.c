// Commands that ask a stage run out of memory: what they print is whole, or an error says that it
// is not. Also tests failure.c.

#include "cli/cli.h"

#include "support/faults.h"
#include "support/files.h"

#include <fcntl.h>

typedef int CommandFn(int argc, char **argv);

typedef struct Ran {
    int code;
    char out[8192], err[8192];
} Ran;

static const char out_file[] = "out.txt", err_file[] = "err.txt";

static void read_file(const char *path, char *out, size_t size)
{
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    size_t length = fread(out, 1, size - 1, file);
    assert_true(length < size - 1);
    out[length] = 0;
    fclose(file);
}

// Sends what is written there to a file; returns what brings it back.
static int redirect(int descriptor, const char *path)
{
    int kept = dup(descriptor), file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    assert_true(kept >= 0 && file >= 0 && dup2(file, descriptor) == descriptor);
    close(file);
    return kept;
}

static void bring_back(int descriptor, int kept)
{
    assert_int_equal(dup2(kept, descriptor), descriptor);
    close(kept);
}

// Of `faults`, the next is met, if there are any.
static void run(CommandFn *command, const char *const *words, TestFaults *faults, Ran *ran)
{
    char *argv[8] = {NULL};
    int argc = 0;
    for (; words[argc]; argc++)
        argv[argc] = (char *)(uintptr_t)words[argc];
    fflush(stdout);
    int out = redirect(STDOUT_FILENO, out_file), err = redirect(STDERR_FILENO, err_file);
    if (faults)
        test_faults_begin(faults);
    ran->code = command(argc, argv);
    fflush(stdout);
    bring_back(STDOUT_FILENO, out);
    bring_back(STDERR_FILENO, err);
    read_file(out_file, ran->out, sizeof ran->out);
    read_file(err_file, ran->err, sizeof ran->err);
}

static void check_command(CommandFn *command, const char *const *words)
{
    Ran whole, ran;
    run(command, words, NULL, &whole);
    assert_true(whole.code == EXIT_WRITTEN && whole.out[0]);
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        run(command, words, &faults, &ran);
        CohortError err = {0};
        bool is_whole = ran.code == whole.code && strcmp(ran.out, whole.out) == 0;
        if (strstr(ran.err, "error: out of memory"))
            err = (CohortError){.code = COHORT_ERROR_OUT_OF_MEMORY, .message = "said"};
        assert_true(is_whole || ran.code == EXIT_LOAD);
        test_faults_end(&faults, is_whole, &err);
    }
    assert_true(faults.count > 5);
}

static void test_tree(void **state)
{
    (void)state;
    const char *const all[] = {"tree", "stage.usda", NULL};
    const char *const one[] = {"tree", "--composition", "/World/Ball", "stage.usda", NULL};
    check_command(command_tree, all);
    check_command(command_tree, one);
}

static void test_check(void **state)
{
    (void)state;
    const char *const text[] = {"check", "stage.usda", NULL};
    const char *const json[] = {"check", "--json", "stage.usda", NULL};
    check_command(command_check, text);
    check_command(command_check, json);
}

static int make_stage(void **state)
{
    static const char text[] =
        "#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n"
        "def Xform \"World\"\n{\n"
        "    class Xform \"Kind\"\n    {\n        def Sphere \"Part\" {}\n    }\n"
        "    def Xform \"One\" (\n        instanceable = true\n        inherits = </World/Kind>\n"
        "    )\n    {\n    }\n"
        "    def Camera \"Camera\" {}\n    def SphereLight \"Light\" {}\n"
        "    def Mesh \"Ball\" (\n        prepend variantSets = \"size\"\n"
        "        variants = {\n            string size = \"big\"\n        }\n    )\n    {\n"
        "        int[] faceVertexCounts = [3]\n        int[] faceVertexIndices = [0, 1, 2]\n"
        "        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n"
        "        float3[] extent = [(0, 0, 0), (1, 1, 0)]\n"
        "        vector3f[] velocities = [(1, 0, 0), (1, 0, 0), (1, 0, 0)]\n"
        "        variantSet \"size\" = {\n            \"big\" {\n"
        "                double3 xformOp:scale = (2, 2, 2)\n"
        "                uniform token[] xformOpOrder = [\"xformOp:scale\"]\n"
        "            }\n        }\n    }\n}\n";
    if (test_folder_enter(state))
        return -1;
    test_write_file("stage.usda", text, sizeof text - 1);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_check), cmocka_unit_test(test_tree)};
    return cmocka_run_group_tests(tests, make_stage, test_folder_leave);
}
