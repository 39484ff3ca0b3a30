// The Ptex reader against files of the reference library: every texel of every level, and files
// that lie. Also tests ptex_edit.c, ptex_level.c, ptex_meta.c and ptex_texels.c.

#include "ptex_evaluate.h"
#include "sha256.h"
#include "support/faults.h"
#include "texture_support.h"

#include <dirent.h>

#define PTEX COHORT_SHARED_DIR "/ptex"

static char *read_text(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    fseek(file, 0, SEEK_END);
    long size = ftell(file);
    rewind(file);
    char *text = malloc((size_t)size + 1);
    text[fread(text, 1, (size_t)size, file)] = 0;
    fclose(file);
    return text;
}

// Checks one face at one resolution against a digest of 16 hexadecimal digits.
static int check_face(const CoPtexFile *file, uint32_t face, int ulog2, int vlog2,
                      const char *digest)
{
    static unsigned char *texels;
    static size_t capacity;
    size_t size = co_ptex_block_size(file, ulog2, vlog2);
    if (size > capacity)
        texels = realloc(texels, capacity = size);
    CohortError err = {0};
    CoPtexDecoder decoder = {0};
    bool ok = co_ptex_face_texels(file, face, ulog2, vlog2, &decoder, texels, &err);
    co_ptex_decoder_clear(&decoder);
    char ours[17];
    sha256_short(texels, size, ours);
    return !ok || strncmp(ours, digest, 16) != 0;
}

// Walks "sha": one list per level of one digest or null per face.
static int check_digests(const CoPtexFile *file, const char *text, int *checked)
{
    const char *at = strstr(text, "\"sha\":");
    assert_non_null(at);
    at = strchr(at, '[') + 1;
    int bad = 0;
    for (int level = 0;; level++) {
        at += strspn(at, " \n,");
        if (*at != '[')
            return bad;
        at++;
        for (uint32_t face = 0; *at != ']'; face++) {
            at += strspn(at, " \n,");
            if (*at == '"') {
                const CoPtexFace *info = &file->faces[face];
                bad += check_face(file, face, info->ulog2 - level, info->vlog2 - level, at + 1);
                ++*checked;
                at += 18;
            } else {
                at += 4; // null
            }
        }
        at++;
    }
}

// Anisotropic requests: {"face":0,"ulog2":1,"vlog2":2,"sha":"..."}.
static int check_resolutions(const CoPtexFile *file, const char *text, int *checked)
{
    int bad = 0;
    for (const char *at = strstr(text, "\"res\""); at; at = strstr(at + 1, "\"face\"")) {
        unsigned face;
        int ulog2, vlog2;
        char digest[17];
        const char *entry = strstr(at, "{\"face\"");
        if (!entry || sscanf(entry, "{\"face\":%u,\"ulog2\":%d,\"vlog2\":%d,\"sha\":\"%16[0-9a-f]",
                             &face, &ulog2, &vlog2, digest) != 4)
            break;
        bad += check_face(file, face, ulog2, vlog2, digest);
        ++*checked;
        at = entry + 8;
    }
    return bad;
}

static void check_folder(const char *folder, int *files, int *checked)
{
    DIR *entries = opendir(folder);
    if (!entries)
        skip();
    for (struct dirent *e = readdir(entries); e; e = readdir(entries)) {
        char path[512];
        size_t length = strlen(e->d_name);
        if (length < 5 || strcmp(e->d_name + length - 4, ".ptx") != 0)
            continue;
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        CohortError err = {0};
        CoPtexFile *file = co_ptex_open(path, &err);
        if (!file)
            fail_msg("%s: %s", path, err.message);
        snprintf(path, sizeof path, "%s/%.*s.json", folder, (int)length - 4, e->d_name);
        char *text = read_text(path);
        int bad = check_digests(file, text, checked) + check_resolutions(file, text, checked);
        if (bad)
            fail_msg("%s: %d faces differ", e->d_name, bad);
        free(text);
        co_ptex_close(file);
        ++*files;
    }
    closedir(entries);
}

static void every_texel_is_as_the_reference_reads_it(void **state)
{
    (void)state;
    int files = 0, checked = 0;
    check_folder(PTEX "/goldens", &files, &checked);
    check_folder(PTEX "/goldens_quirks", &files, &checked);
    print_message("%d files, %d faces\n", files, checked);
    assert_true(files >= 79 && checked > 10000);
}

// Reads all there is of a file; false when something was refused.
static bool read_everything(const CoPtexFile *file)
{
    bool ok = true;
    CoPtexDecoder decoder = {0};
    for (uint32_t face = 0; face < file->faces_count; face++) {
        const CoPtexFace *info = &file->faces[face];
        size_t size = co_ptex_block_size(file, info->ulog2, info->vlog2);
        void *texels = malloc(size);
        ok &= co_ptex_face_texels(file, face, info->ulog2, info->vlog2, &decoder, texels, NULL);
        free(texels);
    }
    co_ptex_decoder_clear(&decoder);
    return ok;
}

static void look_everywhere(const CoPtexFile *file)
{
    if (file->is_triangle)
        return; // has filters of its own
    static const float widths[] = {0, .01f, .1f, .24f, .3f, .6f, 1, 3};
    CoPtexDecoder decoder = {0};
    for (uint32_t i = 0; i < 128; i++) {
        CoPtexQuery query = {.face = i % file->faces_count,
                             .u = (float)(i * 7 % 11) / 10,
                             .v = (float)(i * 5 % 13) / 12,
                             .uw1 = widths[i % 8],
                             .vw2 = widths[i % 8],
                             .width = 1};
        CoPtexFilter filter = {.kind = i & 8 ? CO_PTEX_FILTER_BOX : CO_PTEX_FILTER_BILINEAR};
        float out;
        evaluate_ptex(file, &filter, &query, 0, 1, &decoder, &out);
    }
    co_ptex_decoder_clear(&decoder);
}

static void files_that_lie_are_refused_or_read(void **state)
{
    (void)state;
    char *text = read_text(PTEX "/hostile/hostile.json");
    if (!text)
        skip();
    int count = 0;
    for (char *at = strstr(text, "\"file\": \""); at; at = strstr(at + 1, "\"file\": \"")) {
        char name[128], path[512], info[8], texels[8];
        const char *verdicts = strstr(at, "\"info\": ");
        assert_int_equal(sscanf(at, "\"file\": \"%127[^\"]", name), 1);
        assert_int_equal(
            sscanf(verdicts, "\"info\": \"%7[^\"]\", \"texels\": \"%7[^\"]", info, texels), 2);
        snprintf(path, sizeof path, PTEX "/hostile/%s", name);
        CohortError err = {0};
        CoPtexFile *file = co_ptex_open(path, &err);
        if (file && strcmp(info, "fail") == 0)
            fail_msg("%s is accepted", name);
        if (!file)
            assert_true(err.message[0] && err.code != COHORT_OK);
        if (file && read_everything(file) && strcmp(texels, "fail") == 0)
            fail_msg("texels of %s are accepted", name);
        if (file)
            look_everywhere(file);
        co_ptex_close(file);
        count++;
    }
    free(text);
    assert_true(count >= 236);
}

// Every prefix of a file, and every byte of it flipped.
static void cut_and_flipped_files_end_well(void **state)
{
    (void)state;
    FILE *source = fopen(PTEX "/goldens/odd_small_tiles.ptx", "rb");
    if (!source)
        skip();
    unsigned char bytes[2048];
    size_t size = fread(bytes, 1, sizeof bytes, source);
    fclose(source);
    char path[] = "/tmp/cohort-ptex-XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    FILE *file = fdopen(fd, "wb");
    for (size_t i = 0; i < 2 * size; i++) {
        rewind(file);
        assert_int_equal(ftruncate(fd, 0), 0);
        if (i >= size)
            bytes[i - size] ^= (unsigned char)(1u << i % 8);
        fwrite(bytes, 1, i < size ? i : size, file);
        fflush(file);
        if (i >= size)
            bytes[i - size] ^= (unsigned char)(1u << i % 8);
        CoPtexFile *ptex = co_ptex_open(path, NULL);
        if (ptex) {
            read_everything(ptex);
            look_everywhere(ptex);
        }
        co_ptex_close(ptex);
    }
    fclose(file);
    unlink(path);
}

// Nothing asks for them, and a file of a large mesh has all of its cage there.
static void metadata_are_not_kept(void **state)
{
    (void)state;
    CoPtexFile *file = co_ptex_open(PTEX "/goldens/meta_small.ptx", NULL);
    if (!file)
        skip();
    uint32_t meta_size;
    memcpy(&meta_size, (const char *)file->map.data + 60, sizeof meta_size);
    assert_in_range(meta_size, 2000, 3000);
    assert_true(co_memory_live(CO_MEMORY_TEXTURE) < meta_size);
    co_ptex_close(file);
}

// A file in tiles of our own; where they are, others with metadata of all kinds and with edits.
static void files_open_when_there_is_memory(void **state)
{
    (void)state;
    write_grid(in_folder("tiled.ptx"), 2, 8, CO_PTEX_U8, 3);
    const char *const paths[] = {in_folder("tiled.ptx"), PTEX "/goldens/meta_large.ptx",
                                 PTEX "/goldens/edited_meta.ptx", PTEX "/goldens/edited_alpha.ptx"};
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
        if (access(paths[i], R_OK) != 0)
            continue;
        TestFaults faults = {0};
        while (test_faults_next(&faults)) {
            CohortError err = {0};
            test_faults_begin(&faults);
            CoPtexFile *file = co_ptex_open(paths[i], &err);
            test_faults_end(&faults, file != NULL, &err);
            assert_string_equal(err.file, file || faults.n == 1 ? "" : paths[i]);
            co_ptex_close(file);
        }
        assert_true(faults.count > 8);
    }
}

// A face so large that it is stored in tiles, at a resolution that is not.
static void texels_without_memory_are_no_damage(void **state)
{
    (void)state;
    write_grid(in_folder("tiled.ptx"), 1, 8, CO_PTEX_U8, 3);
    CohortError err = {0};
    CoPtexFile *file = co_ptex_open(in_folder("tiled.ptx"), &err);
    assert_non_null(file);
    assert_int_equal(co_ptex_encoding(&file->blocks[file->level_block[0]]), CO_PTEX_TILED);
    unsigned char *want = texels_of(file, 0, 8, 7), *got = malloc(co_ptex_block_size(file, 8, 7));
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        err = (CohortError){0};
        CoPtexDecoder decoder = {0};
        test_faults_begin(&faults);
        bool ok = co_ptex_face_texels(file, 0, 8, 7, &decoder, got, &err);
        test_faults_end(&faults, ok, &err);
        assert_true(co_ptex_face_texels(file, 0, 8, 7, &decoder, got, NULL));
        assert_memory_equal(got, want, co_ptex_block_size(file, 8, 7));
        co_ptex_decoder_clear(&decoder);
    }
    assert_int_equal(faults.count, 2); // planes, and one place for tiles
    free(want);
    free(got);
    co_ptex_close(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_texel_is_as_the_reference_reads_it),
        cmocka_unit_test(files_that_lie_are_refused_or_read),
        cmocka_unit_test(cut_and_flipped_files_end_well),
        cmocka_unit_test(metadata_are_not_kept),
        cmocka_unit_test(files_open_when_there_is_memory),
        cmocka_unit_test(texels_without_memory_are_no_damage),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
