#pragma once
// Eq 13 has many minima. Rounds of short searches from several starts, of which the best go on to the end.
#include <cstdint>
#include <vector>

#include "fit/models/variable_projection.h"

namespace penumbra {

// Over 8 clusters (199 frames, 16 neurons) 3 rounds come to the sum of objectives of 24 whole searches in a third of
// their time, 1 round to 0.3% above it in a tenth.
struct StartPlan {
    std::size_t neurons = 16;
    std::vector<InputRange> ranges;  // [neurons] or empty
    std::uint64_t seed = 1;
    int rounds = 1;
    int starts = 8, first_iterations = 30, kept = 2;  // of a round
};

// The best of all; `iterations` and `evaluations` are of all searches together. Stops at options.target.
NetFit fitFromManyStarts(const Matrix& inputs, const Matrix& outputs, double alpha, const StartPlan& plan,
                         const LbfgsOptions& options);

}  // namespace penumbra
