#include <imgui.h>

#include "player/view/window/view_widgets.h"

namespace penumbra {

namespace {

namespace fs = std::filesystem;

void chooseFile(ViewState& state, const fs::path& file) {
    state.window.chosen = file;
    state.window.browsed.reset();
}

// Says what a file holds, as far as its name tells.
const char* kindOf(const fs::path& file) {
    const std::string extension = file.extension();
    if (extension == ".json") return "scene";
    if (extension == ".exr" || extension == ".hdr") return "light";
    return file.stem().extension() == ".truth" ? "baked truth" : "";
}

// Writes a line with the kind of the file at the right, where there is room for it.
void fileLine(ViewState& state, const fs::path& file, std::size_t id) {
    const std::string name = file.filename();
    const char* const kind = kindOf(file);
    const float room = ImGui::GetContentRegionAvail().x, width = ImGui::CalcTextSize(kind).x;
    if (listLine(name, id, false)) chooseFile(state, file);
    if (ImGui::IsItemHovered()) tooltip(file.c_str());
    if (ImGui::CalcTextSize(name.c_str()).x + width + ImGui::GetFontSize() > room) return;
    ImGui::SameLine(ImGui::GetWindowContentRegionMin().x + room - width);
    ImGui::TextDisabled("%s", kind);
}

void recentFiles(ViewState& state) {
    ImGui::TextDisabled("Opened last");
    const std::vector<fs::path> recent = state.window.recent;  // a click changes the list
    for (std::size_t i = 0; i < recent.size(); ++i) fileLine(state, recent[i], i);
}

void browse(ViewState& state, const fs::path& folder) { state.window.browsed = state.window.folder = folder; }

// Lists what an asset must be packed of before it can be shown.
void unpackedFiles(const FolderList& list) {
    if (list.unpacked.empty()) return;
    ImGui::TextDisabled("To be packed first");
    for (const fs::path& file : list.unpacked) {
        ImGui::TextDisabled("%s", file.filename().c_str());
        const fs::path kind = file.stem().extension();
        const char* const option = kind == ".brdf" ? " --brdf " : kind == ".light" ? " --light " : nullptr;
        if (option && ImGui::IsItemHovered())
            tooltip(("penumbra-pack asset" + std::string(option) + file.string() + " -o LIBRARY.pnb").c_str());
    }
    ImGui::TextWrapped(
        "penumbra-pack asset --brdf M.brdf.h5 -o LIBRARY.pnb makes a file of materials for the window, "
        "and --light E.light.h5 one of lights.");
}

}  // namespace

void filePanel(const FolderList& list, ViewState& state) {
    if (!state.window.recent.empty()) recentFiles(state);
    ImGui::TextDisabled("Folder");
    ImGui::TextWrapped("%s", list.folder.c_str());
    if (!list.problem.empty()) ImGui::TextColored(ImColor(kMarked), "%s", list.problem.c_str());
    if (list.folder.has_relative_path() && listLine("../  (up)", 1000, false)) browse(state, list.folder.parent_path());
    for (std::size_t i = 0; i < list.folders.size(); ++i)
        if (listLine(list.folders[i].filename().string() + "/", 2000 + i, false)) browse(state, list.folders[i]);
    for (std::size_t i = 0; i < list.files.size(); ++i) fileLine(state, list.files[i], 1000000 + i);
    if (list.files.empty()) ImGui::TextDisabled("no .pnb, .json, .exr or .hdr here");
    unpackedFiles(list);
}

}  // namespace penumbra
