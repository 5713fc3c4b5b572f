#pragma once
// Tables of a height field for shaders, and the sums that are written out for them (shaders/heights.glsl).
#include <cstdint>
#include <string>
#include <vector>

#include "sh/height/height_visibility.h"

namespace penumbra {

// vec4 that a receiver has: V and its normal.
std::size_t heightRowQuads(int order);
// How many shares of what is finer a cell between receivers has: its own and those of its smaller cells.
std::size_t heightCellShares(int step);

// Returns the text of heights.glsl with its preamble, and with heightsMirror() for points of the field or above it:
// void heightsMirror(inout float v[ORDER * ORDER], vec3 normal, vec3 tangent, out float numbers[]), which turns V into
// the frame of a point and mirrors it there. Normal and tangent are in the frame of the field. It destroys v. `corner`
// is where height 0 of row 0 and column 0 stands in the scene.
std::string heightsGlsl(const HeightField& field, const HeightTables& tables, Vec3 corner, HeightReceiver receiver);
// The buffer Taps.
std::vector<std::uint32_t> heightTapWords(const HeightField& field, const HeightTables& tables);

}  // namespace penumbra
