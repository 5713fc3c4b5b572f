#include "bake/trace/far_bias.h"

#include <algorithm>

namespace penumbra {

std::vector<float> farBiases(std::span<const Triangle> triangles, std::span<const Vec3> positions,
                             const BoundingBox& character, float bias) {
    constexpr double kResolved = 1.0 / (1 << 18);  // 64 steps of a float of this size
    constexpr double kNear = 4;                    // diagonals: nothing of the character itself is so large
    const Vec3d middle = (toDouble(character.low) + toDouble(character.high)) * 0.5;
    const double diagonal = length(toDouble(character.high) - toDouble(character.low));
    std::vector<double> reach;  // reach of each vertex, in diagonals
    for (const Vec3 p : positions) reach.push_back(length(toDouble(p) - middle) / diagonal);
    for (const Triangle& t : triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            const double edge = length(toDouble(positions[a]) - toDouble(positions[b])) / diagonal;
            reach[a] = std::max(reach[a], edge);
            reach[b] = std::max(reach[b], edge);
        }
    std::vector<float> out;
    bool any = false;
    for (const double r : reach) {
        out.push_back(r > kNear ? std::max(bias, float(kResolved * r)) : bias);
        any = any || out.back() > bias;
    }
    return any ? out : std::vector<float>();
}

}  // namespace penumbra
