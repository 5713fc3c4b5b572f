#pragma once
// Shades a character or prop of a scene in the modes that compare (player/papers/cast_way.h). Slow: it evaluates the
// radiance of every SH function of the light on its own.
#include <optional>
#include <vector>

#include "player/frame/frame_values.h"
#include "player/papers/cast_way.h"

namespace penumbra {

// Own numbers of an asset's convention as SH over the sphere that are 1 below the horizon, which Nowrouzezahrai 2009
// multiplies: [vertices, 16] of convention A4.
std::vector<float> ownInA4(const Convention& convention, int stride, std::span<const float> coefficients);

// Replaces own visibility by a constant above the horizon with the same mean over the hemisphere, which is the DC
// self-shadow of Nowrouzezahrai 2011. The numbers keep their convention.
void keepHemisphereShare(const Convention& convention, int stride, std::span<float> coefficients);

// V_c of vertices, as castOverSphere() has it, with castOrderOf(mode).
using SphereCast = std::span<const float>;

// E of every vertex past `cast`; `own` has numbers without any cast, and stands in the frame of the scene.
std::vector<float> castAmbient(CastMode mode, const ModelView& model, const FrameVertices& own, SphereCast cast);

class CastShader {
public:
    // The shot is shaded, and its light_rotation turns the light into the scene. Keeps no reference to it, but its
    // asset's arrays must outlive this object. `mode` is not kProduct.
    CastShader(CastMode mode, const Shot& shot);
    CastShader(const CastShader&) = delete;  // the set points to the view
    CastShader& operator=(const CastShader&) = delete;

    // Writes the radiance towards `eye`, with negative values as 0. `own` and `cast` as for castAmbient().
    void shade(const FrameVertices& own, SphereCast cast, Vec3 eye, int threads, std::vector<Vec3>& radiance);

    ShadingSet& shading() { return *set_; }  // materials may change

private:
    CastMode mode_;
    Convention convention_;  // of the asset
    int stride_;
    AssetView view_;
    std::vector<float> light_;  // [n^2, 3], in the scene
    int light_order_;
    std::optional<ShadingSet> set_;

    void shadeFolded(const FrameVertices& own, SphereCast cast, Vec3 eye, int threads, std::vector<Vec3>& radiance);
};

// The SH of a light [n^2, 3], turned.
std::vector<float> turnedLight(const LightView& light, const Mat3d& rotation);

// What an open, level ground makes of V_c, which is linear: radiance_c = sum_k weights[k]_c V_k for a Lambertian albedo
// of 1. `light` is turned into the scene. `light` empty: E, in x.
std::vector<Vec3> groundWeights(CastMode mode, std::span<const float> light, int light_order);
// Returns the radiance of such a ground under a light that is turned, from V_c of its vertices. Without a light: E, in
// x.
std::vector<Vec3> groundInMode(CastMode mode, SphereCast cast, const LightView* light, const Mat3d& light_rotation,
                               Vec3 albedo);

}  // namespace penumbra
