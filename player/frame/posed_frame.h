#pragma once
// Computes one frame after another on the CPU, by model and by truth. Each is computed when it is first asked for.
#include <array>
#include <optional>

#include "player/frame/frame_values.h"

namespace penumbra {

class PosedFrame {
public:
    // `look` (resolveLook()) outlives this object. `threads` as in parallelFor().
    PosedFrame(const Shot& look, int threads);

    // Goes to a frame of the asset's animation, and to its frame of the truth if there is one.
    void pose(std::size_t frame, std::optional<std::size_t> truth_frame);

    int threads() const { return threads_; }
    const Shot& shot() const { return shot_; }  // of this frame
    bool hasTruth() const { return has_truth_; }
    const Evaluator& evaluator() const { return evaluator_; }
    const std::vector<Vec3>& positions() const { return vertices_.positions; }

    // Returns the vertices with the numbers of `source`, valid until the next call. kTruth only where hasTruth().
    const FrameVertices& vertices(VisibilitySource source);
    // Returns these numbers alone, valid until the next pose().
    std::span<const float> coefficients(VisibilitySource source);
    // Returns the radiance of every vertex towards `eye`. The model of an asset of transfer takes no numbers for it.
    std::vector<Vec3> radiance(VisibilitySource source, const ShadingSet& shading, Vec3 eye);
    const FrameVertices& skinned() const { return vertices_; }  // whatever its numbers are
    // Returns E of every vertex.
    const std::vector<float>& ambient(VisibilitySource source);

private:
    Shot shot_;
    int threads_;
    bool has_truth_ = false;
    Evaluator evaluator_;
    FrameVertices vertices_;
    VisibilitySource within_ = VisibilitySource::kModel;  // whose numbers `vertices_` has
    struct Source {
        std::vector<float> coefficients;  // empty while they are in `vertices_`
        std::vector<float> ambient;
        bool known = false, ambient_known = false;
    };
    std::array<Source, 2> sources_;  // indexed by VisibilitySource
};

}  // namespace penumbra
