#pragma once
// What a height field leaves visible to points of a scene on it or above it, joined as casts of characters are. The
// field's columns go along x of the scene, its rows along z and its heights along y.
#include <span>

#include "runtime/cast/cast_shadow.h"
#include "sh/height/height_visibility.h"

namespace penumbra {

constexpr int kAboveFieldOrder = 5;  // of V before it is mirrored

constexpr Vec3 fieldFromScene(Vec3 v) { return {v.z, v.x, v.y}; }
constexpr Vec3 sceneFromField(Vec3 v) { return {v.y, v.z, v.x}; }

// Writes V past the field, mirrored at each receiver's horizon, in its local frame: [receivers, kFarCoefficients].
// `above` has kAboveFieldOrder and kFieldOrder; `corner` is where height 0 of row 0 and column 0 stands in the scene. A
// point below the field sees what the point above it sees. Allocates nothing.
void fieldVisibility(const HeightField& field, const HeightTables& above, Vec3 corner, const CastReceivers& receivers,
                     std::span<float> mirrored);

}  // namespace penumbra
