#include "bake/poses/pose_features.h"

#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "formats/rig/rig_matrix.h"
#include "formats/rig/rig_morphs.h"

namespace penumbra {

constexpr double kNearness = 0.02;  // rest diagonals squared
constexpr std::size_t kNeighbours = 24;

MovingBones movingBones(const Rig& rig) {
    std::vector<double> weight(rig.skin.jointCount());
    for (std::size_t i = 0; i < rig.skin.weights.size(); ++i) weight[rig.skin.joints[i]] += rig.skin.weights[i];
    const std::vector<Vec3> centers = jointCenters(rig.mesh, rig.skin);
    MovingBones bones;
    for (std::size_t j = 0; j < weight.size(); ++j) {
        if (weight[j] <= 0) continue;
        bones.joint.push_back(j);
        bones.share.push_back(weight[j] / double(rig.mesh.vertexCount()));
        bones.center.push_back(toDouble(centers[j]));
    }
    bones.diagonal = characterDiagonal(rig.mesh);
    return bones;
}

namespace {
struct Pair {
    std::size_t from, to;  // indices into MovingBones
    double weight = 1;
};

// Computes p_ij for every pair. From a bone that cannot be inverted (it is scaled to nothing) others are seen as at
// rest.
void relativePositions(const Rig& rig, const MovingBones& bones, const std::vector<Pair>& pairs, RigFrame frame,
                       std::span<float> out) {
    const RigPose pose = evaluatePose(rig, frame.clip, frame.time);
    std::vector<Vec3d> moved;
    std::vector<std::optional<Matrix>> to_rest;
    for (std::size_t b = 0; b < bones.count(); ++b) {
        const Matrix bone = toMatrix(pose.bones[bones.joint[b]]);
        moved.push_back(transformPoint(bone, bones.center[b]));
        to_rest.push_back(inverse(bone));
    }
    for (std::size_t p = 0; p < pairs.size(); ++p) {
        const std::optional<Matrix>& back = to_rest[pairs[p].from];
        const Vec3d seen = back ? transformPoint(*back, moved[pairs[p].to]) : bones.center[pairs[p].to];
        for (int i = 0; i < 3; ++i) out[3 * p + std::size_t(i)] = float(seen[i] * pairs[p].weight / bones.diagonal);
    }
}

// Returns the mean squared distance of the centers of every ordered pair, in diagonals, seen from the first: [count,
// count].
std::vector<double> meanSquaredDistances(const Rig& rig, const MovingBones& bones, std::span<const RigFrame> frames,
                                         int threads) {
    const std::size_t n = bones.count();
    std::vector<Pair> all;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) all.push_back({i, j});
    // At most 64 frames, spread over all of them, are enough, since these are only weights.
    const std::size_t used = std::min<std::size_t>(frames.size(), 64);
    std::vector<float> positions(used * all.size() * 3);
    parallelFor(used, threads, [&](std::size_t f) {
        relativePositions(rig, bones, all, frames[f * frames.size() / used],
                          std::span(positions).subspan(f * all.size() * 3, all.size() * 3));
    });
    std::vector<double> mean(all.size());
    for (std::size_t f = 0; f < used; ++f)
        for (std::size_t p = 0; p < all.size(); ++p) {
            const float* at = &positions[(f * all.size() + p) * 3];
            const Vec3d d = Vec3d{at[0], at[1], at[2]} - bones.center[all[p].from] / bones.diagonal;
            mean[p] += dot(d, d) / double(used);
        }
    return mean;
}

// Pairs every bone with its nearest others, each weighted by sqrt(s_i n_ij).
std::vector<Pair> choosePairs(const MovingBones& bones, const std::vector<double>& distances) {
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < bones.count(); ++i) {
        std::vector<std::size_t> others;
        for (std::size_t j = 0; j < bones.count(); ++j)
            if (j != i) others.push_back(j);
        const auto distance = [&](std::size_t j) { return distances[i * bones.count() + j]; };
        std::stable_sort(others.begin(), others.end(),
                         [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
        if (others.size() > kNeighbours) others.resize(kNeighbours);
        double sum = 0;
        for (const std::size_t j : others) sum += std::pow(kNearness + distance(j), -2);
        for (const std::size_t j : others)
            pairs.push_back({i, j, std::sqrt(bones.share[i] / sum) / (kNearness + distance(j))});
    }
    return pairs;
}

// Returns for each morph target the rms move of all vertices at weight 1, in units of `diagonal`.
std::vector<float> morphMoves(const Mesh& mesh, double diagonal) {
    std::vector<float> moves;
    for (std::size_t m = 0; m < mesh.morphs.count(); ++m) {
        double sum = 0;
        for (const Vec3 move : mesh.morphs.rowsOf(m).positions) sum += dot(toDouble(move), toDouble(move));
        moves.push_back(float(std::sqrt(sum / double(mesh.vertexCount())) / diagonal));
    }
    return moves;
}

}  // namespace

PoseFeatures poseFeatures(const Rig& rig, std::span<const RigFrame> frames, int threads) {
    const MovingBones bones = movingBones(rig);
    const std::vector<Pair> pairs = choosePairs(bones, meanSquaredDistances(rig, bones, frames, threads));
    const std::vector<float> moves = morphMoves(rig.mesh, bones.diagonal);
    PoseFeatures out{frames.size(), 3 * pairs.size() + moves.size(), {}};
    if (double(out.frames) * double(out.width) * sizeof(float) > kMaxFeatureBytes)
        throw BadOption("frames", std::to_string(out.frames) +
                                      " are too many to compare (more than 2 GiB of features); use a lower fps");
    out.values.resize(out.frames * out.width);
    parallelFor(frames.size(), threads, [&](std::size_t f) {
        throwIfInterrupted();
        const std::span<float> row = std::span(out.values).subspan(f * out.width, out.width);
        relativePositions(rig, bones, pairs, frames[f], row);
        const std::vector<float> weights = weightsAt(rig, frames[f].clip, frames[f].time);
        for (std::size_t m = 0; m < moves.size(); ++m) row[3 * pairs.size() + m] = weights[m] * moves[m];
    });
    return out;
}

}  // namespace penumbra
