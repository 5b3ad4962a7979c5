/* Optimal string alignment distance: insertions, deletions, replacements and swaps of neighbours each cost
 * one. */
#include "runtime/core/nearest.h"

#include <string.h>

#define NEAREST_MAX 48 /* longer words are compared by their first characters only */

static size_t min3(size_t a, size_t b, size_t c)
{
    size_t m = a < b ? a : b;
    return m < c ? m : c;
}

static size_t edit_distance(const char *a, size_t n, const char *b, size_t m)
{
    size_t rows[3][NEAREST_MAX + 1];
    size_t *before = rows[0], *above = rows[1], *row = rows[2];
    for (size_t j = 0; j <= m; j++)
        above[j] = j;
    for (size_t i = 1; i <= n; i++) {
        row[0] = i;
        for (size_t j = 1; j <= m; j++) {
            size_t replaced = above[j - 1] + (a[i - 1] != b[j - 1]);
            row[j] = min3(replaced, above[j] + 1, row[j - 1] + 1);
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] && before[j - 2] + 1 < row[j])
                row[j] = before[j - 2] + 1;
        }
        size_t *oldest = before;
        before = above;
        above = row;
        row = oldest;
    }
    return above[m];
}

kd_nearest kd_nearest_to(const char *word)
{
    return (kd_nearest){.word = word};
}

void kd_nearest_offer(kd_nearest *near, const char *candidate)
{
    size_t n = strnlen(near->word, NEAREST_MAX), m = strnlen(candidate, NEAREST_MAX);
    size_t longest = n > m ? n : m;
    size_t distance = edit_distance(near->word, n, candidate, m);
    /* A third of the letters may differ, and one letter always: more is another word, not a slip. */
    size_t allowed = longest / 3 > 1 ? longest / 3 : 1;
    if (distance > allowed || distance >= longest || (near->best && distance >= near->distance))
        return;
    near->best = candidate;
    near->distance = distance;
}

const char *kd_nearest_word(const char *word, const char *const *words)
{
    kd_nearest near = kd_nearest_to(word);
    for (; *words; words++)
        kd_nearest_offer(&near, *words);
    return near.best;
}
