#include "bake/poses/attached_joints.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "bake/poses/limbs.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

constexpr double kSlides = 0.15, kHangs = 0.02;  // in rest diagonals
constexpr std::size_t kMaxFrames = 256, kMaxTransforms = 1000000;

namespace {

// Where each joint is in each frame.
struct Movement {
    std::size_t frames = 0, joints = 0;
    std::vector<Vec3d> origin;                   // [frames, joints] in model space
    std::vector<std::optional<Matrix>> to_rest;  // [frames, joints] model space to rest space

    // Returns how far joint j moves away from where it is in the first frame, seen from joint `from`. Where that joint
    // is scaled to nothing, it sees nothing.
    double slide(std::size_t j, std::size_t from) const {
        std::optional<Vec3d> first;
        double farthest = 0;
        for (std::size_t f = 0; f < frames; ++f) {
            if (!to_rest[f * joints + from]) continue;
            const Vec3d seen = transformPoint(*to_rest[f * joints + from], origin[f * joints + j]);
            if (!first) first = seen;
            farthest = std::max(farthest, length(seen - *first));
        }
        return farthest;
    }
};

Movement movementOf(const Rig& rig, std::span<const RigFrame> frames, int threads) {
    const std::size_t joints = rig.skin.jointCount();
    Movement out;
    out.joints = joints;
    out.frames = std::min({frames.size(), kMaxFrames, std::max<std::size_t>(2, kMaxTransforms / joints)});
    out.origin.resize(out.frames * joints);
    out.to_rest.resize(out.frames * joints);
    parallelFor(out.frames, threads, [&](std::size_t f) {
        throwIfInterrupted();
        const RigFrame& frame = frames[f * frames.size() / out.frames];
        const std::vector<Matrix> globals = globalTransforms(rig.nodes, nodePoses(rig, frame));
        for (std::size_t j = 0; j < joints; ++j) {
            const Matrix& global = globals[std::size_t(rig.node_of_joint[j])];
            out.origin[f * joints + j] = {global[3], global[7], global[11]};
            out.to_rest[f * joints + j] = inverse(multiply(global, rig.inverse_bind[j]));
        }
    });
    return out;
}

bool isBelow(const Rig& rig, std::size_t joint, std::size_t top) {
    int j = int(joint);
    while (j >= 0 && j != int(top)) j = rig.skin.parents[std::size_t(j)];
    return j >= 0;
}

}  // namespace

std::vector<std::pair<int, int>> attachedJoints(const Rig& rig, std::span<const RigFrame> frames, int threads) {
    const std::vector<char> carries = carryingJoints(rig);
    const Movement movement = movementOf(rig, frames, threads);
    const double diagonal = characterDiagonal(rig.mesh);
    std::vector<std::pair<int, int>> pairs;
    bool is_first_root = true;
    for (std::size_t j = 0; j < movement.joints; ++j) {
        throwIfInterrupted();
        const int parent = rig.skin.parents[j];
        if (!carries[j] || (parent < 0 && std::exchange(is_first_root, false))) continue;
        if (parent >= 0 && movement.slide(j, std::size_t(parent)) <= kSlides * diagonal) continue;
        if (parent >= 0) pairs.emplace_back(int(j), parent);
        double least = kHangs * diagonal;
        int nearest = -1;
        for (std::size_t k = 0; k < movement.joints; ++k) {
            if (!carries[k] || isBelow(rig, k, j)) continue;
            if (const double slide = movement.slide(j, k); slide < least) {
                least = slide;
                nearest = int(k);
            }
        }
        if (nearest >= 0) pairs.emplace_back(int(j), nearest);
    }
    return pairs;
}

}  // namespace penumbra
