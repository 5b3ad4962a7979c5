/* The comparison as a page that needs no other file: pictures are PNG in base64, the slider is a few lines of
 * script. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "runtime/app/comparison.h"
#include "runtime/app/image_write.h"
#include "runtime/core/color.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"

static const char head[] = "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n"
                           "<meta name=\"viewport\" content=\"width=device-width\">\n<title>";
static const char style[] =
    "</title>\n<style>\n"
    "body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 1400px; padding: 0 1em; "
    "background: #16161a; color: #ddd }\n"
    "table { border-collapse: collapse; margin: 1em 0 } th, td { padding: .25em .9em; text-align: right; "
    "border-bottom: 1px solid #333 } th:first-child, td:first-child { text-align: left }\n"
    "figure { display: inline-block; margin: 0 1em 1em 0; vertical-align: top } figcaption { color: #999 }\n"
    ".pair { position: relative; display: inline-block; line-height: 0 } .pair img + img { position: "
    "absolute; "
    "left: 0; top: 0 }\n"
    "img { image-rendering: pixelated; max-width: 100% } input { width: 100%; margin: .4em 0 }\n"
    "svg path { stroke: #333 } svg .line { stroke: #e8a; stroke-width: 2 } svg circle { fill: #fc8 } svg "
    "text { fill: "
    "#aaa; font-size: 12px }\n"
    "</style>\n";
static const char script[] = "<script>\n"
                             "for (const f of document.querySelectorAll('figure.slide')) {\n"
                             "  const top = f.querySelectorAll('img')[1], bar = f.querySelector('input');\n"
                             "  const move = () => { top.style.clipPath = `inset(0 0 0 ${bar.value}%)` };\n"
                             "  bar.addEventListener('input', move); move();\n"
                             "}\n</script>\n</html>\n";

static void put_text(FILE *out, const char *text)
{
    for (; *text; text++) {
        if (*text == '<' || *text == '>' || *text == '&' || *text == '"')
            fprintf(out, "&#%d;", *text);
        else
            fputc(*text, out);
    }
}

/* Source  RFC 4648, section 4 */
static void put_base64(FILE *out, const uint8_t *data, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        uint32_t n = (uint32_t)data[i] << 16 | (i + 1 < size ? (uint32_t)data[i + 1] << 8 : 0) |
                     (i + 2 < size ? data[i + 2] : 0);
        fputc(digits[n >> 18], out);
        fputc(digits[n >> 12 & 63], out);
        fputc(i + 1 < size ? digits[n >> 6 & 63] : '=', out);
        fputc(i + 2 < size ? digits[n & 63] : '=', out);
    }
}

static kd_status put_image(FILE *out, const app_picture *p, const char *what)
{
    void *png = NULL;
    size_t size;
    uint8_t *bytes = app_picture_bytes(p, 1, KD_TONEMAP_LINEAR);
    kd_status status =
        bytes ? app_png_encode(p->width, p->height, bytes, &png, &size)
              : kd_fail(KD_NO_MEMORY, "no memory for pictures of the page; choose a smaller size");
    if (status == KD_OK) {
        fprintf(out, "<img alt=\"%s\" width=\"%u\" height=\"%u\" src=\"data:image/png;base64,", what,
                p->width, p->height);
        put_base64(out, png, size);
        fputs("\">", out);
    }
    free(png);
    free(bytes);
    return status;
}

static kd_status put_heat(FILE *out, const app_pair *pair)
{
    app_picture heat;
    kd_status status = app_pair_heat(pair, &heat);
    if (status == KD_OK)
        status = put_image(out, &heat, "difference");
    app_picture_fini(&heat);
    return status;
}

static kd_status put_pair(FILE *out, const app_pair *pair)
{
    fputs("<h3>", out);
    put_text(out, pair->name);
    fprintf(out, ": FLIP %.4f</h3>\n<figure class=\"slide\"><div class=\"pair\">", pair->difference.flip);
    kd_status status = put_image(out, &pair->shown[0], "picture");
    if (status == KD_OK)
        status = put_image(out, &pair->shown[1], "reference");
    fputs("</div><br><input type=\"range\" min=\"0\" max=\"100\" value=\"50\" aria-label=\"divide\">"
          "<figcaption>left: picture, right: reference</figcaption></figure>\n<figure>",
          out);
    if (status == KD_OK)
        status = put_heat(out, pair);
    fputs("<figcaption>FLIP: black 0, pale yellow 1</figcaption></figure>\n", out);
    return status;
}

static void put_figure(FILE *out, double value, const char *format)
{
    fputs("<td>", out);
    if (isnan(value))
        fputs("–", out);
    else
        fprintf(out, format, value);
}

static void put_table(FILE *out, const app_comparison *c)
{
    fputs("<table>\n<tr><th>picture<th>FLIP<th>HDR-FLIP<th>relMSE<th>SSIM<th>mean<th>ms a "
          "frame<th>MiB<th>traced, s\n",
          out);
    for (uint32_t r = 0; r < c->row_count; r++) {
        const app_row *row = &c->rows[r];
        for (uint32_t i = row->first_pair; i < row->first_pair + row->pair_count; i++) {
            const app_difference *d = &c->pairs[i].difference;
            bool first = i == row->first_pair;
            fputs("<tr><td>", out);
            put_text(out, c->pairs[i].name);
            put_figure(out, d->flip, "%.4f");
            put_figure(out, d->hdr_flip, "%.4f");
            put_figure(out, d->relative_mse, "%.4g");
            put_figure(out, d->ssim, "%.4f");
            put_figure(out, d->mean_ratio, "%.4f");
            put_figure(out, first ? row->frame_ms : NAN, "%.1f");
            put_figure(out, first && row->gpu_bytes ? (double)row->gpu_bytes / (1 << 20) : NAN, "%.1f");
            put_figure(out, c->pairs[i].tracer_s, "%.3g");
            fputs("\n", out);
        }
    }
    fputs("</table>\n", out);
}

/* ---- error over time ---- */

enum { CURVE_WIDTH = 570, CURVE_HEIGHT = 300, CURVE_LEFT = 70, DECADE_X = 75, DECADE_Y = 50 };

/* Seconds from 1 ms on to the right, relMSE from 1 down to 10^-5. */
static double curve_x(double seconds)
{
    return CURVE_LEFT + DECADE_X * (log10(fmax(seconds, 1e-3)) + 3);
}

static double curve_y(double error)
{
    return 20 + DECADE_Y * -log10(fmin(fmax(error, 1e-5), 1));
}

static void put_axes(FILE *out)
{
    for (int i = 0; i <= 6; i++)
        fprintf(out, "<path d=\"M%d 20V270\"/><text x=\"%d\" y=\"288\">%g s</text>\n",
                CURVE_LEFT + DECADE_X * i, CURVE_LEFT + DECADE_X * i, pow(10, i - 3));
    for (int i = 0; i <= 5; i++)
        fprintf(out, "<path d=\"M%d %dH%d\"/><text x=\"%d\" y=\"%d\">%g</text>\n", CURVE_LEFT,
                20 + DECADE_Y * i, CURVE_LEFT + 6 * DECADE_X, CURVE_LEFT - 60, 24 + DECADE_Y * i,
                pow(10, -i));
}

/* The path tracer is a line, since its error falls as 1 / t; each technique is a point. */
static void put_curve(FILE *out, const app_comparison *c)
{
    const double k = c->tracer_rate;
    fprintf(
        out,
        "<h3>Indirect light: relMSE over time</h3>\n<svg width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\">\n",
        CURVE_WIDTH, CURVE_HEIGHT, CURVE_WIDTH, CURVE_HEIGHT);
    put_axes(out);
    double from = fmax(k, 1e-3), to = fmin(k / 1e-5, 1e3);
    if (from < to)
        fprintf(out, "<path class=\"line\" d=\"M%.1f %.1fL%.1f %.1f\"/>\n", curve_x(from), curve_y(k / from),
                curve_x(to), curve_y(k / to));
    for (uint32_t r = 0; r < c->row_count; r++) {
        const app_row *row = &c->rows[r];
        double x = curve_x(row->frame_ms * 1e-3),
               y = curve_y(c->pairs[row->first_pair + 2].difference.relative_mse);
        fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\"/><text x=\"%.1f\" y=\"%.1f\">", x, y, x + 8,
                y - 6);
        put_text(out, row->name);
        fputs("</text>\n", out);
    }
    fputs("</svg>\n<p>Line: path tracing on the same machine; points: techniques, whole frame.</p>\n", out);
}

kd_status app_comparison_write_html(const char *path, const app_comparison *c)
{
    kd_file_out file;
    kd_status status = kd_file_out_open(&file, path);
    if (status != KD_OK)
        return status;
    FILE *out = file.stream;
    fputs(head, out);
    put_text(out, c->title);
    fputs(style, out);
    fputs("<h1>", out);
    put_text(out, c->title);
    fprintf(out, "</h1>\n<p>%ux%u, against ", c->width, c->height);
    put_text(out, c->reference);
    fputs(".</p>\n", out);
    put_table(out, c);
    if (c->tracer_rate > 0)
        put_curve(out, c);
    for (uint32_t i = 0; i < c->pair_count && status == KD_OK; i++)
        status = put_pair(out, &c->pairs[i]);
    fputs(script, out);
    if (status != KD_OK) {
        kd_file_out_cancel(&file);
        return status;
    }
    return kd_file_out_commit(&file);
}
