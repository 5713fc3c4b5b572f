#pragma once
// Measures how far predicted transfer is from the truth, independent of any light (Nowrouzezahrai 2007, section 6).
#include <cstddef>
#include <span>
#include <vector>

#include "sh/hemisphere_norm.h"
#include "sh/vec3.h"

namespace penumbra {

// Sums over vertices and frames.
struct TransferSums {
    double difference = 0, variance = 0;           // |t' - t|^2 and |t - mean|^2 over the sphere
    double transfer_error = 0, transfer_norm = 0;  // E of t' - t and E of t
    std::size_t count = 0;                         // vertices times frames

    void add(const TransferSums& other);
};

struct TransferErrors {
    double relative_error = 0;           // sqrt(sum |t' - t|^2 / sum |t - mean|^2), as in section 5 of formulas.md
    double transfer_error = 0;           // mean E_transfer
    double relative_transfer_error = 0;  // sqrt(sum E_transfer / sum E of t)
};
TransferErrors errorsOf(const TransferSums& sums);

// Compares the transfer of one frame, [V, n^2] each. `mean` is that of the training frames.
TransferSums compareTransfer(const HemisphereNorm& norm, std::span<const float> predicted, std::span<const float> truth,
                             std::span<const float> mean, std::span<const Vec3> normals, int threads);

}  // namespace penumbra
