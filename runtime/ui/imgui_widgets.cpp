/* The widgets of ui.h in Dear ImGui's words. */
#include <cfloat>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "runtime/ui/imgui_shim.h"

namespace
{

const ImVec4 dim_color(0.62f, 0.66f, 0.72f, 1);
const ImVec4 error_color(1, 0.45f, 0.35f, 1);

/* Widgets leave this share of a panel's width to their labels. */
constexpr float label_share = 0.48f;

void put_width()
{
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * (1 - label_share));
}

const char *number_format(double value, bool whole)
{
    double size = std::fabs(value);
    return whole ? "%.0f" : size != 0 && (size < 0.01 || size >= 1e5) ? "%.2e" : size < 10 ? "%.3f" : "%.2f";
}

} // namespace

/* ---- panels and menus ---- */

bool kd_ui_panel_begin(kd_ui *ui, const char *title, float x, float y, float width, float height, bool *open)
{
    float s = ui->scale;
    ImGui::SetNextWindowPos(ImVec2(x * s, y * s), ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize(ImVec2(width * s, height * s), ImGuiCond_FirstUseEver);
    return ImGui::Begin(title, open, ImGuiWindowFlags_NoFocusOnAppearing);
}

void kd_ui_panel_end(kd_ui *)
{
    ImGui::End();
}

bool kd_ui_bar_begin(kd_ui *)
{
    return ImGui::BeginMainMenuBar();
}

void kd_ui_bar_end(kd_ui *)
{
    ImGui::EndMainMenuBar();
}

bool kd_ui_menu_begin(kd_ui *, const char *label)
{
    return ImGui::BeginMenu(label);
}

void kd_ui_menu_end(kd_ui *)
{
    ImGui::EndMenu();
}

bool kd_ui_menu_item(kd_ui *, const char *label, const char *key, bool marked)
{
    return ImGui::MenuItem(label, key, marked);
}

void kd_ui_list_begin(kd_ui *ui, const char *label, float height)
{
    ImGui::BeginChild(label, ImVec2(0, height * ui->scale));
}

void kd_ui_list_end(kd_ui *)
{
    ImGui::EndChild();
}

/* ---- what stands in them ---- */

void kd_ui_text(kd_ui *, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    ImGui::TextV(format, arguments);
    va_end(arguments);
}

void kd_ui_text_dim(kd_ui *, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    ImGui::TextColoredV(dim_color, format, arguments);
    va_end(arguments);
}

void kd_ui_text_wrapped(kd_ui *, const char *text)
{
    ImGui::TextWrapped("%s", text);
}

void kd_ui_text_error(kd_ui *, const char *text)
{
    ImGui::PushStyleColor(ImGuiCol_Text, error_color);
    ImGui::TextWrapped("%s", text);
    ImGui::PopStyleColor();
}

void kd_ui_hint(kd_ui *, const char *text)
{
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip("%s", text);
}

void kd_ui_same_line(kd_ui *)
{
    ImGui::SameLine();
}

void kd_ui_separator(kd_ui *)
{
    ImGui::Separator();
}

void kd_ui_id_begin(kd_ui *, uint64_t id)
{
    const char *bytes = reinterpret_cast<const char *>(&id);
    ImGui::PushID(bytes, bytes + sizeof id);
}

void kd_ui_id_end(kd_ui *)
{
    ImGui::PopID();
}

void kd_ui_disabled_begin(kd_ui *, bool disabled)
{
    ImGui::BeginDisabled(disabled);
}

void kd_ui_disabled_end(kd_ui *)
{
    ImGui::EndDisabled();
}

/* ---- widgets ---- */

bool kd_ui_button(kd_ui *, const char *label)
{
    return ImGui::Button(label);
}

bool kd_ui_check(kd_ui *, const char *label, bool *value)
{
    return ImGui::Checkbox(label, value);
}

bool kd_ui_choose(kd_ui *, const char *label, const char *const *words, uint32_t count, uint32_t *index)
{
    bool changed = false;
    put_width();
    if (!ImGui::BeginCombo(label, *index < count ? words[*index] : ""))
        return false;
    for (uint32_t i = 0; i < count; i++) {
        if (ImGui::Selectable(words[i], i == *index)) {
            changed = i != *index;
            *index = i;
        }
    }
    ImGui::EndCombo();
    return changed;
}

bool kd_ui_numbers(kd_ui *, const char *label, double *values, uint32_t count, double speed, double min,
                   double max, bool whole)
{
    bool limited = min != max;
    double largest = 0;
    for (uint32_t i = 0; i < count; i++)
        largest = std::fmax(largest, std::fabs(values[i]));
    put_width();
    return ImGui::DragScalarN(label, ImGuiDataType_Double, values, static_cast<int>(count),
                              static_cast<float>(speed), limited ? &min : nullptr, limited ? &max : nullptr,
                              number_format(largest, whole), limited ? ImGuiSliderFlags_AlwaysClamp : 0);
}

bool ui_edit_srgb(kd_ui *, const char *label, float srgb[3])
{
    put_width();
    return ImGui::ColorEdit3(label, srgb);
}

bool kd_ui_string(kd_ui *, const char *label, char *text, size_t size)
{
    put_width();
    return ImGui::InputText(label, text, size, ImGuiInputTextFlags_EnterReturnsTrue);
}

bool kd_ui_line(kd_ui *, const char *label, bool chosen)
{
    return ImGui::Selectable(label, chosen);
}

bool kd_ui_heading(kd_ui *, const char *label, bool open_at_first)
{
    return ImGui::CollapsingHeader(label, open_at_first ? ImGuiTreeNodeFlags_DefaultOpen : 0);
}

bool kd_ui_node_begin(kd_ui *, uint64_t id, const char *label, bool leaf, bool chosen, bool *clicked)
{
    ImGuiTreeNodeFlags flags = ImGuiTreeNodeFlags_OpenOnArrow | ImGuiTreeNodeFlags_SpanAvailWidth |
                               (leaf ? ImGuiTreeNodeFlags_Leaf : 0) |
                               (chosen ? ImGuiTreeNodeFlags_Selected : 0);
    bool open = ImGui::TreeNodeEx(reinterpret_cast<void *>(static_cast<uintptr_t>(id)), flags, "%s", label);
    *clicked = ImGui::IsItemClicked();
    return open;
}

void kd_ui_node_end(kd_ui *)
{
    ImGui::TreePop();
}

/* ---- tables and curves ---- */

bool kd_ui_table_begin(kd_ui *ui, const char *label, const char *const *columns, uint32_t count, float width,
                       float height)
{
    ImGuiTableFlags flags = ImGuiTableFlags_RowBg | ImGuiTableFlags_BordersInnerV | ImGuiTableFlags_ScrollY |
                            ImGuiTableFlags_SizingFixedFit;
    if (!ImGui::BeginTable(label, static_cast<int>(count), flags, ImVec2(0, height * ui->scale)))
        return false;
    ImGui::TableSetupScrollFreeze(0, 1);
    for (uint32_t i = 0; i < count; i++)
        ImGui::TableSetupColumn(columns[i],
                                i ? ImGuiTableColumnFlags_WidthFixed : ImGuiTableColumnFlags_WidthStretch,
                                i ? width * ui->scale : 0);
    ImGui::TableHeadersRow();
    return true;
}

void kd_ui_table_end(kd_ui *)
{
    ImGui::EndTable();
}

void kd_ui_cell(kd_ui *, const char *format, ...)
{
    va_list arguments;
    ImGui::TableNextColumn();
    va_start(arguments, format);
    ImGui::TextV(format, arguments);
    va_end(arguments);
}

bool kd_ui_row(kd_ui *, const char *label, bool chosen)
{
    ImGui::TableNextColumn();
    return ImGui::Selectable(label, chosen, ImGuiSelectableFlags_SpanAllColumns);
}

void kd_ui_curve(kd_ui *ui, const char *label, const float *values, uint32_t count, uint32_t first, float top,
                 float height)
{
    ImGui::PlotLines("##curve", values, static_cast<int>(count), static_cast<int>(first), label, 0, top,
                     ImVec2(ImGui::GetContentRegionAvail().x, height * ui->scale));
}

void kd_ui_bar(kd_ui *ui, float share, const char *text)
{
    ImGui::ProgressBar(share, ImVec2(-FLT_MIN, 15 * ui->scale), text);
}
