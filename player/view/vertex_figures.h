#pragma once
// Shows what the numbers of the model mean, for people who look for mistakes in it. It uses no GL.
#include "player/view/view_scene.h"

namespace penumbra {

struct VertexFigures {
    std::size_t cluster = 0;
    std::string_view joint;
    std::span<const float> model, truth;  // convention.size() numbers each; truth may be empty
    float model_ambient = 0, true_ambient = 0;
    std::span<const float> scores;  // scores of the cluster's components
};
VertexFigures figuresOf(const Character& character, std::size_t vertex);

// Returns how much a unit of the score of component `k` changes E of every vertex: E(basis_k). 0 where a cluster has
// fewer.
std::vector<float> componentAmbient(const ModelView& model, std::size_t vertices, std::size_t k);
std::size_t mostComponents(const ModelView& model);
// Returns a linear colour: blue for -most, white for 0, red for most.
Vec3 divergingColor(float value, float most);

}  // namespace penumbra
