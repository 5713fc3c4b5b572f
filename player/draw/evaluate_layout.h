#pragma once
// Where evaluate.comp finds what: the asset, which never changes, and one character's pose and looks, which change
// every frame.
#include <cstddef>
#include <cstdint>

namespace penumbra {

// The asset's arrays as they lie in the file, one after another; each begins at a multiple of 16 bytes. Here: in 32-bit
// words from the start of the buffer. Made for the shader: cluster_of_vertex (a word a vertex) and clusters, of
// kClusterWords words: first vertex, vertices, components, first score, mean, basis, and the AssetPrecision of both.
struct AssetPlaces {
    std::uint32_t positions = 0, normals = 0, tangents = 0, skin_joints = 0, skin_weights = 0, slots = 0;
    std::uint32_t cluster_of_vertex = 0, clusters = 0;
};
constexpr std::uint32_t kClusterWords = 8;

// One character in a frame, in vec4 from its start, where its offset in the scene is and whether its numbers are given
// (1) or the model's (0): the rows of the bones' 3x4 skinning
// matrices; rows of the clusters' rotations, the fourth number unused; the scores of all clusters, those of an i8 basis
// times the component's scale; the material of every slot; ShadingLayout::lightTexels() of the light.
struct PosePlaces {
    std::size_t bones = 1, rotations = 0, scores = 0, materials = 0, light = 0, size = 0;
};

}  // namespace penumbra
