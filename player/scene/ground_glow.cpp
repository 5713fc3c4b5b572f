#include "player/scene/ground_glow.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/cast/cast_shadow.h"
#include "sh/bounding_box.h"

namespace penumbra {

namespace {

// Standard deviation of a level that is read bilinearly, in its own cells: each halving blurs by (1, 2, 1) / 4, whose
// variances sum up to 1/6 of a cell's square, and between the points there is another 1/6.
constexpr float kWidthOfCell = 0.57735f;

std::uint32_t sideOf(std::uint32_t side, std::size_t level) { return ((side - 1) >> level) + 1; }

// Blurs a level and keeps every second point. Nothing is missing outside.
void halve(std::span<const Vec3> fine, std::uint32_t side, std::vector<Vec3>& coarse) {
    const std::uint32_t half = sideOf(side, 1);
    coarse.assign(std::size_t(half) * half, Vec3{});
    for (std::uint32_t i = 0; i < half; ++i)
        for (std::uint32_t j = 0; j < half; ++j)
            for (int di = -1; di <= 1; ++di)
                for (int dj = -1; dj <= 1; ++dj) {
                    const auto row = std::int64_t(2 * i) + di, column = std::int64_t(2 * j) + dj;
                    if (row < 0 || column < 0 || row >= side || column >= side) continue;
                    coarse[i * half + j] += fine[std::size_t(row) * side + std::size_t(column)] *
                                            (float((2 - di * di) * (2 - dj * dj)) / 16);
                }
}

}  // namespace

void GroundGlow::cast(const CastShadow& cast, double ground_height, std::span<const Vec3> standing, int threads) {
    constexpr float kReach = 0.5f;  // of the height of the highest: how far around everyone shadows are looked for
    const BoundingBox box = boundsOf(standing);
    height_ = float(ground_height);
    const float reach = kReach * std::max(box.high.y - height_, 0.0f);
    const float extent = std::max(std::max(box.high.x - box.low.x, box.high.z - box.low.z) + 2 * reach, 1e-3f);
    // Cells grow in steps and points stay where they are, so that nothing swims while somebody walks.
    cell_ = std::exp2(std::ceil(4 * std::log2(extent / float(kSide - 3))) / 4);
    const float middle[2] = {(box.low.x + box.high.x) / 2, (box.low.z + box.high.z) / 2};
    for (int axis = 0; axis < 2; ++axis)
        corner_[axis] = (std::round(middle[axis] / cell_) - float((kSide - 1) / 2)) * cell_;
    const std::size_t count = std::size_t(kSide) * kSide;
    positions_.resize(count);
    normals_.assign(count, {0, 1, 0});
    tangents_.assign(count, {0, 0, 1});
    for (std::uint32_t i = 0; i < kSide; ++i)
        for (std::uint32_t j = 0; j < kSide; ++j)
            positions_[i * kSide + j] = {corner_[0] + float(i) * cell_, height_, corner_[1] + float(j) * cell_};
    mirrored_.assign(count * kFarCoefficients, 0.0f);
    for (std::size_t v = 0; v < count; ++v) mirrored_[v * kFarCoefficients] = kOpenSight;
    blocks_ = castBlocks(kSide, kSide);
    castOnBlocks(cast, {kSide, kSide, {positions_, normals_, tangents_}, mirrored_}, blocks_, threads);
}

void GroundGlow::light(const GroundWeights& weights, Vec3 albedo) {
    const auto radianceOf = [&](const float* coefficients) {
        Vec3 out;
        for (std::size_t i = 0; i < kFarCoefficients; ++i) out += toFloat(weights[i]) * coefficients[i];
        for (int c = 0; c < 3; ++c) out[c] = std::max(out[c] * albedo[c] * std::numbers::inv_pi_v<float>, 0.0f);
        return out;
    };
    std::array<float, kFarCoefficients> open{kOpenSight};
    open_ = radianceOf(open.data());
    shade_[0].resize(positions_.size());
    for (std::size_t v = 0; v < positions_.size(); ++v)
        shade_[0][v] = open_ - radianceOf(&mirrored_[v * kFarCoefficients]);
    for (std::size_t level = 1; level < kLevels; ++level)
        halve(shade_[level - 1], sideOf(kSide, level - 1), shade_[level]);
}

void GroundGlow::light(const LightView& of_scene, const Mat3d& rotation, Vec3 albedo) {
    GroundVertices up;
    up.normals = {{0, 1, 0}};
    up.tangents = {{0, 0, 1}};
    light(groundWeights(up, of_scene, rotation), albedo);
}

Vec3 GroundGlow::shadeOf(std::size_t level, float x, float z) const {
    const std::uint32_t side = sideOf(kSide, level);
    const float cell = cell_ * float(1u << level), row = (x - corner_[0]) / cell, column = (z - corner_[1]) / cell;
    if (!(row > -1 && column > -1 && row < float(side) && column < float(side))) return {};
    const float i = std::floor(row), j = std::floor(column), down = row - i, right = column - j;
    Vec3 sum;
    for (int k = 0; k < 4; ++k) {
        const int r = int(i) + k / 2, c = int(j) + k % 2;
        if (r < 0 || c < 0 || r >= int(side) || c >= int(side)) continue;
        sum += shade_[level][std::size_t(r) * side + std::size_t(c)] *
               ((k / 2 == 1 ? down : 1 - down) * (k % 2 == 1 ? right : 1 - right));
    }
    return sum;
}

// Mean over a spot of this standard deviation.
Vec3 GroundGlow::shadeAt(float x, float z, float width) const {
    const float level = std::clamp(std::log2(std::max(width / (kWidthOfCell * cell_), 1.0f)), 0.0f, float(kLevels - 1));
    const auto low = std::min(std::size_t(level), kLevels - 2);
    const float share = level - float(low);
    return shadeOf(low, x, z) * (1 - share) + shadeOf(low + 1, x, z) * share;
}

Vec3 GroundGlow::radianceAt(Vec3 position, Vec3 normal) const {
    const float h = std::max(position.y - height_, 0.0f);
    // 0 straight down, 1 level. Where the normal leans, what is seen of the ground is farther off on this side.
    const float lean = 1 + normal.y;
    const float across = std::sqrt(normal.x * normal.x + normal.z * normal.z);
    const float x = across > 0 ? normal.x / across : 0, z = across > 0 ? normal.z / across : 0;
    Vec3 shade;
    for (const auto& [offset, width, more] : {std::array{0.88f, 0.6f, 0.2f}, std::array{3.87f, 1.32f, 1.1f}}) {
        const float away = offset * lean * h;
        shade += shadeAt(position.x + x * away, position.z + z * away, (width + more * lean) * h) * 0.5f;
    }
    return open_ - shade;
}

}  // namespace penumbra
