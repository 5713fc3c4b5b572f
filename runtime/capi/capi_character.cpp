// The part of penumbra.h that sets poses, evaluates visibility and skins.
#include <algorithm>
#include <cmath>

#include "runtime/capi/capi_handles.h"
#include "runtime/evaluate/deformation.h"
#include "runtime/shade/indirect_light.h"

namespace penumbra {

namespace {

void requireMatrices(const AssetView& asset, penumbra_matrix_layout layout, const float* matrices,
                     std::size_t joint_count) {
    requirePointer(matrices, "matrices");
    const std::size_t joints = asset.animation.jointCount();
    if (joint_count != joints)
        throw UsageError("joint_count is " + std::to_string(joint_count) + "; the asset has " + std::to_string(joints));
    if (layout != PENUMBRA_ROWS_3X4 && layout != PENUMBRA_COLUMNS_4X4)
        throw UsageError("layout is no penumbra_matrix_layout");
}

void requirePose(const AssetView& asset, penumbra_matrix_layout layout, const float* matrices, std::size_t joint_count,
                 const float* rotations, std::size_t rotation_count) {
    requireMatrices(asset, layout, matrices, joint_count);
    if (asset.model.features != FeatureKind::kJointAngles || asset.animation.pose_size == 0) return;
    requirePointer(rotations, "the model reads joint rotations: rotations");
    if (rotation_count != asset.animation.pose_size)
        throw UsageError("rotation_count is " + std::to_string(rotation_count) + "; the asset has " +
                         std::to_string(asset.animation.pose_size));
    requireFinite("rotations", {rotations, rotation_count});
}

void requireSkinned(const AssetView& asset) {
    if (asset.model.deforming)
        throw Unsupported(asset.name + ": is a deforming mesh; its pose is penumbra_character_set_positions()");
}

void requireInputs(const AssetView& asset, const float* inputs, std::size_t input_count) {
    if (input_count != asset.animation.input_names.size())
        throw UsageError("input_count is " + std::to_string(input_count) + "; the asset has " +
                         std::to_string(asset.animation.input_names.size()));
    if (input_count > 0) requirePointer(inputs, "the model reads inputs: inputs");
    requireFinite("inputs", {inputs, input_count});
}

// Puts positions in the caller's order into the order of the shading points.
void gatherPoints(const AssetData& data, penumbra_vertex_order order, std::span<const Vec3> positions,
                  std::span<Vec3> points) {
    const bool source = order == PENUMBRA_SOURCE_VERTICES;
    if (!source && order != PENUMBRA_ASSET_VERTICES) throw UsageError("order is no penumbra_vertex_order");
    const MeshView& mesh = data.view.mesh;
    const std::size_t expected = source ? mesh.source_vertex.size() : mesh.positions.size();
    if (positions.size() != expected)
        throw UsageError("vertex_count is " + std::to_string(positions.size()) + "; the asset has " +
                         std::to_string(expected) + (source ? " source vertices" : " vertices"));
    const std::vector<std::uint32_t>& from = source ? data.source_of_point : data.vertex_of_point;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (from[i] == AssetData::kNoSource)
            throw Unsupported(data.view.name + ": not every vertex has a source vertex; give PENUMBRA_ASSET_VERTICES");
        points[i] = positions[from[i]];
        for (int axis = 0; axis < 3; ++axis)
            if (!std::isfinite(points[i][axis]))
                throw UsageError("positions[" + std::to_string(3 * from[i] + std::size_t(axis)) + "] is not finite");
    }
}

// Reads column-major 4x4 matrices, whose last row is not needed.
void fromColumns(const float* columns, std::span<Affine> bones) {
    for (std::size_t j = 0; j < bones.size(); ++j)
        for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t column = 0; column < 4; ++column)
                bones[j].m[4 * row + column] = columns[16 * j + 4 * column + row];
}

void toColumns(const Affine& bone, float* columns) {
    for (std::size_t row = 0; row < 4; ++row)
        for (std::size_t column = 0; column < 4; ++column)
            columns[4 * column + row] = row < 3 ? bone.m[4 * row + column] : column == 3;
}

}  // namespace

static_assert(PENUMBRA_BOUNCED_STRIDE == kIndirectStride);

void requireBounces(const AssetView& view) {
    if (!view.model.indirect) throw Unsupported(view.name + ": has no light that bounces (penumbra-fit indirect)");
}

void requireCoefficients(const penumbra_vertices* vertices) {
    requirePointer(vertices, "vertices");
    requirePointer(vertices->coefficients, "vertices->coefficients");
}

VertexFrames framesOf(const penumbra_vertices* vertices, std::size_t all, std::size_t stride) {
    requirePointer(vertices, "vertices");
    requirePointer(vertices->positions, "vertices->positions");
    requirePointer(vertices->normals, "vertices->normals");
    requirePointer(vertices->tangents, "vertices->tangents");
    requireRange("vertices", vertices->first, vertices->count, all);
    const auto floats = [](const float* p, std::size_t n) { return std::span(p, p ? n : 0); };
    return {vectors(vertices->positions, all),
            vectors(vertices->normals, all),
            vectors(vertices->tangents, all),
            floats(vertices->coefficients, all * stride),
            vertices->first,
            vertices->first + vertices->count,
            floats(vertices->bounced, all * kIndirectStride),
            vectors(static_cast<const float*>(vertices->received), vertices->received ? all : 0)};
}

void requireCharacter(const penumbra_character* character, const penumbra_vertices* vertices) {
    requirePointer(character, "character");
    requireCoefficients(vertices);
    if (vertices->bounced) requireBounces(character->asset->view);
}

void requireReceiver(const penumbra_character* character, const penumbra_vertices* vertices) {
    requireCharacter(character, vertices);
    requireRange("vertices", vertices->first, vertices->count, character->evaluator.vertexCount());
    refuseTransfer<Unsupported>(character->asset->view, "nothing casts on transfer, which is no visibility");
}

void castOn(const penumbra_character& character, const penumbra_vertices& vertices, std::size_t first,
            std::span<const float> mirrored) {
    const std::size_t count = mirrored.size() / kFarCoefficients,
                      stride = std::size_t(character.asset->view.model.stride);
    character.product({vertices.coefficients + first * stride, count * stride}, stride, mirrored);
    if (vertices.bounced)
        castOnIndirect(mirrored, {vertices.bounced + first * kIndirectStride, count * kIndirectStride});
}

}  // namespace penumbra

using namespace penumbra;

penumbra_status penumbra_character_create(const penumbra_asset* asset, penumbra_character** character,
                                          penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(asset, "asset", character, "character");
        if (!asset->data->view.hasCharacter()) throw Unsupported(asset->data->view.name + ": has no model");
        *character = new penumbra_character{asset->data,
                                            asset->data->restPose(),
                                            std::vector<Affine>(asset->data->view.animation.jointCount()),
                                            std::vector<Vec3>(asset->data->vertex_of_point.size()),
                                            JointChain(asset->data->view.animation),
                                            CastProduct(asset->data->view.model.convention)};
    });
}

void penumbra_character_destroy(penumbra_character* character) { delete character; }

penumbra_status penumbra_character_set_simd(penumbra_character* character, penumbra_simd simd, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character");
        character->evaluator.usePath(pathOf(simd, evaluatorPaths()));
        TransferEvaluator* const transfer = character->evaluator.transfer();
        if (transfer) transfer->usePath(pathOf(simd, transferPaths()));
    });
}

penumbra_status penumbra_character_set_quality(penumbra_character* character, penumbra_quality quality,
                                               penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character");
        if (quality != PENUMBRA_FULL && quality != PENUMBRA_FAST) throw UsageError("quality is no penumbra_quality");
        character->evaluator.setQuality(quality == PENUMBRA_FAST ? FarQuality::kFast : FarQuality::kFull);
    });
}

penumbra_status penumbra_character_set_pose(penumbra_character* character, penumbra_matrix_layout layout,
                                            const float* matrices, size_t joint_count, const float* rotations,
                                            size_t rotation_count, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character");
        const AssetView& asset = character->asset->view;
        requireSkinned(asset);
        requirePose(asset, layout, matrices, joint_count, rotations, rotation_count);
        if (layout == PENUMBRA_COLUMNS_4X4)
            fromColumns(matrices, character->bones);
        else
            std::copy_n(reinterpret_cast<const Affine*>(matrices), joint_count, character->bones.begin());
        requireFinite("matrices", {character->bones.data()->m.data(), 12 * joint_count});
        const bool angles = asset.model.features == FeatureKind::kJointAngles;
        character->evaluator.setPose(character->bones, {rotations, angles ? asset.animation.pose_size : 0});
    });
}

penumbra_status penumbra_asset_input_matrices(const penumbra_asset* asset, penumbra_matrix_layout layout,
                                              const float* inputs, size_t input_count, float* matrices,
                                              size_t joint_count, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(asset, "asset");
        const AssetView& view = asset->data->view;
        requireSkinned(view);
        requireMatrices(view, layout, matrices, joint_count);
        requireInputs(view, inputs, input_count);
        for (const InputJointView& input : view.model.input_joints) {
            const Affine bone = inputBone(view, input, {inputs, input_count});
            if (layout == PENUMBRA_COLUMNS_4X4)
                toColumns(bone, matrices + 16 * std::size_t(input.joint));
            else
                std::copy(bone.m.begin(), bone.m.end(), matrices + 12 * std::size_t(input.joint));
        }
    });
}

penumbra_status penumbra_character_set_rotations(penumbra_character* character, const float* root,
                                                 const float* rotations, size_t rotation_count, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character", rotations, "rotations");
        const AssetView& asset = character->asset->view;
        const std::size_t joints = asset.animation.jointCount();
        requireSkinned(asset);
        if (!asset.model.input_joints.empty())
            throw Unsupported(asset.name +
                              ": has joints that stand for inputs; its pose is penumbra_character_set_pose(), with "
                              "penumbra_asset_input_matrices()");
        if (!hasRestTransforms(asset.animation))
            throw Unsupported(asset.name + ": has no rest transforms of its joints");
        if (rotation_count != 3 * joints)
            throw UsageError("rotation_count is " + std::to_string(rotation_count) + "; the asset has " +
                             std::to_string(joints) + " joints with 3 each");
        requireFinite("rotations", {rotations, rotation_count});
        Affine moved;
        if (root) {
            requireFinite("root", {root, 12});
            std::copy_n(root, 12, moved.m.begin());
        }
        character->chain.pose(moved, vectors(rotations, joints), character->bones);
        requireFinite("the pose: matrices", {character->bones.data()->m.data(), 12 * joints});
        const bool angles = asset.model.features == FeatureKind::kJointAngles;
        character->evaluator.setPose(character->bones, {rotations, angles ? asset.animation.pose_size : 0});
    });
}

penumbra_status penumbra_character_set_positions(penumbra_character* character, penumbra_vertex_order order,
                                                 const float* positions, size_t vertex_count, const float* inputs,
                                                 size_t input_count, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character", positions, "positions");
        const AssetView& asset = character->asset->view;
        if (!asset.model.deforming)
            throw Unsupported(asset.name + ": is a skinned mesh; its pose is penumbra_character_set_pose()");
        requireInputs(asset, inputs, input_count);
        gatherPoints(*character->asset, order, vectors(positions, vertex_count), character->points);
        character->evaluator.setPositions(character->points, {inputs, input_count});
    });
}

penumbra_status penumbra_character_set_frame(penumbra_character* character, size_t frame, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character");
        const AssetView& asset = character->asset->view;
        requireIndex("frame", frame, asset.animation.frameCount());
        if (asset.model.features == FeatureKind::kJointAngles && asset.animation.pose.empty() &&
            asset.animation.pose_size > 0)
            throw Unsupported(asset.name + ": has no rotations of its frames");
        if (asset.model.deforming && asset.animation.playback.positions.empty())
            throw Unsupported(asset.name + ": has no positions of its frames");
        character->evaluator.setFrame(frame);
    });
}

void penumbra_rotation_vector(const float rest[4], const float now[4], float out[3]) {
    const Vec3d r{-rest[0], -rest[1], -rest[2]}, n{now[0], now[1], now[2]};
    const double real = double(rest[3]) * now[3] - dot(r, n);
    const double sign = real < 0 ? -1 : 1;  // q and -q are one rotation; this sign has the angle <= pi
    const Vec3d v = sign * (double(rest[3]) * n + double(now[3]) * r + cross(r, n));
    const double sine = length(v);
    const double scale = sine < 1e-12 ? 2 : 2 * std::atan2(sine, sign * real) / sine;
    for (int i = 0; i < 3; ++i) out[i] = float(scale * v[i]);
}

double penumbra_character_out_of_range(const penumbra_character* character) {
    return character ? character->evaluator.outOfRange() : 0;
}

int penumbra_asset_bounces(const penumbra_asset* asset) {
    const std::optional<IndirectView> none, &indirect = asset ? asset->data->view.model.indirect : none;
    return indirect ? indirect->bounces : 0;
}

penumbra_status penumbra_character_evaluate(const penumbra_character* character, size_t first_cluster,
                                            size_t cluster_count, const penumbra_vertices* vertices,
                                            penumbra_error* error) {
    return guarded(error, [&] {
        requireCharacter(character, vertices);
        const Evaluator& evaluator = character->evaluator;
        requireRange("clusters", first_cluster, cluster_count, evaluator.clusterCount());
        const std::size_t count = evaluator.vertexCount(), stride = std::size_t(character->asset->view.model.stride);
        for (std::size_t c = first_cluster; c < first_cluster + cluster_count; ++c) {
            evaluator.evaluateCluster(c, {vertices->coefficients, count * stride});
            if (vertices->bounced) evaluator.evaluateIndirect(c, {vertices->bounced, count * kIndirectStride});
        }
    });
}

penumbra_status penumbra_character_follow(const penumbra_character* character, const penumbra_vertices* vertices,
                                          penumbra_error* error) {
    return guarded(error, [&] {
        requireCharacter(character, vertices);
        const Evaluator& evaluator = character->evaluator;
        const std::size_t all = evaluator.vertexCount(), stride = std::size_t(character->asset->view.model.stride);
        const VertexFrames frames = framesOf(vertices, all, stride);
        const std::size_t begin = std::max(frames.begin, evaluator.firstFollower());
        if (begin >= frames.end) return;
        evaluator.follow(begin, frames.end, {frames.normals, frames.tangents}, {vertices->coefficients, all * stride});
    });
}

penumbra_status penumbra_character_skin(const penumbra_character* character, const penumbra_vertices* vertices,
                                        penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character");
        const std::size_t all = character->evaluator.vertexCount();
        const VertexFrames frames = framesOf(vertices, all, 0);
        character->evaluator.skin(frames.begin, frames.end, vectors(vertices->positions, all),
                                  vectors(vertices->normals, all), vectors(vertices->tangents, all));
    });
}

penumbra_status penumbra_character_ambient(const penumbra_character* character, const penumbra_vertices* vertices,
                                           float* ambient_out, penumbra_error* error) {
    return guarded(error, [&] {
        requireCharacter(character, vertices);
        requireRange("vertices", vertices->first, vertices->count, character->evaluator.vertexCount());
        requirePointer(ambient_out, "ambient");
        const AssetView& asset = character->asset->view;
        const std::size_t stride = std::size_t(asset.model.stride), first = vertices->first, count = vertices->count;
        const std::span<float> e(ambient_out + first, count);
        ambient(asset, {vertices->coefficients + first * stride, count * stride}, e);
        if (vertices->bounced)
            addBouncedAmbient(asset.model.indirect->axes,
                              {vertices->bounced + first * kIndirectStride, count * kIndirectStride}, e);
    });
}

penumbra_status penumbra_character_transfer(const penumbra_character* character, int order,
                                            const penumbra_vertices* vertices, float* transfer, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character");
        requireCoefficients(vertices);
        requirePointer(transfer, "transfer");
        const std::size_t n = requireTransferOrder(order);
        const AssetView& asset = character->asset->view;
        const auto stride = std::size_t(asset.model.stride);
        const VertexFrames frames = framesOf(vertices, character->evaluator.vertexCount(), stride);
        for (std::size_t v = frames.begin; v < frames.end; ++v) {
            const std::span<const float> own = frames.coefficients.subspan(v * stride, stride);
            const std::span<float> out(transfer + v * n, n);
            if (asset.transfer) {  // its coefficients are transfer, in the model frame
                const std::size_t known = std::min(n, asset.transfer->coefficients());
                std::fill(std::copy_n(own.begin(), known, out.begin()), out.end(), 0.0f);
            } else {
                character->asset->transfer().apply(own, toLocalFrame(frames.normals[v], frames.tangents[v]), order,
                                                   out);
            }
        }
    });
}

penumbra_status penumbra_character_get_scores(const penumbra_character* character, float* scores, float* rotations) {
    if (!character) return PENUMBRA_INVALID_ARGUMENT;
    for (std::size_t c = 0; c < character->evaluator.clusterCount(); ++c) {
        const std::span<const float> y = character->evaluator.scores(c);
        if (scores) scores = std::copy(y.begin(), y.end(), scores);
        if (rotations) rotations = std::copy_n(character->evaluator.clusterRotation(c).m.begin(), 9, rotations);
    }
    return PENUMBRA_OK;
}
