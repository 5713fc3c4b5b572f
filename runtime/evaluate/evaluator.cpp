// Evaluates a model at run time (docs/formulas.md, section 4).
//
// Problem: every frame, turn the skinning matrices of a character into a few numbers of visibility for each vertex,
// in a fraction of a millisecond, on any number of threads.
//
// Naive: evaluate one regression for each vertex. That would read far more coefficients than a frame has time for.
//
// Here: vertices form clusters. setPose() computes for each cluster what its model sees and the cluster's few scores,
// once and on one thread. That is cheap. evaluateCluster() then expands the scores to the vertices (combine.h), which
// is nearly all of the work, and clusters are independent, so that the caller may spread them over threads.
//
// A composed asset expands its scores to what each vertex sees past the nearby parts, multiplies that by what the far
// parts leave visible at the vertex as it is skinned now, and adds the residual (docs/formulas.md, section 7).
#include "runtime/evaluate/evaluator.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string_view>

#include "sh/far/floor_factor.h"
#include "sh/tangent.h"

namespace penumbra {

namespace {

bool hasBytes(const ClusterView& cluster) { return cluster.basis.precision == AssetPrecision::kI8; }

}  // namespace

// Decodes what does not change with the pose, so that many characters of one asset share it.
std::shared_ptr<const Evaluator::Decoded> Evaluator::decode(const AssetView& asset) {
    const auto decoded = std::make_shared<Decoded>();
    Decoded& d = *decoded;
    d.absolute.resize(asset.animation.jointCount());
    if (asset.transfer) return decoded;
    for (const ClusterView& cluster : asset.model.clusters) d.clusters.push_back(&cluster);
    d.first_residual = d.clusters.size();
    if (asset.model.composition)
        for (const ClusterView& cluster : asset.model.composition->residual) d.clusters.push_back(&cluster);
    d.first_indirect = d.clusters.size();
    if (asset.model.indirect)
        for (const ClusterView& cluster : asset.model.indirect->clusters) {
            d.clusters.push_back(&cluster);
            const std::size_t begin = d.indirect_mean.size();
            d.indirect_mean.resize(begin + cluster.mean.count);
            penumbra::decode(cluster.mean, std::span(d.indirect_mean).subspan(begin));
        }
    for (const ClusterView* cluster : d.clusters) {
        const ModelEvaluator& model = d.models.emplace_back(asset.model, *cluster);
        d.first_score.push_back(d.scores);
        d.scores += model.components();
        d.scratch = std::max(d.scratch, model.scratchSize());
        d.first_pair_byte.push_back(d.pairs.size());
        d.first_pair_weight.push_back(d.pair_weights);
        if (!hasBytes(*cluster)) continue;
        appendPairs(reinterpret_cast<const std::int8_t*>(cluster->basis.data), cluster->components(),
                    cluster->mean.count, d.pairs);
        d.pair_weights += (cluster->components() + 1) / 2;
    }
    d.pairs.shrink_to_fit();
    d.ambient_weights.resize(std::size_t(asset.model.stride));
    ambientWeights(asset.model.convention,
                   std::span(d.ambient_weights).first(std::size_t(asset.model.convention.size())));
    for (float weight : d.ambient_weights) d.ambient_norm2 += weight * weight;
    for (const InputJointView& input : asset.model.input_joints)
        d.absolute[std::size_t(input.joint)] = input.absolute();
    if (asset.model.deforming) d.deformation = std::make_unique<Deformation>(asset);
    if (asset.model.composition) d.composed = std::make_unique<Composed>(asset);
    return decoded;
}

namespace {

std::array<FarLayout, 2> layoutsOf(const AssetView& asset, const FarTables& tables) {
    std::vector<std::size_t> part_counts;
    for (std::size_t p = 0; p < tables.partCount(); ++p) part_counts.push_back(tables.partsSeenBy(p).size());
    return {makeFarLayout(asset, part_counts, FarQuality::kFull), makeFarLayout(asset, part_counts, FarQuality::kFast)};
}

}  // namespace

Evaluator::Composed::Composed(const AssetView& asset)
    : far(makeFarTables(*asset.model.composition, asset.model.convention.order)), layouts(layoutsOf(asset, far)) {
    for (const ClusterView& cluster : asset.model.composition->residual) {
        const std::size_t begin = residual_mean.size();
        residual_mean.resize(begin + cluster.mean.count);
        penumbra::decode(cluster.mean, std::span(residual_mean).subspan(begin));
    }
}

const FarLayout& Evaluator::castLayout() const {
    std::call_once(decoded_->cast_once, [&] { decoded_->cast = makeCastLayout(*asset_); });
    return decoded_->cast;
}

Evaluator::Evaluator(const AssetView& asset) : asset_(&asset), decoded_(decode(asset)), path_(evaluatorPaths().back()) {
    assert(asset.hasCharacter());
    if (asset.transfer) transfer_.emplace(asset);
    scratch_.resize(decoded_->scratch);
    bones_.resize(asset.animation.jointCount());
    bone_rotations_.resize(bones_.size());
    rotations_.resize(clusterCount());
    if (asset.model.features == FeatureKind::kRelativeBones) features_.resize(12 * (bones_.size() - 1));
    scores_.resize(decoded_->scores);
    std::size_t components = 0;
    for (const ClusterView* cluster : decoded_->clusters) components = std::max(components, cluster->components());
    weights_.resize(components);
    pair_weights_.resize(decoded_->pair_weights);
    units_.resize(decoded_->clusters.size());
    if (composed()) {
        far_pose_ = FarPose(decoded_->composed->far);
        far_.resize(vertexCount() * kFarNumbers);
        std::size_t values = 0;
        for (const FarLayout& layout : decoded_->composed->layouts) values = std::max(values, layout.values);
        anchors_.resize(values);
    }
    if (!decoded_->deformation) return;
    const std::span<const Vec3> rest = decoded_->deformation->rest();
    points_.assign(rest.begin(), rest.end());
    point_normals_.resize(rest.size());
    fitted_bones_.resize(bones_.size());
    if (asset.model.features == FeatureKind::kDihedrals) pose_.resize(asset.animation.pose_size);
    deformation_scratch_ = decoded_->deformation->scratch();
    decoded_->deformation->normals(points_, deformation_scratch_, point_normals_);
}

void Evaluator::usePath(const EvaluatorPath& path) {
    path_ = path;
    const std::vector<TransferPath> paths = transferPaths();
    if (transfer_) transfer_->usePath(std::string_view(path.name) == paths.front().name ? paths.front() : paths.back());
}

// Computes M_c^-1 M_j centre_j - centre_j in units of feature_scale and R_c^T R_j - I, for every joint j but c
// (model_file.h). From a bone that cannot be inverted (scaled to nothing) others are seen where its rotation alone
// would put them. A joint that stands for a number is seen as it is.
void Evaluator::relativeBoneFeatures(std::size_t joint) {
    const Mat3 linear = bones_[joint].linear(), adjugate = transposed(cofactor(linear));
    const float determinant =
        dot(Vec3{linear.m[0], linear.m[1], linear.m[2]}, Vec3{adjugate.m[0], adjugate.m[3], adjugate.m[6]});
    const Mat3 to_rest = transposed(bone_rotations_[joint]);
    const float scale = 1 / asset_->model.feature_scale;
    float* out = features_.data();
    for (std::size_t j = 0; j < bones_.size(); ++j) {
        if (j == joint) continue;
        const Vec3 centre = asset_->model.joint_centers[j];
        if (decoded_->absolute[j]) {
            const Vec3 moved = (bones_[j].point(centre) - centre) * scale;
            for (int i = 0; i < 3; ++i) *out++ = moved[i];
            out = std::fill_n(out, 9, 0.0f);
            continue;
        }
        const Vec3 offset = bones_[j].point(centre) - bones_[joint].translation();
        const Vec3 seen = determinant != 0 ? (adjugate * offset) / determinant : to_rest * offset;
        const Vec3 moved = (seen - centre) * scale;
        const Mat3 turned = to_rest * bone_rotations_[j];
        for (int i = 0; i < 3; ++i) *out++ = moved[i];
        for (int i = 0; i < 9; ++i) *out++ = turned.m[i] - (i % 4 == 0 ? 1.0f : 0.0f);
    }
}

void Evaluator::setPose(std::span<const Affine> bones, std::span<const float> pose) {
    const ModelView& model = asset_->model;
    const bool angles = model.features != FeatureKind::kRelativeBones;
    assert(bones.size() == bones_.size() && (!angles || pose.size() == asset_->animation.pose_size));
    std::copy(bones.begin(), bones.end(), bones_.begin());
    for (std::size_t j = 0; j < bones.size(); ++j) bone_rotations_[j] = nearestRotation(bones[j].linear());
    if (transfer_) {
        for (Mat3& rotation : rotations_) rotation = bone_rotations_[0];
        return transfer_->setPose(pose);
    }
    int features_of = -1;  // the joint whose features are in features_
    // Neighbouring clusters often share a joint, so its features are computed once for all of them.
    double out_of_range = 0;
    for (std::size_t c = 0; c < clusterCount(); ++c) {
        const ClusterView& cluster = model.clusters[c];
        rotations_[c] = bone_rotations_[std::size_t(cluster.joint)];
        if (!angles && features_of != cluster.joint) relativeBoneFeatures(std::size_t(cluster.joint));
        features_of = cluster.joint;
        const std::span<const float> seen = angles ? pose : std::span<const float>(features_);
        regress(c, seen, out_of_range);
        double ignored = 0;  // the range of a composed model is that of its local features
        if (decoded_->first_indirect > decoded_->first_residual) regress(decoded_->first_residual + c, seen, ignored);
        if (hasIndirect()) regress(decoded_->first_indirect + c, seen, ignored);
    }
    out_of_range_ = std::sqrt(out_of_range / double(vertexCount()));
    if (composed()) far_pose_.set(decoded_->composed->far, bones_);
}

void Evaluator::regress(std::size_t cluster, std::span<const float> seen, double& out_of_range) {
    const ClusterView& view = *decoded_->clusters[cluster];
    const std::span<float> y = std::span(scores_).subspan(decoded_->first_score[cluster], view.components());
    out_of_range += double(view.vertex_count) * double(decoded_->models[cluster].evaluate(seen, scratch_, y));
    setScores(cluster, y);
}

void Evaluator::setPositions(std::span<const Vec3> points, std::span<const float> inputs) {
    const Deformation& deformation = *decoded_->deformation;
    assert(points.size() == points_.size() && inputs.size() == asset_->animation.input_names.size());
    if (points.data() != points_.data()) std::copy(points.begin(), points.end(), points_.begin());
    deformation.normals(points_, deformation_scratch_, point_normals_);
    deformation.bones(points_, inputs, deformation_scratch_, fitted_bones_);
    if (!pose_.empty()) deformation.pose(points_, inputs, deformation_scratch_, pose_);
    setPose(fitted_bones_, pose_);
}

void Evaluator::setFrame(std::size_t frame) {
    const AnimationView& animation = asset_->animation;
    if (!deformation()) return setPose(animation.bonesOf(frame), animation.poseOf(frame));
    readPositions(*asset_, frame, points_);
    setPositions(points_, animation.inputsOf(frame));
}

void Evaluator::setScores(std::size_t cluster, std::span<const float> scores) {
    const ClusterView& view = *decoded_->clusters[cluster];
    for (std::size_t k = 0; k < scores.size(); ++k) scores_[decoded_->first_score[cluster] + k] = scores[k];
    if (!hasBytes(view)) return;
    // combine.h multiplies bytes by 16-bit weights, so the scales go into the weights first.
    for (std::size_t k = 0; k < scores.size(); ++k) weights_[k] = scores[k] * view.basis.scale[k];
    const std::size_t first = decoded_->first_pair_weight[cluster];
    units_[cluster] = packWeights(std::span<const float>(weights_).first(scores.size()),
                                  std::span(pair_weights_).subspan(first, (scores.size() + 1) / 2));
}

std::span<const float> Evaluator::scoresOf(std::size_t index) const {
    if (transfer_) return {};
    return std::span(scores_).subspan(decoded_->first_score[index], decoded_->clusters[index]->components());
}

std::span<const float> Evaluator::scores(std::size_t cluster) const { return scoresOf(cluster); }

std::span<const float> Evaluator::residualScores(std::size_t cluster) const {
    if (decoded_->first_indirect == decoded_->first_residual) return {};
    return scoresOf(decoded_->first_residual + cluster);
}

std::span<const float> Evaluator::indirectScores(std::size_t cluster) const {
    if (!hasIndirect()) return {};
    return scoresOf(decoded_->first_indirect + cluster);
}

const Mat3& Evaluator::clusterRotation(std::size_t cluster) const { return rotations_[cluster]; }

// Writes mean + sum of score times component, clamped. `out` may be the mean itself.
void Evaluator::combine(std::size_t cluster, const void* mean, bool half_mean, const AmbientClamp& clamp,
                        float* out) const {
    const ClusterView& view = *decoded_->clusters[cluster];
    const Decoded& d = *decoded_;
    // A basis of bytes is combined and clamped in one call; halves and floats are clamped afterwards.
    if (hasBytes(view)) {
        const PairInput input{mean,
                              half_mean,
                              d.pairs.data() + d.first_pair_byte[cluster],
                              pair_weights_.data() + d.first_pair_weight[cluster],
                              units_[cluster],
                              (view.components() + 1) / 2,
                              view.mean.count};
        path_.i8(input, clamp, out);
        return;
    }
    const CombineInput input{
        mean, half_mean, view.basis.data, scores_.data() + d.first_score[cluster], view.components(), view.mean.count};
    (view.basis.precision == AssetPrecision::kF16 ? path_.f16 : path_.f32)(input, out);
    path_.clamp(clamp, out, view.vertex_count);
}

void Evaluator::evaluateCluster(std::size_t cluster, std::span<float> numbers) const {
    const ClusterView& view = asset_->model.clusters[cluster];
    const std::size_t stride = std::size_t(asset_->model.stride);
    assert(numbers.size() == vertexCount() * stride);
    if (transfer_)
        return transfer_->transfer(view.first_vertex, view.first_vertex + view.vertex_count, stride, numbers);
    if (composed()) {
        evaluateFar(cluster, far_);
        return composeCluster(cluster, far_, numbers);
    }
    const bool half_mean = view.mean.precision == AssetPrecision::kF16;
    const AmbientClamp clamp{decoded_->ambient_weights.data(), stride, decoded_->ambient_norm2};
    combine(cluster, view.mean.data, half_mean, clamp, numbers.data() + view.first_vertex * stride);
}

void Evaluator::evaluateFar(std::size_t cluster, std::span<float> far) const {
    const FarLayout& layout = farLayout();
    assert(far.size() == vertexCount() * kFarNumbers);
    for (std::uint32_t r = layout.first_run[cluster]; r < layout.first_run[cluster + 1]; ++r)
        evaluateRun(layout.runs[r], cluster, far);
}

namespace {

// Skinned vertices, as many as the kernel takes at once.
struct FarBatch {
    std::array<Vec3, kMaxReceivers> positions, normals, tangents;
    std::size_t count = 0;

    void add(const Receiver& vertex) {
        positions[count] = vertex.position;
        normals[count] = vertex.normal;
        tangents[count++] = vertex.tangent;
    }
    FarReceivers view() const { return {positions.data(), normals.data(), tangents.data(), count}; }
};

}  // namespace

void Evaluator::evaluateRun(const FarRun& run, std::size_t cluster, std::span<float> far) const {
    const Composed& composed = *decoded_->composed;
    const FarLayout& layout = farLayout();
    const std::span<const std::uint16_t> parts = composed.far.partsSeenBy(run.part);
    const FarConstants& constants = composed.far.constants(quality_);
    const FarScene scene{composed.far.tables(), far_pose_.parts.data(), parts.data(), parts.size()};
    // 1. The anchors. Their tangents do not matter.
    FarAnchors anchors;
    anchors.stride = anchorStride(parts.size());
    if (run.anchor_count > 0) anchors.values = anchors_.data() + run.first_value;
    for (std::size_t first = 0; first < run.anchor_count; first += kMaxReceivers) {
        FarBatch batch;
        for (std::size_t a = first; a < std::min<std::size_t>(run.anchor_count, first + kMaxReceivers); ++a)
            batch.add(skinned(layout.anchors[run.first_anchor + a], cluster));
        path_.far->anchors(constants, scene, batch.view(), anchors_.data() + run.first_value + first * anchors.stride);
    }
    // 2. The vertices.
    std::array<float, kMaxReceivers * kFarNumbers> out;
    for (std::size_t first = run.first; first < run.first + run.count; first += kMaxReceivers) {
        FarBatch batch;
        const std::size_t end = std::min<std::size_t>(run.first + run.count, first + kMaxReceivers);
        for (std::size_t r = first; r < end; ++r) batch.add(skinned(layout.receivers[r], cluster));
        anchors.anchor = layout.anchor.data() + first * kAnchorsOfReceiver;
        anchors.weight = layout.weight.data() + first * kAnchorsOfReceiver;
        path_.far->far(constants, scene, anchors, batch.view(), out.data());
        if (composed.far.fields().floor)
            multiplyByFloor(*path_.far, std::span(batch.normals).first(batch.count),
                            std::span(batch.tangents).first(batch.count),
                            std::span(out).first(batch.count * kFarNumbers));
        for (std::size_t i = 0; i < batch.count; ++i)
            std::copy_n(out.begin() + std::ptrdiff_t(i * kFarNumbers), kFarNumbers,
                        far.begin() + std::ptrdiff_t(layout.receivers[first + i] * kFarNumbers));
    }
}

namespace {

constexpr std::array<float, coefficientCount(kMaxOrder)> kNoWeights{};  // these clamp nothing

}  // namespace

void Evaluator::evaluateIndirect(std::size_t cluster, std::span<float> indirect) const {
    assert(hasIndirect() && indirect.size() == vertexCount() * kIndirectStride);
    const std::size_t index = decoded_->first_indirect + cluster,
                      first = asset_->model.clusters[cluster].first_vertex * kIndirectStride;
    combine(index, decoded_->indirect_mean.data() + first, false, {kNoWeights.data(), kIndirectStride, 1},
            indirect.data() + first);
}

void Evaluator::evaluateLocal(std::size_t cluster, std::span<float> numbers) const {
    const ClusterView& view = asset_->model.clusters[cluster];
    const std::size_t stride = std::size_t(asset_->model.stride);
    assert(numbers.size() == vertexCount() * stride);
    combine(cluster, view.mean.data, view.mean.precision == AssetPrecision::kF16, {kNoWeights.data(), stride, 1},
            numbers.data() + view.first_vertex * stride);
}

void Evaluator::composeCluster(std::size_t cluster, std::span<const float> far, std::span<float> numbers) const {
    const ClusterView& view = asset_->model.clusters[cluster];
    const Composed& composed = *decoded_->composed;
    const std::size_t stride = std::size_t(asset_->model.stride), first = view.first_vertex * stride;
    assert(far.size() == vertexCount() * kFarNumbers);
    // 1. What the vertices see past the nearby parts.
    evaluateLocal(cluster, numbers);
    float* const out = numbers.data() + first;
    // 2. Times what the far parts leave visible, plus the mean of the residual.
    const float* mean = composed.residual_mean.empty() ? nullptr : composed.residual_mean.data() + first;
    path_.far->compose(composed.far.constants(), far.data() + view.first_vertex * kFarNumbers, mean, view.vertex_count,
                       stride, out);
    // 3. The components of the residual.
    const AmbientClamp clamp{decoded_->ambient_weights.data(), stride, decoded_->ambient_norm2};
    if (mean)
        combine(decoded_->first_residual + cluster, out, false, clamp, out);
    else
        path_.clamp(clamp, out, view.vertex_count);
}

namespace {

// Blends the bones that move a vertex, by its weights (linear blend skinning).
Affine blendBones(const MeshView& mesh, std::size_t vertex, std::span<const Affine> bones) {
    Affine blend;
    blend.m.fill(0);
    const std::size_t first = vertex * std::size_t(mesh.influences);
    for (std::size_t k = first; k < first + std::size_t(mesh.influences); ++k) {
        const float weight = mesh.skin_weights[k];
        if (weight == 0) continue;
        const Affine& bone = bones[mesh.skin_joints[k]];
        for (int e = 0; e < 12; ++e) blend.m[e] += weight * bone.m[e];
    }
    return blend;
}

}  // namespace

Receiver Evaluator::skinned(std::size_t vertex, std::size_t cluster) const {
    const MeshView& mesh = asset_->mesh;
    Receiver out;
    if (deformation()) {
        const std::size_t point = mesh.pointOf(vertex);
        out.position = points_[point];
        out.normal = mesh.isBack(vertex) ? -point_normals_[point] : point_normals_[point];
    } else {
        const Affine blend = blendBones(mesh, vertex, bones_);
        out.position = blend.point(mesh.positions[vertex]);
        out.normal = normalized(cofactor(blend.linear()) * mesh.normals[vertex]);
    }
    out.tangent = tangentOf(out.normal, mesh.tangents.empty() ? Vec3{} : rotations_[cluster] * mesh.tangents[vertex]);
    return out;
}

void Evaluator::skin(std::size_t begin, std::size_t end, std::span<Vec3> positions, std::span<Vec3> normals,
                     std::span<Vec3> tangents) const {
    assert(end <= vertexCount() && positions.size() == vertexCount() && normals.size() == vertexCount() &&
           tangents.size() == vertexCount());
    const std::size_t count = end - begin;
    skin(begin, positions.subspan(begin, count), normals.subspan(begin, count), tangents.subspan(begin, count));
}

void Evaluator::skin(std::size_t begin, std::span<Vec3> positions, std::span<Vec3> normals,
                     std::span<Vec3> tangents) const {
    assert(begin + positions.size() <= vertexCount());
    const std::vector<ClusterView>& clusters = asset_->model.clusters;
    // Clusters are contiguous ranges of vertices: find the one that has `begin`, then go along.
    const auto after = std::upper_bound(clusters.begin(), clusters.end(), begin,
                                        [](std::size_t v, const ClusterView& c) { return v < c.first_vertex; });
    std::size_t cluster = std::size_t(after - clusters.begin()) - 1;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const std::size_t v = begin + i;
        if (v >= clusters[cluster].first_vertex + std::size_t(clusters[cluster].vertex_count)) ++cluster;
        const Receiver vertex = skinned(v, cluster);
        positions[i] = vertex.position;
        normals[i] = vertex.normal;
        tangents[i] = vertex.tangent;
    }
}

}  // namespace penumbra
