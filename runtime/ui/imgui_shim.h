#ifndef KD_UI_IMGUI_SHIM_H
#define KD_UI_IMGUI_SHIM_H

/* What the C++ files of this module share. */

#include <imgui.h>
#include <imgui_internal.h>

#include "runtime/ui/internal.h"

extern "C" {
#include "runtime/core/log.h"
}

constexpr int UI_MAX_EVENTS = 512;

struct kd_ui {
    kd_gpu *gpu;
    ImGuiContext *context;
    ui_draw draw;
    float scale;
    kd_window_event events[UI_MAX_EVENTS]; /* not seen by ImGui yet */
    int event_count;
    bool owns[KD_MOUSE_COUNT];    /* the button was pressed on a panel */
    float x, y;                   /* of the pointer */
    ImVector<ui_vertex> vertices; /* of the last frame; kept, so that a steady frame allocates nothing */
    ImVector<uint32_t> indices;
    ImVector<ui_batch> batches;
};

#endif
