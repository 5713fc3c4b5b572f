#include <imgui.h>

#include "player/view/window/view_widgets.h"

namespace penumbra {

namespace {

namespace fs = std::filesystem;

void chooseFile(ViewState& state, const fs::path& file) {
    state.window.chosen = file;
    state.window.browsed.reset();
}

void recentFiles(ViewState& state) {
    ImGui::TextDisabled("Opened last");
    for (std::size_t i = 0; i < state.window.recent.size(); ++i) {
        const fs::path file = state.window.recent[i];
        if (listLine(file.filename().string(), i, false)) chooseFile(state, file);
        if (ImGui::IsItemHovered()) tooltip(file.c_str());
    }
}

}  // namespace

void filePanel(const FolderList& list, ViewState& state) {
    if (!state.window.recent.empty()) recentFiles(state);
    ImGui::TextDisabled("Folder");
    ImGui::TextWrapped("%s", list.folder.c_str());
    if (!list.problem.empty()) ImGui::TextColored(ImColor(kMarked), "%s", list.problem.c_str());
    if (list.folder.has_relative_path() && listLine("..", 1000, false))
        state.window.browsed = list.folder.parent_path();
    for (std::size_t i = 0; i < list.folders.size(); ++i)
        if (listLine(list.folders[i].filename().string() + "/", 2000 + i, false))
            state.window.browsed = list.folders[i];
    for (std::size_t i = 0; i < list.files.size(); ++i)
        if (listLine(list.files[i].filename().string(), 1000000 + i, false)) chooseFile(state, list.files[i]);
    if (list.files.empty()) ImGui::TextDisabled("no .pnb, .json, .exr or .hdr here");
    if (ImGui::Button("Close (F2)")) state.window.browsed.reset();
}

}  // namespace penumbra
