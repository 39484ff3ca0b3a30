// One batch of lookups: request, read, add (Eisenacher et al. 2013, 3.2).

#include "texture/block_sort.h"
#include "texture/textures.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/mapped_file.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define CHUNK 4096                       // lookups that one worker turns into requests at a time
#define GROUP_GRAIN 4                    // blocks that one worker takes at a time
#define PREFETCH 32                      // blocks that reading is ahead of decoding
#define IN_CORE_MOST ((size_t)256 << 20) // larger arrays of a batch lie in scratch files

typedef struct Chunk {
    CoPending *pending; // [lookups of the chunk]; NULL: its results are written already
    size_t waiting;     // requests that need a block
    size_t first_entry;
} Chunk;

typedef struct Batch {
    CoTextures *textures;
    const CoLookup *lookups;
    size_t count;
    float (*out)[4];
    CoLookupMode mode;
    const volatile int *cancel;
    const char *scratch_folder;
    Chunk *chunks;
    size_t chunk_count;
    CoBlockEntry *entries;
    size_t entry_count;
    size_t *groups; // first entry of each group, and one past the last
    size_t group_count;
    CoBlockCount blocks;
    atomic_uint_fast64_t requests;
    atomic_bool has_failed;
} Batch;

static bool is_stopped(const Batch *batch)
{
    return atomic_load_explicit(&batch->has_failed, memory_order_relaxed) ||
           (batch->cancel && *batch->cancel);
}

static void fail_without_memory(Batch *batch, CoReader *reader)
{
    CO_FAIL(&reader->err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for texture blocks");
    atomic_store(&batch->has_failed, true);
}

// ---- Request ---------------------------------------------------------------------------------

static CoPending request_one(CoRequestSink *sink, CoTextures *textures, const CoLookup *lookup,
                             float out[4])
{
    const CoTexture *texture =
        lookup->texture < textures->count ? &textures->textures[lookup->texture] : NULL;
    CoPending pending = {.scale = -1}; // the result is written already
    uint32_t file = texture ? texture->file : COHORT_INVALID_ID;
    CoLookup moved = *lookup;
    if (texture && texture->kind == CO_TEXTURE_IMAGE && texture->udim)
        file = co_image_udim(texture, &moved);
    bool is_usable = texture && texture->kind != CO_TEXTURE_FALLBACK && file != COHORT_INVALID_ID &&
                     (texture->kind != CO_TEXTURE_PTEX ||
                      lookup->face < textures->files[file]->ptex->faces_count);
    if (!is_usable) {
        static const float black[4] = {0, 0, 0, 1};
        memcpy(out, texture ? texture->fallback : black, sizeof black);
        return pending;
    }
    sink->texture = texture;
    sink->texture_id = lookup->texture;
    sink->file = textures->files[file];
    sink->file_id = file;
    sink->first = NULL;
    sink->last = &sink->first;
    sink->missing = 0;
    pending.scale = texture->kind == CO_TEXTURE_PTEX ? co_ptex_request(sink, &moved)
                                                     : co_image_request(sink, &moved);
    pending.first = sink->first;
    pending.missing = sink->missing;
    return pending;
}

static void finish_one(const CoTextures *textures, const CoLookup *lookup, const CoPending *pending,
                       float out[4])
{
    if (pending->scale == -1)
        return;
    const CoTexture *texture = &textures->textures[lookup->texture];
    float sum[CO_TEXTURE_CHANNELS] = {0};
    for (const CoRequest *request = pending->first; request; request = request->next)
        for (uint32_t c = 0; c < texture->channel_count; c++)
            sum[c] += request->sum[c];
    for (uint32_t c = 0; c < texture->channel_count; c++)
        sum[c] = pending->scale == 0 ? 0 : sum[c] / pending->scale;
    uint32_t colors = texture->channel_count - texture->has_alpha;
    for (uint32_t c = 0; c < 3; c++)
        out[c] = c < colors ? sum[c] : colors == 1 ? sum[0] : 0;
    out[3] = texture->has_alpha ? sum[colors] : 1.0f - pending->missing;
}

// What is resident, or cached in the unsorted mode, is summed at once.
static void serve_early(Batch *batch, uint32_t worker, CoRequest *request)
{
    CoTextures *textures = batch->textures;
    CoReader *reader = &textures->readers[worker];
    CoTextureFile *file = textures->files[request->file];
    const CoTexture *texture = &textures->textures[request->texture];
    const void *texels = NULL;
    bool is_damaged = false;
    if (batch->mode == CO_LOOKUP_SORTED) {
        if (!file->blocks)
            return;
        texels = atomic_load_explicit(&file->blocks[request->block], memory_order_acquire);
        if (!texels)
            return;
    }
    if (batch->mode == CO_LOOKUP_CACHED || request->steps)
        texels = co_block_cache_get(&textures->caches[worker], reader, file, request, &is_damaged);
    if (texels)
        co_reader_sum(file, texture, request, texels);
    else if (is_damaged)
        co_reader_give_up(file, textures->textures, &request, 1);
    else
        fail_without_memory(batch, reader);
}

static void request_chunk(Batch *batch, size_t index, uint32_t worker)
{
    CoTextures *textures = batch->textures;
    Chunk *chunk = &batch->chunks[index];
    CoRequestPool *pool = &textures->pools[worker];
    size_t first = index * CHUNK;
    size_t count = batch->count - first < CHUNK ? batch->count - first : CHUNK;
    CoRequestMark mark = co_request_mark(pool);
    CoRequestSink sink = {.pool = pool, .err = &textures->readers[worker].err, .ok = true};
    chunk->pending = co_request_alloc(pool, count * sizeof *chunk->pending, sink.err);
    sink.ok = chunk->pending != NULL;
    for (size_t i = 0; sink.ok && i < count; i++) {
        CoPending *pending = &chunk->pending[i];
        *pending = request_one(&sink, textures, &batch->lookups[first + i], batch->out[first + i]);
        for (CoRequest *request = pending->first; request; request = request->next) {
            if (!request->is_served)
                serve_early(batch, worker, request);
            chunk->waiting += !request->is_served;
        }
    }
    atomic_fetch_add_explicit(&batch->requests, sink.count, memory_order_relaxed);
    if (!sink.ok) {
        atomic_store(&batch->has_failed, true);
    } else if (chunk->waiting == 0) {
        for (size_t i = 0; i < count; i++)
            finish_one(textures, &batch->lookups[first + i], &chunk->pending[i],
                       batch->out[first + i]);
        chunk->pending = NULL;
        co_request_rewind(pool, mark);
    }
}

static void request_chunks(void *context, size_t begin, size_t end, uint32_t worker)
{
    Batch *batch = context;
    for (size_t i = begin; i < end && !is_stopped(batch); i++)
        request_chunk(batch, i, worker);
}

// ---- Read ------------------------------------------------------------------------------------

static void list_entries(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    Batch *batch = context;
    for (size_t i = begin; i < end; i++) {
        const Chunk *chunk = &batch->chunks[i];
        if (!chunk->pending)
            continue;
        size_t count = batch->count - i * CHUNK < CHUNK ? batch->count - i * CHUNK : CHUNK;
        CoBlockEntry *entry = batch->entries + chunk->first_entry;
        for (size_t j = 0; j < count; j++)
            for (CoRequest *r = chunk->pending[j].first; r; r = r->next)
                if (!r->is_served)
                    *entry++ =
                        (CoBlockEntry){co_request_key(r, batch->textures->files[r->file]), r};
    }
}

// End of the keys that belong to the block of `entry`: of a whole tiled face, its tiles too.
static uint64_t group_end(const Batch *batch, const CoBlockEntry *entry)
{
    const CoPtexFile *ptex = batch->textures->files[entry->request->file]->ptex;
    const CoPtexBlock *block = ptex ? &ptex->blocks[entry->request->block] : NULL;
    if (block && co_ptex_encoding(block) == CO_PTEX_TILED)
        return entry->key + co_ptex_stored_size(block);
    return entry->key + 1;
}

static void find_groups(Batch *batch, size_t *groups)
{
    uint64_t end = 0;
    batch->groups = groups;
    for (size_t i = 0; i < batch->entry_count; i++) {
        if (i > 0 && batch->entries[i].key < end)
            continue;
        end = group_end(batch, &batch->entries[i]);
        batch->groups[batch->group_count++] = i;
    }
    batch->groups[batch->group_count] = batch->entry_count;
}

// Decodes one block and serves all that waits for it.
static void read_group(Batch *batch, const CoBlockEntry *entries, size_t count, uint32_t worker)
{
    CoTextures *textures = batch->textures;
    CoReader *reader = &textures->readers[worker];
    const CoRequest *whole = entries[0].request;
    CoTextureFile *file = textures->files[whole->file];
    size_t size = co_reader_block_size(file, whole);
    void *kept = NULL;
    if (file->blocks)
        kept = co_alloc(CO_MEMORY_TEXTURE, size);
    void *texels = kept ? kept : co_reader_texels(reader, size);
    if (!texels) {
        fail_without_memory(batch, reader);
        return;
    }
    CoRequest *requests[256];
    bool is_read = co_reader_decode(reader, file, whole, texels);
    bool ok = is_read || !co_reader_is_short(reader, file);
    for (size_t i = 0; i < count && ok; i += 256) {
        size_t n = count - i < 256 ? count - i : 256;
        for (size_t j = 0; j < n; j++) {
            requests[j] = entries[i + j].request;
            __builtin_prefetch(requests[j], 1); // they lie in the order of lookups, not of blocks
            __builtin_prefetch(requests[j]->weights);
        }
        if (is_read)
            ok = co_reader_serve(reader, file, textures->textures, whole, requests, n, texels);
        else
            co_reader_give_up(file, textures->textures, requests, n);
    }
    if (!ok)
        fail_without_memory(batch, reader);
    if (kept && is_read) {
        file->sizes[whole->block] = size;
        atomic_store_explicit(&file->blocks[whole->block], kept, memory_order_release);
    } else {
        co_free(CO_MEMORY_TEXTURE, kept, size);
    }
}

// Asks the system for the blocks that will be read next, in the order of the file.
static void prefetch_groups(const Batch *batch, size_t begin, size_t end)
{
    if (end > batch->group_count)
        return;
    const CoBlockEntry *first = &batch->entries[batch->groups[begin]];
    const CoBlockEntry *last = &batch->entries[batch->groups[end - 1]];
    const CoTextureFile *file = batch->textures->files[first->request->file];
    if (!file->ptex || last->request->file != first->request->file)
        return;
    const CoPtexBlock *from = &file->ptex->blocks[first->request->block];
    const CoPtexBlock *to = &file->ptex->blocks[last->request->block];
    uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE);
    uintptr_t at = (uintptr_t)file->ptex->map.data + from->offset;
    uintptr_t stop = (uintptr_t)file->ptex->map.data + to->offset + co_ptex_stored_size(to);
    at -= at % page;
    madvise((void *)at, stop - at, MADV_WILLNEED); // only a hint: its failure changes nothing
}

static void read_groups(void *context, size_t begin, size_t end, uint32_t worker)
{
    Batch *batch = context;
    prefetch_groups(batch, begin + PREFETCH, end + PREFETCH);
    for (size_t i = begin; i < end && !is_stopped(batch); i++)
        read_group(batch, batch->entries + batch->groups[i],
                   batch->groups[i + 1] - batch->groups[i], worker);
}

static void finish_chunks(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    Batch *batch = context;
    for (size_t i = begin; i < end; i++) {
        const Chunk *chunk = &batch->chunks[i];
        size_t first = i * CHUNK;
        size_t count = batch->count - first < CHUNK ? batch->count - first : CHUNK;
        for (size_t j = 0; chunk->pending && j < count; j++)
            finish_one(batch->textures, &batch->lookups[first + j], &chunk->pending[j],
                       batch->out[first + j]);
    }
}

// An array in core, or in a scratch file where it is large.
static void *array_create(const Batch *batch, size_t size, CohortError *err)
{
    if (size <= IN_CORE_MOST) {
        void *array = co_alloc(CO_MEMORY_TEXTURE, size);
        if (!array)
            CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for texture requests");
        return array;
    }
    int fd = co_scratch_file(batch->scratch_folder, size, err);
    if (fd < 0)
        return NULL;
    void *array = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    close(fd);
    if (array != MAP_FAILED)
        return array;
    CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "cannot map %zu MB of scratch space", size >> 20);
    return NULL;
}

static void array_destroy(void *array, size_t size)
{
    if (size <= IN_CORE_MOST)
        co_free(CO_MEMORY_TEXTURE, array, size);
    else if (array)
        munmap(array, size);
}

static bool read_and_finish(Batch *batch, CohortError *err)
{
    for (size_t i = 0; i < batch->chunk_count; i++) {
        batch->chunks[i].first_entry = batch->entry_count;
        batch->entry_count += batch->chunks[i].waiting;
    }
    if (batch->entry_count == 0)
        return true;
    size_t size = (batch->entry_count + 1) * sizeof(CoBlockEntry);
    CoBlockEntry *entries = array_create(batch, size, err);
    CoBlockEntry *spare = entries ? array_create(batch, size, err) : NULL;
    bool ok = spare != NULL;
    if (ok) {
        batch->entries = entries;
        co_parallel_for(batch->chunk_count, 1, list_entries, batch);
        batch->entries = co_block_sort(entries, spare, batch->entry_count);
        ok = batch->entries != NULL;
        if (!ok)
            CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for sorting requests");
    }
    if (ok) {
        // The array that the sort has left is free for the groups.
        find_groups(batch, (size_t *)(void *)(batch->entries == entries ? spare : entries));
        co_parallel_for(batch->group_count, GROUP_GRAIN, read_groups, batch);
        if (!is_stopped(batch))
            co_parallel_for(batch->chunk_count, 1, finish_chunks, batch);
    }
    array_destroy(spare, size);
    array_destroy(entries, size);
    return ok;
}

// ---- Batch -----------------------------------------------------------------------------------

static void tell_damage(CoTextures *textures)
{
    for (uint32_t i = 0; i < textures->file_count; i++) {
        CoTextureFile *file = textures->files[i];
        if (!atomic_load(&file->is_damaged) || file->is_damage_told)
            continue;
        file->is_damage_told = true;
        co_textures_warn(textures, file->path,
                         "a block of texels is damaged; its fallback color is shown there");
    }
}

static bool run(Batch *batch, CohortError *err)
{
    CoTextures *textures = batch->textures;
    size_t size = batch->chunk_count * sizeof(Chunk);
    batch->chunks = co_alloc_zero(CO_MEMORY_TEXTURE, size);
    CO_CHECK_MEMORY(batch->chunks, err);
    co_parallel_for(batch->chunk_count, 1, request_chunks, batch);
    bool ok = is_stopped(batch) || read_and_finish(batch, err);
    co_free(CO_MEMORY_TEXTURE, batch->chunks, size);
    for (uint32_t i = 0; i < textures->worker_count; i++) {
        CohortError *worker_err = &textures->readers[i].err;
        if (worker_err->code != COHORT_OK && err && err->code == COHORT_OK)
            *err = *worker_err;
        *worker_err = (CohortError){0};
        co_request_pool_clear(&textures->pools[i]);
        textures->readers[i].decoder.count = NULL;
    }
    ok = ok && !atomic_load(&batch->has_failed);
    CO_CHECK(!ok || !batch->cancel || !*batch->cancel, err, COHORT_ERROR_CANCELLED, "cancelled");
    return ok;
}

bool co_textures_evaluate(CoTextures *textures, const CoLookup *lookups, size_t count,
                          float (*out)[4], CoLookupMode mode, const volatile int *cancel,
                          const char *scratch_folder, CoLookupStats *stats, CohortError *err)
{
    double start = co_clock_seconds();
    Batch batch = {.textures = textures,
                   .lookups = lookups,
                   .count = count,
                   .out = out,
                   .mode = mode,
                   .cancel = cancel,
                   .scratch_folder = scratch_folder,
                   .chunk_count = (count + CHUNK - 1) / CHUNK};
    if (!co_textures_prepare(textures, err))
        return false;
    textures->batch = textures->batch == UINT32_MAX ? 1 : textures->batch + 1;
    batch.blocks.batch = textures->batch;
    for (uint32_t i = 0; i < textures->worker_count; i++) {
        textures->readers[i].decoder.count = &batch.blocks;
        textures->pools[i].scratch_folder = scratch_folder;
        textures->pools[i].budget = &textures->request_budget;
    }
    bool ok = count == 0 || run(&batch, err);
    tell_damage(textures);
    if (stats)
        *stats = (CoLookupStats){.lookups = count,
                                 .requests = atomic_load(&batch.requests),
                                 .blocks_read = atomic_load(&batch.blocks.read),
                                 .blocks_twice = atomic_load(&batch.blocks.twice),
                                 .bytes_read = atomic_load(&batch.blocks.bytes),
                                 .seconds = co_clock_seconds() - start};
    return ok;
}
