#include "fit/visibility/choose_near.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/common/parallel_for.h"
#include "formats/common/spread_evenly.h"

namespace penumbra {

namespace {

// Vertices of a part, and training frames, that the choice looks at.
constexpr std::size_t kSampledVertices = 64, kSampledFrames = 32;
// Clusters that cross-validation fits, and groups of training frames that it holds out in turn.
constexpr std::size_t kSampledClusters = 4;
constexpr int kGroups = 3;
// Opening hidden vertices may cost this factor of the error: it mends dark spots, which people see and a mean does not.
constexpr double kOpeningMayCost = 1.01;

// The variance over poses of what a part leaves visible at some vertices, summed over their numbers.
double variationOf(const FarTables& far, const VertexSet& vertices, std::span<const SetPose> poses,
                   std::uint16_t part) {
    const std::vector<std::uint16_t> everywhere(far.partCount(), part);
    std::vector<float> factor(vertices.part.size() * kFarCoefficients);
    std::vector<double> sum(factor.size());
    double squares = 0;
    for (const SetPose& pose : poses) {
        nearFactor(far, vertices, pose, everywhere, factor);
        for (std::size_t i = 0; i < factor.size(); ++i) {
            sum[i] += factor[i];
            squares += double(factor[i]) * factor[i];
        }
    }
    for (const double x : sum) squares -= x * x / double(poses.size());
    return squares;
}

// Returns the local parts of `own` whose visibility varies most at its vertices over the training frames.
std::vector<std::uint16_t> mostVarying(const FitJob& job, const ComposedClusters& shared, std::uint16_t own) {
    const Composition& composition = *shared.model.composition;
    const std::size_t parts = composition.fields.parts.size();
    std::vector<std::uint32_t> vertices;
    for (std::size_t v = 0; v < composition.part_of_vertex.size(); ++v)
        if (composition.part_of_vertex[v] == own) vertices.push_back(std::uint32_t(v));
    if (vertices.empty()) return {};
    const VertexSet set = vertexSet(shared.model, evenSample(vertices, kSampledVertices), job.clusters.joint);
    std::vector<SetPose> poses;
    for (const std::size_t f : evenSample(job.split.train, kSampledFrames))
        poses.push_back(poseOfSet(set, job.poses, f, std::span(shared.posed).subspan(f * parts, parts)));
    std::vector<std::pair<double, std::uint16_t>> found;
    for (std::uint16_t p = 0; p < parts; ++p) {
        if (p == own || int(composition.steps[own * parts + p]) > composition.local_steps) continue;
        const double variation = variationOf(shared.far, set, poses, p);
        if (variation > 0) found.emplace_back(-variation, p);
    }
    std::sort(found.begin(), found.end());
    std::vector<std::uint16_t> most;
    for (std::size_t k = 0; k < std::min(found.size(), kMaxNear); ++k) most.push_back(found[k].second);
    return most;
}

// Gives every part its near parts, with gains of 1.
void addNearParts(const FitJob& job, Model& model) {
    const ComposedClusters shared(job, model);
    std::vector<std::vector<std::uint16_t>> near(shared.far.partCount());
    parallelFor(near.size(), job.options.threads,
                [&](std::size_t p) { near[p] = mostVarying(job, shared, std::uint16_t(p)); });
    Composition& composition = *model.composition;
    for (const std::vector<std::uint16_t>& parts : near)
        composition.near_count = std::max(composition.near_count, parts.size());
    for (std::vector<std::uint16_t>& parts : near) {
        parts.resize(composition.near_count, kNoPart);
        composition.near_parts.insert(composition.near_parts.end(), parts.begin(), parts.end());
    }
    composition.near_gains.assign(composition.part_of_vertex.size() * composition.near_count,
                                  std::uint8_t(1 / kPerGain));
}

// The folds of the training frames, dealt out to a few groups. Each group is foretold from the others.
struct Group {
    Split split;  // its frames are held out
    std::vector<int> folds;
};

std::vector<Group> groupsOf(const FitJob& job) {
    const int folds = *std::max_element(job.folds.begin(), job.folds.end()) + 1;
    std::vector<Group> groups;
    for (int g = 0; g < std::min(folds, kGroups); ++g) {
        Group& group = groups.emplace_back();
        for (std::size_t i = 0; i < job.folds.size(); ++i) {
            const int fold = job.folds[i];
            (fold % kGroups == g ? group.split.held_out : group.split.train).push_back(job.split.train[i]);
            // Folds are numbered without gaps.
            if (fold % kGroups != g) group.folds.push_back(fold - (fold + kGroups - 1 - g) / kGroups);
        }
    }
    return groups;
}

// Sums over held-out frames.
struct HeldOut {
    double variance = 0, with_residual = 0, with_mean = 0, product = 0;

    void add(const ComposedFit& fit, const std::vector<std::size_t>& frames) {
        for (const std::size_t f : frames) {
            variance += fit.errors.variance[f];
            with_residual += fit.errors.squared[f];
            with_mean += fit.with_mean.squared[f];
            product += fit.without_residual.squared[f];
        }
    }
    void add(const HeldOut& other) {
        variance += other.variance;
        with_residual += other.with_residual;
        with_mean += other.with_mean;
        product += other.product;
    }
    // A model keeps of its residual what pays.
    double relativeError() const {
        return variance > 0 ? std::sqrt(std::min({with_residual, with_mean, product}) / variance) : 0;
    }
};

// Finds the relative errors of a model without near parts and of one with them, in which hidden vertices are learned or
// opened.
NearReport crossValidate(const FitJob& job, const Model& without, const Model& with) {
    const std::vector<std::size_t> sample = evenSample(indices(job.clusters.vertices.size()), kSampledClusters);
    const std::vector<ClusterCoefficients> coefficients = readComposedCoefficients(job, without, sample);
    const std::vector<Group> groups = groupsOf(job);
    std::array<ComposedClusters, 3> shared{ComposedClusters(job, without), ComposedClusters(job, with),
                                           ComposedClusters(job, with)};
    shared.back().hidden = HiddenVertices::kOpened;
    const std::size_t ways = shared.size();
    std::vector<HeldOut> found(ways * groups.size() * sample.size());
    parallelFor(found.size(), job.options.threads, [&](std::size_t i) {
        const std::size_t c = i / ways % sample.size();
        const Group& group = groups[i / ways / sample.size()];
        const FitJob part{job.reader, job.options, job.observer, job.poses, job.clusters, group.split, group.folds};
        found[i].add(fitComposedCluster(part, shared[i % ways], sample[c], coefficients[c]), group.split.held_out);
    });
    std::array<HeldOut, 3> sums;
    for (std::size_t i = 0; i < found.size(); ++i) sums[i % ways].add(found[i]);
    return {sums[0].relativeError(), sums[1].relativeError(), sums[2].relativeError()};
}

}  // namespace

NearChoice chooseNearParts(const FitJob& job, Model& model) {
    if (model.deforming || job.options.near == NearUse::kOff) return {};
    Model with = model;
    addNearParts(job, with);
    NearChoice choice;
    if (job.options.near == NearUse::kAuto) {
        // One block of frames cannot foretell another.
        if (with.composition->near_count == 0 || groupsOf(job).size() < 2) return {};
        NearReport report = crossValidate(job, model, with);
        const bool opens = report.hidden_opened <= kOpeningMayCost * report.hidden_learned;
        choice.hidden = opens ? HiddenVertices::kOpened : HiddenVertices::kLearned;
        report.with_near = opens ? report.hidden_opened : report.hidden_learned;
        choice.report = report;
    }
    if (!choice.report || choice.report->with_near < choice.report->local_alone)
        model.composition = std::move(with.composition);
    return choice;
}

}  // namespace penumbra
