#pragma once
// A bending tube with a made-up model of Nowrouzezahrai 2007. Nothing in it is trained.
#include "formats/stage/transfer_file.h"
#include "tests/synthetic_model.h"

namespace penumbra::synthetic {

// A model of two components of the angles and three of the vertices where it is reduced. The first angle and the last
// are left out, as angles are that never change.
inline TransferModel tubeTransfer(TransferModelKind kind, int order, TubeOptions options = {}) {
    options.features = FeatureKind::kJointAngles;
    const Model tube = tubeModel(options);
    TransferModel model;
    model.order = order;
    model.kind = kind;
    model.alpha = 0.5;
    model.mesh = tube.mesh;
    model.rest_normals = tube.rest_normals;
    model.skin = tube.skin;
    model.frames = tube.frames;
    model.bones = tube.bones;
    model.pose_size = tube.pose_size;
    model.pose = tube.pose;
    model.holdout_clips = tube.holdout_clips;
    for (int a = 1; a + 1 < model.pose_size; ++a) model.angles.push_back(std::uint32_t(a));
    const std::size_t vertices = model.mesh.vertexCount(), n = model.coefficients();
    Noise noise(11);
    if (kind == TransferModelKind::kLinear) {
        fillNoise(model.weights, n * (model.angles.size() + 1) * vertices, 0.3f, noise);
        return model;
    }
    fillNoise(model.pose_basis, model.angles.size() * 2, 0.5f, noise);
    fillNoise(model.weights, n * 3 * 3, 0.5f, noise);
    fillNoise(model.basis, 3 * vertices, 0.5f, noise);
    fillNoise(model.mean, vertices, 0.5f, noise);
    return model;
}

}  // namespace penumbra::synthetic
