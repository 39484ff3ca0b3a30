// From a file or text to a layer.

#include "base/error.h"
#include "base/mapped_file.h"
#include "base/parallel.h"
#include "parse/siblings.h"

#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

// Errors reported for one layer before the rest is left alone.
enum {
    MAX_ERRORS = 100
};

static uint64_t limit(uint64_t asked, uint64_t normal)
{
    return asked ? asked : normal;
}

// "#usda 1.x" and whatever else the line holds.
static bool parse_header(CoParser *p)
{
    static const char magic[] = "#usda ";
    CoScan *scan = &p->scan;
    size_t size = (size_t)(scan->end - scan->begin), length = sizeof magic - 1;
    if (size < length || memcmp(scan->begin, magic, length) != 0)
        return co_parse_expected(p, "'#usda 1.0' as the first line of a layer");
    scan->at += length;
    const char *version = scan->at;
    const char *stop = memchr(scan->at, '\n', size - length);
    scan->at = stop ? stop + 1 : scan->end;
    bool known = (size_t)(scan->at - version) >= 3 && version[0] == '1' && version[1] == '.' &&
                 version[2] >= '0' && version[2] <= '4' &&
                 !(scan->at - version > 3 && version[3] >= '0' && version[3] <= '9');
    if (known && !stop && memchr(version, '\r', (size_t)(scan->end - version)))
        return co_parse_fail(p, version, "found line ends of CR only, expected LF or CR LF");
    if (known)
        return true;
    scan->at = version;
    return co_parse_expected(p, "a version from 1.0 to 1.4");
}

static bool end_root_item(CoParser *p, bool semicolon)
{
    co_scan_line(&p->scan);
    int c = co_scan_peek(&p->scan);
    if (c < 0)
        return true;
    if (c != '\n' && c != '\r' && !(semicolon && c == ';'))
        return co_parse_expected(p, "a line end");
    p->scan.at++;
    return true;
}

static bool parse_root_item(CoParser *p, CoSpec *root)
{
    CoScan ahead = p->scan;
    bool found;
    if (co_scan_word(&ahead, "reorder") && co_scan_gap(&ahead) &&
        co_scan_word(&ahead, "rootPrims")) {
        p->scan.at = ahead.at;
        return co_parse_names(p, root, "primOrder") && end_root_item(p, true);
    }
    if (!co_parse_prim(p, root, &found))
        return false;
    if (!found)
        return co_parse_expected(p, "def, over, class or the end of the file");
    return end_root_item(p, false);
}

static void parse_layer(CoParser *p)
{
    if (!parse_header(p))
        return;
    CoSpec *root = p->layer->root;
    co_scan_space(&p->scan);
    if (co_scan_peek(&p->scan) == '(')
        co_parse_metadata(p, root);
    co_scan_space(&p->scan);
    while (!p->stopped && p->scan.at < p->scan.end) {
        const char *before = p->scan.at;
        if (!co_parse_siblings(p, root) && !p->stopped && !parse_root_item(p, root)) {
            if (p->stopped)
                return;
            co_parse_recover(p);
            p->scan.at += p->scan.at < p->scan.end && (p->scan.at == before || *p->scan.at != '\n');
        }
        co_scan_space(&p->scan);
    }
}

static bool begin(CoParser *p, const char *path, CohortError *err)
{
    CoLayer *layer = co_alloc_zero(CO_MEMORY_USDA, sizeof *layer);
    CO_CHECK_MEMORY(layer, err);
    p->layer = layer;
    layer->arena = (CoArena){.tag = CO_MEMORY_USDA};
    layer->path = co_token(path, strlen(path));
    p->prim_path_capacity = 64;
    p->prim_path = co_alloc(CO_MEMORY_USDA, p->prim_path_capacity);
    const char *root_name = co_token("/", 1);
    p->empty = co_token("", 0);
    CO_CHECK_MEMORY(layer->path && p->prim_path && root_name && p->empty ? p : NULL, err);
    memcpy(p->prim_path, "/", 2);
    p->prim_path_length = 1;
    layer->root = co_parse_spec(p, NULL, CO_SPEC_LAYER, root_name, p->scan.begin);
    return layer->root != NULL;
}

typedef struct Source {
    const char *path, *text;
    size_t size;
    bool is_mapped;
} Source;

static CoLayer *parse_source(const Source *source, const CohortStageOptions *options,
                             CohortDiagnosticFn *report, void *cookie, CohortError *err)
{
    const char *path = source->path, *text = source->text;
    size_t size = source->size;
    static const CohortStageOptions defaults = {0};
    const CohortStageOptions *o = options ? options : &defaults;
    uint64_t max_bytes = limit(o->max_bytes, UINT64_C(16) << 30);
    if (size > max_bytes) {
        CohortError local = {0};
        CO_FAIL(&local, COHORT_ERROR_LIMIT,
                "the layer holds %zu bytes, more than the limit of %llu", size,
                (unsigned long long)max_bytes);
        co_error_place(&local, path, 0, 0, NULL);
        if (report)
            report(cookie, COHORT_SEVERITY_ERROR, path, 0, 0, "", local.message);
        if (err && err->code == COHORT_OK)
            *err = local;
        return NULL;
    }
    uint64_t max_length = limit(o->max_array_length, UINT64_C(1) << 31);
    CoParser parser = {
        .max_depth = limit(o->max_depth, 512),
        .max_edit_size = limit(o->max_array_length, UINT64_C(1) << 24),
        .max_array_length = max_length < UINT32_MAX ? max_length : UINT32_MAX,
        .max_prims = limit(o->max_prims, 5000000),
        .max_errors = MAX_ERRORS,
        .report = report,
        .cookie = cookie,
        .err = err,
        .is_mapped = source->is_mapped,
        .released = text,
        .stop = o->stop,
    };
    co_scan_init(&parser.scan, size ? text : "", size);
    bool begun = begin(&parser, path, err);
    uint32_t workers = co_worker_count();
    co_worker_count_set(o->threads ? o->threads : workers);
    if (begun) {
        parser.siblings = co_siblings_create(&parser);
        parse_layer(&parser);
        co_siblings_destroy(parser.siblings, &parser);
    }
    co_worker_count_set(workers);
    CoLayer *layer = parser.layer;
    if (layer)
        layer->byte_count = size;
    co_parse_buffers_free(&parser);
    if (!begun && !parser.error_count && report)
        report(cookie, COHORT_SEVERITY_ERROR, path, 0, 0, "", "out of memory");
    if (!begun || parser.error_count || parser.stopped) {
        co_layer_destroy(layer);
        return NULL;
    }
    return layer;
}

CoLayer *co_layer_parse(const char *path, const char *text, size_t size,
                        const CohortStageOptions *options, CohortDiagnosticFn *report, void *cookie,
                        CohortError *err)
{
    const Source source = {path, text, size, false};
    return parse_source(&source, options, report, cookie, err);
}

static bool refuse_binary(const void *data, size_t size, const char *path, CohortError *err)
{
    const char *what = NULL;
    if (size >= 8 && memcmp(data, "PXR-USDC", 8) == 0)
        what = "a binary crate (.usdc)";
    else if (size >= 4 && memcmp(data, "PK\3\4", 4) == 0)
        what = "a zip package (.usdz)";
    if (!what)
        return true;
    CO_FAIL(err, COHORT_ERROR_USD_BINARY,
            "found %s, expected text; convert it with `usdcat -o name.usda`", what);
    co_error_place(err, path, 1, 1, NULL);
    return false;
}

static CoFileStamp stamp_of(const char *path)
{
    struct stat st;
    if (stat(path, &st) != 0)
        return (CoFileStamp){0};
    return (CoFileStamp){(uint64_t)st.st_ino, (uint64_t)st.st_size, (int64_t)st.st_mtim.tv_sec,
                         (int64_t)st.st_mtim.tv_nsec};
}

bool co_layer_is_current(const CoLayer *layer)
{
    CoFileStamp now = stamp_of(layer->path);
    const CoFileStamp *then = &layer->stamp;
    return then->inode && then->inode == now.inode && then->size == now.size &&
           then->seconds == now.seconds && then->nanoseconds == now.nanoseconds;
}

// True if the opener has the layer; *out is NULL then when it could not be read.
static bool open_given(const char *path, const CohortStageOptions *options,
                       CohortDiagnosticFn *report, void *cookie, CohortError *err, CoLayer **out)
{
    CohortBytes bytes = {0};
    if (!options || !options->open || !options->open(options->open_cookie, path, &bytes))
        return false;
    const char *text = bytes.data ? bytes.data : "";
    if (refuse_binary(text, bytes.size, path, err))
        *out = co_layer_parse(path, text, bytes.size, options, report, cookie, err);
    else if (report)
        report(cookie, COHORT_SEVERITY_ERROR, path, err->line, err->column, "", err->message);
    if (options->release)
        options->release(options->open_cookie, &bytes);
    return true;
}

CoLayer *co_layer_open(const char *path, const CohortStageOptions *options,
                       CohortDiagnosticFn *report, void *cookie, CohortError *err)
{
    CohortError local = {0};
    CoLayer *given = NULL;
    if (open_given(path, options, report, cookie, &local, &given)) {
        if (err && err->code == COHORT_OK)
            *err = local;
        return given;
    }
    CoMappedFile file;
    char *resolved = realpath(path, NULL);
    const char *name = resolved ? resolved : path;
    CoLayer *layer = NULL;
    bool parsed = false;
    CoFileStamp stamp = stamp_of(name);
    if (co_mapped_file_open(name, &file, &local)) {
        parsed = refuse_binary(file.data, file.size, name, &local);
        if (parsed)
            layer = parse_source(&(Source){name, file.data, file.size, true}, options, report,
                                 cookie, &local);
        co_mapped_file_close(&file);
    }
    if (layer)
        layer->stamp = stamp;
    // What the parser found it has reported already.
    if (!parsed && report)
        report(cookie, COHORT_SEVERITY_ERROR, name, local.line, local.column, "", local.message);
    if (err && err->code == COHORT_OK)
        *err = local;
    free(resolved);
    return layer;
}

CoLayer *co_layer_share(CoLayer *layer)
{
    atomic_fetch_add(&layer->users, 1);
    return layer;
}

void co_layer_destroy(CoLayer *layer)
{
    if (!layer || (atomic_load(&layer->users) && atomic_fetch_sub(&layer->users, 1)))
        return;
    co_arena_clear(&layer->arena);
    co_free(CO_MEMORY_USDA, layer, sizeof *layer);
}
