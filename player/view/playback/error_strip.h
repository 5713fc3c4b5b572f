#pragma once
// Computes |E(model) - E(truth)| of every frame of a clip, where E is ambient visibility, a few clusters at a time
// between the frames of a window.
#include <optional>

#include "player/frame/frame_values.h"

namespace penumbra {

struct FrameError {
    float mean = 0, most = 0;  // over vertices
    bool has_truth = false;    // a truth may have been baked of some clips only
};

class ErrorStrip {
public:
    // Starts anew when animation, truth or clip have changed. Poses a copy of `evaluator`.
    void compute(const Evaluator& evaluator, const AssetView& truth, std::size_t clip, double milliseconds);
    // Returns the errors of the clip's first frames, as many as are known.
    std::size_t clip() const { return clip_; }
    std::span<const FrameError> errors() const { return errors_; }

private:
    std::optional<Evaluator> evaluator_;
    const AssetView* truth_ = nullptr;
    std::size_t clip_ = 0;
    std::vector<FrameError> errors_;
    // The frame that is under way. Clusters before `cluster_` are summed up.
    std::size_t cluster_ = 0;
    std::optional<std::size_t> truth_frame_;
    double sum_ = 0;
    FrameError frame_;
    FrameVertices vertices_;
    std::vector<float> truth_numbers_, model_ambient_, true_ambient_;

    void start(const Evaluator& evaluator, const AssetView& truth, std::size_t clip);
    void startFrame(std::size_t frame);
    void addCluster();
};

}  // namespace penumbra
