#pragma once
// A tube with morph targets, without a rig or a fit.
#include "sh/rigid_fit.h"
#include "tests/synthetic_model.h"

namespace penumbra::synthetic {

// The weights of frame f.
inline std::vector<float> morphWeightsOf(std::size_t f) { return {0.2f * float(f), 1 - 0.3f * float(f)}; }

// "fat" widens the upper half of the tube, "lean" shifts the middle and turns its normals. Two joints more stand for
// the weights, with offsets and scales of their own.
inline Model morphTube() {
    constexpr std::uint32_t kOwn = 3;
    Model model = tubeModel({.rings = 10, .segments = 8, .joints = int(kOwn) + 2, .clusters = 2});
    for (std::uint16_t& joint : model.skin.joints) joint = std::min<std::uint16_t>(joint, kOwn - 1);
    for (std::size_t i = 0; i < model.skin.joints.size(); i += 2)
        if (model.skin.joints[i] == model.skin.joints[i + 1]) {
            model.skin.weights[i] = 1;
            model.skin.weights[i + 1] = 0;
        }
    model.input_names = {"fat", "lean"};
    model.input_joints = {{kOwn, 0, 1, 0.5f, 2}, {kOwn + 1, 1, 1, 0.25f, 3}};
    model.pose_size = int(3 * kOwn + 2);
    model.pose.assign(model.frames.frameCount() * std::size_t(model.pose_size), 0);
    for (std::size_t f = 0; f < model.frames.frameCount(); ++f)
        for (std::size_t m = 0; m < 2; ++m) {
            const InputJoint& joint = model.input_joints[m];
            const float weight = morphWeightsOf(f)[m];
            model.pose[(f + 1) * std::size_t(model.pose_size) - 2 + m] = weight;
            model.bones[f * (kOwn + 2) + joint.joint] = numberBone(weight, joint.offset, joint.scale);
        }
    MorphTargets& morphs = model.mesh.morphs;
    morphs.names = model.input_names;
    morphs.rest_weights = {0.5f, 0};
    morphs.first = {0};
    for (int m = 0; m < 2; ++m) {
        for (std::uint32_t v = 0; v < model.mesh.vertexCount(); ++v) {
            const Vec3 p = model.mesh.rest_positions[v];
            if (m == 0 ? p.y < 0.9f : (p.y < 0.4f || p.y > 1.4f)) continue;
            morphs.vertices.push_back(v);
            morphs.positions.push_back(m == 0 ? Vec3{p.x, 0, p.z} : Vec3{0.2f, 0, 0});
            morphs.normals.push_back(m == 0 ? Vec3{0, 0, 0} : Vec3{0, 0.5f, 0});
        }
        morphs.first.push_back(std::uint32_t(morphs.vertices.size()));
    }
    return model;
}

// The vertices of the model in one of its frames, by the rule of the bake.
inline RestShape morphedFrame(const Model& model, std::size_t f) {
    const std::size_t joints = model.skin.jointCount();
    const std::vector<Affine> bones(model.bones.begin() + std::ptrdiff_t(f * joints),
                                    model.bones.begin() + std::ptrdiff_t((f + 1) * joints));
    RestShape out;
    skinMorphed(model.mesh, model.skin, model.rest_normals, {bones, morphWeightsOf(f)}, out);
    return out;
}

}  // namespace penumbra::synthetic
