#include "player/composite/ground_ratio.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "formats/common/parallel_for.h"
#include "player/composite/sun_pixels.h"
#include "player/scene/cast_blocks.h"
#include "sh/visibility_convention.h"

namespace penumbra {

namespace {

constexpr std::uint32_t kStep = 2;  // pixels between two vertices of the grid

Vec3 irradianceOf(const GroundWeights& weights, const float* mirrored) {
    Vec3d sum;
    for (std::size_t i = 0; i < kFarCoefficients; ++i) sum += weights[i] * double(mirrored[i]);
    return toFloat(sum);
}

float hiddenFrom(std::span<const float, kFarCoefficients> weights, const float* mirrored) {
    float e = 0;
    for (std::size_t i = 0; i < kFarCoefficients; ++i) e += weights[i] * mirrored[i];
    return 1 - e;
}

}  // namespace

GroundRatio::GroundRatio(const PinholeCamera& camera)
    : camera_(camera),
      rows_(std::uint32_t(camera.height) / kStep + 1),
      columns_(std::uint32_t(camera.width) / kStep + 1) {
    for (std::uint32_t y = 0; y < 2 * rows_ - 1; ++y)
        for (std::uint32_t x = 0; x < 2 * columns_ - 1; ++x)
            rays_.push_back(toFloat(viewRay(camera, {double(x), double(y)})));
    points_.resize(rays_.size());
    sees_.resize(rays_.size());
    const std::size_t count = std::size_t(rows_) * columns_;
    grid_points_.resize(count);
    normals_.assign(count, {0, 1, 0});
    tangents_.assign(count, {0, 0, 1});
    for (std::vector<Vec3>* of_vertex : {&past_, &from_, &without_}) of_vertex->resize(count);
}

void GroundRatio::placePoints(const SceneView& view, double ground_height, int threads) {
    constexpr double kMinSlope = 1e-3;  // the ground is seen up to a thousand times the height of the eye
    const Mat3d to_scene = transposed(view.turn());
    const Vec3d eye = view.eye();
    const double above = eye.y - ground_height;
    parallelFor(2 * rows_ - 1, threads, [&](std::size_t y) {
        for (std::uint32_t x = 0; x < 2 * columns_ - 1; ++x) {
            const std::size_t i = rayIndex(std::uint32_t(y), x);
            const Vec3d direction = to_scene * toDouble(rays_[i]);
            sees_[i] = above > 0 && direction.y < -kMinSlope;
            const double far = sees_[i] ? -above / direction.y : 1e3;
            points_[i] = toFloat(eye + direction * far);
            if (y % kStep == 0 && x % kStep == 0) grid_points_[y / kStep * columns_ + x / kStep] = points_[i];
        }
    });
}

// Evaluates what a cast leaves visible into mirrored_, for blocks that see the ground and are in reach.
std::vector<CastBlock> GroundRatio::castOn(const CastShadow& cast, int threads) {
    std::vector<CastBlock> blocks = castBlocks(rows_, columns_);
    parallelFor(blocks.size(), threads, [&](std::size_t b) {
        CastBlock& block = blocks[b];
        std::array<Vec3, 4> corners;
        std::size_t n = 0;
        bool sees = true;
        for (const std::uint32_t i : {block.low[0], block.high[0]})
            for (const std::uint32_t j : {block.low[1], block.high[1]}) {
                sees = sees && sees_[rayIndex(kStep * i, kStep * j)];
                corners[n++] = grid_points_[std::size_t(i) * columns_ + j];
            }
        block.wanted = false;
        if (!sees) return;
        const CasterSphere around = sphereAround(corners);
        for (std::size_t c = 0; c < cast.casterCount() && !block.wanted; ++c) block.wanted = cast.reaches(c, around);
    });
    mirrored_.resize(grid_points_.size() * kFarCoefficients);
    castOnBlocks(cast, {rows_, columns_, {grid_points_, normals_, tangents_}, mirrored_}, blocks, threads);
    return blocks;
}

void GroundRatio::castSoft(const GroundLight& light, int threads) {
    std::array<float, kFarCoefficients> open{}, ambient;
    open[0] = kOpenSight;
    ambientWeights(parseConvention("D" + std::to_string(kFieldOrder)), ambient);
    free_ = irradianceOf(light.weights, open.data());
    std::ranges::fill(past_, free_);
    std::ranges::fill(from_, Vec3{});
    std::ranges::fill(without_, free_);
    changed_.assign(castBlocks(rows_, columns_).size(), 0);
    // Calls body(vertex) for all vertices of blocks that see anybody. Neighbours share those of their edges.
    const auto overSeen = [&](std::span<const CastBlock> blocks, const auto& body) {
        for (std::size_t b = 0; b < blocks.size(); ++b) {
            const CastBlock& block = blocks[b];
            if (!block.wanted || !block.seen) continue;
            changed_[b] = 1;
            for (std::uint32_t i = block.low[0]; i <= block.high[0]; ++i)
                for (std::uint32_t j = block.low[1]; j <= block.high[1]; ++j) body(std::size_t(i) * columns_ + j);
        }
    };
    std::vector<float> hidden_by_real;
    if (light.real) {
        hidden_by_real.assign(past_.size(), 0.0f);
        overSeen(castOn(*light.real, threads), [&](std::size_t v) {
            without_[v] = irradianceOf(light.weights, &mirrored_[v * kFarCoefficients]);
            hidden_by_real[v] = hiddenFrom(ambient, &mirrored_[v * kFarCoefficients]);
        });
    }
    const std::vector<CastBlock> blocks = castOn(*light.all, threads);
    overSeen(blocks, [&](std::size_t v) { past_[v] = irradianceOf(light.weights, &mirrored_[v * kFarCoefficients]); });
    if (!light.emitters.empty()) addBounce(light.emitters, blocks, hidden_by_real, threads);
}

// The mean radiance of characters is looked up at the corners of blocks, each once, and interpolated between them.
void GroundRatio::addBounce(std::span<const Emitter> emitters, std::span<const CastBlock> blocks,
                            std::span<const float> hidden_by_real, int threads) {
    std::array<float, kFarCoefficients> ambient;
    ambientWeights(parseConvention("D" + std::to_string(kFieldOrder)), ambient);
    std::vector<char> wanted(past_.size());
    std::vector<std::size_t> corners;
    for (const CastBlock& block : blocks)
        if (block.wanted && block.seen)
            for (const std::uint32_t i : {block.low[0], block.high[0]})
                for (const std::uint32_t j : {block.low[1], block.high[1]})
                    if (const std::size_t v = std::size_t(i) * columns_ + j; !std::exchange(wanted[v], char(1)))
                        corners.push_back(v);
    std::vector<Vec3> mean(past_.size());
    parallelFor(corners.size(), threads, [&](std::size_t n) {
        mean[corners[n]] = meanRadiance(emitters, grid_points_[corners[n]], {0, 1, 0});
    });
    parallelFor(blocks.size(), threads, [&](std::size_t b) {
        const CastBlock& block = blocks[b];
        if (!block.wanted || !block.seen) return;
        const auto at = [&](std::size_t i, std::size_t j) { return mean[i * columns_ + j]; };
        // The far edges belong to the next blocks.
        for (std::uint32_t i = block.low[0]; i < block.high[0]; ++i)
            for (std::uint32_t j = block.low[1]; j < block.high[1]; ++j) {
                const std::size_t v = std::size_t(i) * columns_ + j;
                const float down = float(i - block.low[0]) / float(block.high[0] - block.low[0]),
                            right = float(j - block.low[1]) / float(block.high[1] - block.low[1]);
                const Vec3 above =
                               at(block.low[0], block.low[1]) * (1 - right) + at(block.low[0], block.high[1]) * right,
                           below =
                               at(block.high[0], block.low[1]) * (1 - right) + at(block.high[0], block.high[1]) * right;
                const float hidden = hiddenFrom(ambient, &mirrored_[v * kFarCoefficients]) -
                                     (hidden_by_real.empty() ? 0.0f : hidden_by_real[v]);
                from_[v] = (above * (1 - down) + below * down) * (std::numbers::pi_v<float> * std::max(hidden, 0.0f));
            }
    });
}

// Interpolates the grid at every pixel. Where no block around it is changed, a pixel has exactly what is free.
void GroundRatio::addSoft(const GroundLight& light, int threads, std::vector<Vec3>& past,
                          std::vector<Vec3>& without) const {
    const auto width = std::uint32_t(camera_.width);
    const std::size_t across = (columns_ - 2) / kCastBlock + 1;  // blocks
    parallelFor(std::size_t(camera_.height), threads, [&](std::size_t y) {
        const std::size_t i = std::min<std::size_t>(y / kStep, rows_ - 2);
        const float down = float(y - kStep * i) / float(kStep);
        for (std::uint32_t x = 0; x < width; ++x) {
            const std::size_t j = std::min<std::size_t>(x / kStep, columns_ - 2), v = i * columns_ + j;
            past[y * width + x] = without[y * width + x] = free_;
            if (!changed_[i / kCastBlock * across + j / kCastBlock]) continue;
            const float right = float(x - kStep * j) / float(kStep);
            const auto between = [&](const std::vector<Vec3>& of) {
                return (of[v] * (1 - right) + of[v + 1] * right) * (1 - down) +
                       (of[v + columns_] * (1 - right) + of[v + columns_ + 1] * right) * down;
            };
            past[y * width + x] = between(past_) + between(from_);
            if (light.real) without[y * width + x] = between(without_);
        }
    });
}

void GroundRatio::compute(const SceneView& view, double ground_height, const GroundLight& light, int threads,
                          std::vector<Vec3>& ratio) {
    placePoints(view, ground_height, threads);
    castSoft(light, threads);
    const std::size_t pixels = std::size_t(camera_.width) * std::size_t(camera_.height);
    std::vector<Vec3> without(pixels);
    ratio.resize(pixels);
    addSoft(light, threads, ratio, without);
    const PixelPoints points{camera_.width, camera_.height, 2 * columns_ - 1, points_, sees_};
    Vec3 whole = free_;  // the irradiance of ground that nothing is near
    for (std::size_t s = 0; s < light.suns.size(); ++s) {
        const Vec3 full = light.suns[s].irradiance * std::max(light.suns[s].direction.y, 0.0f);
        if (full == Vec3{}) continue;
        whole += full;
        addSun(points, light.sun_maps[s], full, threads, ratio);
        if (light.real_sun_maps.empty())
            for (Vec3& e : without) e += full;
        else
            addSun(points, light.real_sun_maps[s], full, threads, without);
    }
    constexpr float kDark = 1e-6f;  // of the whole irradiance, below which nothing can be told
    Vec3 least;
    for (int c = 0; c < 3; ++c) least[c] = kDark * std::max(whole[c], 0.0f);
    parallelFor(std::size_t(camera_.height), threads, [&](std::size_t y) {
        for (std::size_t x = 0; x < std::size_t(camera_.width); ++x) {
            const std::size_t i = y * std::size_t(camera_.width) + x;
            const bool sees = sees_[rayIndex(std::uint32_t(y), std::uint32_t(x))];
            for (int c = 0; c < 3; ++c)
                ratio[i][c] = sees && without[i][c] > least[c] ? std::max(ratio[i][c], 0.0f) / without[i][c] : 1.0f;
        }
    });
}

}  // namespace penumbra
