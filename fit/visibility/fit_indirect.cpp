// Learns indirect transfer as visibility is learned.
//
// Problem: predict what a vertex gets by reflection from the rest of the character, in poses that nobody baked.
//
// Naive: bounce light at run time between predicted vertices. That takes a sparse matrix a pose, which is to be
// predicted too.
//
// Here: the sum of all bounces is one smooth function of directions for each vertex. In the local frame it changes for
// the same reason as visibility does: other bones come near. So clusters, frames and regression are those of
// visibility. Albedo is baked in; colours have few principal axes (sh/indirect_coefficients.h), and one PCA over all
// vertices and numbers of a cluster reduces what is left.
#include "fit/visibility/fit_indirect.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/numerics/cross_validation.h"
#include "fit/visibility/fit_batches.h"
#include "fit/visibility/predict.h"
#include "fit/visibility/split_frames.h"
#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/stage/pose_file.h"
#include "sh/symmetric_eigen.h"

namespace penumbra {

namespace {

// Returns the frame of the model that each frame of the bake is.
std::vector<std::size_t> framesOfModel(const Model& model, const FrameList& bake, const std::string& file) {
    std::vector<std::size_t> found;
    for (std::size_t b = 0; b < bake.frameCount(); ++b) {
        const std::string& clip = bake.clip_names[bake.clip[b]];
        std::size_t f = 0;
        while (f < model.frames.frameCount() && (model.frames.clip_names[model.frames.clip[f]] != clip ||
                                                 std::abs(model.frames.time[f] - bake.time[b]) > kSameTime))
            ++f;
        if (f == model.frames.frameCount())
            throw InvalidInput(file + ": /frames: clip '" + clip + "', " + std::to_string(bake.time[b]) +
                               " s is no frame of the model: bake transfer with the clips and the fps of the "
                               "visibility, or some of its frames");
        found.push_back(f);
    }
    return found;
}

// Returns the poses of the bake's frames as the model has them.
PoseTable posesOf(const Model& model, std::span<const std::size_t> frames) {
    PoseTable poses;
    poses.joints = model.skin.jointCount();
    poses.pose_size = std::size_t(model.pose_size);
    poses.skin = model.skin;
    poses.joint_centers = model.joint_centers;
    poses.input_joints = model.input_joints;
    poses.deforming = model.deforming;
    const auto append = [](auto& to, const auto& from, std::size_t frame, std::size_t size) {
        to.insert(to.end(), from.begin() + std::ptrdiff_t(frame * size),
                  from.begin() + std::ptrdiff_t((frame + 1) * size));
    };
    for (const std::size_t f : frames) {
        append(poses.bones, model.bones, f, poses.joints);
        append(poses.pose, model.pose, f, poses.pose_size);
        if (!model.deforming) continue;
        const std::size_t fronts = model.mesh.frontVertexCount(), first = poses.positions.size();
        append(poses.positions, model.positions, f, fronts);
        const std::vector<Vec3> normals =
            vertexNormals(model.mesh.frontTriangles(), std::span(poses.positions).subspan(first, fronts));
        poses.normals.insert(poses.normals.end(), normals.begin(), normals.end());
    }
    poses.rotations = rotationsOf(poses.bones);
    return poses;
}

// Energies of one frame, over vertices, channels and coefficients.
struct FrameEnergy {
    double direct = 0, indirect = 0;
    double left = 0;  // of the indirect transfer, what its numbers leave out
};

// Returns the principal axes of the colours of the indirect transfer over some frames, the largest first.
ColorAxes colorAxes(const VisibilityReader& reader, std::span<const std::size_t> train) {
    constexpr std::size_t kMaxSampledFrames = 16;
    const std::size_t n2 = reader.header().coefficientCount(),
                      step = (train.size() + kMaxSampledFrames - 1) / kMaxSampledFrames;
    std::array<double, 9> scatter{}, vectors{};
    for (std::size_t i = 0; i < train.size(); i += step) {
        const std::vector<float> t = reader.readFrame(train[i]).indirect;
        for (std::size_t at = 0; at < t.size(); at += 3 * n2)
            for (std::size_t k = 0; k < kIndirectCoefficients; ++k)
                for (std::size_t a = 0; a < 3; ++a)
                    for (std::size_t b = 0; b < 3; ++b)
                        scatter[3 * a + b] += double(t[at + a * n2 + k]) * t[at + b * n2 + k];
    }
    diagonalise(3, scatter, vectors);
    std::array<std::size_t, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return scatter[4 * a] > scatter[4 * b]; });
    ColorAxes axes;
    for (int k = 0; k < 3; ++k) {
        const double* v = vectors.data() + 3 * order[std::size_t(k)];
        const double sign = v[0] + v[1] + v[2] < 0 ? -1 : 1;
        for (int c = 0; c < 3; ++c) axes(k, c) = float(sign * v[c]);
    }
    return axes;
}

// Rotations keep the energy of a band, so the model frame will do.
FrameEnergy energyOf(const VisibilityFrame& frame, const ColorAxes& axes, std::size_t n2) {
    FrameEnergy energy;
    double kept = 0;
    std::array<float, kIndirectSize> coefficients;
    for (const float t : frame.coefficients) energy.direct += 3.0 * double(t) * t;
    for (const float t : frame.indirect) energy.indirect += double(t) * t;
    for (std::size_t at = 0; at < frame.indirect.size(); at += 3 * n2) {
        toIndirectCoefficients(axes, std::span(frame.indirect).subspan(at, 3 * n2), coefficients);
        for (const float t : coefficients) kept += double(t) * t;
    }
    energy.left = std::max(0.0, energy.indirect - kept);
    return energy;
}

// Sums of errors over clusters and some frames.
struct ErrorSums {
    double squared = 0, variance = 0, ambient = 0, direct = 0, indirect = 0, left = 0;
};

ErrorSums sumErrors(const std::vector<ClusterFit>& fits, std::span<const FrameEnergy> energies,
                    std::span<const std::size_t> frames) {
    ErrorSums sums;
    for (const std::size_t f : frames) {
        for (const ClusterFit& fit : fits) {
            sums.squared += fit.errors.squared[f];
            sums.variance += fit.errors.variance[f];
            sums.ambient += fit.errors.ambient[f];
        }
        sums.direct += energies[f].direct;
        sums.indirect += energies[f].indirect;
        sums.left += energies[f].left;
    }
    return sums;
}

IndirectShares sharesOf(const ErrorSums& sums, double points) {
    if (!(sums.direct > 0)) return {};
    return {std::sqrt(sums.indirect / sums.direct), std::sqrt((sums.variance + sums.left) / sums.direct),
            std::sqrt((sums.squared + sums.left) / sums.direct), sums.ambient / points};
}

double relative(const ErrorSums& sums) { return sums.variance > 0 ? std::sqrt(sums.squared / sums.variance) : 0; }

}  // namespace

void checkIndirectFit(const Model& model, const VisibilityHeader& header, const std::string& file) {
    if (header.quantity != kDiffuseTransfer)
        throw InvalidInput(file + ": quantity '" + header.quantity +
                           "': indirect light needs a bake of transfer with bounces");
    if (!header.hasBounces()) throw InvalidInput(file + ": bounces: 0, so that no light is reflected; bake with 3");
    if (header.order < kIndirectOrder)
        throw InvalidInput(file + ": sh_order: " + std::to_string(header.order) + "; indirect light needs order " +
                           std::to_string(kIndirectOrder));
    checkCharacter(model, header, file);
    if (header.mesh.rest_positions != model.mesh.rest_positions)
        throw InvalidInput(file + ": /mesh/rest_positions is not that of the model: the bake is of another character");
    framesOfModel(model, header.frames, file);
    for (std::size_t f = 0; f < header.frames.frameCount(); ++f)
        if (!isHeldOut(model.holdout_clips, header.frames, f)) return;
    throw BadOption("bake", file + ": the model holds out all of its clips; no frame is left to train on");
}

IndirectFit fitIndirect(const Model& model, const VisibilityReader& reader, const std::string& file,
                        const IndirectFitOptions& options, const FitObserver& observer) {
    const VisibilityHeader& header = reader.header();
    checkIndirectFit(model, header, file);
    const auto phase = [&](const char* name) {
        throwIfInterrupted();
        if (observer.phase) observer.phase(name);
    };
    // 1. The poses, and which of them are trained on.
    phase("poses");
    const PoseTable poses = posesOf(model, framesOfModel(model, header.frames, file));
    Split split;
    for (std::size_t f = 0; f < poses.frameCount(); ++f)
        (isHeldOut(model.holdout_clips, header.frames, f) ? split.held_out : split.train).push_back(f);
    // 2. The colours.
    phase("colours");
    IndirectFit result;
    result.model.bounces = header.bounces;
    result.model.axes = colorAxes(reader, split.train);
    std::vector<FrameEnergy> energies;
    for (std::size_t f = 0; f < poses.frameCount(); ++f) {
        throwIfInterrupted();
        energies.push_back(energyOf(reader.readFrame(f), result.model.axes, header.coefficientCount()));
    }
    // 3. Every cluster.
    phase("fit");
    FitOptions as_of_model;
    as_of_model.model = model.kind;
    as_of_model.features = model.features;
    as_of_model.input_variance = model.input_variance;
    as_of_model.output_variance = options.output_variance;
    as_of_model.threads = options.threads;
    VertexClusters clusters{model.cluster_of_vertex, {}, jointsOfClusters(model)};
    for (const ClusterModel& cluster : model.clusters) clusters.vertices.push_back(cluster.vertices);
    const FitJob job{reader,
                     as_of_model,
                     observer,
                     poses,
                     clusters,
                     split,
                     makeFolds(header.frames, split.train),
                     &result.model.axes};
    std::vector<ClusterFit> fits = fitClusters(job, model);
    // 4. The errors.
    IndirectReport& report = result.report;
    const double vertices = double(model.mesh.vertexCount());
    const ErrorSums of_train = sumErrors(fits, energies, split.train),
                    of_held_out = sumErrors(fits, energies, split.held_out);
    report.train_frames = split.train.size();
    report.held_out_frames = split.held_out.size();
    report.train = sharesOf(of_train, vertices * double(split.train.size()));
    report.held_out = sharesOf(of_held_out, vertices * double(split.held_out.size()));
    report.train_error = relative(of_train);
    report.held_out_error = relative(of_held_out);
    double validated = 0;
    for (ClusterFit& fit : fits) {
        validated += fit.cross_validated;
        result.model.clusters.push_back(std::move(fit.model));
    }
    report.cross_validated_error = of_train.variance > 0 ? std::sqrt(validated / of_train.variance) : 0;
    result.model.train_share = report.train.model;
    result.model.holdout_share =
        split.held_out.empty() ? std::numeric_limits<double>::quiet_NaN() : report.held_out.model;
    return result;
}

}  // namespace penumbra
