#pragma once
#include <algorithm>
#include <vector>

#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/vertex_frames.h"
#include "sh/indirect_coefficients.h"

namespace penumbra {

// Returns the coefficients of all vertices of an evaluator's pose.
inline std::vector<float> coefficientsOf(const Evaluator& evaluator) {
    std::vector<float> out(evaluator.vertexCount() * std::size_t(evaluator.asset().model.stride), -7.0f);
    for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) evaluator.evaluateCluster(c, out);
    return out;
}

// All vertices of an evaluator's pose, as shading reads them.
struct PosedArrays {
    std::vector<Vec3> positions, normals, tangents;
    std::vector<float> coefficients, indirect;

    explicit PosedArrays(const Evaluator& evaluator)
        : positions(evaluator.vertexCount()),
          normals(positions),
          tangents(positions),
          coefficients(coefficientsOf(evaluator)) {
        evaluator.skin(0, positions.size(), positions, normals, tangents);
        if (evaluator.hasFollowers())
            evaluator.follow(evaluator.firstFollower(), positions.size(), {normals, tangents}, coefficients);
        if (!evaluator.hasIndirect()) return;
        indirect.resize(positions.size() * kIndirectStride);
        for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) evaluator.evaluateIndirect(c, indirect);
    }
    VertexFrames range(std::size_t begin, std::size_t end) const {
        return {positions, normals, tangents, coefficients, begin, end, indirect};
    }
    VertexFrames all() const { return range(0, positions.size()); }
    // Returns the radiance by a VertexShader or ShadingSet, `piece` vertices at a time.
    template <class Shader>
    std::vector<Vec3> shade(const Shader& shader, Vec3 eye, std::size_t piece = 1 << 20) const {
        std::vector<Vec3> radiance(positions.size());
        for (std::size_t at = 0; at < radiance.size(); at += piece)
            shader.shade(range(at, std::min(radiance.size(), at + piece)), eye, radiance);
        return radiance;
    }
};

}  // namespace penumbra
