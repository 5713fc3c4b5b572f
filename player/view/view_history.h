#pragma once
// Goes back to views that the user had before, and forth again: camera, light, what is shown, materials, clips and the
// picked vertex. The time of the clip is none of it.
#include <vector>

#include "player/view/view_state.h"

namespace penumbra {

class ViewHistory {
public:
    // Notes what `state` shows, if that is another view than the last. Call it where nothing is being dragged: a drag
    // is one step. Views that were gone back from are forgotten then.
    void note(const ViewState& state);
    // Goes by `steps` views, back where that is below 0, as far as there are any. Returns whether the view changed.
    bool go(ViewState& state, int steps);
    // Forgets all views, which are of another scene.
    void forget() { *this = {}; }

private:
    struct View {
        Camera camera;
        Lighting lighting;
        ShowChoice show;
        DisplayTransform display;
        bool automatic_exposure = true;
        std::vector<CharacterChoice> characters;
        std::size_t selected = 0, slot = 0;
        Inspection inspect;
        bool operator==(const View&) const = default;
    };
    static View viewOf(const ViewState& state);
    std::vector<View> views_;
    std::size_t at_ = 0;  // number of the view that is shown
};

}  // namespace penumbra
