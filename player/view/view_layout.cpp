#include "player/view/view_layout.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

Rectangle pictureArea(int width, int height, float scale) {
    const int left = int(kSidePanelWidth * scale), below = int(kTimelineHeight * scale);
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
