#include "pack/pack_indirect.h"

#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "pack/compress/compress_model.h"
#include "runtime/evaluate/evaluator.h"

namespace penumbra {

namespace {

// Calls body(evaluator) for every training frame.
template <class Body>
void overTraining(const AssetView& asset, Evaluator& evaluator, const Body& body) {
    const AnimationView& animation = asset.animation;
    for (const ClipView& clip : animation.clips) {
        if (clip.held_out) continue;
        throwIfInterrupted();
        for (std::size_t f = clip.first_frame; f < clip.first_frame + std::size_t(clip.frame_count); ++f) {
            evaluator.setPose(animation.bonesOf(f), animation.poseOf(f));
            body(f);
        }
    }
}

// Turns every cluster to the principal axes of its predictions. Returns the energies of its components.
std::vector<std::vector<double>> rankComponents(Model& model, const WriteAttempt& write) {
    const std::vector<std::byte> bytes = write(model, AssetPrecision::kF32, {AssetPrecision::kF32});
    const AssetView asset = openAsset(bytes);
    Evaluator evaluator(asset);
    std::vector<std::vector<float>> scores(model.indirect->clusters.size());
    overTraining(asset, evaluator, [&](std::size_t) {
        for (std::size_t c = 0; c < scores.size(); ++c) {
            const std::span<const float> y = evaluator.indirectScores(c);
            scores[c].insert(scores[c].end(), y.begin(), y.end());
        }
    });
    std::vector<std::vector<double>> energies;
    for (std::size_t c = 0; c < scores.size(); ++c)
        energies.push_back(turnToPrincipalAxes(model.indirect->clusters[c], scores[c]));
    return energies;
}

std::size_t sectionBytes(std::span<const std::byte> bytes) {
    const AssetView asset = openAsset(bytes);
    for (const SizeOf& size : sectionSizes(asset, bytes.size()))
        if (size.section == kBouncedSection) return size.bytes;
    return 0;
}

// The bytes of one component of each cluster with its row of the weights.
std::vector<double> bytesOfComponents(const IndirectView& indirect) {
    std::vector<double> bytes;
    for (const ClusterView& c : indirect.clusters)
        bytes.push_back(double(c.vertex_count) * kIndirectStride + 8 +
                        double(c.units * bytesPerNumber(c.weights.precision)));
    return bytes;
}

Model chosen(const Model& model, const ComponentChoice& choice) {
    Model smaller = model;
    for (std::size_t c = 0; c < choice.kept.size(); ++c) keepComponents(smaller.indirect->clusters[c], choice.kept[c]);
    return smaller;
}

// Compares two assets of the same light, which may have different components.
double differenceOf(std::span<const std::byte> packed, std::span<const std::byte> exact) {
    const AssetView a = openAsset(packed), b = openAsset(exact);
    Evaluator evaluate_a(a), evaluate_b(b);
    std::vector<float> of_a(a.mesh.positions.size() * kIndirectStride), of_b(of_a.size());
    std::vector<double> sum(of_a.size());
    double difference = 0, signal = 0, frames = 0;
    overTraining(b, evaluate_b, [&](std::size_t f) {
        evaluate_a.setPose(b.animation.bonesOf(f), b.animation.poseOf(f));
        for (std::size_t c = 0; c < evaluate_a.clusterCount(); ++c) {
            evaluate_a.evaluateIndirect(c, of_a);
            evaluate_b.evaluateIndirect(c, of_b);
        }
        for (std::size_t i = 0; i < of_a.size(); ++i) {
            difference += (double(of_a[i]) - of_b[i]) * (double(of_a[i]) - of_b[i]);
            signal += double(of_b[i]) * of_b[i];
            sum[i] += of_b[i];
        }
        ++frames;
    });
    for (const double s : sum) signal -= s * s / std::max(frames, 1.0);
    return signal > 0 ? std::sqrt(difference / signal) : 0;
}

// Leaves out the groups that no unit of an additive model sees. They only tell how far a pose is out of range, which
// the model of the visibility does already.
void dropUnseenGroups(ClusterModel& cluster) {
    if (cluster.unit_group.empty() || cluster.groups.empty()) return;
    const std::size_t size = cluster.group_min.size() / cluster.groups.size();
    std::vector<std::uint32_t> place(cluster.groups.size());
    std::vector<bool> seen(cluster.groups.size());
    for (const std::uint32_t group : cluster.unit_group) seen[group] = true;
    std::size_t kept = 0;
    for (std::size_t g = 0; g < seen.size(); ++g) {
        if (!seen[g]) continue;
        place[g] = std::uint32_t(kept);
        cluster.groups[kept] = cluster.groups[g];
        cluster.group_weight[kept] = cluster.group_weight[g];
        for (std::vector<float>* range : {&cluster.group_min, &cluster.group_max})
            std::copy_n(range->begin() + std::ptrdiff_t(g * size), size, range->begin() + std::ptrdiff_t(kept * size));
        ++kept;
    }
    cluster.groups.resize(kept);
    cluster.group_weight.resize(kept);
    cluster.group_min.resize(kept * size);
    cluster.group_max.resize(kept * size);
    for (std::uint32_t& group : cluster.unit_group) group = place[group];
}

// Ranks the components, and drops as many as the bound asks for. Units go with the last component of a cluster, so how
// many bytes to drop is searched for.
void dropComponents(Model& model, AssetPrecision precision, double bytes_per_vertex, const PackedIndirect& packed,
                    const WriteAttempt& write) {
    const std::vector<std::vector<double>> energies = rankComponents(model, write);
    const std::vector<std::byte> ranked = write(model, precision, packed);
    ComponentCosts costs{energies, bytesOfComponents(*openAsset(ranked).model.indirect)};
    costs.least.assign(energies.size(), 0);
    const double vertices = double(model.mesh.vertexCount()), bound = bytes_per_vertex * vertices;
    if (double(sectionBytes(ranked)) <= bound) return;
    double too_little = 0, enough = 0;
    for (std::size_t c = 0; c < energies.size(); ++c) enough += costs.bytes[c] * double(energies[c].size());
    Model smaller = chosen(model, dropForBytes(costs, enough));
    const double least = double(sectionBytes(write(smaller, precision, packed)));
    if (least > bound)
        throw BadOption("bounce_bytes", "the means of the light that bounces alone take " +
                                            std::to_string(least / vertices) + " bytes a vertex, the bound is " +
                                            std::to_string(bytes_per_vertex));
    for (int step = 0; step < 8; ++step) {
        throwIfInterrupted();
        const double middle = (too_little + enough) / 2;
        Model attempt = chosen(model, dropForBytes(costs, middle));
        const bool fits = double(sectionBytes(write(attempt, precision, packed))) <= bound;
        (fits ? enough : too_little) = middle;
        if (fits) smaller = std::move(attempt);
    }
    model = std::move(smaller);
}

}  // namespace

PackedIndirect shrinkIndirect(Model& model, AssetPrecision precision, std::optional<double> bytes_per_vertex,
                              const WriteAttempt& write) {
    PackedIndirect packed;
    packed.weights = precision == AssetPrecision::kF32 ? precision : AssetPrecision::kF16;
    for (ClusterModel& cluster : model.indirect->clusters) dropUnseenGroups(cluster);
    const Model whole = model;
    // 1. Weights that are too large for a half, or that nearly cancel one another, stay as they are.
    constexpr double kFelt = 0.1, kSafeHalf = 60000;
    const std::vector<std::byte> exact = write(whole, AssetPrecision::kF32, {AssetPrecision::kF32});
    for (const ClusterModel& cluster : model.indirect->clusters) {
        packed.all_components += cluster.components();
        for (const std::vector<float>* coefficients : {&cluster.weights, &cluster.hidden})
            for (const float x : *coefficients)
                if (std::abs(x) > kSafeHalf) packed.weights = AssetPrecision::kF32;
    }
    if (packed.weights == AssetPrecision::kF16 &&
        differenceOf(write(whole, AssetPrecision::kF32, {AssetPrecision::kF16}), exact) > kFelt)
        packed.weights = AssetPrecision::kF32;
    // 2. Drop what does not fit, and measure what rounding and dropping cost.
    if (bytes_per_vertex) dropComponents(model, precision, *bytes_per_vertex, packed, write);
    for (const ClusterModel& cluster : model.indirect->clusters) packed.components += cluster.components();
    packed.error = differenceOf(write(model, precision, packed), exact);
    return packed;
}

}  // namespace penumbra
