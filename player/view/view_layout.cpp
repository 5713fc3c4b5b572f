#include "player/view/view_layout.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

PanelSizes panelSizes(float width, float height, float unit) {
    constexpr float kSide = 320, kTimeline = 132;                    // units
    constexpr float kLargestSide = 0.42f, kLargestTimeline = 0.36f;  // shares of the window
    return {std::min(kSide * unit, kLargestSide * width), std::min(kTimeline * unit, kLargestTimeline * height)};
}

Rectangle pictureArea(int width, int height, float scale) {
    const PanelSizes panels = panelSizes(float(width), float(height), scale);
    const int left = int(panels.side), below = int(panels.timeline);
    return {std::min(left, width - 1), 0, std::max(1, width - left), std::max(1, height - below)};
}

namespace {

// Returns the left `part` of a rectangle, and the rest.
std::pair<Rectangle, Rectangle> cut(const Rectangle& whole, float part) {
    const int left = std::clamp(int(std::lround(part * float(whole.width))), 0, whole.width);
    return {{whole.x, whole.y, left, whole.height}, {whole.x + left, whole.y, whole.width - left, whole.height}};
}

}  // namespace

std::vector<Pane> panesOf(const ViewState& state, const Rectangle& picture) {
    switch (shownCompare(state)) {
        case Compare::kTruth:
            return {{Shown::kTruth, picture, picture}};
        case Compare::kDifference:
            return {{Shown::kDifference, picture, picture}};
        case Compare::kSideBySide: {
            const auto [left, right] = cut(picture, 0.5f);
            return {{Shown::kModel, left, left}, {Shown::kTruth, right, right}};
        }
        case Compare::kWipe: {
            const auto [left, right] = cut(picture, state.show.wipe);
            return {{Shown::kModel, picture, left}, {Shown::kTruth, picture, right}};
        }
        default:
            return {{Shown::kModel, picture, picture}};
    }
}

}  // namespace penumbra
