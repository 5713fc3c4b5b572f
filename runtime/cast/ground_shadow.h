#pragma once
// What a level ground without end hides from what stands on it, and the light that it sends back.
//
// The ground hides every direction that goes down, wherever a point stands above it. So what it leaves visible depends
// on the normal alone, and so does what it hides of a point's hemisphere: (1 - n.y) / 2 of a white sky. What a point
// sees of it is lit by the sky past everyone who stands there (docs/formulas.md, section 8, "Level ground").
#include <span>

#include "runtime/cast/cast_shadow.h"

namespace penumbra {

// Writes V of a level ground at vertices in the scene, mirrored at their horizons: [V, kFarCoefficients], as
// CastShadow::evaluate() has it. y is up; normals and tangents are unit and [V].
void groundVisibility(std::span<const Vec3> normals, std::span<const Vec3> tangents, std::span<float> mirrored);

}  // namespace penumbra
