#pragma once
// Surfaces that are drawn beside a character, and what their vertices show. It uses no GL.
#include <cstdint>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

struct Shape {
    std::vector<Vec3> positions, values;  // values: linear colours, unless something else is said
    std::vector<std::uint32_t> triangles;
};

// Makes a sphere of radius 1 about the origin: `rings` quads from pole to pole, and twice as many around. Its
// positions are directions.
Shape unitSphere(int rings);

}  // namespace penumbra
