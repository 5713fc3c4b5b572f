#include "fit/papers/compare/compare_character.h"

#include "fit/clusters/tangent_frames.h"

namespace penumbra {

CompareCharacter prepareCharacter(const CompareInput& input, const CompareOptions& options) {
    const VisibilityHeader& header = input.reader.header();
    CompareCharacter character{splitFrames(header.frames, options.holdout), {}, {}};
    character.clusters =
        clustersOf(header.mesh, input.poses, std::size_t(options.referenceClusters()), options.threads);
    character.rest_tangents = restTangents(header.mesh, header.rest_normals, character.clusters, options.threads);
    return character;
}

ClusterCoefficientsRequest requestFor(const CompareCharacter& character, const Convention& convention, int threads) {
    ClusterCoefficientsRequest request;
    request.convention = convention;
    request.frames = character.frames();
    request.threads = threads;
    return request;
}

FeatureRecipe recipeFor(const CompareInput& input, FeatureKind kind) {
    const VisibilityHeader& header = input.reader.header();
    const double scale = boxDiagonal(header.mesh.rest_positions);
    return {kind,
            scale,
            input.poses.joint_centers,
            jointSpreads(header.mesh, input.poses.skin, input.poses.joint_centers, scale),
            input.poses.pose_size,
            input.poses.deforming,
            input.poses.input_joints,
            header.input_names.size()};
}

}  // namespace penumbra
