#pragma once
// Computes the range of the model's scores over the frames that it was trained on, a few frames at a time.
#include <vector>

#include "runtime/evaluate/evaluator.h"

namespace penumbra {

struct ComponentFigures {
    float least = 0, most = 0;  // range of its score
    float share = 0;            // share of the variance of the cluster's numbers: var(score) |basis|^2 over the sum of
                                // all
};

class ScoreRanges {
public:
    // Goes over frames of clips that were not held out, or of all clips when all were. `evaluator` loses its pose and
    // must always have the same asset.
    void compute(Evaluator& evaluator, double milliseconds);
    bool complete() const { return complete_; }
    // Returns one entry for each component; empty until complete().
    std::vector<ComponentFigures> figures(const Evaluator& evaluator, std::size_t cluster) const;

private:
    struct Range {
        float least = 0, most = 0;
        double sum = 0, square_sum = 0;
    };
    std::vector<std::vector<Range>> ranges_;  // [cluster][component]
    std::size_t next_frame_ = 0, frames_ = 0;
    bool complete_ = false;

    void add(const Evaluator& evaluator);
};

}  // namespace penumbra
