#pragma once
// Hidden weights to start a search from.
#include <cstdint>

#include "fit/models/neural_model.h"

namespace penumbra {

// Neurons that each tell two training frames apart: d^n = s (x_b - x_a) / |x_b - x_a|^2, d0^n so that the activation
// goes through zero half way, s = 2 atanh(1/2) so that it is -1/2 and 1/2 at the two. The pairs are drawn with a
// probability proportional to |y_b - y_a| / |x_b - x_a|, so that neurons start where the outputs change fast (Bolager
// et al. 2023, "Sampling weights of deep neural networks"); distances are over the neuron's range of inputs. Same
// arguments, same net.
TanhNet startNet(const Matrix& inputs, const Matrix& outputs, std::size_t neurons,
                 const std::vector<InputRange>& ranges, std::uint64_t seed);

}  // namespace penumbra
