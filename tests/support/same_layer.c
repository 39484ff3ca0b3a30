#include "support/same_layer.h"

static bool same_tree(const CoSpec *a, const CoSpec *b);

static bool same_specs(CoSpec *const *a, size_t a_count, CoSpec *const *b, size_t b_count)
{
    bool same = a_count == b_count;
    for (size_t i = 0; same && i < a_count; i++)
        same = same_tree(a[i], b[i]);
    return same;
}

static bool same_tree(const CoSpec *a, const CoSpec *b)
{
    const CoContents *x = co_spec_contents(a), *y = co_spec_contents(b);
    return co_spec_equal(a, b) &&
           same_specs(x->children, x->child_count, y->children, y->child_count) &&
           same_specs(x->variant_sets, x->variant_set_count, y->variant_sets, y->variant_set_count);
}

bool same_layer(const CoLayer *a, const CoLayer *b)
{
    return same_tree(a->root, b->root);
}
