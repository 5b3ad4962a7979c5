/* Colours are linear everywhere but on the screen, where people judge them. */
#include <math.h>

#include "runtime/core/color.h"
#include "runtime/ui/internal.h"

bool kd_ui_color(kd_ui *ui, const char *label, float rgb[3])
{
    /* Brighter than white is kept as a factor: it is the hue and the shade that are chosen. */
    float shown[3], top = fmaxf(1, fmaxf(rgb[0], fmaxf(rgb[1], rgb[2])));
    for (int i = 0; i < 3; i++)
        shown[i] = kd_color_srgb_encode(rgb[i] / top);
    if (!ui_edit_srgb(ui, label, shown))
        return false;
    for (int i = 0; i < 3; i++)
        rgb[i] = kd_color_srgb_decode(shown[i]) * top;
    return true;
}
