// Where an asset path leads: relative to the layer that says it.

#include "compose/composer.h"

#include "base/hash.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

bool co_asset_exists(const CoComposer *c, const char *path)
{
    struct stat st;
    if (c->options.open && c->options.open(c->options.open_cookie, path, NULL))
        return true;
    return stat(path, &st) == 0;
}

// Resolves "." and ".." in place, in an absolute path.
static size_t normalize(char *path, size_t length)
{
    size_t out = 0, at = 0;
    while (at < length) {
        while (at < length && path[at] == '/')
            at++;
        size_t end = at;
        while (end < length && path[end] != '/')
            end++;
        size_t size = end - at;
        if (size == 2 && path[at] == '.' && path[at + 1] == '.') {
            while (out > 0 && path[--out] != '/')
                ;
        } else if (size > 0 && !(size == 1 && path[at] == '.')) {
            path[out++] = '/';
            memmove(path + out, path + at, size);
            out += size;
        }
        at = end;
    }
    if (out == 0)
        path[out++] = '/';
    return out;
}

static const char *join(CoComposer *c, const char *folder, size_t folder_length, const char *name)
{
    size_t length = strlen(name), total = folder_length + 1 + length;
    char small[1024];
    char *path = total < sizeof small ? small : co_composer_alloc(c, total + 1);
    if (folder_length)
        memcpy(path, folder, folder_length);
    path[folder_length] = '/';
    memcpy(path + folder_length + 1, name, length);
    bool is_double = folder_length == 1 && folder[0] == '/';
    size_t skip = is_double ? 1 : 0;
    return co_composer_need(c, co_token(path, skip + normalize(path + skip, total - skip)));
}

static const char *from_here(CoComposer *c, const char *authored)
{
    char current[4096];
    if (!getcwd(current, sizeof current))
        current[0] = 0;
    return join(c, current, strlen(current), authored);
}

// The same of what is asked for again and again: assets that many prims name.
static bool is_there(CoComposer *c, const char *path)
{
    const char **found = &c->found[co_hash64((uint64_t)(uintptr_t)path) % CO_FOUND_PLACES];
    if (*found != path && !co_asset_exists(c, path))
        return false;
    *found = path;
    return true;
}

// Beside the layer, at the current folder, or in the first folder of the search paths that has it.
//
// Source: OpenUSD, ArDefaultResolver.
static const char *search(CoComposer *c, const char *beside, const char *authored)
{
    const CohortPaths *folders = &c->options.search_paths;
    bool is_relative = !strncmp(authored, "./", 2) || !strncmp(authored, "../", 3);
    if (is_relative || is_there(c, beside))
        return beside;
    const char *path = from_here(c, authored);
    for (size_t i = 0; i <= folders->count; i++) {
        if (path != beside && is_there(c, path))
            return path;
        if (i < folders->count)
            path = join(c, folders->items[i], strlen(folders->items[i]), authored);
    }
    return beside;
}

const char *co_asset_anchor(CoComposer *c, const CoLayerFile *layer, const char *authored)
{
    if (!*authored)
        return co_composer_need(c, co_token("", 0));
    // As POSIX has it, exactly two leading slashes may mean something of their own.
    if (authored[0] == '/')
        return authored[1] == '/' && authored[2] != '/' ? join(c, "/", 1, authored + 2)
                                                        : join(c, "", 0, authored);
    const char *slash = layer ? strrchr(layer->path, '/') : NULL;
    size_t length = slash ? (size_t)(slash - layer->path) : 0;
    return search(c, slash ? join(c, layer->path, length, authored) : from_here(c, authored),
                  authored);
}
