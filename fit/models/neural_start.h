#pragma once
// Makes the hidden weights from which a search starts.
#include <cstdint>

#include "fit/models/neural_model.h"

namespace penumbra {

// Returns a net in which each neuron tells two training frames a and b apart: d^n = s (x_b - x_a) / |x_b - x_a|^2. The
// bias d0^n makes the activation zero half way between them, and s = 2 atanh(1/2) makes it -1/2 at a and 1/2 at b. Each
// pair is drawn from 16 random ones with a probability proportional to |y_b - y_a| / |x_b - x_a|, so that neurons start
// where the outputs change fast (Bolager et al. 2023, "Sampling weights of deep neural networks"). Distances are
// measured over the neuron's range of inputs. Output weights are zero. The same arguments always give the same net.
//
// `inputs` is [n, I], `outputs` [n, K]; `ranges` has one entry a neuron, or none when every neuron sees all inputs.
TanhNet startNet(const Matrix& inputs, const Matrix& outputs, std::size_t neurons,
                 const std::vector<InputRange>& ranges, std::uint64_t seed);

}  // namespace penumbra
