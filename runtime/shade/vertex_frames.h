#pragma once
#include <cassert>
#include <span>

#include "runtime/shade/shade_kernel.h"
#include "sh/vec3.h"

namespace penumbra {

// Posed vertices as shading reads them: the arrays of all V vertices, and [begin, end), which a call works on.
struct VertexFrames {
    std::span<const Vec3> positions, normals, tangents;  // [V]
    std::span<const float> coefficients;                 // [V * stride] of visibility, or transfer
    std::size_t begin = 0, end = 0;
    std::span<const float> indirect = {};  // [V * kIndirectStride] light that bounces; empty: there is none
    // [V] irradiance of light that a ground and others in the scene reflect onto the vertex; empty: none
    std::span<const Vec3> received = {};
};

// Returns what the kernel reads of vertices that have `size` coefficients each; `radiance` is [V].
inline ShadeInput shadeInput(const VertexFrames& vertices, int stride, int size, Vec3 eye, std::span<Vec3> radiance) {
    assert(vertices.begin <= vertices.end && vertices.end <= radiance.size() &&
           vertices.positions.size() == radiance.size() && vertices.normals.size() == radiance.size() &&
           vertices.tangents.size() == radiance.size() &&
           vertices.coefficients.size() == radiance.size() * std::size_t(stride));
    return {vertices.positions.data(),
            vertices.normals.data(),
            vertices.tangents.data(),
            vertices.coefficients.data(),
            stride,
            size,
            eye,
            radiance.data()};
}

}  // namespace penumbra
