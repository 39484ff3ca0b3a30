// Refits: a tree keeps its shape and takes new boxes. Children stand behind their parents, so one
// pass from the last node to the first sees every child before its parent.

#include "accel/build.h"

#include "accel/grid_leaf.h"
#include "base/parallel.h"

#include <string.h>

// Beyond this times the cost it was built with, a tree is better built anew.
#define WORTH 1.5

enum {
    LEAF_GRAIN = 256 // nodes
};

static CoBox child_box(const CoWideNode *node, int i)
{
    CoBox box;
    for (int k = 0; k < 3; k++) {
        box.lo[k] = node->planes[2 * k][i];
        box.hi[k] = node->planes[2 * k + 1][i];
    }
    return box;
}

static CoBox node_box(const CoWideNode *node)
{
    CoBox all;
    co_box_empty(&all);
    for (int i = 0; i < CO_NODE_WIDTH; i++) {
        CoBox box = child_box(node, i);
        co_box_extend(&all, box.lo, box.hi);
    }
    return all;
}

// Nodes and leaves that a ray through the whole is expected to meet.
static double tree_cost(const CoTree *tree)
{
    double area = co_box_area(&tree->box), sum = 0.0;
    for (size_t n = 0; n < tree->node_count; n++) {
        for (int i = 0; i < CO_NODE_WIDTH; i++) {
            CoBox box = child_box(&tree->nodes[n], i);
            sum += co_box_area(&box);
        }
    }
    return area > 0.0 ? sum / area : 0.0;
}

// Once the boxes of leaves are set. False when the tree has become too bad to keep.
static bool refit_tree(CoTree *tree, double built_cost)
{
    for (size_t n = tree->node_count; n-- > 0;) {
        CoWideNode *node = &tree->nodes[n];
        for (int i = 0; i < CO_NODE_WIDTH; i++) {
            uint32_t ref = node->child[i];
            if (ref & CO_REF_LEAF || ref == CO_REF_NONE)
                continue;
            CoBox box = node_box(&tree->nodes[ref]);
            co_wide_node_set(node, i, &box, ref);
        }
    }
    if (tree->node_count)
        tree->box = node_box(&tree->nodes[0]);
    tree->built_cost = built_cost;
    return tree_cost(tree) <= WORTH * built_cost || built_cost == 0.0;
}

static double built_cost(const CoTree *tree)
{
    return tree->built_cost > 0.0 ? tree->built_cost : tree_cost(tree);
}

bool co_top_refit(CoTop *top, const CoInstance *instances, uint32_t count, const CoObject *objects)
{
    // Layers are planned for where things stand.
    if (count != top->count || top->layer_count > 0 || !co_top_measure(top, instances, objects) ||
        top->layer_count > 0)
        return false;
    double cost = built_cost(&top->tree);
    for (size_t n = 0; n < top->tree.node_count; n++) {
        CoWideNode *node = &top->tree.nodes[n];
        for (int i = 0; i < CO_NODE_WIDTH; i++)
            if (node->child[i] & CO_REF_LEAF)
                co_wide_node_set(node, i, &top->placed[node->child[i] & ~CO_REF_LEAF].box,
                                 node->child[i]);
    }
    return refit_tree(&top->tree, cost);
}

typedef struct LeafRefit {
    CoBvh *bvh;
    const CoMesh *mesh;
} LeafRefit;

// Writes a leaf's points again; returns their box.
static CoBox refit_triangles(const CoMesh *mesh, uint32_t ref, unsigned char *leaves)
{
    unsigned char *bytes = leaves + CO_LEAF_UNIT * (size_t)(ref & CO_REF_LEAF_PLACE);
    const CoTriLeaf leaf = co_leaf_open(bytes);
    unsigned char *points = bytes + ((const unsigned char *)leaf.points[0] - bytes);
    CoBox box;
    co_box_empty(&box);
    for (uint32_t j = 0; j < leaf.count; j++) {
        uint32_t tri[3];
        co_mesh_triangle(mesh, co_leaf_tri(&leaf, j), tri);
        for (uint32_t c = 0; c < 3; c++) {
            const float *p = mesh->points + 3 * (size_t)tri[c];
            unsigned char *at = points + sizeof(float) * co_leaf_corner(&leaf, c, j);
            for (size_t k = 0; k < 3; k++)
                memcpy(at + sizeof(float) * k * leaf.point_count, &p[k], sizeof(float));
            co_box_extend(&box, p, p);
        }
    }
    return box;
}

static void refit_leaves(void *context, size_t begin, size_t end, uint32_t worker)
{
    const LeafRefit *refit = context;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        CoWideNode *node = &refit->bvh->tree.nodes[n];
        for (int i = 0; i < CO_NODE_WIDTH; i++) {
            uint32_t ref = node->child[i];
            if (!(ref & CO_REF_LEAF))
                continue;
            CoBox box = refit->mesh->patches
                            ? co_grid_refit(refit->mesh, ref, refit->bvh->leaves)
                            : refit_triangles(refit->mesh, ref, refit->bvh->leaves);
            co_wide_node_set(node, i, &box, ref);
        }
    }
}

bool co_bvh_refit(CoBvh *bvh, const CoMesh *mesh)
{
    if (bvh->has_shards)
        return false;
    bvh->is_flat = mesh->is_flat;
    double cost = built_cost(&bvh->tree);
    LeafRefit refit = {bvh, mesh};
    co_parallel_for(bvh->tree.node_count, LEAF_GRAIN, refit_leaves, &refit);
    if (mesh->patches)
        co_grid_attach(bvh, mesh);
    return refit_tree(&bvh->tree, cost);
}
