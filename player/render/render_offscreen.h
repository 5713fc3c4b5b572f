#pragma once
// Renders pictures of frames without a window. There is one OpenGL context, whose shaders and uploads are made once.
#include <map>

#include "player/draw/draw_frame.h"
#include "player/draw/model_painter.h"
#include "player/draw/overlay_painter.h"
#include "player/draw/sky_painter.h"
#include "player/draw/sunlight.h"
#include "player/gl/gl_context.h"
#include "player/gl/offscreen_target.h"
#include "player/papers/transfer_error.h"

namespace penumbra {

// Tells what one picture shows of a frame.
struct Panel {
    Channel channel = Channel::kShaded;
    VisibilitySource source = VisibilitySource::kModel;
    auto operator<=>(const Panel&) const = default;
};

class OffscreenRenderer {
public:
    // `look` (resolveLook()) outlives this object. Throws the errors of createGlContext() and OffscreenTarget.
    OffscreenRenderer(const RenderOptions& options, const Shot& look);

    const std::string& gl() const { return context_->description; }
    EvaluationPath path() const { return path_; }
    // Returns linear Rec.709 with alpha, the colours multiplied by it, with the lobe and boxes of the look. The frame
    // must have truth where the panel shows it, and a shaded panel needs a shaded look.
    Image draw(const Panel& panel, PosedFrame& frame, const FrameView& view);
    Image drawWithoutOverlays(const Panel& panel, PosedFrame& frame, const FrameView& view);
    // Returns what the look's light looks like, without alpha.
    Image drawSky(const FrameView& view);
    // Shaded pictures will be multiplied by this factor. Lobes and boxes are divided by it, so they keep their colours.
    void setExposure(float factor) { exposure_ = factor; }

private:
    const AssetView* asset_;
    std::unique_ptr<GlContext> context_;  // stands before what must be released while it is current
    EvaluationPath path_;
    OffscreenTarget target_;
    std::optional<ShadingSet> shading_;
    std::map<Channel, ValuePainter> value_painters_;
    LobeTable lobe_table_;
    std::vector<LobeRange> lobes_;       // one for each vertex
    std::vector<SlotLobes> slot_lobes_;  // one for each slot
    std::optional<Sunlight> sunlight_;   // where the look has suns
    std::shared_ptr<GlAsset> gl_asset_;
    std::optional<ModelPainter> model_painter_;
    OverlayPainter overlays_;
    std::optional<SkyPainter> sky_;
    std::optional<TransferError> transfer_error_;  // once the channel was drawn
    float exposure_ = 1;

    void shineOn(std::span<const Vec3> positions);  // draws the shadow maps
    std::vector<Vec3> valuesOf(const Panel& panel, PosedFrame& frame, Vec3 eye);
    void drawValues(const Panel& panel, PosedFrame& frame, const FrameView& view);
    void drawModel(const Panel& panel, PosedFrame& frame, const FrameView& view);
    void drawCharacter(const Panel& panel, PosedFrame& frame, const FrameView& view);
    void drawOverlays(const Panel& panel, PosedFrame& frame, const FrameView& frame_view);
};

// Puts the background behind pixels that the mesh covers in part or not at all.
void putBehind(Image& image, Vec3 background);
void putBehind(Image& image, const Image& background);  // the background has the same size and no alpha
// Returns what a PNG shows of a channel. Normals are numbers, and a PNG's 8-bit value / 255 must give them back. So
// this applies the inverse of the transfer function that writePng() applies, to colours that it then divides by
// alpha.
Image forDisplay(Image image, Channel channel);

struct RenderResult {
    Image image;     // over options.background, if there is one
    std::string gl;  // GlContext::description
    EvaluationPath path = EvaluationPath::kCpu;
};

// Renders one frame alone. `truth` may be null where nothing needs it. Throws the errors of resolveShot(),
// OffscreenRenderer and makeCamera() (as UsageError).
RenderResult renderOffscreen(const RenderOptions& options, const AssetView& asset, const AssetView* truth, int threads);

}  // namespace penumbra
