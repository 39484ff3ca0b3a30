#include "command.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static const char stage[] =
    "#usda 1.0\n"
    "(\n"
    "    defaultPrim = \"World\"\n"
    "    renderSettingsPrimPath = \"/Render/Settings\"\n"
    ")\n"
    "def Xform \"World\"\n"
    "{\n"
    "    def Camera \"cam\"\n"
    "    {\n"
    "        float focalLength = 50\n"
    "        float horizontalAperture = 20\n"
    "        float verticalAperture = 15\n"
    "        double3 xformOp:translate.timeSamples = { 1: (0, 0, 10), 4: (3, 0, 10) }\n"
    "        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n"
    "    }\n"
    "    def Camera \"side\"\n"
    "    {\n"
    "    }\n"
    "    def Sphere \"ball\" (\n"
    "        variants = { string size = \"big\" }\n"
    "        prepend variantSets = \"size\"\n"
    "    )\n"
    "    {\n"
    "        color3f[] primvars:displayColor = [(0.8, 0.4, 0.2)]\n"
    "        variantSet \"size\" = {\n"
    "            \"big\" {\n"
    "                double radius = 1\n"
    "            }\n"
    "            \"small\" {\n"
    "                double radius = 0.25\n"
    "            }\n"
    "        }\n"
    "    }\n"
    "    def SphereLight \"key\"\n"
    "    {\n"
    "        float inputs:intensity = 60\n"
    "        double3 xformOp:translate = (3, 4, 5)\n"
    "        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n"
    "    }\n"
    "}\n"
    "def Scope \"Render\"\n"
    "{\n"
    "    def RenderSettings \"Settings\"\n"
    "    {\n"
    "        uniform int2 resolution = (24, 18)\n"
    "        rel camera = </World/cam>\n"
    "        rel products = </Render/Product>\n"
    "    }\n"
    "    def RenderProduct \"Product\"\n"
    "    {\n"
    "        token productName = \"product.exr\"\n"
    "    }\n"
    "}\n";

enum {
    ARGUMENTS_MAX = 64
};
static const char out_file[] = "stdout.txt", err_file[] = "stderr.txt";
static char folder[] = "/tmp/cohort-cli-XXXXXX";

int scratch_enter(void **state)
{
    (void)state;
    unsetenv("OCIO");
    if (!mkdtemp(folder) || chdir(folder))
        return 1;
    write_text("stage.usda", stage);
    return 0;
}

int scratch_leave(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return chdir("/") || system(command);
}

static void redirect(const char *path, int descriptor)
{
    int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (fd < 0 || dup2(fd, descriptor) < 0)
        _exit(126);
    close(fd);
}

static pid_t start(const char *arguments, size_t file_bytes)
{
    static char text[4096];
    static char command[] = COHORT_COMMAND;
    char *argv[ARGUMENTS_MAX] = {command};
    int argc = 1;
    snprintf(text, sizeof text, "%s", arguments);
    char *rest = text;
    for (char *word; (word = strsep(&rest, " ")) != NULL && argc < ARGUMENTS_MAX - 1;)
        if (word[0])
            argv[argc++] = word;
    unlink(out_file);
    pid_t pid = fork();
    if (pid != 0)
        return pid;
    redirect(out_file, STDOUT_FILENO);
    redirect(err_file, STDERR_FILENO);
    struct rlimit limit = {file_bytes, file_bytes};
    if (file_bytes && setrlimit(RLIMIT_FSIZE, &limit))
        _exit(126);
    execv(COHORT_COMMAND, argv);
    _exit(127);
}

static void read_text(const char *path, char *out, size_t size)
{
    FILE *file = fopen(path, "r");
    size_t n = file ? fread(out, 1, size - 1, file) : 0;
    out[n] = 0;
    if (file)
        fclose(file);
}

void command_wait(pid_t pid, Ran *ran)
{
    int status = 0;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    ran->code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    read_text(out_file, ran->out, sizeof ran->out);
    read_text(err_file, ran->err, sizeof ran->err);
}

pid_t command_start(const char *arguments)
{
    pid_t pid = start(arguments, 0);
    assert_true(pid > 0);
    return pid;
}

void command_run(Ran *ran, const char *format, ...)
{
    char arguments[4096];
    va_list args;
    va_start(args, format);
    vsnprintf(arguments, sizeof arguments, format, args);
    va_end(args);
    command_wait(command_start(arguments), ran);
}

void command_run_limited(Ran *ran, size_t file_bytes, const char *arguments)
{
    pid_t pid = start(arguments, file_bytes);
    assert_true(pid > 0);
    command_wait(pid, ran);
}

static bool await(const char *path, off_t least)
{
    struct timespec step = {0, 10000000};
    for (int i = 0; i < 6000; i++) {
        struct stat info;
        if (stat(path, &info) == 0 && info.st_size >= least)
            return true;
        nanosleep(&step, NULL);
    }
    return false;
}

bool command_await_output(void)
{
    return await(out_file, 1);
}

bool command_await_file(const char *path)
{
    return await(path, 0);
}

void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

bool file_exists(const char *path)
{
    return access(path, F_OK) == 0;
}

int line_count(const char *text)
{
    int lines = 0;
    for (; *text; text++)
        lines += *text == '\n';
    return lines;
}

void assert_ran(const Ran *ran, int code, const char *said)
{
    if (ran->code != code || !strstr(ran->err, said))
        fail_msg("exit code %d, expected %d; expected \"%s\" in:\n%s", ran->code, code, said,
                 ran->err);
}
