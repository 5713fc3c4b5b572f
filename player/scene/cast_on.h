#pragma once
#include "runtime/cast/cast_shadow.h"

namespace penumbra {

// Runs CastShadow::evaluate() for many receivers by several threads. Resizes `mirrored` [receivers, kFarCoefficients].
// Neighbours should follow one another. Returns how many receivers see any caster.
std::size_t castOn(const CastShadow& cast, CasterChoice choice, const CastReceivers& receivers, int threads,
                   std::vector<float>& mirrored);

// The same for all vertices of a character, with anchors (castOnCluster()). `vertices` are in the scene.
std::size_t castOnCharacter(const CastShadow& cast, CasterChoice choice, const Evaluator& character,
                            const CastReceivers& vertices, int threads, std::vector<float>& mirrored);

}  // namespace penumbra
