/* The voxel scene: what is cached, what stands in the cascades, and how full they are.
 * Source  Yalciner 2016, figure A.3 */
#include <stdio.h>

#include "components/render_targets.h"
#include "components/voxel_scene.h"
#include "runtime/app/window/session.h"

static const char *const columns[] = {"cascade", "span m", "voxels", "nodes", "bytes", "full"};

static const char *count_text(uint64_t n, char out[16])
{
    if (n >= 10000000)
        snprintf(out, 16, "%.0f M", (double)n * 1e-6);
    else if (n >= 10000)
        snprintf(out, 16, "%.1f k", (double)n * 1e-3);
    else
        snprintf(out, 16, "%u", (unsigned)n);
    return out;
}

static void draw_cascades(window_session *s, const kd_tree *tree)
{
    char text[16];
    double cells = (double)tree->resolution * tree->resolution * tree->resolution;
    if (!kd_ui_table_begin(s->ui, "cascades", columns, 6, 44, 20 + 17 * (float)(tree->cascade_count + 1)))
        return;
    for (uint32_t c = 0; c < tree->cascade_count; c++) {
        kd_ui_cell(s->ui, "%u", c);
        kd_ui_cell(s->ui, "%.3g", (double)tree->span_m[c]);
        kd_ui_cell(s->ui, "%s", count_text(tree->cascade_voxels[c], text));
        kd_ui_cell(s->ui, "%s", count_text(tree->cascade_nodes[c], text));
        kd_ui_cell(s->ui, "%s", window_bytes(tree->cascade_bytes[c], text));
        kd_ui_cell(s->ui, "%.2f %%", cells > 0 ? 100 * (double)tree->cascade_voxels[c] / cells : 0);
    }
    kd_ui_table_end(s->ui);
}

static void draw_pages(window_session *s, const char *name, const kd_voxel_pages *pages)
{
    char text[64], count[16];
    uint32_t room = pages->page_count * KD_PAGE_SEGMENTS;
    snprintf(text, sizeof text, "%s: %u of %u segments, %s voxels", name, pages->segment_count, room,
             count_text(pages->voxel_count, count));
    kd_ui_bar(s->ui, room ? (float)pages->segment_count / (float)room : 0, text);
}

void window_panel_voxels(window_session *s)
{
    char a[16], b[16], bytes[16];
    const kd_tree *tree = kd_singleton(s->stage->world, kd_tree);
    const kd_voxel_scene *scene = kd_singleton(s->stage->world, kd_voxel_scene);
    kd_ui_text(s->ui, "%s voxels cached, %s in pages", count_text(tree->cached_voxels, a),
               count_text(tree->resident_voxels, b));
    kd_ui_text(s->ui, "%s static, %s dynamic", count_text(tree->static_voxels, a),
               count_text(tree->dynamic_voxels, b));
    kd_ui_text(s->ui, "%s leaf cells, %s nodes, %s on the GPU in all", count_text(tree->leaf_cells, a),
               count_text(tree->node_count, b), window_bytes(kd_gpu_bytes(s->gpu), bytes));
    draw_cascades(s, tree);
    draw_pages(s, "static", &scene->pages[KD_LAYER_STATIC]);
    draw_pages(s, "dynamic", &scene->pages[KD_LAYER_DYNAMIC]);
    kd_ui_separator(s->ui);
    window_settings(s, "voxels");
    window_settings(s, "svo");
}
