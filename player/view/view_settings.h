#pragma once
// Keeps settings of the window from one run to the next, in $XDG_CONFIG_HOME/penumbra/view.json, else in
// ~/.config/penumbra/view.json.
#include <filesystem>
#include <string>

#include "player/view/view_state.h"
#include "player/view/window_place.h"

namespace penumbra {

// Returns what the window begins with where nothing was kept yet: tones are filmic, so that lit skin does not burn out,
// and the hint is on.
ViewState firstState();

struct ViewSettings {
    WindowPlace window;
    // Kept from it are the display (no exposure if that is automatic), the speed, the scale of errors, whether
    // background, ground and panels are on, and the files that were opened last.
    ViewState state = firstState();
};

// Returns an empty path when the environment names no home.
std::filesystem::path settingsPath();
// Returns the defaults where there is no file or where it is not JSON, and for each field that is absent or out of
// range. `problem` names what the file has but cannot be used.
ViewSettings readSettings(const std::filesystem::path& path, std::string& problem);
void writeSettings(const std::filesystem::path& path, const ViewSettings& settings);  // throws IoError

}  // namespace penumbra
