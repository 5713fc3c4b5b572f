// What the ground sees.
//
// Problem: a ground of 128 x 128 vertices looks up 31 parts at each, 19 ms of one core, while its visibility varies
// slowly but for a hand's breadth around each foot.
//
// Naive: evaluate all vertices.
//
// Here: blocks of 4 x 4 squares are evaluated at their corners and in the middle. Where the corners are alike and the
// middle is what they say, the vertices between are interpolated: all have one local frame, so numbers may be mixed.
// All vertices of the other blocks are evaluated. Neighbouring blocks share their edge's vertices, so nothing cracks.
#include "player/scene/scene_ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "player/scene/cast_on.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr std::uint32_t kBlock = 4;  // squares a side
// rms of V over the sphere: how far the middle may be from its corners' mean, and the corners from one another.
constexpr float kMiddleOff = 0.003f, kCornersApart = 0.15f;
// rms of the corners' a - b - c + d, up to which a fan about the middle may show a smooth block. The fan is a 16th of
// it off at most.
constexpr float kMostTwist = 0.012f;

using Row = std::span<const float, kFarNumbers>;

// A block of squares: vertices low..high both ways.
struct Block {
    std::uint32_t low[2], high[2];

    std::uint32_t middle(int axis) const { return (low[axis] + high[axis]) / 2; }
};

class Refinement {
public:
    Refinement(const CastShadow& cast, GroundVertices& ground, int threads)
        : cast_(cast), ground_(ground), threads_(threads), done_(ground.positions.size()) {
        std::vector<std::uint32_t> lines;
        for (std::uint32_t i = 0; i + 1 < ground.side; i += kBlock) lines.push_back(i);
        lines.push_back(ground.side - 1);
        blocks_a_side_ = lines.size() - 1;
        for (std::size_t i = 0; i + 1 < lines.size(); ++i)
            for (std::size_t j = 0; j + 1 < lines.size(); ++j)
                blocks_.push_back({{lines[i], lines[j]}, {lines[i + 1], lines[j + 1]}});
    }

    void run() {
        for (const Block& block : blocks_) {
            for (const std::uint32_t i : {block.low[0], block.high[0]})
                for (const std::uint32_t j : {block.low[1], block.high[1]}) want(i, j);
            want(block.middle(0), block.middle(1));
        }
        evaluate();
        std::vector<const Block*> smooth;
        for (const Block& block : blocks_) {
            const bool is_smooth = isSmooth(block);
            coarse_.push_back(is_smooth && isFlat(block));
            if (is_smooth) {
                smooth.push_back(&block);
                continue;
            }
            for (std::uint32_t i = block.low[0]; i <= block.high[0]; ++i)
                for (std::uint32_t j = block.low[1]; j <= block.high[1]; ++j) want(i, j);
        }
        evaluate();
        for (const Block* block : smooth) interpolate(*block);
        for (std::size_t b = 0; b < blocks_.size(); ++b) coarse_[b] ? addFan(b) : addSquares(blocks_[b]);
    }

private:
    const CastShadow& cast_;
    GroundVertices& ground_;
    int threads_;
    std::size_t blocks_a_side_ = 0;
    std::vector<Block> blocks_;          // row by row
    std::vector<bool> coarse_;           // of a block: a fan shows it
    std::vector<bool> done_;             // a vertex is evaluated, or about to be
    std::vector<std::uint32_t> wanted_;  // vertices

    std::uint32_t vertex(std::uint32_t i, std::uint32_t j) const { return i * ground_.side + j; }
    Row row(std::uint32_t i, std::uint32_t j) const {
        return Row(ground_.mirrored.data() + vertex(i, j) * kFarNumbers, kFarNumbers);
    }
    void want(std::uint32_t i, std::uint32_t j) {
        if (done_[vertex(i, j)]) return;
        done_[vertex(i, j)] = true;
        wanted_.push_back(vertex(i, j));
    }

    void evaluate() {
        std::vector<Vec3> positions;
        for (const std::uint32_t v : wanted_) positions.push_back(ground_.positions[v]);
        const std::span normals = std::span(ground_.normals).first(wanted_.size()),
                        tangents = std::span(ground_.tangents).first(wanted_.size());
        std::vector<float> mirrored;
        castOn(cast_, {}, {positions, normals, tangents}, threads_, mirrored);
        for (std::size_t n = 0; n < wanted_.size(); ++n)
            std::copy_n(&mirrored[n * kFarNumbers], kFarNumbers, &ground_.mirrored[wanted_[n] * kFarNumbers]);
        ground_.evaluated += wanted_.size();
        wanted_.clear();
    }

    // Numbers of a vertex between the corners.
    std::array<float, kFarNumbers> between(const Block& block, std::uint32_t i, std::uint32_t j) const {
        const float x = float(i - block.low[0]) / float(block.high[0] - block.low[0]),
                    z = float(j - block.low[1]) / float(block.high[1] - block.low[1]);
        const Row a = row(block.low[0], block.low[1]), b = row(block.low[0], block.high[1]),
                  c = row(block.high[0], block.low[1]), d = row(block.high[0], block.high[1]);
        std::array<float, kFarNumbers> out;
        for (std::size_t n = 0; n < kFarNumbers; ++n)
            out[n] = (1 - x) * ((1 - z) * a[n] + z * b[n]) + x * ((1 - z) * c[n] + z * d[n]);
        return out;
    }

    static float apart(Row a, Row b) {
        float sum = 0;
        for (std::size_t n = 0; n < kFarNumbers; ++n) sum += (a[n] - b[n]) * (a[n] - b[n]);
        return std::sqrt(sum / (4 * std::numbers::pi_v<float>));
    }
    bool isSmooth(const Block& block) const {
        const Row first = row(block.low[0], block.low[1]);
        for (const Row other :
             {row(block.low[0], block.high[1]), row(block.high[0], block.low[1]), row(block.high[0], block.high[1])})
            if (apart(first, other) > kCornersApart) return false;
        const std::array<float, kFarNumbers> expected = between(block, block.middle(0), block.middle(1));
        return apart(expected, row(block.middle(0), block.middle(1))) <= kMiddleOff;
    }

    bool isFlat(const Block& block) const {
        const Row a = row(block.low[0], block.low[1]), b = row(block.low[0], block.high[1]),
                  c = row(block.high[0], block.low[1]), d = row(block.high[0], block.high[1]);
        std::array<float, kFarNumbers> ad, bc;
        for (std::size_t n = 0; n < kFarNumbers; ++n) {
            ad[n] = a[n] + d[n];
            bc[n] = b[n] + c[n];
        }
        return block.high[0] - block.low[0] > 1 && block.high[1] - block.low[1] > 1 && apart(ad, bc) <= kMostTwist;
    }

    void addSquares(const Block& block) {
        for (std::uint32_t i = block.low[0]; i < block.high[0]; ++i)
            for (std::uint32_t j = block.low[1]; j < block.high[1]; ++j) {
                const std::uint32_t a = vertex(i, j), b = vertex(i + 1, j);
                ground_.drawn.insert(ground_.drawn.end(), {a, a + 1, b, b, a + 1, b + 1});
            }
    }

    // A fan about the middle. Beside a block that is no fan it has all vertices of their edge, so that nothing cracks.
    void addFan(std::size_t index) {
        const Block& block = blocks_[index];
        const std::uint32_t middle = vertex(block.middle(0), block.middle(1));
        const std::size_t i = index / blocks_a_side_, j = index % blocks_a_side_, last = blocks_a_side_ - 1;
        const bool fine[4] = {i > 0 && !coarse_[index - blocks_a_side_], j < last && !coarse_[index + 1],
                              i < last && !coarse_[index + blocks_a_side_], j > 0 && !coarse_[index - 1]};
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

    void interpolate(const Block& block) {
        for (std::uint32_t i = block.low[0]; i <= block.high[0]; ++i)
            for (std::uint32_t j = block.low[1]; j <= block.high[1]; ++j) {
                if (done_[vertex(i, j)]) continue;
                const std::array<float, kFarNumbers> numbers = between(block, i, j);
                std::copy(numbers.begin(), numbers.end(), &ground_.mirrored[vertex(i, j) * kFarNumbers]);
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
            out.positions.push_back(toFloat(Vec3d{ground.centre.x + x, ground.height, ground.centre.z + z}));
        }
    out.normals.assign(out.positions.size(), {0, 1, 0});
    out.tangents.assign(out.positions.size(), {0, 0, 1});
    out.mirrored.resize(out.positions.size() * kFarNumbers);
    for (std::uint32_t i = 0; i + 1 < side; ++i)
        for (std::uint32_t j = 0; j + 1 < side; ++j) {
            const std::uint32_t a = i * side + j, b = a + side;
            out.triangles.insert(out.triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
        }
    return out;
}

GroundVertices groundVertices(const SceneGround& ground, const CastShadow& cast, int threads) {
    GroundVertices vertices = groundMesh(ground);
    Refinement(cast, vertices, threads).run();
    return vertices;
}

GroundVertices groundVertices(const PosedScene& scene, int threads) {
    return groundVertices(*scene.file().ground, scene.cast(), threads);
}

std::vector<float> groundAmbient(const GroundVertices& ground) {
    std::array<float, kFarNumbers> weights;
    ambientWeights(parseConvention("D" + std::to_string(kFieldOrder)), weights);
    std::vector<float> e(ground.positions.size());
    for (std::size_t v = 0; v < e.size(); ++v)
        for (std::size_t i = 0; i < kFarNumbers; ++i) e[v] += weights[i] * ground.mirrored[v * kFarNumbers + i];
    return e;
}

GroundWeights groundWeights(const GroundVertices& ground, const LightView& light, const Mat3d& rotation) {
    const Vec3d n = toDouble(ground.normals.front()), t = toDouble(ground.tangents.front()), b = cross(n, t);
    const Mat3d to_light = transposed(rotation);
    const std::vector<int> even = evenIndices(kFieldOrder);
    GroundWeights weights{};
    std::vector<double> y(kFieldNumbers), of_light(std::size_t(light.order * light.order));
    for (const WeightedDirection& d : gaussHemisphere(16, 32)) {
        evalBasis(light.order, to_light * (t * d.direction.x + b * d.direction.y + n * d.direction.z), of_light);
        Vec3d radiance;
        for (std::size_t i = 0; i < of_light.size(); ++i)
            for (int c = 0; c < 3; ++c) radiance[c] += of_light[i] * light.sh[3 * i + std::size_t(c)];
        evalBasis(kFieldOrder, d.direction, y);
        for (std::size_t i = 0; i < kFarNumbers; ++i)
            weights[i] += radiance * (d.weight * d.direction.z * y[std::size_t(even[i])]);
    }
    return weights;
}

std::vector<Vec3> groundRadiance(const GroundVertices& ground, const LightView& light, const Mat3d& rotation,
                                 Vec3 albedo) {
    const GroundWeights weights = groundWeights(ground, light, rotation);
    const Vec3d reflected = toDouble(albedo) * (1 / std::numbers::pi);
    std::vector<Vec3> out;
    for (std::size_t v = 0; v < ground.positions.size(); ++v) {
        Vec3d irradiance;
        for (std::size_t i = 0; i < kFarNumbers; ++i)
            irradiance += weights[i] * double(ground.mirrored[v * kFarNumbers + i]);
        Vec3 radiance = toFloat(reflected * irradiance);
        for (int c = 0; c < 3; ++c) radiance[c] = std::max(radiance[c], 0.0f);
        out.push_back(radiance);
    }
    return out;
}

std::vector<Vec3> groundRadiance(const PosedScene& scene, const GroundVertices& ground) {
    return groundRadiance(ground, *scene.light(), scene.lightRotation(), scene.file().ground->albedo);
}

}  // namespace penumbra
