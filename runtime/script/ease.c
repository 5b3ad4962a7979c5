#include "runtime/script/ease.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PI            3.14159265358979323846
#define OVERSHOOT     1.70158 /* "back" swings out by a tenth */
#define ELASTIC_TURNS 0.3     /* period of "elastic" as a share of the time */

enum { LINEAR, IN, OUT, INOUT };

const char *const script_ease_families[] = {"quad", "cubic",   "sine",   "expo",
                                            "back", "elastic", "bounce", NULL};

typedef enum family { QUAD, CUBIC, SINE, EXPO, BACK, ELASTIC, BOUNCE, FAMILY_COUNT } family;

int script_ease_find(const char *name)
{
    static const char *const directions[] = {"in", "out", "inout"};
    char word[32];
    if (strcmp(name, "linear") == 0)
        return LINEAR;
    if (strncmp(name, "ease_", 5) == 0)
        return strcmp(name, "ease_in") == 0       ? CUBIC * 4 + IN
               : strcmp(name, "ease_out") == 0    ? CUBIC * 4 + OUT
               : strcmp(name, "ease_in_out") == 0 ? CUBIC * 4 + INOUT
                                                  : -1;
    for (int f = 0; f < FAMILY_COUNT; f++) {
        for (int d = 0; d < 3; d++) {
            snprintf(word, sizeof word, "%s_%s", script_ease_families[f], directions[d]);
            if (strcmp(word, name) == 0)
                return f * 4 + d + 1;
        }
    }
    return -1;
}

/* Four parabolas, each jump lower. The numbers follow from jumps of 1, 1/2 and 1/4 of the length: 2.75 halves
 * of the first in all, and 1 / (4/11)^2 = 7.5625. */
static double bounce_out(double s)
{
    const double steep = 7.5625, unit = 2.75;
    if (s < 1 / unit)
        return steep * s * s;
    if (s < 2 / unit)
        return steep * (s - 1.5 / unit) * (s - 1.5 / unit) + 0.75;
    if (s < 2.5 / unit)
        return steep * (s - 2.25 / unit) * (s - 2.25 / unit) + 0.9375;
    return steep * (s - 2.625 / unit) * (s - 2.625 / unit) + 0.984375;
}

/* Every family as it starts slowly. */
static double ease_in(family f, double s)
{
    switch (f) {
    case QUAD: return s * s;
    case CUBIC: return s * s * s;
    case SINE: return 1 - cos(s * PI / 2);
    case EXPO: /* 2^-10 at 0 is brought to 0 */ return (exp2(10 * (s - 1)) - exp2(-10)) / (1 - exp2(-10));
    case BACK: return s * s * ((OVERSHOOT + 1) * s - OVERSHOOT);
    case ELASTIC: return -exp2(10 * (s - 1)) * sin((s - 1 - ELASTIC_TURNS / 4) * 2 * PI / ELASTIC_TURNS);
    case BOUNCE: return 1 - bounce_out(1 - s);
    default: return s;
    }
}

double script_ease(int curve, double share)
{
    family f = (family)(curve / 4);
    if (!(share > 0))
        return 0;
    if (share >= 1)
        return 1;
    switch (curve % 4) {
    case IN: return ease_in(f, share);
    case OUT: return 1 - ease_in(f, 1 - share);
    case INOUT: return share < 0.5 ? ease_in(f, 2 * share) / 2 : 1 - ease_in(f, 2 - 2 * share) / 2;
    default: return share;
    }
}
