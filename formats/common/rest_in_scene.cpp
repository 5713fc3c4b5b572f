#include "formats/common/rest_in_scene.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace penumbra {

namespace {

// Returns the median of the factors by which the bones scale lengths; 1 without bones, or where the middle one scales
// to nothing.
double scaleOf(std::span<const Affine> bones) {
    std::vector<double> scales;
    for (const Affine& bone : bones) scales.push_back(std::cbrt(std::abs(double(determinant(bone.linear())))));
    if (scales.empty()) return 1;
    const auto middle = scales.begin() + std::ptrdiff_t(scales.size() / 2);
    std::nth_element(scales.begin(), middle, scales.end());
    return *middle > 0 && std::isfinite(*middle) ? *middle : 1;
}

}  // namespace

std::vector<Vec3> restInScene(std::span<const Vec3> rest_positions, const SkinRows& skin,
                              std::span<const Affine> bones) {
    std::vector<Vec3> out(rest_positions.begin(), rest_positions.end());
    const double scale = scaleOf(bones);
    if (scale > 0.5 && scale < 2) return out;
    const std::size_t k = std::size_t(skin.influences);
    assert(skin.joints.size() == out.size() * k && skin.weights.size() == skin.joints.size());
    for (std::size_t v = 0; v < out.size(); ++v)
        out[v] = blendBones(skin.joints.subspan(v * k, k), skin.weights.subspan(v * k, k), bones).point(out[v]);
    return out;
}

}  // namespace penumbra
