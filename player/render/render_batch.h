#pragma once
// Renders many frames in one run: pictures, panels of a contact sheet and figures, with one camera, one OpenGL
// context and one upload.
#include <functional>

#include "player/render/frame_figures.h"
#include "player/render/render_offscreen.h"

namespace penumbra {

enum class Framing {
    kClips,  // one camera for all frames of all chosen clips
    kClip,   // one for each clip
    kFrame,  // each frame is framed as if it were alone
};
inline constexpr Word<Framing> kFramingWords[] = {
    {"clips", Framing::kClips}, {"clip", Framing::kClip}, {"frame", Framing::kFrame}};

struct BatchPlan {
    RenderOptions options;
    Shot look;  // made by resolveLook()
    ChosenFrames chosen = {};
    std::vector<std::optional<std::size_t>> truth_frames = {};  // for each chosen frame; empty without truth
    Framing framing = Framing::kFrame;
    std::vector<std::filesystem::path> files = {};  // one picture for each chosen frame; empty: none are drawn
    std::vector<Panel> panels = {};                 // drawn for BatchSink::panels
    bool relative_error = false;                    // measured; it needs the truth of all training frames
    bool image_error = false, flip = false;         // measured; pictures of model and truth in options.channel
    bool draws() const { return !files.empty() || !panels.empty() || image_error; }
    bool exposes() const;  // tells whether shaded colours become 8 bits
};

// Fills `truth_frames`. Throws InvalidInput when plan.files show the truth of a frame that has none.
void findTruth(BatchPlan& plan);

// Gets the results frame by frame, in order. Pictures have alpha and no background. A panel that shows a truth that
// does not exist has no pixels.
struct BatchSink {
    std::function<void(std::size_t index, const Image& picture)> picture = {};      // only where files are drawn
    std::function<void(std::size_t index, std::vector<Image> panels)> panels = {};  // only where panels are drawn
    std::function<void(std::size_t done)> progress;
    // Gets BatchResult::exposure before the first picture. May be empty.
    std::function<void(float exposure)> exposure = {};
};

struct BatchResult {
    std::vector<FrameRecord> frames;
    std::string gl;  // GlContext::description; "" when nothing was drawn
    EvaluationPath path = EvaluationPath::kCpu;
    bool mean_from_truth = false;  // see TruthMean
    // The factor on the colours of all shaded pictures: options.exposure, or the automatic one of the first frame of
    // the chosen clips, whichever frames are drawn. There the truth decides where it has this frame, and the model
    // where it does not. So slices of a sequence agree, and so do models that are compared with one truth.
    float exposure = 1;
};

BatchResult runBatch(const BatchPlan& plan, int threads, const BatchSink& sink);

}  // namespace penumbra
