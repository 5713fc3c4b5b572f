#pragma once
// The flags of scenes: the time, and how the shadow of others joins a receiver's own visibility.
#include "formats/common/command_line.h"
#include "formats/common/options.h"
#include "player/papers/cast_way.h"

namespace penumbra {

constexpr const char* kSceneGroup = "Scenes";

inline void addCastFlags(CLI::App& app, CastWay& way) {
    addChoice(app, "--cast", way.mode, kCastModeWords,
              "how shadows of others are combined with a character's own visibility; all but product are slow, for "
              "comparison")
        ->group(kSceneGroup);
    addParsed(app, "--cast-exponential", way.exponential, parseCastExponential,
              "how the spheres of casters are multiplied: hyb-ps2, or for comparison hyb-ol, ps-K, ol or chain (slow)")
        ->default_str(nameOf(way.exponential))
        ->group(kSceneGroup);
}

inline void addTimeFlag(CLI::App& app, std::optional<double>& time) {
    app.add_option("--time", time, "seconds into everyone's clip (default: as the scene says)")
        ->check(within(0.0, 1e6))
        ->group(kSceneGroup);
}

}  // namespace penumbra
