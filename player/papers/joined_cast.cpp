#include "player/papers/joined_cast.h"

#include "player/papers/sphere_cast.h"

namespace penumbra {

void JoinedCast::see(CastMode mode, const CastShadow& cast, CasterChoice choice, const FrameVertices& at, int threads) {
    mode_ = mode;
    castOverSphere(cast, choice, castOrderOf(mode), {at.positions, at.normals, at.tangents}, threads, others_);
}

ShadingSet& JoinedCast::dress(const Shot& shot) { return shader_.emplace(mode_, shot).shading(); }

std::vector<Vec3> JoinedCast::radiance(const FrameVertices& own, Vec3 eye, int threads) {
    std::vector<Vec3> values;
    shader_->shade(own, others_, eye, threads, values);
    return values;
}

std::vector<Vec3> JoinedCast::ambient(const ModelView& model, const FrameVertices& own) const {
    std::vector<Vec3> values;
    for (const float e : castAmbient(mode_, model, own, others_)) values.push_back({e, 0, 0});
    return values;
}

std::vector<Vec3> joinedGround(CastMode mode, const CastShadow& cast, const CastReceivers& ground,
                               const LightView* light, const Mat3d& light_rotation, Vec3 albedo, int threads) {
    std::vector<float> past;
    castOverSphere(cast, {}, castOrderOf(mode), ground, threads, past);
    return groundInMode(mode, past, light, light_rotation, albedo);
}

}  // namespace penumbra
