#pragma once
// The light at points of a scene in the modes that fold it (cast_way.h).
#include <optional>

#include "formats/asset/asset_file.h"
#include "player/papers/cast_way.h"
#include "sh/cast/cast_fold.h"

namespace penumbra {

class FoldedLight {
public:
    // Without a light, and in a mode that does not fold it, there is no irradiance.
    FoldedLight(CastMode mode, const LightView* light, const Mat3d& rotation);

    // Returns the irradiance of what V_c leaves of the light, for a unit normal. Both are in the scene.
    std::optional<Vec3d> irradiance(std::span<const float> cast, Vec3 normal) const;

private:
    CastFold fold_;
};

}  // namespace penumbra
