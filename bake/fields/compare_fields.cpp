#include "bake/fields/compare_fields.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/common/parallel_for.h"
#include "formats/common/spread_evenly.h"
#include "formats/common/write_file.h"
#include "formats/stage/visibility_file.h"
#include "sh/tangent.h"

namespace penumbra {

FieldReceivers fieldReceivers(const BakeSource& source, const PartTable& table) {
    FieldReceivers out;
    if (!source.rig) return out;
    const Mesh& mesh = source.mesh();
    const std::vector<std::size_t> vertices = spreadEvenly(mesh.vertexCount(), kComparedVertices);
    for (const std::size_t v : vertices) out.part.push_back(table.part_of_vertex[v]);
    out.far_parts = farParts(table.steps, table.partCount(), LocalMoments{}.steps);
    out.rays = std::make_shared<const PartRays>(mesh, source.rig->skin, table);
    const auto add = [&](int clip, double time) {
        SourcePose pose = poseSource(source, clip, time);
        FieldReceivers::Pose taken{std::move(pose.bones), {}, {}};
        for (const std::size_t v : vertices) {
            taken.positions.push_back(pose.positions[v]);
            taken.normals.push_back(pose.normals[v]);
        }
        out.poses.push_back(std::move(taken));
    };
    const FrameList frames = sampleFrames(source, {}, 0);
    const std::vector<int> clips = clipIndices(source, frames.clip_names);
    for (const std::size_t f : spreadEvenly(frames.frameCount(), kComparedFrames))
        add(clips[frames.clip[f]], frames.time[f]);
    return out;
}

namespace {

// Sums of squares of V over the receivers of one pose.
struct PoseSums {
    std::vector<double> part, part_receivers;  // [P]
    double product = 0, receivers = 0;
};

PoseSums comparePose(const FieldReceivers& receivers, const FieldReceivers::Pose& pose, const FarFields& fields,
                     const std::vector<std::vector<std::uint16_t>>& seen) {
    std::vector<PosedPart> posed(fields.tables.size());
    poseParts(fields, pose.bones, posed);
    PoseSums sums{std::vector<double>(posed.size()), std::vector<double>(posed.size())};
    for (std::size_t v = 0; v < receivers.part.size(); ++v) {
        const Vec3 position = pose.positions[v], normal = pose.normals[v];
        if (!std::isfinite(length(position)) || !(length(normal) > 0.5f)) continue;
        const std::vector<std::uint16_t>& parts = seen[receivers.part[v]];
        const FarComparison far =
            compareFar({fields, *receivers.rays, posed}, parts, {position, normal, tangentOf(normal, {})});
        for (const std::uint16_t p : parts) {
            sums.part[p] += far.squares[p];
            ++sums.part_receivers[p];
        }
        for (std::size_t i = 0; i < kFarCoefficients; ++i) {
            const double d = double(far.by_fields[i]) - far.by_rays[i];
            sums.product += d * d / (4 * std::numbers::pi);
        }
        ++sums.receivers;
    }
    return sums;
}

double rootOfMean(double sum, double count) { return count > 0 ? std::sqrt(sum / count) : 0; }

}  // namespace

FieldErrors compareFields(const FieldReceivers& receivers, const PartFields& fields, std::size_t first_part,
                          int threads) {
    const std::size_t own = fields.parts.size();
    FieldErrors errors{std::vector<double>(own), 0};
    if (receivers.poses.empty()) return errors;
    // 1. Parts of other shards have no field, and no receiver sees them.
    FarFields all;
    all.tables.resize(receivers.far_parts.size());
    all.joints.resize(receivers.far_parts.size());
    for (std::size_t p = 0; p < own; ++p) {
        all.tables[first_part + p] = makeFieldTable(fields.parts[p], fields.bytesOf(p), fields.fade);
        all.joints[first_part + p] = fields.parts[p].joint;
    }
    std::vector<std::vector<std::uint16_t>> seen = receivers.far_parts;
    for (std::vector<std::uint16_t>& parts : seen)
        std::erase_if(parts, [&](std::uint16_t p) { return p < first_part || p >= first_part + own; });
    // 2. Pose by pose.
    std::vector<PoseSums> sums(receivers.poses.size());
    parallelFor(sums.size(), threads, [&](std::size_t f) {
        throwIfInterrupted();
        sums[f] = comparePose(receivers, receivers.poses[f], all, seen);
    });
    PoseSums total;
    for (const PoseSums& one : sums) {
        total.product += one.product;
        total.receivers += one.receivers;
    }
    errors.product = rootOfMean(total.product, total.receivers);
    for (std::size_t p = 0; p < own; ++p) {
        double squares = 0, count = 0;
        for (const PoseSums& one : sums) {
            squares += one.part[first_part + p];
            count += one.part_receivers[first_part + p];
        }
        errors.part[p] = rootOfMean(squares, count);
    }
    return errors;
}

}  // namespace penumbra
