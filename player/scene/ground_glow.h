#pragma once
// The light that a level ground sends back to what stands on it.
//
// Problem: what a vertex sees of the ground is as bright as the sky makes it, and darker where characters shade it: the
// sole of a shoe sees nearly nothing, a hand that hangs down the shadow of the body.
//
// Naive: sum over the whole ground what each of its points sends to each vertex.
//
// Here: the ground has the radiance of free sight but for the shadows on it. These stand on a coarse grid around
// everyone, from which a pyramid is made whose levels are ever more blurred. A vertex at height h sees a spot whose
// width grows with h: half of what goes straight down comes from within h. It reads two levels of the pyramid, for the
// near and the far half of what it sees (docs/formulas.md, section 8, "Level ground").
#include <array>
#include <vector>

#include "player/scene/cast_blocks.h"
#include "player/scene/scene_ground.h"

namespace penumbra {

class GroundGlow {
public:
    // Finds the shadows on the ground around `standing`, corners of boxes of everyone, in a pose of the casters.
    void cast(const CastShadow& cast, double ground_height, std::span<const Vec3> standing, int threads);
    // Lights what cast() found. `weights` are of the whole light (groundWeights()).
    void light(const GroundWeights& weights, Vec3 albedo);
    // Lights it by a light whose SH, suns included, are turned by `rotation`.
    void light(const LightView& light, const Mat3d& rotation, Vec3 albedo);

    // The mean radiance of what a vertex sees of the ground. Below the ground it is that of the ground itself.
    Vec3 radianceAt(Vec3 position, Vec3 normal) const;

private:
    static constexpr std::uint32_t kSide = 65;  // points of the grid, a power of two and 1
    static constexpr std::size_t kLevels = 6;   // levels of 65, 33, .. 3 points a side

    float height_ = 0, cell_ = 1;
    float corner_[2] = {0, 0};  // x and z of the first point
    std::vector<Vec3> positions_, normals_, tangents_;
    std::vector<float> mirrored_;
    std::vector<CastBlock> blocks_;
    Vec3 open_;  // radiance of free sight
    // Light that shadows take from it; columns along z. Around each level is a margin of one point without any.
    using Texel = std::array<float, 4>;  // RGB, and 0
    std::array<std::vector<Texel>, kLevels> shade_;

    static std::uint32_t sideOf(std::size_t level) { return ((kSide - 1) >> level) + 1; }
    void halve(std::size_t level);
    Texel shadeAt(float x, float z, float width) const;
    void addShade(std::size_t level, float x, float z, float share, Texel& sum) const;
};

}  // namespace penumbra
