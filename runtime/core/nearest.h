#ifndef KD_CORE_NEAREST_H
#define KD_CORE_NEAREST_H

/* Near misses: which known word was meant by one that is unknown.
 *
 *     kd_nearest near = kd_nearest_to("modl");
 *     for (…) kd_nearest_offer(&near, words[i]);
 *     if (near.best) … "did you mean '%s'?", near.best */

#include <stddef.h>

typedef struct kd_nearest {
    const char *word;
    const char *best; /* NULL as long as nothing offered was near enough */
    size_t distance;  /* edits between the two */
} kd_nearest;

/** Start a search; `word` must outlive it. */
kd_nearest kd_nearest_to(const char *word);

/** Offer a candidate, which must outlive the search. The first among equals wins. Cost: product of the
 * lengths */
void kd_nearest_offer(kd_nearest *near, const char *candidate);

/** Search a NULL-terminated list. Returns one of its words, or NULL. */
const char *kd_nearest_word(const char *word, const char *const *words);

#endif
