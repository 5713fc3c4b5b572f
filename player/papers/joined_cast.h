#pragma once
// Computes what a mesh of a scene shows where the shadow of others joins in another way than as a product
// (cast_way.h). The window knows nothing else of these ways.
#include "player/papers/cast_shader.h"
#include "runtime/cast/cast_shadow.h"

namespace penumbra {

class JoinedCast {
public:
    // Computes V_c of vertices that stand in the scene, past the chosen casters.
    void see(CastMode mode, const CastShadow& cast, CasterChoice choice, const FrameVertices& at, int threads);
    // Takes the look of a shot, as CastShader does. Its materials may change.
    ShadingSet& dress(const Shot& shot);

    // Returns the radiance of the vertices towards `eye`, or E in x. `own` has numbers without any cast.
    std::vector<Vec3> radiance(const FrameVertices& own, Vec3 eye, int threads);
    std::vector<Vec3> ambient(const ModelView& model, const FrameVertices& own) const;

private:
    CastMode mode_ = CastMode::kFolded;
    std::vector<float> others_;
    std::optional<CastShader> shader_;
};

// Returns what the vertices of a level ground show past all casters: radiance under a light that is turned, or E in x
// without one.
std::vector<Vec3> joinedGround(CastMode mode, const CastShadow& cast, const CastReceivers& ground,
                               const LightView* light, const Mat3d& light_rotation, Vec3 albedo, int threads);

}  // namespace penumbra
