#ifndef KD_CORE_BOX_TREE_H
#define KD_CORE_BOX_TREE_H

/* A hierarchy of boxes over numbered items, for finding those in a region among millions. Items lie in the
 * order of their centres along a Morton curve when the tree is built, sixteen a node; a box that changes
 * later is entered into the nodes above it alone. What has moved far makes nodes large and questions slow,
 * never wrong: the tree is built again when kd_box_tree_is_worn says so. Nodes know the box of all their
 * items and the box of those that are marked still. */

#include "runtime/core/frustum.h"
#include "runtime/core/math.h"
#include "runtime/core/status.h"

/* Empty when low.x > high.x. */
typedef struct kd_box {
    kd_vec3 low, high;
} kd_box;

typedef struct kd_box_node {
    kd_box all, still;
} kd_box_node;

#define KD_BOX_FAN    16
#define KD_BOX_LEVELS 8 /* 16^8 items */

typedef struct kd_box_tree {
    uint32_t count, capacity;
    kd_box *boxes;   /* [count], by number: written before building, then by kd_box_tree_set */
    uint8_t *still;  /* [count], likewise */
    uint32_t *order; /* [count] numbers along the curve */
    uint32_t *place; /* [count] where in the order */
    kd_box_node *nodes;
    uint32_t levels, first[KD_BOX_LEVELS],
        nodes_on[KD_BOX_LEVELS]; /* level 0 holds items; the last one node */
    uint64_t *keys;              /* [2 * capacity] scratch of building */
    uint32_t changes;            /* since it was built */
} kd_box_tree;

/** Make room for `count` items and set the count; boxes and still keep what was there. Errors NO_MEMORY */
kd_status kd_box_tree_reserve(kd_box_tree *tree, uint32_t count);

/** Build over the boxes as they are. */
void kd_box_tree_build(kd_box_tree *tree);

/** Change one item. Cost: sixteen boxes a level. */
void kd_box_tree_set(kd_box_tree *tree, uint32_t item, kd_box box, bool still);

/** Tell whether so many boxes have changed that building pays. */
static inline bool kd_box_tree_is_worn(const kd_box_tree *tree)
{
    return tree->changes > tree->count / 4 + 1024;
}

/** Box of all items, of those that are still; empty when there are none. */
kd_box kd_box_tree_all(const kd_box_tree *tree);
kd_box kd_box_tree_still(const kd_box_tree *tree);

/** Find the items whose boxes touch a frustum, or a box, in ascending order.
 *  out  [2 * count] numbers; the second half is scratch
 *  Returns how many. Threading: any number of readers at once */
uint32_t kd_box_tree_in_frustum(const kd_box_tree *tree, const kd_frustum *frustum, uint32_t *out);
uint32_t kd_box_tree_in_box(const kd_box_tree *tree, const kd_box *box, uint32_t *out);

void kd_box_tree_fini(kd_box_tree *tree);

#endif
