#pragma once
#include <algorithm>
#include <optional>
#include <span>

namespace penumbra {

// Sizes of a window in units of 1/96 inch. The least leaves the picture 190 x 200 beside the panels.
constexpr int kMinWidth = 480, kMinHeight = 320, kMaxWidth = 16384, kMaxHeight = 16384;

struct WindowPlace {
    int width = 1280, height = 800;  // units of 1/96 inch
    // screen coordinates, below 0 left of or above the first monitor; unset: where the system puts it
    std::optional<int> x, y;
};

// An area in screen coordinates.
struct ScreenArea {
    int x = 0, y = 0, width = 0, height = 0;
};

// Tells whether enough of the window's upper edge is on a monitor to be taken hold of.
inline bool isReachable(const ScreenArea& window, std::span<const ScreenArea> monitors) {
    constexpr int kHold = 64;
    return std::ranges::any_of(monitors, [&](const ScreenArea& monitor) {
        const int across = std::min(window.x + window.width, monitor.x + monitor.width) - std::max(window.x, monitor.x);
        return across >= kHold && window.y >= monitor.y - kHold && window.y + kHold <= monitor.y + monitor.height;
    });
}

}  // namespace penumbra
