#pragma once
// What the window keeps from one run to the next: $XDG_CONFIG_HOME/penumbra/view.json, else
// ~/.config/penumbra/view.json.
#include <filesystem>
#include <string>

#include "player/view/view_state.h"
#include "player/view/window_place.h"

namespace penumbra {

struct ViewSettings {
    WindowPlace window;
    DisplayTransform display;
    double speed = 1;
    float error_max = 0.25f;
    bool background = true, ground = false, panels = true;
};

// Empty when the environment names no home.
std::filesystem::path settingsPath();
// The defaults where there is no file, or none that is JSON, and for each field that is absent or out of range:
// `problem` says so of what is there and not used.
ViewSettings readSettings(const std::filesystem::path& path, std::string& problem);
void writeSettings(const std::filesystem::path& path, const ViewSettings& settings);  // IoError

void applySettings(const ViewSettings& settings, ViewState& state);
ViewSettings settingsOf(const ViewState& state, const WindowPlace& window);

}  // namespace penumbra
