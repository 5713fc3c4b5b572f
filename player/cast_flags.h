#pragma once
// The flags that choose how the shadow of others joins a receiver's own visibility.
#include "formats/common/command_line.h"
#include "player/scene/cast_way.h"

namespace penumbra {

struct CastFlags {
    std::string mode = "product", exponential = "hyb-ps2";
    CastWay way() const { return parseCastWay(mode, exponential); }  // throws UsageError
};

inline void addCastFlags(CLI::App& app, CastFlags& flags) {
    app.add_option(
           "--cast", flags.mode,
           "of a scene, how shadows of others join own visibility: product, or for comparison folded, sphere-product "
           "or hemisphere-share (slow)")
        ->capture_default_str();
    app.add_option("--cast-exponential", flags.exponential,
                   "of a scene, how the spheres of casters are multiplied: hyb-ps2, or for comparison hyb-ol, ps-K, ol "
                   "or chain (slow)")
        ->capture_default_str();
}

}  // namespace penumbra
