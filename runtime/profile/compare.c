/* Which systems became slower since an earlier run.
 *
 * Each system's times of the two runs are compared by rank, so that neither outliers nor the shape of their
 * distribution matter (Mann, Whitney 1947, with the correction for ties). Times of successive frames resemble
 * each other: what counts is as many of them as would be independent, n (1 - r) / (1 + r) with r their lag-1
 * correlation (Bartlett 1946). As many systems are tested at once, the probabilities are adjusted (Holm
 * 1979). A difference is reported when it would come about by chance in fewer than 1 of 100 comparisons, and
 * is worth a report: 5 % and 10 microseconds of the median. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/profile/internal.h"
#include "runtime/profile/json_read.h"

enum { MIN_SAMPLES = 8, MAX_WARM_UP = 8, NAME_SIZE = 128 };
#define CHANCE       0.01
#define MIN_SHARE    0.05
#define MIN_SHIFT_MS 0.01
#define MAX_BYTES    ((size_t)1 << 31)

typedef struct samples {
    double *ms;
    size_t count;
} samples;

typedef struct old_system {
    char name[NAME_SIZE];
    samples times;
} old_system;

typedef struct old_profile {
    old_system *systems;
    size_t count;
    samples frame;
} old_profile;

/* ---- the earlier run ---- */

static samples read_samples(json_reader *r)
{
    samples s = {0};
    size_t capacity = 0;
    for (json_begin(r, '['); json_next_item(r);) {
        if (s.count == capacity) {
            capacity = capacity ? capacity * 2 : 256;
            double *grown = realloc(s.ms, capacity * sizeof *grown);
            if (!grown) {
                r->failed = true;
                break;
            }
            s.ms = grown;
        }
        s.ms[s.count++] = json_number(r);
    }
    return s;
}

static void read_system(json_reader *r, old_profile *old)
{
    char key[32];
    old_system *grown = realloc(old->systems, (old->count + 1) * sizeof *grown);
    if (!grown) {
        r->failed = true;
        return;
    }
    old->systems = grown;
    old_system *system = &grown[old->count++];
    *system = (old_system){0};
    for (json_begin(r, '{'); json_next_key(r, key, sizeof key);) {
        if (strcmp(key, "name") == 0) {
            json_string(r, system->name, sizeof system->name);
        } else if (strcmp(key, "samples_ms") == 0) {
            free(system->times.ms);
            system->times = read_samples(r);
        } else {
            json_skip(r);
        }
    }
}

static void read_frame(json_reader *r, old_profile *old)
{
    char key[32];
    for (json_begin(r, '{'); json_next_key(r, key, sizeof key);) {
        if (strcmp(key, "samples_ms") == 0) {
            free(old->frame.ms);
            old->frame = read_samples(r);
        } else {
            json_skip(r);
        }
    }
}

static void read_profile(json_reader *r, old_profile *old)
{
    char key[32];
    for (json_begin(r, '{'); json_next_key(r, key, sizeof key);) {
        if (strcmp(key, "frame") == 0)
            read_frame(r, old);
        else if (strcmp(key, "systems") == 0)
            for (json_begin(r, '['); json_next_item(r);)
                read_system(r, old);
        else
            json_skip(r);
    }
}

static void free_old(old_profile *old)
{
    for (size_t i = 0; i < old->count; i++)
        free(old->systems[i].times.ms);
    free(old->systems);
    free(old->frame.ms);
}

static kd_status read_old(const char *path, old_profile *old)
{
    char key[32];
    void *data;
    size_t size;
    bool found = false;
    kd_status status = kd_file_read(path, MAX_BYTES, &data, &size);
    if (status != KD_OK)
        return status;
    json_reader r = {.at = data, .end = (const char *)data + size};
    for (json_begin(&r, '{'); json_next_key(&r, key, sizeof key);) {
        if (strcmp(key, "kandil") == 0 && !found) {
            read_profile(&r, old);
            found = true;
        } else {
            json_skip(&r);
        }
    }
    free(data);
    if (!r.failed && found)
        return KD_OK;
    return kd_fail(KD_BAD_FORMAT, "%s: is no profile; give a file that --profile FILE.json wrote", path);
}

/* ---- the test ---- */

typedef struct ranked {
    double ms, rank;
    size_t at; /* in the old samples, then the new ones */
} ranked;

static int compare_ms(const void *a, const void *b)
{
    double x = ((const ranked *)a)->ms, y = ((const ranked *)b)->ms;
    return (x > y) - (x < y);
}

static int compare_places(const void *a, const void *b)
{
    size_t x = ((const ranked *)a)->at, y = ((const ranked *)b)->at;
    return (x > y) - (x < y);
}

/* Give ranks from 1, equal ones their mean. Returns the sum of t^3 - t over groups of t equal ones. */
static double rank_all(ranked *all, size_t count)
{
    double ties = 0;
    qsort(all, count, sizeof *all, compare_ms);
    for (size_t i = 0, end; i < count; i = end) {
        for (end = i + 1; end < count && !(all[end].ms > all[i].ms); end++)
            ;
        double t = (double)(end - i);
        for (size_t k = i; k < end; k++)
            all[k].rank = ((double)i + 1 + (double)end) / 2;
        ties += t * t * t - t;
    }
    return ties;
}

/* As many of the samples as would be independent. */
static double effective(const ranked *ranks, size_t count)
{
    double mean = 0, variance = 0, product = 0;
    for (size_t i = 0; i < count; i++)
        mean += ranks[i].rank / (double)count;
    for (size_t i = 0; i < count; i++) {
        variance += (ranks[i].rank - mean) * (ranks[i].rank - mean);
        product += i ? (ranks[i].rank - mean) * (ranks[i - 1].rank - mean) : 0;
    }
    double r = variance > 0 ? product / variance : 0;
    r = r < 0 ? 0 : r > 0.95 ? 0.95 : r;
    double n = (double)count * (1 - r) / (1 + r);
    return n < 2 ? 2 : n;
}

static double rank_test(ranked *all, size_t n, size_t m)
{
    double a = (double)n, b = (double)m, whole = a + b, sum = 0;
    double ties = rank_all(all, n + m);
    qsort(all, n + m, sizeof *all, compare_places);
    for (size_t i = 0; i < n; i++)
        sum += all[i].rank;
    double u = sum - a * (a + 1) / 2;
    double variance = a * b / 12 * (whole + 1 - ties / (whole * (whole - 1)));
    double ea = effective(all, n), eb = effective(all + n, m);
    double fewer = (ea * eb / (ea + eb)) / (a * b / whole); /* how much less the samples say */
    double z = variance > 0 ? (u - a * b / 2) / sqrt(variance) * sqrt(fewer) : 0;
    return erfc(fabs(z) / sqrt(2));
}

/* ---- rows ---- */

typedef enum verdict { SAME, SLOWER, FASTER, NEW, GONE, TOO_FEW } verdict;

typedef struct row {
    char name[NAME_SIZE];
    double old_ms, new_ms, chance;
    verdict verdict;
} row;

static int compare_double(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double *ms, size_t count)
{
    double *sorted = count ? malloc(count * sizeof *sorted) : NULL;
    double value = 0;
    if (sorted) {
        memcpy(sorted, ms, count * sizeof *sorted);
        qsort(sorted, count, sizeof *sorted, compare_double);
        value = (sorted[(count - 1) / 2] + sorted[count / 2]) / 2;
    }
    free(sorted);
    return value;
}

/* The first frames fill caches: a tenth of them, at most MAX_WARM_UP, is left out. */
static size_t warm_up(size_t count)
{
    return count / 10 < MAX_WARM_UP ? count / 10 : MAX_WARM_UP;
}

static void judge(row *out, samples old, samples now)
{
    size_t skip_old = warm_up(old.count), skip_now = warm_up(now.count);
    size_t n = old.count - skip_old, m = now.count - skip_now;
    out->old_ms = median(old.ms + skip_old, n);
    out->new_ms = median(now.ms + skip_now, m);
    out->chance = 1;
    out->verdict = !old.count ? NEW : !now.count ? GONE : n < MIN_SAMPLES || m < MIN_SAMPLES ? TOO_FEW : SAME;
    ranked *all = out->verdict == SAME ? malloc((n + m) * sizeof *all) : NULL;
    for (size_t i = 0; all && i < n + m; i++)
        all[i] = (ranked){.ms = i < n ? old.ms[skip_old + i] : now.ms[skip_now + i - n], .at = i};
    if (all)
        out->chance = rank_test(all, n, m);
    free(all);
}

static int compare_chance(const void *a, const void *b)
{
    double x = (*(row *const *)a)->chance, y = (*(row *const *)b)->chance;
    return (x > y) - (x < y);
}

/* Adjust the chances for their number, then say what is worth a report. */
static bool decide(row *rows, size_t count)
{
    double least = 0;
    row **sorted = malloc((count + 1) * sizeof *sorted);
    size_t tests = 0;
    for (size_t i = 0; sorted && i < count; i++)
        if (rows[i].verdict == SAME)
            sorted[tests++] = &rows[i];
    if (sorted && tests)
        qsort(sorted, tests, sizeof *sorted, compare_chance);
    for (size_t i = 0; sorted && i < tests; i++) {
        row *r = sorted[i];
        double adjusted = r->chance * (double)(tests - i), shift = r->new_ms - r->old_ms;
        least = adjusted > least ? adjusted : least;
        r->chance = least < 1 ? least : 1;
        if (r->chance < CHANCE && fabs(shift) > MIN_SHIFT_MS && fabs(shift) > MIN_SHARE * r->old_ms)
            r->verdict = shift > 0 ? SLOWER : FASTER;
    }
    free(sorted);
    return sorted != NULL;
}

/* ---- the report ---- */

static const char *const verdict_words[] = {"same", "slower", "faster", "new", "gone", "too few frames"};

static void write_row(FILE *out, const row *r)
{
    fprintf(out, "%-24s  %9.3f  %9.3f", r->name, r->old_ms, r->new_ms);
    if (r->verdict == SAME || r->verdict == SLOWER || r->verdict == FASTER)
        fprintf(out, "  %+7.1f %%  %8.2g", r->old_ms > 0 ? 100 * (r->new_ms / r->old_ms - 1) : 0, r->chance);
    else
        fprintf(out, "  %9s  %8s", "", "");
    fprintf(out, "  %s\n", verdict_words[r->verdict]);
}

static void write_report(FILE *out, const row *rows, size_t count, const char *old_path)
{
    const char *between = "slower: ";
    fprintf(out, "compared with %s\n%-24s  %9s  %9s  %9s  %8s  %s\n", old_path, "system", "old ms", "new ms",
            "change", "chance", "verdict");
    for (size_t i = 0; i < count; i++)
        write_row(out, &rows[i]);
    for (size_t i = 0; i < count; i++) {
        if (rows[i].verdict != SLOWER)
            continue;
        fprintf(out, "%s%s", between, rows[i].name);
        between = ", ";
    }
    size_t judged = 0;
    for (size_t i = 0; i < count; i++)
        judged += rows[i].verdict != TOO_FEW && rows[i].verdict != NEW && rows[i].verdict != GONE;
    if (between[0] == ',' || judged)
        fprintf(out, "%s\n", between[0] == ',' ? "" : "no system became slower");
    else
        fprintf(out, "nothing can be told: both runs need %d frames at least\n", MIN_SAMPLES + 1);
}

static samples samples_of(const kd_profile *p, uint32_t system)
{
    profile_samples ns = profile_system_samples(p, system);
    samples s = {.ms = malloc((ns.count + 1) * sizeof(double))};
    for (uint64_t i = 0; s.ms && i < ns.count; i++)
        s.ms[s.count++] = (double)ns.ns[(ns.first + i) % ns.count] * 1e-6;
    return s;
}

static const old_system *find_old(const old_profile *old, const char *name)
{
    for (size_t i = 0; i < old->count; i++)
        if (strcmp(old->systems[i].name, name) == 0)
            return &old->systems[i];
    return NULL;
}

static void add_row(row *rows, size_t *count, const char *name, samples old, samples now)
{
    if (!old.count && !now.count)
        return;
    row *r = &rows[(*count)++];
    *r = (row){.verdict = SAME};
    snprintf(r->name, sizeof r->name, "%s", name);
    judge(r, old, now);
}

/* Systems of this run in their order, those that are gone, then the frame. */
static size_t fill_rows(const kd_profile *p, const old_profile *old, row *rows)
{
    size_t count = 0;
    uint32_t systems = kd_profile_system_count(p);
    for (uint32_t i = 0; i <= systems; i++) {
        const char *name = i < systems ? kd_profile_system_at(p, i).name : "frame";
        const old_system *before = i < systems ? find_old(old, name) : NULL;
        samples now = samples_of(p, i);
        add_row(rows, &count, name, i == systems ? old->frame : before ? before->times : (samples){0}, now);
        free(now.ms);
    }
    for (size_t i = 0; i < old->count; i++) {
        bool known = false;
        for (uint32_t k = 0; k < systems; k++)
            known = known || strcmp(kd_profile_system_at(p, k).name, old->systems[i].name) == 0;
        if (!known)
            add_row(rows, &count, old->systems[i].name, old->systems[i].times, (samples){0});
    }
    return count;
}

kd_status kd_profile_compare(const kd_profile *p, const char *old_path, FILE *out)
{
    old_profile old = {0};
    kd_status status = read_old(old_path, &old);
    row *rows = status == KD_OK ? calloc(kd_profile_system_count(p) + old.count + 1, sizeof *rows) : NULL;
    if (rows) {
        size_t count = fill_rows(p, &old, rows);
        if (!decide(rows, count))
            status = kd_fail(KD_NO_MEMORY, "%s: out of memory", old_path);
        else
            write_report(out, rows, count, old_path);
    } else if (status == KD_OK) {
        status = kd_fail(KD_NO_MEMORY, "%s: out of memory", old_path);
    }
    free(rows);
    free_old(&old);
    return status;
}

kd_status kd_profile_check_old(const char *path)
{
    old_profile old = {0};
    kd_status status = read_old(path, &old);
    free_old(&old);
    return status;
}
