#ifndef KD_SCRIPT_EASE_H
#define KD_SCRIPT_EASE_H

/* Easing curves: how far a movement has come (0 to 1, but for back and elastic, which overshoot) at a share
 * of its time. */

/** Find a curve by its name: "linear", or FAMILY_in, FAMILY_out, FAMILY_inout; "ease_in", "ease_out" and
 * "ease_in_out" are the cubic ones. Returns -1 when there is none. */
int script_ease_find(const char *name);

/** Evaluate a curve.
 *
 *  Units   share: 0 … 1 of the time; less and more are held
 *  Returns 0 at 0 and 1 at 1, exactly
 *  Source  Penner, "Programming Macromedia Flash MX", 2002, chapter 7
 */
double script_ease(int curve, double share);

extern const char *const script_ease_families[]; /* ended by NULL; without "linear" */

#endif
