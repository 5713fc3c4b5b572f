#pragma once
// Evaluates the linear models of transfer: all transfer of a pose, or its shading under one light.
#include <array>
#include <span>
#include <string>
#include <vector>

#include "fit/visibility/predict.h"
#include "formats/stage/transfer_file.h"

namespace penumbra {

// Returns the transfer of a pose (P numbers), [V, n^2] in the model frame.
std::vector<float> predictTransfer(const TransferModel& model, std::span<const float> pose, int threads);

// A model whose weights are summed over the coefficients of one light. Shading is linear in transfer and in light, so
// that the light can be multiplied in before the vertices are: sum_c l_c X^c is one map a colour channel, where
// transfer needs n^2.
struct LitTransfer {
    std::array<std::vector<float>, 3> weights;  // [k + 1, m] sum_c l_c X^c
    std::array<float, 3> of_mean{};             // sum_c l_c, the factor of the mean
};
// `light` is [n^2, 3].
LitTransfer contractLight(const TransferModel& model, std::span<const float> light);
// Adds up the light that reaches each vertex, l . t, [3, V]; albedo / pi times that is the radiance.
void shadeTransfer(const TransferModel& model, const LitTransfer& lit, std::span<const float> pose,
                   std::span<float> out);

// Throws InvalidInput when the poses are those of another character than the model's.
void checkCharacter(const TransferModel& model, const VisibilityHeader& header, const std::string& file);

// Predicts every pose of a file that passed checkCharacter(). The result has the layout of a bake of diffuse transfer.
void predictFile(const TransferModel& model, const VisibilityReader& poses, const PredictionOutput& to);

}  // namespace penumbra
