#pragma once
// What the numbers of the model mean, for people who look for mistakes in it. No GL.
#include "player/view/view_scene.h"
#include "player/view/view_shapes.h"

namespace penumbra {

// The function that a vertex' numbers stand for, over the directions above its horizon, as a sphere about `center` that
// is deformed to radius V(s) `scale`. Values: x = V; V < 0 has radius 0.
Shape visibilityLobe(const Convention& convention, std::span<const float> numbers, const Mat3& local_frame, Vec3 center,
                     float scale);

// Its values as colours: blue for V = 0 to yellow for 1, under a lamp at the eye so that its shape is seen.
void shadeLobe(Shape& lobe, Vec3 eye);

struct VertexFigures {
    std::size_t cluster = 0;
    std::string_view joint;
    std::span<const float> model, truth;  // numbers, convention.size() of them; truth may be empty
    float model_ambient = 0, true_ambient = 0;
    std::span<const float> scores;  // of the cluster's components
};
std::size_t clusterAt(const ModelView& model, std::size_t vertex);
VertexFigures figuresOf(const Character& character, std::size_t vertex);

// How much of component `k` changes E of every vertex, a unit of score: E(basis_k). 0 where a cluster has fewer.
std::vector<float> componentAmbient(const ModelView& model, std::size_t vertices, std::size_t k);
std::size_t mostComponents(const ModelView& model);
// Blue for -most over white for 0 to red for most, linear.
Vec3 divergingColor(float value, float most);

}  // namespace penumbra
