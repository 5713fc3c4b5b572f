#include "player/view/window/first_file.h"

#include <algorithm>

#include "formats/common/write_file.h"
#include "player/gl/gl_loader.h"
#include "player/view/cached.h"
#include "player/view/folder_list.h"
#include "player/view/view_actions.h"
#include "player/view/window/view_panels.h"

namespace penumbra {

void beginEmptyPicture(ViewWindow& window) {
    gl::BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl::Viewport(0, 0, window.width(), window.height());
    gl::ClearColor(0.1f, 0.1f, 0.1f, 1);
    gl::Clear(GL_COLOR_BUFFER_BIT);
    window.beginPanels();
}

std::optional<std::filesystem::path> chooseFirstFile(ViewWindow& window, const ViewState& settings,
                                                     const std::string& problem) {
    constexpr double kWait = 0.05;  // seconds between pictures
    ViewState state = settings;
    Cached<std::filesystem::path, FolderList> folder;
    while (!state.window.chosen) {
        if (!state.window.browsed) browseFiles(state);  // this list cannot be closed
        throwIfInterrupted();
        const ViewEvents events = window.poll(kWait);
        const bool quits = std::ranges::any_of(events.keys, [](const KeyPress& press) { return press.key == 'Q'; });
        if (events.close || quits) return std::nullopt;
        if (!events.dropped.empty()) return events.dropped.front();
        if (!window.visible()) continue;
        folder.update(*state.window.browsed, [&](FolderList& list) { list = listFolder(*state.window.browsed); });
        beginEmptyPicture(window);
        buildFirstPanel(*folder, state, problem);
        window.drawPanels();
        window.present();
    }
    return state.window.chosen;
}

}  // namespace penumbra
