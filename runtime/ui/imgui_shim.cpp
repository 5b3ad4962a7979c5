/* The shim over Dear ImGui: a context, events fed one step a frame, geometry in flat arrays. Widgets are in
 * imgui_widgets.cpp. */
#include "runtime/ui/imgui_shim.h"

#include <cmath>
#include <cstring>
#include <new>

namespace
{

constexpr float font_pixels = 13; /* size of the built-in font: it is drawn for this one */

void set_keys(ImGuiIO &io)
{
    static const struct {
        ImGuiKey key;
        int code;
    } rows[] = {{ImGuiKey_Tab, KD_KEY_TAB},
                {ImGuiKey_LeftArrow, KD_KEY_LEFT},
                {ImGuiKey_RightArrow, KD_KEY_RIGHT},
                {ImGuiKey_UpArrow, KD_KEY_UP},
                {ImGuiKey_DownArrow, KD_KEY_DOWN},
                {ImGuiKey_PageUp, KD_KEY_PAGE_UP},
                {ImGuiKey_PageDown, KD_KEY_PAGE_DOWN},
                {ImGuiKey_Home, KD_KEY_HOME},
                {ImGuiKey_End, KD_KEY_END},
                {ImGuiKey_Insert, KD_KEY_INSERT},
                {ImGuiKey_Delete, KD_KEY_DELETE},
                {ImGuiKey_Backspace, KD_KEY_BACKSPACE},
                {ImGuiKey_Space, KD_KEY_SPACE},
                {ImGuiKey_Enter, KD_KEY_ENTER},
                {ImGuiKey_Escape, KD_KEY_ESCAPE},
                {ImGuiKey_KeyPadEnter, KD_KEY_KP_ENTER},
                {ImGuiKey_A, KD_KEY_A},
                {ImGuiKey_C, KD_KEY_C},
                {ImGuiKey_V, KD_KEY_V},
                {ImGuiKey_X, KD_KEY_X},
                {ImGuiKey_Y, KD_KEY_Y},
                {ImGuiKey_Z, KD_KEY_Z}};
    for (const auto &row : rows)
        io.KeyMap[row.key] = row.code;
}

/* Opaque frames and panels: text stays readable over any picture. */
void set_style(float scale)
{
    ImGuiStyle style;
    ImGui::StyleColorsDark(&style);
    style.WindowRounding = 3;
    style.FrameRounding = 2;
    style.WindowBorderSize = 0;
    style.WindowPadding = ImVec2(6, 6);
    style.ItemSpacing = ImVec2(6, 3);
    style.FramePadding = ImVec2(4, 2);
    style.IndentSpacing = 14;
    style.Colors[ImGuiCol_WindowBg] = ImVec4(0.09f, 0.09f, 0.11f, 0.92f);
    style.Colors[ImGuiCol_FrameBg] = ImVec4(0.20f, 0.25f, 0.33f, 1);
    style.Colors[ImGuiCol_MenuBarBg] = ImVec4(0.13f, 0.13f, 0.16f, 0.95f);
    style.Colors[ImGuiCol_TitleBg] = ImVec4(0.11f, 0.12f, 0.15f, 1);
    style.Colors[ImGuiCol_TitleBgCollapsed] = ImVec4(0.11f, 0.12f, 0.15f, 0.9f);
    style.ScaleAllSizes(scale);
    ImGui::GetStyle() = style;
}

/* Make the letters for the window's scale; they are drawn at a whole size, since they are made of pixels. */
kd_status set_scale(kd_ui *ui, float scale)
{
    unsigned char *texels = nullptr;
    int width = 0, height = 0;
    ImFontAtlas *fonts = ui->context->IO.Fonts;
    ImFontConfig config;
    config.SizePixels = std::floor(font_pixels * scale);
    ui->scale = scale;
    set_style(scale);
    fonts->Clear();
    fonts->AddFontDefault(&config);
    fonts->GetTexDataAsAlpha8(&texels, &width, &height);
    return ui_draw_font(&ui->draw, texels, static_cast<uint32_t>(width), static_cast<uint32_t>(height));
}

/* A panel under a point of the window? */
bool is_covered(const kd_ui *ui, float x, float y)
{
    const ImGuiContext *g = ui->context;
    for (int i = 0; i < g->Windows.Size; i++) {
        const ImGuiWindow *window = g->Windows[i];
        if ((window->Active || window->WasActive) && !window->Hidden &&
            !(window->Flags & (ImGuiWindowFlags_NoMouseInputs | ImGuiWindowFlags_ChildWindow)) &&
            window->OuterRectClipped.Contains(ImVec2(x, y)))
            return true;
    }
    return false;
}

void apply(kd_ui *ui, const kd_window_event &event)
{
    ImGuiIO &io = ui->context->IO;
    switch (event.kind) {
    case KD_WINDOW_POINTER: io.MousePos = ImVec2(event.x, event.y); break;
    case KD_WINDOW_BUTTON:
        io.MousePos = ImVec2(event.x, event.y);
        io.MouseDown[event.code] = event.down;
        break;
    case KD_WINDOW_SCROLL:
        io.MouseWheel += event.y;
        io.MouseWheelH += event.x;
        break;
    case KD_WINDOW_TEXT: io.AddInputCharacter(static_cast<unsigned>(event.code)); break;
    case KD_WINDOW_FOCUS: io.AddFocusEvent(event.down); break;
    case KD_WINDOW_LEFT: io.MousePos = ImVec2(-FLT_MAX, -FLT_MAX); break;
    case KD_WINDOW_KEY:
        if (event.code >= 0 && event.code < KD_KEY_COUNT)
            io.KeysDown[event.code] = event.down;
        break;
    case KD_WINDOW_CHANGED: break;
    }
    if (event.kind == KD_WINDOW_KEY || event.kind == KD_WINDOW_BUTTON) {
        io.KeyCtrl = io.KeysDown[KD_KEY_LEFT_CONTROL] || io.KeysDown[KD_KEY_RIGHT_CONTROL];
        io.KeyShift = io.KeysDown[KD_KEY_LEFT_SHIFT] || io.KeysDown[KD_KEY_RIGHT_SHIFT];
        io.KeyAlt = io.KeysDown[KD_KEY_LEFT_ALT] || io.KeysDown[KD_KEY_RIGHT_ALT];
    }
}

/* Take what may share a frame: moves, or one press or release. ImGui looks once a frame at what is down and
 * where the pointer is, so that a drag begins where it was pressed and ends where it was let go. */
void apply_some(kd_ui *ui)
{
    int taken = 0;
    bool moved = false;
    for (; taken < ui->event_count; taken++) {
        const kd_window_event &event = ui->events[taken];
        bool presses = event.kind == KD_WINDOW_BUTTON || event.kind == KD_WINDOW_KEY;
        if (presses && moved)
            break;
        apply(ui, event);
        moved = moved || event.kind == KD_WINDOW_POINTER;
        if (presses) {
            taken++;
            break;
        }
    }
    ui->event_count -= taken;
    std::memmove(ui->events, ui->events + taken, static_cast<size_t>(ui->event_count) * sizeof *ui->events);
}

/* Lay the lists end to end. ui_vertex is ImGui's own layout. */
void flatten(kd_ui *ui, const ImDrawData &data, ui_geometry *out)
{
    static_assert(sizeof(ui_vertex) == sizeof(ImDrawVert), "vertices are ImGui's");
    ui->vertices.resize(0);
    ui->indices.resize(0);
    ui->batches.resize(0);
    for (int i = 0; i < data.CmdListsCount; i++) {
        const ImDrawList *list = data.CmdLists[i];
        for (const ImDrawCmd &command : list->CmdBuffer) {
            ui_batch batch = {
                static_cast<uint32_t>(ui->indices.Size),
                command.ElemCount,
                {command.ClipRect.x, command.ClipRect.y, command.ClipRect.z, command.ClipRect.w}};
            uint32_t base = static_cast<uint32_t>(ui->vertices.Size) + command.VtxOffset;
            for (unsigned k = 0; k < command.ElemCount; k++)
                ui->indices.push_back(base + list->IdxBuffer[static_cast<int>(command.IdxOffset + k)]);
            if (command.ElemCount)
                ui->batches.push_back(batch);
        }
        int first = ui->vertices.Size;
        ui->vertices.resize(first + list->VtxBuffer.Size);
        std::memcpy(&ui->vertices.Data[first], list->VtxBuffer.Data,
                    static_cast<size_t>(list->VtxBuffer.Size) * sizeof(ui_vertex));
    }
    *out = {ui->vertices.Data,
            ui->indices.Data,
            ui->batches.Data,
            static_cast<uint32_t>(ui->vertices.Size),
            static_cast<uint32_t>(ui->indices.Size),
            static_cast<uint32_t>(ui->batches.Size),
            static_cast<uint32_t>(data.DisplaySize.x),
            static_cast<uint32_t>(data.DisplaySize.y)};
}

} // namespace

kd_status kd_ui_open(kd_gpu *gpu, kd_ui **out)
{
    *out = nullptr;
    kd_ui *ui = new (std::nothrow) kd_ui();
    if (!ui)
        return kd_fail(KD_NO_MEMORY, "out of memory for the window's panels");
    ui->gpu = gpu;
    ui->context = ImGui::CreateContext();
    ImGui::SetCurrentContext(ui->context);
    ui->context->IO.IniFilename = nullptr; /* panels stand where they stood at first in every run */
    ui->context->IO.LogFilename = nullptr;
    set_keys(ui->context->IO);
    kd_status status = ui_draw_open(&ui->draw, gpu);
    if (status == KD_OK)
        status = set_scale(ui, kd_gpu_window_scale(gpu));
    if (status == KD_OK)
        *out = ui;
    else
        kd_ui_close(ui);
    return status;
}

void kd_ui_close(kd_ui *ui)
{
    if (!ui)
        return;
    ui_draw_close(&ui->draw);
    ImGui::DestroyContext(ui->context);
    delete ui;
}

bool kd_ui_event(kd_ui *ui, const kd_window_event *event)
{
    if (ui->event_count < UI_MAX_EVENTS)
        ui->events[ui->event_count++] = *event;
    switch (event->kind) {
    case KD_WINDOW_BUTTON:
        if (event->down)
            ui->owns[event->code] = is_covered(ui, event->x, event->y);
        return ui->owns[event->code];
    case KD_WINDOW_POINTER:
        ui->x = event->x;
        ui->y = event->y;
        return ui->owns[KD_MOUSE_LEFT] && ui->context->IO.MouseDown[KD_MOUSE_LEFT];
    case KD_WINDOW_SCROLL: return is_covered(ui, ui->x, ui->y);
    case KD_WINDOW_KEY:
    case KD_WINDOW_TEXT:
        return ui->context->IO.WantTextInput && event->down != (event->kind == KD_WINDOW_TEXT);
    default: return false;
    }
}

bool kd_ui_waiting(const kd_ui *ui)
{
    return ui->event_count > 0;
}

void kd_ui_begin(kd_ui *ui, float dt_s)
{
    uint32_t width, height;
    float scale = kd_gpu_window_scale(ui->gpu);
    if (scale != ui->scale)
        (void)set_scale(ui, scale);
    kd_gpu_window_size(ui->gpu, &width, &height);
    ui->context->IO.DisplaySize = ImVec2(static_cast<float>(width), static_cast<float>(height));
    ui->context->IO.DeltaTime = dt_s > 1e-5f ? dt_s : 1e-5f;
    apply_some(ui);
    ImGui::NewFrame();
}

void kd_ui_end(kd_ui *ui)
{
    ui_geometry geometry;
    ImGui::Render();
    flatten(ui, *ImGui::GetDrawData(), &geometry);
    ui_draw_all(&ui->draw, &geometry);
}

void kd_ui_size(const kd_ui *ui, float *width, float *height)
{
    *width = ui->context->IO.DisplaySize.x / ui->scale;
    *height = ui->context->IO.DisplaySize.y / ui->scale;
}
