#include "accel/build.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <float.h>
#include <stdatomic.h>

enum {
    BIN_COUNT = 16,
    MEDIAN_DEPTH = 60,        // from here ranges are halved, so depth <= 60 + log2(2^32) < 96
    PARALLEL_BINNING = 65536, // ranges from this size are binned by all workers
    BINNING_GRAIN = 16384,
    TASK_COUNT = 64, // subtrees of about 1 / TASK_COUNT are built by one worker
    TASK_SIZE_MIN = 2048
};
_Static_assert(MEDIAN_DEPTH + 33 <= CO_TREE_DEPTH_MAX, "the walk's stack follows from the depth");

typedef struct Bin {
    CoBox box;
    size_t count;
} Bin;

typedef struct Bins {
    Bin bin[3][BIN_COUNT];
} Bins;

// How centroids map to bins. scale 0: no extent on that axis.
typedef struct Binning {
    float origin[3], scale[3];
} Binning;

typedef struct Split {
    int axis; // -1: none found
    int bin;  // the last one on the left
    double cost;
} Split;

// Half sums, so that centroids of the largest finite boxes are finite.
static float centroid(const CoBuildPrim *prim, int axis)
{
    return 0.5f * prim->lo[axis] + 0.5f * prim->hi[axis];
}

static int bin_of(const Binning *binning, const CoBuildPrim *prim, int axis)
{
    float x = (centroid(prim, axis) - binning->origin[axis]) * binning->scale[axis];
    if (!(x >= 1.0f)) // also where the difference overflows and the scale is 0
        return 0;
    return x < (float)BIN_COUNT ? (int)x : BIN_COUNT - 1;
}

static void range_boxes(const CoBuildPrim *prims, size_t count, CoBox *box, CoBox *centroids)
{
    co_box_empty(box);
    co_box_empty(centroids);
    for (size_t i = 0; i < count; i++) {
        float c[3] = {centroid(&prims[i], 0), centroid(&prims[i], 1), centroid(&prims[i], 2)};
        co_box_extend(box, prims[i].lo, prims[i].hi);
        co_box_extend(centroids, c, c);
    }
}

static Binning binning_over(const CoBox *centroids)
{
    Binning binning;
    for (int k = 0; k < 3; k++) {
        float extent = centroids->hi[k] - centroids->lo[k];
        float scale = (float)BIN_COUNT * (1.0f - 1e-6f) / extent;
        binning.origin[k] = centroids->lo[k];
        binning.scale[k] = extent > 0.0f && extent <= FLT_MAX && scale <= FLT_MAX ? scale : 0.0f;
    }
    return binning;
}

static void bins_clear(Bins *bins)
{
    for (int k = 0; k < 3; k++) {
        for (int b = 0; b < BIN_COUNT; b++) {
            co_box_empty(&bins->bin[k][b].box);
            bins->bin[k][b].count = 0;
        }
    }
}

static void bins_fill(Bins *bins, const Binning *binning, const CoBuildPrim *prims, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            Bin *bin = &bins->bin[k][bin_of(binning, &prims[i], k)];
            co_box_extend(&bin->box, prims[i].lo, prims[i].hi);
            bin->count++;
        }
    }
}

// Minima, maxima and counts: the order of merging does not show.
static void bins_merge(Bins *into, const Bins *from)
{
    for (int k = 0; k < 3; k++) {
        for (int b = 0; b < BIN_COUNT; b++) {
            const Bin *bin = &from->bin[k][b];
            co_box_extend(&into->bin[k][b].box, bin->box.lo, bin->box.hi);
            into->bin[k][b].count += bin->count;
        }
    }
}

static void split_axis(const Bin *bins, int axis, Split *best)
{
    double right_cost[BIN_COUNT];
    CoBox box;
    size_t count = 0;
    co_box_empty(&box);
    for (int b = BIN_COUNT - 1; b > 0; b--) {
        co_box_extend(&box, bins[b].box.lo, bins[b].box.hi);
        count += bins[b].count;
        right_cost[b] = count ? co_box_area(&box) * (double)count : -1.0;
    }
    count = 0;
    co_box_empty(&box);
    for (int b = 0; b < BIN_COUNT - 1; b++) {
        co_box_extend(&box, bins[b].box.lo, bins[b].box.hi);
        count += bins[b].count;
        if (count == 0 || right_cost[b + 1] < 0.0)
            continue;
        double cost = co_box_area(&box) * (double)count + right_cost[b + 1];
        if (best->axis < 0 || cost < best->cost)
            *best = (Split){axis, b, cost};
    }
}

static Split split_best(const Bins *bins, const Binning *binning)
{
    Split best = {-1, 0, 0.0};
    for (int k = 0; k < 3; k++)
        if (binning->scale[k] > 0.0f)
            split_axis(bins->bin[k], k, &best);
    return best;
}

static size_t partition(CoBuildPrim *prims, size_t count, const Binning *binning, Split split)
{
    size_t left = 0, right = count;
    while (left < right) {
        if (bin_of(binning, &prims[left], split.axis) <= split.bin) {
            left++;
        } else {
            CoBuildPrim moved = prims[left];
            prims[left] = prims[--right];
            prims[right] = moved;
        }
    }
    return left;
}

// One range of all prims, to become the subtree at `node`.
typedef struct Task {
    uint32_t first, count, node, depth;
} Task;

typedef struct Builder {
    CoBuildPrim *prims;
    CoBinaryNode *nodes;
    _Atomic uint32_t node_count;
    const CoLeafRule *rule;
    Task tasks[4 * TASK_COUNT];
    size_t task_count;
    Bins *worker_bins;   // one per worker
    CoBox *worker_boxes; // two per worker: all, centroids
} Builder;

typedef struct Pass {
    Builder *builder;
    const CoBuildPrim *prims;
    const Binning *binning;
} Pass;

static void measure_block(void *context, size_t begin, size_t end, uint32_t worker)
{
    Pass *pass = context;
    CoBox box, centroids, *mine = &pass->builder->worker_boxes[2 * worker];
    range_boxes(pass->prims + begin, end - begin, &box, &centroids);
    co_box_extend(&mine[0], box.lo, box.hi);
    co_box_extend(&mine[1], centroids.lo, centroids.hi);
}

static void fill_block(void *context, size_t begin, size_t end, uint32_t worker)
{
    Pass *pass = context;
    bins_fill(&pass->builder->worker_bins[worker], pass->binning, pass->prims + begin, end - begin);
}

static void measure(Builder *builder, const CoBuildPrim *prims, size_t count, CoBox *box,
                    CoBox *centroids)
{
    if (count < PARALLEL_BINNING) {
        range_boxes(prims, count, box, centroids);
        return;
    }
    uint32_t workers = co_worker_count();
    for (uint32_t i = 0; i < 2 * workers; i++)
        co_box_empty(&builder->worker_boxes[i]);
    Pass pass = {builder, prims, NULL};
    co_parallel_for(count, BINNING_GRAIN, measure_block, &pass);
    co_box_empty(box);
    co_box_empty(centroids);
    for (uint32_t i = 0; i < workers; i++) {
        const CoBox *from = &builder->worker_boxes[2 * i];
        co_box_extend(box, from[0].lo, from[0].hi);
        co_box_extend(centroids, from[1].lo, from[1].hi);
    }
}

static void bin_range(Builder *builder, const Binning *binning, const CoBuildPrim *prims,
                      size_t count, Bins *bins)
{
    bins_clear(bins);
    if (count < PARALLEL_BINNING) {
        bins_fill(bins, binning, prims, count);
        return;
    }
    uint32_t workers = co_worker_count();
    for (uint32_t i = 0; i < workers; i++)
        bins_clear(&builder->worker_bins[i]);
    Pass pass = {builder, prims, binning};
    co_parallel_for(count, BINNING_GRAIN, fill_block, &pass);
    for (uint32_t i = 0; i < workers; i++)
        bins_merge(bins, &builder->worker_bins[i]);
}

// Makes the task's node; true with its two halves when it is no leaf.
static bool split_task(Builder *builder, Task task, Task halves[2])
{
    CoBuildPrim *prims = builder->prims + task.first;
    CoBinaryNode *node = &builder->nodes[task.node];
    CoBox centroids;
    node->first = task.first;
    node->count = task.count;
    node->left = 0;
    measure(builder, prims, task.count, &node->box, &centroids);
    if (task.count <= builder->rule->most &&
        builder->rule->fits(builder->rule->context, prims, task.count))
        return false;
    uint32_t left = 0;
    if (task.depth < MEDIAN_DEPTH) {
        Binning binning = binning_over(&centroids);
        Bins bins;
        bin_range(builder, &binning, prims, task.count, &bins);
        Split split = split_best(&bins, &binning);
        if (split.axis >= 0)
            left = (uint32_t)partition(prims, task.count, &binning, split);
    }
    if (left == 0 || left == task.count)
        left = task.count / 2;
    // Order does not matter: the numbers say nothing, and what is in the nodes is read after a
    // join.
    node->left = atomic_fetch_add_explicit(&builder->node_count, 2, memory_order_relaxed);
    halves[0] = (Task){task.first, left, node->left, task.depth + 1};
    halves[1] = (Task){task.first + left, task.count - left, node->left + 1, task.depth + 1};
    return true;
}

static void build_subtree(Builder *builder, Task task)
{
    Task halves[2];
    if (!split_task(builder, task, halves))
        return;
    build_subtree(builder, halves[0]);
    build_subtree(builder, halves[1]);
}

static void build_tasks(void *context, size_t begin, size_t end, uint32_t worker)
{
    Builder *builder = context;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        build_subtree(builder, builder->tasks[i]);
}

// Splits ranges until they are small or many: the largest first, by one thread, with parallel
// passes.
static void open_tasks(Builder *builder, uint32_t count)
{
    uint32_t small = count / TASK_COUNT < TASK_SIZE_MIN ? TASK_SIZE_MIN : count / TASK_COUNT;
    builder->tasks[0] = (Task){0, count, 0, 0};
    builder->task_count = 1;
    for (size_t i = 0; i < builder->task_count;) {
        Task halves[2], task = builder->tasks[i];
        if (task.count <= small || builder->task_count == 4 * TASK_COUNT) {
            i++;
        } else if (split_task(builder, task, halves)) {
            builder->tasks[i] = halves[0];
            builder->tasks[builder->task_count++] = halves[1];
        } else {
            builder->tasks[i] = builder->tasks[--builder->task_count];
        }
    }
}

size_t co_binary_build(CoBuildPrim *prims, uint32_t count, const CoLeafRule *rule,
                       CoBinaryNode *nodes, CohortError *err)
{
    uint32_t workers = co_worker_count();
    size_t bins_size = workers * sizeof(Bins), boxes_size = 2 * workers * sizeof(CoBox);
    size_t node_count = 0;
    Builder *builder = co_alloc(CO_MEMORY_ACCEL, sizeof *builder);
    Bins *bins = co_alloc(CO_MEMORY_ACCEL, bins_size);
    CoBox *boxes = co_alloc(CO_MEMORY_ACCEL, boxes_size);
    if (builder && bins && boxes) {
        *builder = (Builder){.prims = prims, .nodes = nodes, .rule = rule};
        atomic_init(&builder->node_count, 1);
        builder->worker_bins = bins;
        builder->worker_boxes = boxes;
        open_tasks(builder, count);
        co_parallel_for(builder->task_count, 1, build_tasks, builder);
        node_count = atomic_load(&builder->node_count);
    } else {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "no memory to build a tree over %u things", count);
    }
    co_free(CO_MEMORY_ACCEL, boxes, boxes_size);
    co_free(CO_MEMORY_ACCEL, bins, bins_size);
    co_free(CO_MEMORY_ACCEL, builder, sizeof *builder);
    return node_count;
}
