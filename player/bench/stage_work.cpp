#include "player/bench/stage_work.h"

#include <algorithm>

#include "sh/far/far_visibility.h"

namespace penumbra {

namespace {

constexpr std::size_t kFloat = sizeof(float);

std::size_t storedBytes(const NumbersView& numbers) { return numbers.count * bytesPerNumber(numbers.precision); }

// Counts PoseFeatures::lookFrom: a point moved, differences, the inverse bone applied, and a product of
// rotations.
double featureFlop(std::size_t joints) { return double(joints - 1) * (18 + 3 + 15 + 3 + 6 + 45 + 3); }

// Counts ModelEvaluator::clampedInputs with boneInputs (sh/pose_inputs.h), then three a number for clamping and what
// it cut off.
double groupFlop(bool bones, std::size_t inputs) {
    return (bones ? 3 + 6 + 2 + 3 + 1 + 45 + 9 : 0) + 3.0 * double(inputs);
}

double regressionFlop(const ModelView& model, const ClusterView& cluster) {
    const bool bones = model.features == FeatureKind::kRelativeBones;
    const double inputs = double(cluster.inputs()), units = double(cluster.units);
    const std::size_t group_inputs = cluster.groups.empty() ? 0 : cluster.group_min.count / cluster.groups.size();
    double flop = double(cluster.groups.size()) * groupFlop(bones, group_inputs);
    switch (model.kind) {
        case ModelKind::kAdditive:
            flop += units * (3 * double(group_inputs) + 2);
            break;
        case ModelKind::kQuadratic:
            flop += inputs * (inputs + 1) / 2;
            break;
        case ModelKind::kNeural:
            flop += units * (2 * inputs + 1);
            break;
        case ModelKind::kLinear:
            break;
    }
    if (model.kind != ModelKind::kAdditive) flop += 2 * double(cluster.input_basis.count);
    return flop + 2 * units * double(cluster.components());
}

// Counts partMotions (sh/rigid_fit.h): sums, then differences, a square and an outer product; and vertexNormals
// (sh/vertex_normals.h): two differences, a cross product and three sums a triangle, then a length.
void addDeformation(const AssetView& asset, StageWork& work) {
    const auto points = double(asset.mesh.pointCount()), triangles = double(asset.mesh.frontTriangles().size()) / 3;
    work.flop += points * (6 + 6 + 5 + 18) + triangles * (6 + 9 + 9) + points * 9;
    work.read +=
        asset.mesh.pointCount() * (2 * sizeof(Vec3) + sizeof(std::uint16_t)) + asset.mesh.frontTriangles().size_bytes();
    work.written += asset.mesh.pointCount() * 2 * sizeof(Vec3);
}

// Counts TransferEvaluator::setPose(): the inputs, the scores of all coefficients, and those of a light.
StageWork transferPoseWork(const TransferView& transfer) {
    StageWork work;
    const std::size_t maps = transfer.reduced() ? transfer.weights.count : 0;
    work.read = transfer.angles.size_bytes() + transfer.pose_basis.size_bytes() + maps * kFloat;
    work.written = transfer.reduced() ? transfer.coefficients() * transfer.outputs() * kFloat : kFloat;
    work.flop = 2 * double(transfer.pose_basis.size() + maps);
    return work;
}

// Counts TransferEvaluator::transfer().
StageWork transferWork(const TransferView& transfer, std::size_t vertices) {
    StageWork work;
    work.read = ((transfer.reduced() ? transfer.basis.count : transfer.weights.count) + transfer.mean.size()) * kFloat;
    work.written = vertices * transfer.coefficients() * kFloat;
    const std::size_t terms = transfer.reduced() ? transfer.outputs() : transfer.inputs() + 1;
    work.flop = 2 * double(vertices * transfer.coefficients() * terms);
    return work;
}

}  // namespace

StageWork poseWork(const AssetView& asset) {
    const ModelView& model = asset.model;
    const std::size_t joints = asset.animation.jointCount();
    StageWork work;
    if (asset.transfer) return transferPoseWork(*asset.transfer);
    work.read = joints * sizeof(Affine);
    if (model.deforming) addDeformation(asset, work);
    int features_of = -1;
    for (const ClusterView& cluster : model.clusters) {
        if (model.features == FeatureKind::kRelativeBones && cluster.joint != features_of)
            work.flop += featureFlop(joints);
        features_of = cluster.joint;
        work.flop += regressionFlop(model, cluster);
        // These were decoded to floats when the evaluator was made.
        for (const NumbersView& numbers :
             {cluster.input_basis, cluster.group_min, cluster.group_max, cluster.hidden, cluster.weights})
            work.read += numbers.count * kFloat;
        work.written += cluster.components() * kFloat;
    }
    if (!model.composition) return work;
    for (const ClusterView& cluster : model.composition->residual) {
        work.flop += regressionFlop(model, cluster);
        for (const NumbersView& numbers : {cluster.group_min, cluster.group_max, cluster.hidden, cluster.weights})
            work.read += numbers.count * kFloat;
        work.written += cluster.components() * kFloat;
    }
    return work;
}

StageWork skinWork(const AssetView& asset) {
    const MeshView& mesh = asset.mesh;
    const std::size_t vertices = mesh.positions.size();
    StageWork work;
    work.read = vertices * 3 * sizeof(Vec3) + mesh.skin_joints.size_bytes() + mesh.skin_weights.size_bytes();
    work.written = vertices * 3 * sizeof(Vec3);
    if (asset.model.deforming) {  // the tangent turned, projected, its length
        work.read += mesh.shading_point.size_bytes();
        work.flop = double(vertices) * (15 + 11 + 9);
        return work;
    }
    const auto used = std::count_if(mesh.skin_weights.begin(), mesh.skin_weights.end(), [](float w) { return w != 0; });
    // This counts blending; a point moved, the cofactor and a normal through it, and its length; the tangent turned
    // and projected, and its length.
    work.flop = 24.0 * double(used) + double(vertices) * ((18 + 27 + 15 + 9) + (15 + 11 + 9));
    return work;
}

namespace {

// Counts far_lanes.cpp. A product has some 200 pairs of two multiplications and 560 multiply-adds.
constexpr double kProductFlop = 200 * 3 + 560 * 2;
// A lookup is 8 corners of 36 numbers; a rotation by bands of 1..11 numbers is 285 multiply-adds.
constexpr double kFarPartFlop = 2 * 8 * 36 + 2 * 285 + 4 * 36;
// Two turns into the local frame (each 3 turns about z and two by a right angle) and an exponential.
constexpr double kFarSumFlop = 2 * (3 * 15 * 6 + 2 * 2 * 80) + 2 * kProductFlop;

}  // namespace

StageWork farWork(const AssetView& asset) {
    const CompositionView& composition = *asset.model.composition;
    StageWork work = skinWork(asset);
    work.read += composition.byteCount() * FieldTable::kStride / kFieldCoefficients;
    work.written = composition.part_of_vertex.size() * kFarCoefficients * kFloat;
    const auto far_parts = farParts(composition.steps, composition.parts.size(), composition.local_steps);
    for (const std::uint16_t part : composition.part_of_vertex)
        work.flop += double(far_parts[part].size() + composition.near_count) * kFarPartFlop + kFarSumFlop;
    return work;
}

StageWork evaluateWork(const AssetView& asset) {
    const ModelView& model = asset.model;
    StageWork work;
    if (asset.transfer) return transferWork(*asset.transfer, asset.mesh.positions.size());
    for (const ClusterView& cluster : model.clusters) {
        work.read += storedBytes(cluster.mean) + storedBytes(cluster.basis) + cluster.components() * kFloat;
        work.written += cluster.mean.count * kFloat;
        work.flop += 2 * double(cluster.basis.count);
    }
    if (!model.composition) return work;
    for (const ClusterView& cluster : model.composition->residual) {
        work.read += cluster.mean.count * kFloat + storedBytes(cluster.basis);
        work.flop += 2 * double(cluster.basis.count);
    }
    const StageWork far = farWork(asset);
    work.read += far.read;
    work.flop += far.flop + double(asset.mesh.positions.size()) * kProductFlop;
    return work;
}

namespace {

// Counts laneBasis (runtime/shade/shade_lanes.cpp).
double basisFlop(int order) {
    const double n = order;
    return n * (n - 1) / 2 * 4 + n * n + 6 * n;
}

// Counts liveTransfer (runtime/shade/shade_live_lanes.h).
double liveFlop(const ShadeLive& live) {
    const double n = live.order, turn = 6 * n * (n - 1) / 2;
    return 2 * double(live.moment_terms + live.turn_terms + live.turn_back_terms + live.matrix_terms) + 2 * turn +
           2 * 6 * (n - 2) + 6 + 39;
}

double materialFlop(const ShadeMaterial& material) {
    if (material.is_live) return liveFlop(material.live);
    double flop = basisFlop(material.view_order);
    for (std::size_t c = 0; c < material.channels; ++c) {
        flop += 2 * double(material.view_terms[c]);
        for (std::size_t r = 0; r < material.row_count; ++r)
            flop += 2.0 * material.rows[r].terms + (r < material.mirrored_rows ? 4 : 2);
    }
    return flop;
}

double lightFlop(const ShadeLight& light, std::size_t channels) {
    const double n = light.order, numbers = n * n, each = double(channels);
    if (light.lobes) return double(light.axis_count) * (15 + basisFlop(light.order) + 2 * each * numbers + 6 * n);
    const double turn = 6 * n * (n - 1) / 2;  // turnBack
    return each * (3 * turn + 4 * double(light.turn_count)) + 3 * 6 * (n - 2) + 6 * numbers;
}

}  // namespace

StageWork shadeWork(const ShadingSet& shading) {
    const ModelView& model = shading.asset().model;
    StageWork work;
    const std::size_t vertices = shading.asset().mesh.positions.size();
    if (const auto& transfer = shading.asset().transfer) {  // the light multiplied in first
        const std::size_t terms = transfer->reduced() ? transfer->outputs() : transfer->inputs() + 1;
        work.read = vertices * (transfer->reduced() ? terms + 1 : 3 * terms) * kFloat;
        work.written = vertices * sizeof(Vec3);
        work.flop = double(vertices) * (6 * double(terms) + 6);
        return work;
    }
    work.written = vertices * shading.terms() * sizeof(Vec3);
    for (std::size_t pass = 0; pass < shading.passes(); ++pass)  // more than one with pictures
        for (std::size_t slot = 0; slot < shading.slotCount(); ++slot) {
            const std::optional<ShadeMaterial> material = shading.materialView(slot, pass);
            if (!material) continue;
            const std::size_t of_slot = shading.vertexCount(slot);
            work.read += of_slot * (3 * sizeof(Vec3) + std::size_t(model.convention.size()) * kFloat);
            // This counts the bitangent, the unit direction to the eye, its way into the local frame, and the colour's
            // factors.
            const double of_vertex = 9 + 3 + 10 + 15 + 3;
            work.flop += double(of_slot) * (of_vertex + materialFlop(*material) +
                                            lightFlop(shading.lightTables().view(), material->channels));
        }
    return work;
}

}  // namespace penumbra
