#pragma once
// The window before anything is open in it.
#include <filesystem>
#include <optional>
#include <string>

#include "player/view/view_state.h"
#include "player/view/window/view_window.h"

namespace penumbra {

// Begins a picture of panels alone, which ViewWindow::drawPanels() and present() end.
void beginEmptyPicture(ViewWindow& window);

// Lists files, with those that `settings` opened last, until the user has chosen or dropped one. `problem` says why the
// last one did not open. Returns nothing when the user closes the window. Throws Interrupted.
std::optional<std::filesystem::path> chooseFirstFile(ViewWindow& window, const ViewState& settings,
                                                     const std::string& problem);

}  // namespace penumbra
