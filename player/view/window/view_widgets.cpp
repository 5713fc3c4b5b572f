#include "player/view/window/view_widgets.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace penumbra {

bool listLine(const std::string& name, std::size_t id, bool chosen, float width) {
    return ImGui::Selectable((name + "##" + std::to_string(id)).c_str(), chosen, 0, ImVec2(width, 0));
}

void tooltip(const char* text) {
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(22 * ImGui::GetFontSize());
    ImGui::TextUnformatted(text);
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

namespace {

void drawMenu(const Menu& menu, const char* label, const Scene& scene, ViewState& state) {
    const std::vector<std::string> names = menu.names(scene, state);
    const std::size_t chosen = menu.chosen(state);
    const float room = ImGui::CalcItemWidth() - 2.5f * ImGui::GetFontSize();  // without the arrow
    const bool open = ImGui::BeginCombo(label, names[chosen].c_str());
    if (!open && ImGui::CalcTextSize(names[chosen].c_str()).x > room && ImGui::IsItemHovered())
        tooltip(names[chosen].c_str());
    if (!open) return;
    if (std::exchange(state.window.closes_list, false)) ImGui::CloseCurrentPopup();
    for (std::size_t i = 0; i < names.size(); ++i)
        if (menu.offers(scene, i) && listLine(names[i], i, i == chosen)) menu.choose(state, scene, i);
    ImGui::EndCombo();
}

// Numbers from 0 on spread over log(1 + x), so that 0 takes no more of the slider than it shows.
bool slideFromZero(const char* label, double& value, const SliderRange& range, const char* text) {
    auto place = float(std::log1p(value));
    if (!ImGui::SliderFloat(label, &place, 0, float(std::log1p(range.most)), text,
                            ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput))
        return false;
    value = std::expm1(double(place));
    return true;
}

void drawSlider(const Slider& slider, const char* label, const Scene& scene, ViewState& state) {
    const SliderRange range = slider.rangeOf(scene, state);
    const std::string format = (range.name.empty() ? "" : std::string(range.name) + " ") + range.format;
    double value = slider.get(scene, state);
    char text[64];
    std::snprintf(text, sizeof text, format.c_str(), value);
    const int flags = ImGuiSliderFlags_AlwaysClamp | (range.logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
    if (range.logarithmic && range.least <= 0 ? slideFromZero(label, value, range, text)
                                              : ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &range.least,
                                                                    &range.most, format.c_str(), flags))
        slider.set(state, scene, value);
}

void drawControl(const Control& control, const Scene& scene, ViewState& state) {
    const std::string label = std::string("##") + control.id;
    if (const auto* menu = std::get_if<const Menu*>(&control.does)) drawMenu(**menu, label.c_str(), scene, state);
    if (const auto* slider = std::get_if<Slider>(&control.does)) drawSlider(*slider, label.c_str(), scene, state);
    if (const auto* to_switch = std::get_if<Switch>(&control.does))
        ImGui::Checkbox(to_switch->name, &to_switch->of(state));
}

// Writes the name at the left, and leaves the rest of the line to the control.
void nameOf(const Control& control) {
    const float column = std::min(6 * ImGui::GetFontSize(), 0.4f * ImGui::GetWindowWidth());
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(control.name);
    if (ImGui::IsItemHovered()) tooltip(control.tip);
    ImGui::SameLine(column);
}

}  // namespace

void drawControls(ControlPanel panel, const Scene& scene, ViewState& state, float width) {
    for (const Control& control : controls()) {
        if (control.panel != panel) continue;
        if (control.heading) ImGui::TextDisabled("%s", control.heading);
        if (control.exists && !control.exists(scene, state)) continue;
        if (control.same_line) ImGui::SameLine();
        if (control.name) nameOf(control);
        ImGui::SetNextItemWidth(width);
        ImGui::BeginDisabled(control.works && !control.works(scene, state));
        drawControl(control, scene, state);
        ImGui::EndDisabled();
        if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled) && !ImGui::IsItemActive()) tooltip(control.tip);
        const std::string problem = control.problem ? control.problem(scene, state) : "";
        if (!problem.empty()) ImGui::TextColored(ImColor(kMarked), "%s", problem.c_str());
    }
}

}  // namespace penumbra
