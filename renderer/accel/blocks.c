// Blocks that the trees of small meshes share.

#include "accel/build.h"

#include "base/memory.h"
#include "base/pages.h"

#include <string.h>

#define TAG CO_MEMORY_ACCEL

enum {
    LINE = 64,
    BLOCK_BYTES = CO_PAGES_ALIGNMENT,
    PACKED_MOST = BLOCK_BYTES / 8 // of a tree: what is left over at the end of a block is less
};

static size_t whole_lines(size_t size)
{
    return (size + LINE - 1) & ~(size_t)(LINE - 1);
}

void co_bvh_block_leave(CoBvhBlock *block)
{
    if (block && atomic_fetch_sub(&block->users, 1) == 1)
        co_free(TAG, block, BLOCK_BYTES);
}

void co_bvh_blocks_close(CoBvhBlocks *blocks)
{
    co_bvh_block_leave(blocks->open);
    blocks->open = NULL;
}

// Room for so many bytes in the open block, or a new one. False without memory.
static bool make_room(CoBvhBlocks *blocks, size_t size)
{
    if (blocks->open && size <= BLOCK_BYTES - blocks->open->used)
        return true;
    CoBvhBlock *block = co_alloc(TAG, BLOCK_BYTES);
    if (!block)
        return false;
    atomic_init(&block->users, 1);
    block->used = whole_lines(sizeof *block);
    co_bvh_blocks_close(blocks);
    blocks->open = block;
    return true;
}

static void *put(CoBvhBlock *block, const void *from, size_t size)
{
    void *to = (char *)block + block->used;
    memcpy(to, from, size);
    block->used += whole_lines(size);
    return to;
}

void co_bvh_pack(CoBvh *bvh, CoBvhBlocks *blocks)
{
    CoTree *tree = &bvh->tree;
    const size_t nodes = tree->node_count * sizeof *tree->nodes;
    const size_t leaves = bvh->leaf_bytes ? bvh->leaf_bytes + CO_LEAF_TAIL : 0;
    const size_t size = whole_lines(nodes) + whole_lines(leaves);
    if (bvh->block || size == 0 || size > PACKED_MOST)
        return;
    blocks->seen += size;
    if (blocks->seen <= BLOCK_BYTES || !make_room(blocks, size))
        return;
    CoWideNode *old_nodes = tree->nodes;
    unsigned char *old_leaves = bvh->leaves;
    const size_t old_node_bytes = tree->node_capacity * sizeof *tree->nodes;
    bvh->block = blocks->open;
    atomic_fetch_add(&bvh->block->users, 1);
    tree->nodes = put(bvh->block, old_nodes, nodes);
    tree->node_capacity = tree->node_count;
    if (leaves)
        bvh->leaves = put(bvh->block, old_leaves, leaves);
    if (bvh->leaf_at == old_leaves)
        bvh->leaf_at = bvh->leaves;
    co_free(TAG, old_nodes, old_node_bytes);
    co_free(TAG, old_leaves, bvh->leaf_capacity);
    bvh->leaf_capacity = leaves;
    if (!leaves)
        bvh->leaves = NULL;
}
