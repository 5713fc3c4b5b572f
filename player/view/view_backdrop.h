#pragma once
// Draws what is behind and below the characters: the light as they see it, and a ground plane.
#include <optional>

#include "player/draw/draw_frame.h"
#include "player/view/view_scene.h"
#include "player/view/view_shapes.h"

namespace penumbra {

// Tells whether the ground is drawn. From below it would hide everyone.
bool showsGround(const Scene& scene, const ViewState& state);

class Backdrop {
public:
    // Draws into the pane that is set, and clears its depth. `view` has the pane's camera; `aspect` is its shape.
    void draw(const Scene& scene, const ViewState& state, const FrameView& view, double aspect);

private:
    // The light that the uploaded values were made for, and its version.
    struct Made {
        std::size_t light = 0;
        std::uint64_t version = 0;
        bool operator==(const Made&) const = default;
    };
    std::optional<ValuePainter> sky_, ground_;
    Shape sphere_;
    std::optional<Made> sky_made_;
    GroundTiles tiles_;
    std::uint64_t ground_version_ = 0;  // of the values that are uploaded

    void drawSky(const ShadingSet& shading, const ViewState& state, const FrameView& view, double aspect);
    void drawGround(const Scene& scene, const FrameView& view);
};

}  // namespace penumbra
