#include "bake/poses/cover_poses.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "bake/common/random_numbers.h"
#include "bake/poses/pose_features.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

constexpr int kSteps = 2;
constexpr double kPositionWidth = 0.12;  // rest diagonals
constexpr double kRotationWidth = 0.8;   // radians
constexpr std::size_t kPairValues = 12;
constexpr std::size_t kMinPool = 2000, kPoolOfEach = 8;
constexpr std::size_t kPosesPerTask = 64;

namespace {

// Returns, for each bone, its nearest ancestor that moves vertices: an index into the bones, or -1.
std::vector<int> movingParents(const Rig& rig, const MovingBones& bones) {
    std::vector<int> bone_of_joint(rig.skin.jointCount(), -1);
    for (std::size_t b = 0; b < bones.count(); ++b) bone_of_joint[bones.joint[b]] = int(b);
    std::vector<int> parents;
    for (const std::size_t joint : bones.joint) {
        int j = rig.skin.parents[joint];
        while (j >= 0 && bone_of_joint[std::size_t(j)] < 0) j = rig.skin.parents[std::size_t(j)];
        parents.push_back(j < 0 ? -1 : bone_of_joint[std::size_t(j)]);
    }
    return parents;
}

// Returns for each bone those within kSteps of it, ascending, without itself.
std::vector<std::vector<std::size_t>> nearBones(const Rig& rig, const MovingBones& bones) {
    const std::vector<int> parents = movingParents(rig, bones);
    std::vector<std::vector<std::size_t>> linked(bones.count());
    for (std::size_t b = 0; b < bones.count(); ++b) {
        if (parents[b] < 0) continue;
        linked[b].push_back(std::size_t(parents[b]));
        linked[std::size_t(parents[b])].push_back(b);
    }
    std::vector<std::vector<std::size_t>> near(bones.count());
    for (std::size_t b = 0; b < bones.count(); ++b) {
        std::vector<std::size_t> reached{b};
        for (int step = 0; step < kSteps; ++step)
            for (std::size_t i = 0, count = reached.size(); i < count; ++i)
                reached.insert(reached.end(), linked[reached[i]].begin(), linked[reached[i]].end());
        std::sort(reached.begin(), reached.end());
        reached.erase(std::unique(reached.begin(), reached.end()), reached.end());
        std::erase(reached, b);
        near[b] = std::move(reached);
    }
    return near;
}

// Writes where bone `to` is, seen from bone `from`. From a bone that is scaled to nothing others are seen as at rest.
void writePair(const MovingBones& bones, const std::optional<Matrix>& from, const Matrix& to, std::size_t bone,
               std::span<float> out) {
    const Matrix seen = from ? multiply(*from, to) : kIdentityMatrix;
    const Vec3d center = transformPoint(seen, bones.center[bone]) / (kPositionWidth * bones.diagonal);
    for (int i = 0; i < 3; ++i) out[std::size_t(i)] = float(center[i]);
    const Mat3d rotation = matrixOf(decompose(seen).rotation);
    for (std::size_t i = 0; i < 9; ++i) out[3 + i] = float(rotation.m[i] / (kRotationWidth * std::sqrt(2.0)));
}

void writeRow(const Rig& rig, const MovingBones& bones, const std::vector<std::vector<std::size_t>>& near,
              std::span<const float> values, std::span<float> out) {
    const std::vector<Matrix> globals = globalTransforms(rig.nodes, nodePosesOf(values));
    std::vector<Matrix> matrices;
    for (const std::size_t joint : bones.joint)
        matrices.push_back(multiply(globals[std::size_t(rig.node_of_joint[joint])], rig.inverse_bind[joint]));
    std::size_t at = 0;
    for (std::size_t b = 0; b < bones.count(); ++b) {
        const std::optional<Matrix> back = inverse(matrices[b]);
        for (const std::size_t other : near[b]) {
            writePair(bones, back, matrices[other], other, out.subspan(at, kPairValues));
            at += kPairValues;
        }
    }
}

}  // namespace

LocalFeatures localFeatures(const Rig& rig, std::span<const float> values, int threads) {
    const MovingBones bones = movingBones(rig);
    const std::vector<std::vector<std::size_t>> near = nearBones(rig, bones);
    const std::size_t pose_width = rig.nodes.size() * kNodeValues, poses = values.size() / pose_width;
    LocalFeatures out;
    out.share = bones.share;
    out.starts = {0};
    for (const std::vector<std::size_t>& others : near)
        out.starts.push_back(out.starts.back() + kPairValues * others.size());
    if (double(poses) * double(out.width()) * sizeof(float) > kMaxFeatureBytes)
        throw BadOption("cover", std::to_string(poses) +
                                     " poses are too many to compare (more than 2 GiB of features); cover fewer, or "
                                     "list fewer frames");
    out.values.resize(poses * out.width());
    parallelFor(poses, threads, [&](std::size_t p) {
        throwIfInterrupted();
        writeRow(rig, bones, near, values.subspan(p * pose_width, pose_width),
                 std::span(out.values).subspan(p * out.width(), out.width()));
    });
    return out;
}

namespace {

// Twelve sums side by side, which a compiler turns into vector instructions.
float distanceAcrossPairs(std::span<const float> a, std::span<const float> b) {
    std::array<float, kPairValues> sums{};
    for (std::size_t at = 0; at < a.size(); at += kPairValues)
        for (std::size_t i = 0; i < kPairValues; ++i) sums[i] += (a[at + i] - b[at + i]) * (a[at + i] - b[at + i]);
    return std::accumulate(sums.begin(), sums.end(), 0.0f);
}

// Keeps, for every pose and bone, the squared distance to the nearest covered pose, and the share that is open.
class LocalGaps {
public:
    LocalGaps(const LocalFeatures& poses, int threads)
        : poses_(poses),
          threads_(threads),
          bones_(poses.share.size()),
          squared_(poses.poses() * bones_, std::numeric_limits<float>::infinity()),
          open_(poses.poses(), std::numeric_limits<double>::infinity()) {}

    void cover(const LocalFeatures& covered, std::size_t first, std::size_t count) {
        assert(covered.starts == poses_.starts);
        const std::size_t tasks = (poses_.poses() + kPosesPerTask - 1) / kPosesPerTask;
        parallelFor(tasks, threads_, [&](std::size_t task) {
            throwIfInterrupted();
            const std::size_t end = std::min(poses_.poses(), (task + 1) * kPosesPerTask);
            for (std::size_t p = task * kPosesPerTask; p < end; ++p) {
                bool nearer = false;
                for (std::size_t c = first; c < first + count; ++c) nearer |= approach(p, covered.row(c));
                if (nearer) open_[p] = openNow(p);
            }
        });
    }
    std::span<const double> open() const { return open_; }
    double meanOpen() const {
        return open_.empty() ? 0 : std::accumulate(open_.begin(), open_.end(), 0.0) / double(open_.size());
    }

private:
    const LocalFeatures& poses_;
    int threads_;
    std::size_t bones_;
    std::vector<float> squared_;  // [poses, bones]
    std::vector<double> open_;    // [poses]

    // Lowers the distances of a pose. Returns whether one became less.
    bool approach(std::size_t pose, std::span<const float> to) {
        const std::span<const float> from = poses_.row(pose);
        bool nearer = false;
        for (std::size_t b = 0; b < bones_; ++b) {
            const std::size_t start = poses_.starts[b], size = poses_.starts[b + 1] - start;
            const float squared = distanceAcrossPairs(from.subspan(start, size), to.subspan(start, size));
            if (float& least = squared_[pose * bones_ + b]; squared < least) {
                least = squared;
                nearer = true;
            }
        }
        return nearer;
    }
    double openNow(std::size_t pose) const {
        double sum = 0;
        for (std::size_t b = 0; b < bones_; ++b)
            sum -= poses_.share[b] * std::expm1(-0.5 * double(squared_[pose * bones_ + b]));
        return sum;
    }
};

// Returns the pose with the largest open share that is not taken yet, and of equals the first.
std::size_t mostOpen(std::span<const double> open, const std::vector<char>& taken) {
    std::size_t best = taken.size();
    for (std::size_t p = 0; p < taken.size(); ++p) {
        if (taken[p]) continue;
        // Poses without any near bones have no shares: then all are equal.
        if (best == taken.size() || (!open.empty() && open[p] > open[best])) best = p;
    }
    return best;
}

}  // namespace

std::vector<double> openShares(const LocalFeatures& poses, const LocalFeatures& covered, int threads) {
    LocalGaps gaps(poses, threads);
    gaps.cover(covered, 0, covered.poses());
    return {gaps.open().begin(), gaps.open().end()};
}

CoveringPoses coverPoses(const MixSource& source, std::span<const float> covered, std::size_t count, std::uint64_t seed,
                         int threads) {
    // The pool has other poses than mixPoses() gives for the same seed, which may be among the covered ones.
    const std::vector<float> values =
        mixPoses(source, std::max(kMinPool, kPoolOfEach * count), nextRandom(seed), threads);
    const std::size_t width = source.rig.nodes.size() * kNodeValues, pool_size = values.size() / width;
    const LocalFeatures pool = localFeatures(source.rig, values, threads);
    LocalGaps gaps(pool, threads);
    const LocalFeatures known = localFeatures(source.rig, covered, threads);
    gaps.cover(known, 0, known.poses());
    CoveringPoses out;
    out.open_before = gaps.meanOpen();
    std::vector<char> taken(pool_size, 0);
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t best = mostOpen(gaps.open(), taken);
        taken[best] = 1;
        const auto at = values.begin() + std::ptrdiff_t(best * width);
        out.values.insert(out.values.end(), at, at + std::ptrdiff_t(width));
        if (pool.poses() > 0) gaps.cover(pool, best, 1);
    }
    out.open_after = gaps.meanOpen();
    return out;
}

}  // namespace penumbra
