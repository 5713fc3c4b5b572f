#include "player/frame/visibility_factors.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "formats/common/errors.h"
#include "formats/common/find_by_name.h"
#include "player/frame/frame_values.h"

namespace penumbra {

namespace {

constexpr Convention kFarConvention{BelowHorizon::kMirrored, kFieldOrder};

float ambientOf(const Convention& convention, std::span<const float> coefficients) {
    std::vector<float> weights(std::size_t(convention.size()));
    ambientWeights(convention, weights);
    return std::inner_product(weights.begin(), weights.end(), coefficients.begin(), 0.0f);
}

VisibilityFactor factorOf(FactorChoice choice, const Convention& convention, std::span<const float> coefficients) {
    const std::span<const float> used = coefficients.first(std::size_t(convention.size()));
    return {choice, convention, {used.begin(), used.end()}, ambientOf(convention, used)};
}

// Evaluates factors of one vertex; of one that follows points those of the point that it has most of.
class VertexFactors {
public:
    VertexFactors(const Evaluator& evaluator, std::size_t vertex)
        : evaluator_(evaluator),
          model_(evaluator.asset().model),
          vertex_(evaluator.asset().mesh.leaderOf(vertex)),
          cluster_(clusterAt(evaluator.asset(), vertex)) {
        if (!evaluator.composed()) return;
        const std::size_t count = evaluator.vertexCount();
        std::vector<Vec3> positions(count), normals(count), tangents(count);
        evaluator.skin(vertex_, vertex_ + 1, positions, normals, tangents);
        receiver_ = {positions[vertex_], normals[vertex_], tangents[vertex_]};
    }

    VisibilityFactor whole() const {
        return ofCoefficients(FactorKind::kWhole,
                              [&](std::span<float> out) { evaluator_.evaluateCluster(cluster_, out); });
    }
    VisibilityFactor local() const {
        return ofCoefficients(FactorKind::kLocal,
                              [&](std::span<float> out) { evaluator_.evaluateLocal(cluster_, out); });
    }
    VisibilityFactor far() const {
        std::vector<float> far(evaluator_.vertexCount() * kFarCoefficients);
        evaluator_.evaluateFar(cluster_, far);
        return factorOf({FactorKind::kFar}, kFarConvention, std::span(far).subspan(vertex_ * kFarCoefficients));
    }
    VisibilityFactor residual() const;
    VisibilityFactor part(std::size_t part) const;
    std::span<const std::uint16_t> farParts() const {
        return evaluator_.farTables().partsSeenBy(model_.composition->part_of_vertex[vertex_]);
    }

private:
    const Evaluator& evaluator_;
    const ModelView& model_;
    std::size_t vertex_, cluster_;
    Receiver receiver_;  // only of a composed asset

    template <class Evaluate>
    VisibilityFactor ofCoefficients(FactorKind kind, const Evaluate& evaluate) const {
        const std::size_t stride = std::size_t(model_.stride);
        std::vector<float> coefficients(evaluator_.vertexCount() * stride);
        evaluate(coefficients);
        return factorOf({kind}, model_.convention,
                        std::span<const float>(coefficients).subspan(vertex_ * stride, stride));
    }
};

// The mean plus scores times components, of this vertex alone.
VisibilityFactor VertexFactors::residual() const {
    const ClusterView& cluster = model_.composition->residual[cluster_];
    const std::size_t stride = std::size_t(model_.stride), first = (vertex_ - cluster.first_vertex) * stride;
    std::vector<float> mean(cluster.mean.count), basis(cluster.basis.count);
    decode(cluster.mean, mean);
    decode(cluster.basis, basis);
    const std::span<const float> scores = evaluator_.residualScores(cluster_);
    std::vector<float> sum(mean.begin() + std::ptrdiff_t(first), mean.begin() + std::ptrdiff_t(first + stride));
    for (std::size_t k = 0; k < scores.size(); ++k)
        for (std::size_t i = 0; i < stride; ++i) sum[i] += scores[k] * basis[k * mean.size() + first + i];
    return factorOf({FactorKind::kResidual}, model_.convention, sum);
}

VisibilityFactor VertexFactors::part(std::size_t part) const {
    const auto index = std::uint16_t(part);
    std::array<float, kFarCoefficients> coefficients;
    farVisibility(evaluator_.farTables().fields(), evaluator_.posedParts(), {&index, 1}, receiver_, coefficients);
    return factorOf({FactorKind::kPart, part}, kFarConvention, coefficients);
}

}  // namespace

std::string nameOfPart(const AssetView& asset, std::size_t part) {
    const std::uint32_t joint = asset.model.composition->parts[part].field.joint;
    return joint == kStillJoint ? "still:" + std::to_string(part) : std::string(asset.animation.joint_names[joint]);
}

std::size_t findPart(const AssetView& asset, std::string_view word, const std::string& option) {
    struct Named {
        std::string name;
    };
    std::vector<Named> parts;
    for (std::size_t p = 0; p < asset.model.composition->parts.size(); ++p) parts.push_back({nameOfPart(asset, p)});
    return findByName(parts, word, option);
}

std::string nameOf(const AssetView& asset, const FactorChoice& choice) {
    switch (choice.kind) {
        case FactorKind::kWhole:
            return "whole";
        case FactorKind::kLocal:
            return "local";
        case FactorKind::kFar:
            return "far";
        case FactorKind::kPart:
            return "far: " + nameOfPart(asset, choice.part);
        case FactorKind::kResidual:
            return "residual";
    }
    return "";
}

std::vector<VisibilityFactor> visibilityFactors(const Evaluator& evaluator, std::size_t vertex) {
    const VertexFactors of(evaluator, vertex);
    std::vector<VisibilityFactor> factors = {of.whole()};
    if (!evaluator.composed()) return factors;
    factors.push_back(of.local());
    factors.push_back(of.far());
    if (!evaluator.asset().model.composition->residual.empty()) factors.push_back(of.residual());
    const std::size_t first_part = factors.size();
    for (const std::size_t p : of.farParts()) {
        VisibilityFactor part = of.part(p);
        // farVisibility() leaves the function 1 as it is where a part does not count.
        if (std::any_of(part.coefficients.begin() + 1, part.coefficients.end(), [](float x) { return x != 0; }))
            factors.push_back(std::move(part));
    }
    std::ranges::stable_sort(factors.begin() + std::ptrdiff_t(first_part), factors.end(), {},
                             &VisibilityFactor::ambient);
    return factors;
}

VisibilityFactor visibilityFactor(const Evaluator& evaluator, std::size_t vertex, const FactorChoice& choice) {
    const AssetView& asset = evaluator.asset();
    const VertexFactors of(evaluator, vertex);
    if (choice.kind == FactorKind::kWhole) return of.whole();
    if (!evaluator.composed()) throw BadOption("lobe_of", asset.name + " is not composed; its visibility is one whole");
    if (choice.kind == FactorKind::kLocal) return of.local();
    if (choice.kind == FactorKind::kFar) return of.far();
    if (choice.kind == FactorKind::kResidual) {
        if (asset.model.composition->residual.empty()) throw BadOption("lobe_of", asset.name + " has no residual");
        return of.residual();
    }
    const std::span<const std::uint16_t> parts = of.farParts();
    if (std::find(parts.begin(), parts.end(), choice.part) == parts.end())
        throw BadOption("lobe_of", "part " + nameOfPart(asset, choice.part) + " is not far from vertex " +
                                       std::to_string(vertex) +
                                       " in the skeleton: what it blocks is in the local visibility");
    return of.part(choice.part);
}

FactorChoice parseFactor(const AssetView& asset, std::string_view word) {
    constexpr std::pair<std::string_view, FactorKind> kWords[] = {{"whole", FactorKind::kWhole},
                                                                  {"local", FactorKind::kLocal},
                                                                  {"far", FactorKind::kFar},
                                                                  {"residual", FactorKind::kResidual}};
    if (word == kWords[0].first) return {};
    if (!asset.model.composition)
        throw BadOption("lobe_of", asset.name + " is not composed; its visibility is one whole, without a factor \"" +
                                       std::string(word) + "\"");
    for (const auto& [name, kind] : kWords)
        if (word == name) return {kind};
    return {FactorKind::kPart, findPart(asset, word, "lobe_of")};
}

}  // namespace penumbra
