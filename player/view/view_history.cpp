#include "player/view/view_history.h"

#include <algorithm>

namespace penumbra {

namespace {

constexpr std::size_t kMaxViews = 256;

}  // namespace

// An exposure that is measured follows from the rest.
ViewHistory::View ViewHistory::viewOf(const ViewState& state) {
    View view{state.camera,     state.lighting, state.show, state.display, state.automatic_exposure,
              state.characters, state.selected, state.slot, state.inspect};
    if (state.automatic_exposure) view.display.exposure = 1;
    return view;
}

void ViewHistory::note(const ViewState& state) {
    View view = viewOf(state);
    if (!views_.empty() && views_[at_] == view) return;
    if (!views_.empty()) views_.resize(at_ + 1);
    if (views_.size() == kMaxViews) views_.erase(views_.begin());
    views_.push_back(std::move(view));
    at_ = views_.size() - 1;
}

bool ViewHistory::go(ViewState& state, int steps) {
    if (views_.empty()) return false;
    const auto last = std::ptrdiff_t(views_.size()) - 1;
    const auto wanted = std::size_t(std::clamp(std::ptrdiff_t(at_) + steps, std::ptrdiff_t(0), last));
    if (wanted == at_) return false;
    at_ = wanted;
    const View& view = views_[at_];
    const float exposure = state.display.exposure;
    state.camera = view.camera;
    state.lighting = view.lighting;
    state.show = view.show;
    state.display = view.display;
    state.automatic_exposure = view.automatic_exposure;
    if (state.automatic_exposure) state.display.exposure = exposure;
    state.characters = view.characters;
    state.selected = view.selected;
    state.slot = view.slot;
    state.inspect = view.inspect;
    return true;
}

}  // namespace penumbra
