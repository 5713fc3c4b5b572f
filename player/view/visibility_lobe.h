#pragma once
// Shows what the numbers of the model mean, for people who look for mistakes in it. It uses no GL.
#include "player/view/view_scene.h"
#include "player/view/view_shapes.h"

namespace penumbra {

// Makes the function that a vertex' numbers stand for visible, over the directions above its horizon: a sphere about
// `center` is deformed to radius V(s) `scale`. Its values have x = V; where V < 0 the radius is 0.
Shape visibilityLobe(const Convention& convention, std::span<const float> numbers, const Mat3& local_frame, Vec3 center,
                     float scale);

// Turns the values into colours: blue for V = 0 to yellow for 1, under a lamp at the eye so that the shape is seen.
void shadeLobe(Shape& lobe, Vec3 eye);

struct VertexFigures {
    std::size_t cluster = 0;
    std::string_view joint;
    std::span<const float> model, truth;  // convention.size() numbers each; truth may be empty
    float model_ambient = 0, true_ambient = 0;
    std::span<const float> scores;  // of the cluster's components
};
std::size_t clusterAt(const ModelView& model, std::size_t vertex);
VertexFigures figuresOf(const Character& character, std::size_t vertex);

// Returns how much a unit of the score of component `k` changes E of every vertex: E(basis_k). 0 where a cluster has
// fewer.
std::vector<float> componentAmbient(const ModelView& model, std::size_t vertices, std::size_t k);
std::size_t mostComponents(const ModelView& model);
// Returns a linear colour: blue for -most, white for 0, red for most.
Vec3 divergingColor(float value, float most);

}  // namespace penumbra
