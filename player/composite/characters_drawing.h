#pragma once
// Draws the characters of a scene as a photograph's camera sees them, without its lens. Those in the photograph hide
// what is behind them.
#include <memory>
#include <optional>
#include <vector>

#include "player/composite/real_surfaces.h"
#include "player/draw/draw_frame.h"
#include "player/gl/gl_context.h"
#include "player/gl/offscreen_target.h"
#include "player/render/scene_frames.h"

namespace penumbra {

// A rectangle of a picture; outside of it nothing is drawn.
struct DrawnPart {
    Image image;       // with alpha; may be empty
    int x = 0, y = 0;  // position of its upper left pixel
};

class CharactersDrawing {
public:
    // Reads from the options: samples, backend and sun_map. `frames` and the scene outlive this object.
    CharactersDrawing(const PosedScene& scene, const SceneFrames& frames, const RenderOptions& options,
                      const PinholeCamera& camera);
    // Draws what `frames` shaded last by a camera that stands as `view` does, and has the constructor's pixels. Only
    // the rectangle around the characters is drawn. `moved` is false where everyone stands as before.
    // `sunlit` is what the vertices of each member show, with suns.
    DrawnPart draw(SceneView view, std::span<const std::vector<Vec3>> sunlit, bool moved);

    // Draws what of the surfaces is seen: their ratios times coverage.
    DrawnPart drawRatios(SceneView view, std::span<const RealSurface> surfaces);

private:
    const PosedScene& scene_;
    const SceneFrames& frames_;
    PinholeCamera camera_;
    int samples_;
    std::unique_ptr<GlContext> context_;
    std::optional<OffscreenTarget> target_;
    std::optional<Sunlight> suns_;
    bool shone_ = false;                  // true once the suns' maps are drawn
    std::vector<ValuePainter> painters_;  // for frames_.meshes()
    std::vector<ValuePainter> hiding_;    // for real members, then for real meshes
    std::vector<ValuePainter> surfaces_;  // for drawRatios(), made when it is first asked for
    std::optional<OffscreenTarget> surfaces_target_;

    FrameView frameView(const SceneView& view) const;

    struct Part {
        int x, y, width, height;
    };
    Part partOf(const SceneView& view) const;
    void drawMeshes(const FrameView& view, std::span<const std::vector<Vec3>> sunlit);
    // Tells whether vertices are so many that suns need no fragments. Fragments cost software most of its time.
    bool sunsAtVertices() const;
    void drawHiding(const FrameView& view);
};

}  // namespace penumbra
