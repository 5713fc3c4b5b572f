#include "runtime/evaluate/followers.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace penumbra {

void followPoints(const MeshView& mesh, const TurnTable& turns, std::size_t begin, std::size_t end,
                  const FollowedFrames& frames, std::size_t stride, std::span<float> coefficients) {
    const std::size_t first = mesh.firstFollower();
    assert(begin >= first && end <= mesh.positions.size() && coefficients.size() == mesh.positions.size() * stride);
    for (std::size_t v = begin; v < end; ++v) {
        const std::span<float> own = coefficients.subspan(v * stride, stride);
        std::fill(own.begin(), own.end(), 0.0f);
        const Vec3 normal = frames.normals[v], tangent = frames.tangents[v], across = cross(normal, tangent);
        for (std::size_t i = 0; i < 3; ++i) {
            const float weight = mesh.follower_weights[v - first][i];
            if (weight == 0) continue;
            const std::size_t corner = mesh.follower_corners[v - first][i];
            const Vec3 carried = carriedTangent(frames.normals[corner], normal, frames.tangents[corner]);
            const float along = dot(carried, tangent), aside = dot(carried, across);
            const float size = std::sqrt(along * along + aside * aside);
            addTurned(turns, size > 0 ? along / size : 1, size > 0 ? aside / size : 0, weight,
                      coefficients.subspan(corner * stride, stride), own);
        }
    }
}

}  // namespace penumbra
