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

}  // namespace

void GroundGlow::cast(const CastShadow& cast, double ground_height, std::span<const Vec3> standing, int threads) {
    constexpr float kReach = 0.5f;  // in heights of the highest member: radius around each in which shadows are sought
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
    if (blocks_.empty()) blocks_ = castBlocks(kSide, kSide);
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
    const std::size_t wide = kSide + 2;
    shade_[0].assign(wide * wide, Texel{});
    for (std::size_t v = 0; v < positions_.size(); ++v) {
        const Vec3 shade = open_ - radianceOf(&mirrored_[v * kFarCoefficients]);
        shade_[0][(v / kSide + 1) * wide + v % kSide + 1] = {shade.x, shade.y, shade.z, 0};
    }
    for (std::size_t level = 1; level < kLevels; ++level) halve(level);
}

// Makes a level: blurs the one before it and keeps every second point.
void GroundGlow::halve(std::size_t level) {
    const std::uint32_t side = sideOf(level), wide = side + 2, fine_wide = sideOf(level - 1) + 2;
    const std::vector<Texel>& fine = shade_[level - 1];
    shade_[level].assign(std::size_t(wide) * wide, Texel{});
    for (std::uint32_t i = 0; i < side; ++i)
        for (std::uint32_t j = 0; j < side; ++j) {
            Texel& out = shade_[level][(i + 1) * wide + j + 1];
            for (std::uint32_t row = 0; row < 3; ++row)
                for (std::uint32_t column = 0; column < 3; ++column) {
                    const Texel& from = fine[(2 * i + row) * fine_wide + 2 * j + column];
                    const float share = float((row == 1 ? 2 : 1) * (column == 1 ? 2 : 1)) / 16;
                    for (std::size_t c = 0; c < 3; ++c) out[c] += from[c] * share;
                }
        }
}

void GroundGlow::light(const LightView& of_scene, const Mat3d& rotation, Vec3 albedo) {
    GroundVertices up;
    up.normals = {{0, 1, 0}};
    up.tangents = {{0, 0, 1}};
    light(groundWeights(up, of_scene, rotation), albedo);
}

// Adds a share of what a level has between its points.
void GroundGlow::addShade(std::size_t level, float x, float z, float share, Texel& sum) const {
    const std::uint32_t side = sideOf(level), wide = side + 2;
    const float cell = cell_ * float(1u << level), row = (x - corner_[0]) / cell + 1,
                column = (z - corner_[1]) / cell + 1;
    if (!(row > 0 && column > 0 && row < float(side + 1) && column < float(side + 1))) return;
    const auto i = std::uint32_t(row), j = std::uint32_t(column);
    const float down = row - float(i), right = column - float(j);
    const Texel *const above = &shade_[level][std::size_t(i) * wide + j], *const below = above + wide;
    const float weights[4] = {share * (1 - down) * (1 - right), share * (1 - down) * right, share * down * (1 - right),
                              share * down * right};
    for (std::size_t c = 0; c < 4; ++c)
        sum[c] += (above[0][c] * weights[0] + above[1][c] * weights[1]) +
                  (below[0][c] * weights[2] + below[1][c] * weights[3]);
}

// Mean over a spot of this standard deviation.
GroundGlow::Texel GroundGlow::shadeAt(float x, float z, float width) const {
    const float level = std::clamp(std::log2(std::max(width / (kWidthOfCell * cell_), 1.0f)), 0.0f, float(kLevels - 1));
    const auto low = std::min(std::size_t(level), kLevels - 2);
    const float share = level - float(low);
    Texel sum{};
    addShade(low, x, z, 1 - share, sum);
    addShade(low + 1, x, z, share, sum);
    return sum;
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
        const Texel half = shadeAt(position.x + x * away, position.z + z * away, (width + more * lean) * h);
        shade += Vec3{half[0], half[1], half[2]} * 0.5f;
    }
    return open_ - shade;
}

}  // namespace penumbra
