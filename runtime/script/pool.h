#ifndef KD_SCRIPT_POOL_H
#define KD_SCRIPT_POOL_H

#include <stddef.h>

/* Memory of a scenario. Lua makes and drops small blocks all the time: those come from lists of free blocks
 * of equal size, cut from chunks that live as long as the pool; larger ones from the heap. {0} is an empty
 * pool. */
enum { SCRIPT_POOL_STEP = 16, SCRIPT_POOL_CLASSES = 16 };

typedef struct script_pool {
    void *free[SCRIPT_POOL_CLASSES]; /* of (class + 1) * SCRIPT_POOL_STEP bytes; each points to the next */
    void *chunks;                    /* each points to the one before */
    char *rest;                      /* of the newest chunk */
    size_t rest_bytes;
} script_pool;

/** Make a block (old_size 0), or change its size and keep what fits. Returns NULL when memory is out; the
 * block is as it was then */
void *script_pool_resize(script_pool *pool, void *block, size_t old_size, size_t new_size);
/** Give a block of `size` bytes back. NULL does nothing. */
void script_pool_free(script_pool *pool, void *block, size_t size);
/** Free everything but large blocks, which are given back one by one. */
void script_pool_fini(script_pool *pool);

#endif
