#include "player/scene/scene_receivers.h"

#include <algorithm>

#include "player/scene/cast_on.h"
#include "sh/mirrored_product.h"
#include "sh/sh_basis.h"
#include "sh/sh_product.h"

namespace penumbra {

namespace {

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

}  // namespace penumbra
