// Computes the visibility on the ground, by blocks of squares (cast_blocks.h), and the triangles that show it.
#include "player/scene/scene_ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/common/parallel_for.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

// rms of the corners' a - b - c + d, up to which a fan about the middle may show a smooth block. The fan is a 16th of
// it off at most.
constexpr float kMaxTwist = 0.012f;

// Draws smooth blocks with fewer triangles.
class Fans {
public:
    Fans(GroundVertices& ground, const CastGrid& grid)
        : ground_(ground), grid_(grid), blocks_(ground.blocks), coarse_(roomForCoarse()) {
        while (blocks_a_side_ < blocks_.size() && blocks_[blocks_a_side_].low[0] == 0) ++blocks_a_side_;
        coarse_.clear();
        for (const CastBlock& block : blocks_) coarse_.push_back(block.smooth && isFlat(block) ? 1 : 0);
    }

    void add() {
        for (std::size_t b = 0; b < blocks_.size(); ++b) coarse_[b] != 0 ? addFan(b) : addSquares(blocks_[b]);
    }

private:
    GroundVertices& ground_;
    const CastGrid& grid_;
    std::span<const CastBlock> blocks_;  // row by row
    std::size_t blocks_a_side_ = 0;
    std::vector<std::uint8_t>& coarse_;  // one for each block: a fan shows it

    static std::vector<std::uint8_t>& roomForCoarse() {
        thread_local std::vector<std::uint8_t> room;
        return room;
    }

    std::uint32_t vertex(std::uint32_t i, std::uint32_t j) const { return i * ground_.side + j; }

    bool isFlat(const CastBlock& block) const {
        const auto row = [&](std::uint32_t i, std::uint32_t j) {
            return grid_.mirrored.data() + vertex(i, j) * kFarCoefficients;
        };
        const float *a = row(block.low[0], block.low[1]), *b = row(block.low[0], block.high[1]),
                    *c = row(block.high[0], block.low[1]), *d = row(block.high[0], block.high[1]);
        std::array<float, kFarCoefficients> ad, bc;
        for (std::size_t n = 0; n < kFarCoefficients; ++n) {
            ad[n] = a[n] + d[n];
            bc[n] = b[n] + c[n];
        }
        return block.high[0] - block.low[0] > 1 && block.high[1] - block.low[1] > 1 &&
               castRowsApart(ad, bc) <= kMaxTwist;
    }

    void addSquares(const CastBlock& block) {
        for (std::uint32_t i = block.low[0]; i < block.high[0]; ++i)
            for (std::uint32_t j = block.low[1]; j < block.high[1]; ++j) {
                const std::uint32_t a = vertex(i, j), b = vertex(i + 1, j);
                ground_.drawn.insert(ground_.drawn.end(), {a, a + 1, b, b, a + 1, b + 1});
            }
    }

    // A fan about the middle. Beside a block that is no fan it has all vertices of their edge, so that nothing cracks.
    void addFan(std::size_t index) {
        const CastBlock& block = blocks_[index];
        const std::uint32_t middle = vertex(block.middle(0), block.middle(1));
        const std::size_t i = index / blocks_a_side_, j = index % blocks_a_side_, last = blocks_a_side_ - 1;
        const bool fine[4] = {i > 0 && coarse_[index - blocks_a_side_] == 0, j < last && coarse_[index + 1] == 0,
                              i < last && coarse_[index + blocks_a_side_] == 0, j > 0 && coarse_[index - 1] == 0};
        const std::uint32_t corner[4][2] = {{block.low[0], block.low[1]},
                                            {block.low[0], block.high[1]},
                                            {block.high[0], block.high[1]},
                                            {block.high[0], block.low[1]}};
        const std::uint32_t stride[2] = {1, ground_.side},
                            squares[2] = {block.high[1] - block.low[1], block.high[0] - block.low[0]};
        for (std::size_t side = 0; side < 4; ++side) {
            const std::uint32_t from = vertex(corner[side][0], corner[side][1]),
                                to = vertex(corner[(side + 1) % 4][0], corner[(side + 1) % 4][1]);
            const std::uint32_t step = stride[side % 2] * (fine[side] ? 1 : squares[side % 2]);
            for (std::uint32_t at = from; at != to;) {
                const std::uint32_t next = to > from ? at + step : at - step;
                ground_.drawn.insert(ground_.drawn.end(), {middle, at, next});
                at = next;
            }
        }
    }
};

}  // namespace

GroundVertices groundMesh(const SceneGround& ground) {
    const auto side = std::uint32_t(ground.resolution);
    GroundVertices out;
    out.side = side;
    for (std::uint32_t i = 0; i < side; ++i)
        for (std::uint32_t j = 0; j < side; ++j) {
            const double x = ground.size * (double(i) / (side - 1) - 0.5),
                         z = ground.size * (double(j) / (side - 1) - 0.5);
            out.positions.push_back(toFloat(Vec3d{ground.center.x + x, ground.height, ground.center.z + z}));
        }
    out.normals.assign(out.positions.size(), {0, 1, 0});
    out.tangents.assign(out.positions.size(), {0, 0, 1});
    out.mirrored.resize(out.positions.size() * kFarCoefficients);
    for (std::uint32_t i = 0; i + 1 < side; ++i)
        for (std::uint32_t j = 0; j + 1 < side; ++j) {
            const std::uint32_t a = i * side + j, b = a + side;
            out.triangles.insert(out.triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
        }
    return out;
}

void castOnGround(const CastShadow& cast, int threads, GroundVertices& ground) {
    std::ranges::fill(ground.mirrored, 0.0f);
    for (std::size_t v = 0; v < ground.positions.size(); ++v) ground.mirrored[v * kFarCoefficients] = kOpenSight;
    const CastGrid grid{ground.side, ground.side, {ground.positions, ground.normals, ground.tangents}, ground.mirrored};
    if (ground.blocks.empty()) ground.blocks = castBlocks(ground.side, ground.side);
    ground.evaluated = castOnBlocks(cast, grid, ground.blocks, threads);
    ground.drawn.clear();
    Fans(ground, grid).add();
}

GroundVertices groundVertices(const SceneGround& ground, const CastShadow& cast, int threads) {
    GroundVertices out = groundMesh(ground);
    castOnGround(cast, threads, out);
    return out;
}

GroundVertices groundVertices(const PosedScene& scene, int threads) {
    return groundVertices(*scene.file().ground, scene.cast(), threads);
}

void groundAmbient(const GroundVertices& ground, std::vector<float>& e) {
    std::array<float, kFarCoefficients> weights;
    ambientWeights(Convention{BelowHorizon::kMirrored, kFieldOrder}, weights);
    e.assign(ground.positions.size(), 0.0f);
    for (std::size_t v = 0; v < e.size(); ++v)
        for (std::size_t i = 0; i < kFarCoefficients; ++i)
            e[v] += weights[i] * ground.mirrored[v * kFarCoefficients + i];
}

std::vector<float> groundAmbient(const GroundVertices& ground) {
    std::vector<float> e;
    groundAmbient(ground, e);
    return e;
}

GroundWeights groundWeights(const GroundVertices& ground, const LightView& light, const Mat3d& rotation) {
    const Vec3d n = toDouble(ground.normals.front()), t = toDouble(ground.tangents.front()), b = cross(n, t);
    const Mat3d to_light = transposed(rotation);
    const std::vector<int> even = evenIndices(kFieldOrder);
    GroundWeights weights{};
    std::vector<double> y(kFieldCoefficients), of_light(std::size_t(light.order * light.order));
    for (const WeightedDirection& d : gaussHemisphere(16, 32)) {
        evalBasis(light.order, to_light * (t * d.direction.x + b * d.direction.y + n * d.direction.z), of_light);
        Vec3d radiance;
        for (std::size_t i = 0; i < of_light.size(); ++i)
            for (int c = 0; c < 3; ++c) radiance[c] += of_light[i] * light.sh[3 * i + std::size_t(c)];
        evalBasis(kFieldOrder, d.direction, y);
        for (std::size_t i = 0; i < kFarCoefficients; ++i)
            weights[i] += radiance * (d.weight * d.direction.z * y[std::size_t(even[i])]);
    }
    return weights;
}

void groundRadiance(const GroundVertices& ground, const LitGround& lit, int threads, std::vector<Vec3>& out) {
    std::array<Vec3, kFarCoefficients> weights;
    const GroundWeights of_light = groundWeights(ground, lit.light, lit.rotation);
    for (std::size_t i = 0; i < kFarCoefficients; ++i)
        weights[i] = toFloat(toDouble(lit.albedo) * of_light[i] * (1 / std::numbers::pi));
    out.assign(ground.positions.size(), Vec3{});
    parallelFor(ground.side, threads, [&](std::size_t row) {
        for (std::size_t v = row * ground.side; v < (row + 1) * ground.side; ++v) {
            for (std::size_t i = 0; i < kFarCoefficients; ++i)
                out[v] += weights[i] * ground.mirrored[v * kFarCoefficients + i];
            for (int c = 0; c < 3; ++c) out[v][c] = std::max(out[v][c], 0.0f);
        }
    });
}

std::vector<Vec3> groundRadiance(const GroundVertices& ground, const LightView& light, const Mat3d& rotation,
                                 Vec3 albedo, int threads) {
    std::vector<Vec3> out;
    groundRadiance(ground, {light, rotation, albedo}, threads, out);
    return out;
}

std::vector<Vec3> groundRadiance(const PosedScene& scene, const GroundVertices& ground, int threads) {
    return groundRadiance(ground, *scene.light(), scene.lightRotation(), scene.file().ground->albedo, threads);
}

}  // namespace penumbra
