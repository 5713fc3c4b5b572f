#pragma once
// The asset's arrays as GL buffers: vertex attributes, and texture buffers for everything that the evaluating vertex
// shader looks up. Quantised numbers go up as they are stored.
#include <map>
#include <string>

#include "player/gl_objects.h"
#include "player/runtime/evaluator.h"
#include "player/shader_source.h"

namespace penumbra {

struct GlModel {
    GlObject vertex_array, positions, normals, tangents, cluster, slot, triangles;
    GLsizei index_count = 0;
    std::map<std::string, TextureBuffer> samplers;  // by the name of the shader's sampler
    ArrayFormat mean = ArrayFormat::kFloat, basis = ArrayFormat::kFloat;
};

// All that does not change from frame to frame.
GlModel uploadModel(const AssetView& asset);

// Bones, cluster rotations and scores of the pose that `evaluator` has.
void uploadPose(GlModel& model, const Evaluator& evaluator, std::span<const Affine> bones);

// Numbers that take the place of the model's (ShaderRecipe::numbers_given), [V, stride].
void uploadNumbers(GlModel& model, std::span<const float> numbers);

}  // namespace penumbra
