#pragma once
// The flags of scenes: the time, and how the shadow of others joins a receiver's own visibility.
#include "formats/common/command_line.h"
#include "formats/common/options.h"
#include "player/papers/cast_way.h"

namespace penumbra {

constexpr const char* kSceneGroup = "Scenes";

struct CastFlags {
    std::string mode = "product", exponential = "hyb-ps2";
    CastWay way() const { return parseCastWay(mode, exponential); }  // throws UsageError
};

inline void addCastFlags(CLI::App& app, CastFlags& flags) {
    app.add_option(
           "--cast", flags.mode,
           "of a scene, how shadows of others join own visibility: product, or for comparison folded, sphere-product "
           "or hemisphere-share (slow)")
        ->group(kSceneGroup);
    app.add_option("--cast-exponential", flags.exponential,
                   "of a scene, how the spheres of casters are multiplied: hyb-ps2, or for comparison hyb-ol, ps-K, ol "
                   "or chain (slow)")
        ->group(kSceneGroup);
}

inline void addTimeFlag(CLI::App& app, std::optional<double>& time) {
    app.add_option("--time", time, "seconds into everyone's clip (default: as the scene says)")
        ->check(within(0.0, 1e6))
        ->group(kSceneGroup);
}

}  // namespace penumbra
