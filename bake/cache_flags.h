#pragma once
// The flags of visibility and fields that tell what a point cache does not say itself.
#include "formats/cache/point_cache.h"
#include "formats/common/options.h"

namespace penumbra {

inline void addCacheFlags(CLI::App& app, PointCacheOptions& cache) {
    static constexpr Word<bool> kUpWords[] = {{"y", false}, {"z", true}};
    addParsed(app, "--units", cache.metres, metresOfUnit,
              "unit of a point cache: m, cm, mm, inch, or its length in metres (default: m)");
    addChoice(app, "--up", cache.z_up, kUpWords, "up axis of a point cache: y or z");
}

}  // namespace penumbra
