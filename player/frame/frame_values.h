#pragma once
// Computes one frame on the CPU: the evaluator and the shading of runtime over all vertices, on several
// threads.
#include <vector>

#include "player/frame/shot.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading.h"

namespace penumbra {

struct FrameVertices {
    std::vector<Vec3> positions, normals, tangents;  // [V]
    std::vector<float> coefficients;                 // [V, stride], of the model or of the truth
    std::vector<float> indirect;                     // [V, kIndirectStride], of the model; empty where no light bounces
    std::vector<Vec3> received;                      // [V] irradiance of light that others reflect; empty: none

    VertexFrames range(std::size_t begin, std::size_t end) const {
        return {positions, normals, tangents, coefficients, begin, end, indirect, received};
    }
};

// Poses the evaluator for the shot's frame, then skins and evaluates. Sizes `vertices`. `threads` as in
// parallelFor().
void evaluateFrame(const Shot& shot, VisibilitySource source, Evaluator& evaluator, int threads,
                   FrameVertices& vertices);

// Its parts, for an evaluator that has its pose: skinning, the model's numbers, and its light that bounces, which is
// empty where the asset has none.
void skinFrame(const Evaluator& evaluator, int threads, FrameVertices& vertices);
void evaluateCoefficients(const Evaluator& evaluator, int threads, FrameVertices& vertices);
// Does the same for `vertices` that skinFrame() has written in this pose. Nothing is skinned twice.
void evaluateSkinned(const Evaluator& evaluator, int threads, FrameVertices& vertices);
void evaluateIndirect(const Evaluator& evaluator, int threads, std::vector<float>& indirect);

// Returns the baked truth as numbers of the model's convention, in the local frames of `vertices`. shot.truth must be
// set.
std::vector<float> truthCoefficients(const Shot& shot, const FrameVertices& vertices, int threads);

// Returns E of every vertex from numbers of the model's convention.
std::vector<float> ambientOf(const Shot& shot, const std::vector<float>& coefficients, int threads);

// Computes the radiance of every vertex towards `eye`, with negative values as 0. Sizes `radiance`: [shading.terms(),
// V].
void shadeFrame(const ShadingSet& shading, const FrameVertices& vertices, Vec3 eye, int threads,
                std::vector<Vec3>& radiance);

// Shades `some` vertices alone (ShadingSet::shadeSome()), and leaves the others undefined. Sizes `radiance`: [V].
void shadeSome(const ShadingSet& shading, std::span<const std::uint32_t> some, const FrameVertices& vertices, Vec3 eye,
               std::vector<Vec3>& radiance);

// Returns what the picture shows of every vertex, as the fragment shader takes it: radiance ([terms, V]), normal, or a
// number in x. Reads `shading` only for kShaded, and `true_ambient` only for kError.
std::vector<Vec3> channelValues(const Shot& shot, Channel channel, const ShadingSet* shading,
                                const FrameVertices& vertices, const std::vector<float>& true_ambient, Vec3 eye,
                                int threads);
// The channel kTransferError is not among these (player/papers/transfer_error.h).

// Returns clusterAt() of every vertex.
std::vector<std::uint32_t> clusterOfVertex(const AssetView& asset);

}  // namespace penumbra
