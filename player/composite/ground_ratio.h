#pragma once
// How much brighter or darker characters make each pixel of a photograph's ground, for all pixels of a picture.
//
// ratio = (light past all characters + light from them) / light without them, per channel, at the point of the plane
// that the pixel sees. It is 1 where the pixel sees no ground, and may be above 1 (docs/ar.md).
//
// Problem: a picture of 640 x 480 pixels has 300,000 points, and the cast of 31 parts costs 1 us at each.
//
// Here: the points of every second pixel are the vertices of a grid. Blocks of 4 x 4 squares are evaluated at their
// corners and in the middle, and whole where that does not do (player/scene/cast_blocks.h). Suns have edges, so each is
// looked up in its maps at every fourth pixel and, where neighbours differ, at all.
#include <memory>
#include <vector>

#include "formats/scene/scene_camera.h"
#include "player/scene/cast_blocks.h"
#include "player/scene/character_light.h"
#include "player/scene/scene_ground.h"
#include "player/scene/scene_suns.h"

namespace penumbra {

// The lights on the ground, and their casters.
struct GroundLight {
    const CastShadow* all = nullptr;   // all casters
    const CastShadow* real = nullptr;  // the casters in the photograph; null if there are none
    GroundWeights weights{};           // weights of the light without its suns: irradiance of the visible part
    std::span<const Sun> suns;
    std::span<const SunMaps> sun_maps;       // past everyone, of each sun
    std::span<const SunMaps> real_sun_maps;  // past those in the photograph; empty where nobody is
    std::span<const Emitter> emitters;       // emitters of the characters
};

class GroundRatio {
public:
    // For all pictures of a camera.
    explicit GroundRatio(const PinholeCamera& camera);
    // Writes the ratio of every pixel, [height, width], for a level ground at this height of the scene.
    void compute(const SceneView& view, double ground_height, const GroundLight& light, int threads,
                 std::vector<Vec3>& ratio);

private:
    PinholeCamera camera_;
    std::uint32_t rows_, columns_;  // size of the grid
    std::vector<Vec3> rays_;        // [2 rows - 1, 2 columns - 1] unit, of every pixel, in the camera's frame
    std::vector<Vec3> points_;      // the same: on the ground, in the scene
    std::vector<char> sees_;        // the same: whether the pixel sees the ground
    std::vector<Vec3> grid_points_, normals_, tangents_;
    std::vector<float> mirrored_;
    // [rows, columns] irradiance past all characters and from them, and past those in the photograph.
    std::vector<Vec3> past_, from_, without_;
    std::vector<char> changed_;  // for each block of the grid: whether any of these differs from free sight
    Vec3 free_;                  // irradiance of free sight

    std::size_t rayIndex(std::uint32_t y, std::uint32_t x) const { return std::size_t(y) * (2 * columns_ - 1) + x; }
    void placePoints(const SceneView& view, double ground_height, int threads);
    void castSoft(const GroundLight& light, int threads);
    std::vector<CastBlock> castOn(const CastShadow& cast, int threads);
    void addBounce(std::span<const Emitter> emitters, std::span<const CastBlock> blocks,
                   std::span<const float> hidden_by_real, int threads);
    void addSoft(const GroundLight& light, int threads, std::vector<Vec3>& past, std::vector<Vec3>& without) const;
};

}  // namespace penumbra
