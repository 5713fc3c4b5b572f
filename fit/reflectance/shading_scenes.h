#pragma once
// The scenes that shading errors are measured on, docs/formulas.md section 3: what a point of a surface may see (local
// frame, z = normal) under band-limited light, from many views.
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// Blocks the directions s with dot(s, direction) < 0 (a wall along the horizon of `direction`) or > cosine (a cap).
struct OccluderPart {
    enum Kind { kWall, kCap };
    Kind kind;
    Vec3d direction;
    double cosine;  // of the cap's half-angle
};

struct ShadingScenes {
    std::vector<std::vector<OccluderPart>> occluders;  // unions of parts
    std::vector<Vec3d> views;
    std::vector<std::vector<double>> lights;  // one channel, [light_order^2] each
    int light_order = 4;
};

// 61 occluders (open, walls, creases, corners, caps, limbs), 6 lights (sun and sky, area, smooth) and the 54 directions
// of a Fibonacci set of 120 that are higher than 0.1. Where the numbers come from:
// tests/golden/scene_seed11.json.
ShadingScenes referenceScenes();

bool isBlocked(const std::vector<OccluderPart>& parts, Vec3d direction);

}  // namespace penumbra
