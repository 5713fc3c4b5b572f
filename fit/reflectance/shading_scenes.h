#pragma once
// The scenes on which shading errors are measured (docs/formulas.md section 3). They say what a point of a surface may
// see in its local frame (z is the normal), under band-limited light and from many views.
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// A part blocks the directions s with dot(s, direction) < 0 (a wall along the horizon of `direction`) or with dot(s,
// direction) > cosine (a cap).
struct OccluderPart {
    enum Kind { kWall, kCap };
    Kind kind;
    Vec3d direction;
    double cosine;  // cosine of the cap's half-angle
};

struct ShadingScenes {
    std::vector<std::vector<OccluderPart>> occluders;  // each is a union of parts
    std::vector<Vec3d> views;
    std::vector<std::vector<double>> lights;  // one channel each, [light_order^2]
    int light_order = 4;
};

// Returns 61 occluders (open, walls, creases, corners, caps, limbs), 6 lights (sun and sky, area, smooth) and 54 views:
// the directions of a Fibonacci set of 120 that are higher than 0.1. tests/golden/scene_seed11.json says where the
// numbers come from.
ShadingScenes referenceScenes();

// Tells whether any part blocks the direction.
bool isBlocked(const std::vector<OccluderPart>& parts, Vec3d direction);

}  // namespace penumbra
