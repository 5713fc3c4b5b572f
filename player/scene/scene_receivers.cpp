#include "player/scene/scene_receivers.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "sh/mirrored_product.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "sh/sh_product.h"

namespace penumbra {

namespace {

constexpr std::size_t kPiece = 512;  // receivers that a thread takes at once

// Writes what receivers see past the chosen casters. Returns how many see any.
std::size_t castOn(const CastShadow& cast, CasterChoice choice, const CastReceivers& receivers, int threads,
                   std::vector<float>& mirrored) {
    const std::size_t count = receivers.positions.size(), pieces = (count + kPiece - 1) / kPiece;
    mirrored.resize(count * kFarNumbers);
    std::vector<std::size_t> seen(pieces);
    parallelFor(pieces, threads, [&](std::size_t piece) {
        const std::size_t first = piece * kPiece, n = std::min(kPiece, count - first);
        std::vector<std::uint16_t> parts;
        seen[piece] = cast.evaluate({receivers.positions.subspan(first, n), receivers.normals.subspan(first, n),
                                     receivers.tangents.subspan(first, n)},
                                    choice, parts, std::span(mirrored).subspan(first * kFarNumbers, n * kFarNumbers));
    });
    std::size_t all = 0;
    for (const std::size_t n : seen) all += n;
    return all;
}

// Multiplies the numbers of one vertex by what others leave visible.
class Multiplier {
public:
    explicit Multiplier(const Convention& convention)
        : convention_(convention), size_(std::size_t(convention.size())), weights_(size_), below_(size_) {
        ambientWeights(convention, weights_);
        for (const float w : weights_) norm2_ += w * w;
        if (convention.below == BelowHorizon::kOpen) belowHorizonCoefficients(convention.order, below_);
    }

    void operator()(std::span<float> numbers, std::span<const float> mirrored) const {
        if (convention_.below == BelowHorizon::kMirrored)
            multiplyInMirror(numbers, mirrored);
        else
            multiplyAbove(numbers, mirrored);
        clampAmbient(weights_, norm2_, numbers);
    }

private:
    Convention convention_;
    std::size_t size_;
    std::vector<float> weights_;
    std::vector<double> below_;  // what stands below the horizon of A
    float norm2_ = 0;
    std::vector<int> even_ = evenIndices(kFieldOrder);

    void multiplyInMirror(std::span<float> numbers, std::span<const float> mirrored) const {
        std::array<float, mirroredCount(kMaxOrder)> product;
        const std::span<float> out(product.data(), size_);
        multiplyMirrored(convention_.order, numbers, convention_.order, mirrored, kFieldOrder, out);
        std::copy(out.begin(), out.end(), numbers.begin());
    }

    // What is 0 below the horizon stays 0 there, whatever it is multiplied by.
    void multiplyAbove(std::span<float> numbers, std::span<const float> mirrored) const {
        std::array<double, coefficientCount(kMaxOrder)> above, product;
        std::array<double, coefficientCount(kFieldOrder)> others{};
        for (std::size_t i = 0; i < kFarNumbers; ++i) others[std::size_t(even_[i])] = mirrored[i];
        for (std::size_t i = 0; i < size_; ++i) above[i] = numbers[i] - below_[i];
        const int order = convention_.order;
        penumbra::multiply(order, std::span(above).first(size_), order, others, kFieldOrder,
                           std::span(product).first(size_));
        for (std::size_t i = 0; i < size_; ++i) numbers[i] = float(product[i] + below_[i]);
    }
};

void multiply(const ModelView& model, std::span<const float> mirrored, FrameVertices& vertices) {
    const Multiplier multiplier(model.convention);
    for (std::size_t v = 0; v < vertices.positions.size(); ++v)
        multiplier(
            std::span(vertices.numbers).subspan(v * std::size_t(model.stride), std::size_t(model.convention.size())),
            mirrored.subspan(v * kFarNumbers, kFarNumbers));
}

}  // namespace

FrameVertices memberVertices(const PosedScene& scene, std::size_t index, int threads) {
    const SceneMember& member = *scene.members()[index];
    FrameVertices vertices;
    skinFrame(member.evaluator, threads, vertices);
    evaluateNumbers(member.evaluator, threads, vertices);
    const Mat3 turn = member.to_scene.linear();
    for (Vec3& p : vertices.positions) p = member.to_scene.point(p);
    for (std::vector<Vec3>* directions : {&vertices.normals, &vertices.tangents})
        for (Vec3& d : *directions) d = turn * d;
    std::vector<float> mirrored;
    if (castOn(scene.cast(), {.except = member.caster}, {vertices.positions, vertices.normals, vertices.tangents},
               threads, mirrored) > 0)
        multiply(member.asset->view.model, mirrored, vertices);
    return vertices;
}

GroundVertices groundVertices(const PosedScene& scene, int threads) {
    const SceneGround& ground = *scene.file().ground;
    const auto side = std::uint32_t(ground.resolution);
    GroundVertices out;
    for (std::uint32_t i = 0; i < side; ++i)
        for (std::uint32_t j = 0; j < side; ++j) {
            const double x = ground.size * (double(i) / (side - 1) - 0.5),
                         z = ground.size * (double(j) / (side - 1) - 0.5);
            out.positions.push_back(toFloat(Vec3d{ground.centre.x + x, ground.height, ground.centre.z + z}));
        }
    out.normals.assign(out.positions.size(), {0, 1, 0});
    out.tangents.assign(out.positions.size(), {0, 0, 1});
    for (std::uint32_t i = 0; i + 1 < side; ++i)
        for (std::uint32_t j = 0; j + 1 < side; ++j) {
            const std::uint32_t a = i * side + j, b = a + side;
            out.triangles.insert(out.triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
        }
    castOn(scene.cast(), {}, {out.positions, out.normals, out.tangents}, threads, out.mirrored);
    return out;
}

std::vector<float> groundAmbient(const GroundVertices& ground) {
    std::array<float, kFarNumbers> weights;
    ambientWeights(parseConvention("D" + std::to_string(kFieldOrder)), weights);
    std::vector<float> e(ground.positions.size());
    for (std::size_t v = 0; v < e.size(); ++v)
        for (std::size_t i = 0; i < kFarNumbers; ++i) e[v] += weights[i] * ground.mirrored[v * kFarNumbers + i];
    return e;
}

std::vector<Vec3> groundRadiance(const PosedScene& scene, const GroundVertices& ground) {
    // All vertices have one frame, so that irradiance is one weighted sum of the numbers: w_i = integral over the
    // hemisphere of L cos y_i.
    const LightView& light = *scene.light();
    const Vec3d n = toDouble(ground.normals.front()), t = toDouble(ground.tangents.front()), b = cross(n, t);
    const Mat3d to_light = transposed(scene.lightRotation());
    const std::vector<int> even = evenIndices(kFieldOrder);
    std::array<Vec3d, kFarNumbers> weights{};
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
    const Vec3d albedo = toDouble(scene.file().ground->albedo) * (1 / std::numbers::pi);
    std::vector<Vec3> out;
    for (std::size_t v = 0; v < ground.positions.size(); ++v) {
        Vec3d irradiance;
        for (std::size_t i = 0; i < kFarNumbers; ++i)
            irradiance += weights[i] * double(ground.mirrored[v * kFarNumbers + i]);
        Vec3 radiance = toFloat(albedo * irradiance);
        for (int c = 0; c < 3; ++c) radiance[c] = std::max(radiance[c], 0.0f);
        out.push_back(radiance);
    }
    return out;
}

}  // namespace penumbra
