#pragma once
// Tells where evaluate.comp finds what: the asset, which never changes, and one character's pose and looks, which
// change every frame.
#include <cstddef>
#include <cstdint>

namespace penumbra {

// Places in 32-bit words from the start of the buffer. The asset's arrays lie one after another as in the file, and
// each begins at a multiple of 16 bytes. Two arrays are made for the shader: cluster_of_vertex (a word a vertex), and
// clusters, of kClusterWords words each: first vertex, vertices, components, first score, mean, basis, and the
// AssetPrecision of both. The clusters of a residual follow those of the model, and then those of light that bounces.
struct AssetPlaces {
    std::uint32_t positions = 0, normals = 0, tangents = 0, skin_joints = 0, skin_weights = 0, slots = 0;
    std::uint32_t cluster_of_vertex = 0, clusters = 0;
    std::uint32_t part_of_vertex = 0;  // only of a composed asset
    std::uint32_t other_side = 0;      // only of a two-sided mesh with membranes: a word a vertex
    // Of a dense mesh: the first vertex that follows points (0: none does), and 3 words of each such vertex.
    std::uint32_t first_follower = 0, point_corners = 0, point_weights = 0;
};
constexpr std::uint32_t kClusterWords = 8;

// Places of the tables of FarWords (runtime/glsl/far_glsl.h) in that buffer, of a composed asset that the GPU
// evaluates, and how many of what they have. The bytes of the fields lie there as in the file.
struct FarPlaces {
    std::uint32_t parts = 0, lists = 0, receivers = 0, anchors = 0;
    std::uint32_t part_count = 0, anchor_count = 0, anchor_values = 0;
    std::uint32_t near_count = 0, near_parts = 0, near_gains = 0;  // arrays of the asset (CompositionView)
    int coefficients = 0;                                          // of a vertex
};

// Places of one character in a frame, in vec4 from its start. The first 3 vec4 are the rows of its place in the
// scene, 3x4; the next has whether its numbers are given (1) or the model's (0), and which caster it is (-1: none).
// Then follow the rows of the bones' 3x4 skinning matrices; rows of the clusters' rotations, whose fourth number is
// unused; the scores of all clusters, which for an i8 basis are multiplied by the component's scale, those of residuals
// and then of light that bounces after all others; the parts (writePosedPart()) of a composed asset that the GPU
// evaluates; the material of every slot; the SlotLobes of every slot, which are read where suns shine; and
// writeTermRows() (runtime/shade/shading_layout.h) where pictures are shown; and ShadingLayout::lightTexels() of the
// light.
struct PosePlaces {
    std::size_t bones = 4, rotations = 0, scores = 0, parts = 0, materials = 0, lobes = 0, terms = 0, light = 0,
                size = 0;
};

// Of what evaluate.comp writes for a vertex, in vec4: position and value, and where suns shine the surface, too. The
// terms of pictures beside the first follow these (`terms` of them, `slopes` the first), after a normal with slopes.
constexpr std::size_t kEvaluatedQuads = 2, kSunlitQuads = 4;
constexpr std::size_t firstTermQuad(std::size_t slopes, std::size_t sunlit_models) {
    return sunlit_models ? kSunlitQuads : kEvaluatedQuads + (slopes > 0 ? 1 : 0);
}

}  // namespace penumbra
