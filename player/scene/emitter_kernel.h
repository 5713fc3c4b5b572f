#pragma once
// The mean radiance of what many points see of emitters (meanRadiance(), player/scene/character_light.h): every point
// takes some hundred emitters, 8 points at a time.
#include <cstddef>

#include "player/scene/character_light.h"
#include "sh/kernel.h"

namespace penumbra {

// Points with unit normals.
struct EmitterPoints {
    const Vec3 *positions, *normals;  // [count]
    std::size_t count;
};

struct EmitterPath {
    static const EmitterPath portable, avx2;
    // Writes the mean of each point. Allocates nothing.
    void (*mean)(const Emitter* emitters, std::size_t emitter_count, const EmitterPoints& points,
                 Vec3* means) = nullptr;
};

inline const EmitterPath& fastestEmitterPath() { return fastestPath<EmitterPath>(); }

}  // namespace penumbra
