#pragma once
// The ways in which the shadow of others joins a receiver's own visibility. Scenes use the first; the others are slow,
// run on the CPU, and are there for comparison (docs/formulas.md, section 10).
#include "formats/common/words.h"
#include "formats/scene/scene_file.h"
#include "sh/cast/cast_reference.h"

namespace penumbra {

enum class CastMode {
    kProduct,          // own numbers times V_c, both mirrored at the horizon
    kFolded,           // V_c over the whole sphere is taken out of the light, L' = M^L V_c
    kSphereProduct,    // Nowrouzezahrai 2009, section 7: own numbers in A4 times V_c of order 4, casters are spheres
    kHemisphereShare,  // Nowrouzezahrai 2011, section 6: folded, and own visibility is the share of the hemisphere,
                       // casters are spheres
};
inline constexpr Word<CastMode> kCastModeWords[] = {{"product", CastMode::kProduct},
                                                    {"folded", CastMode::kFolded},
                                                    {"sphere-product", CastMode::kSphereProduct},
                                                    {"hemisphere-share", CastMode::kHemisphereShare}};
constexpr std::size_t kCastModes = std::size(kCastModeWords);
constexpr std::string_view nameOf(CastMode mode) { return wordOf(kCastModeWords, mode); }

struct CastWay {
    CastMode mode = CastMode::kProduct;
    CastExponential exponential = {};  // for casters that are spheres
};

bool needsSpheres(CastMode mode);
int castOrderOf(CastMode mode);  // order of V_c over the whole sphere
// Lets all casters of a scene cast by spheres, but for those that are to cast nothing.
void castBySpheres(SceneDescription& scene);

}  // namespace penumbra
