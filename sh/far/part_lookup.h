#pragma once
// Far visibility where something else than fields says what the parts block, such as rays.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "sh/far/far_visibility.h"

namespace penumbra {

// Writes what a part blocks at a point of its rest frame, [kFieldCoefficients], and returns how dark it is there
// besides, as sampleField() does.
using PartLookup = std::function<float(std::size_t part, Vec3 point, std::span<float> out)>;

// Computes what farVisibility() does of fields.
void farVisibility(const PartLookup& lookup, std::span<const PosedPart> posed, std::span<const std::uint16_t> parts,
                   const Receiver& receiver, std::span<float> out);

}  // namespace penumbra
