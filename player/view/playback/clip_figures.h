#pragma once
// Computes figures of every frame of a clip, a few at a time between the frames of a window.
#include <optional>

#include "player/frame/frame_values.h"

namespace penumbra {

// Adds Evaluator::outOfRange() of the next frames of a clip to those that are known. `evaluator` loses its pose, so it
// must not be the one that is drawn.
void computeRanges(Evaluator& evaluator, const ClipView& clip, double milliseconds, std::vector<float>& out_of_range);

struct FrameError {
    float mean = 0, most = 0;  // over vertices
    bool has_truth = false;    // a truth may have been baked of some clips only
};

// Computes |E(model) - E(truth)| of every frame, where E is ambient visibility, a few clusters at a time.
class ErrorStrip {
public:
    // Adds the next frames of a clip to `errors`, as the last call left them. Starts anew when these, the truth or the
    // clip are other ones. Poses a copy of `evaluator`, which always has the same asset.
    void compute(const Evaluator& evaluator, const AssetView& truth, std::size_t clip, double milliseconds,
                 std::vector<FrameError>& errors);

private:
    std::optional<Evaluator> evaluator_;
    const AssetView* truth_ = nullptr;
    std::size_t clip_ = 0, known_ = 0;
    // The frame that is under way. Clusters before `cluster_` are summed up.
    std::size_t cluster_ = 0;
    std::optional<std::size_t> truth_frame_;
    double sum_ = 0;
    FrameError frame_;
    FrameVertices vertices_;
    std::vector<float> truth_coefficients_, model_ambient_, true_ambient_;

    void start(const Evaluator& evaluator, const AssetView& truth, std::size_t clip);
    void startFrame(std::size_t frame);
    void addCluster();
};

}  // namespace penumbra
