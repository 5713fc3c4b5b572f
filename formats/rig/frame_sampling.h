#pragma once
// Which times of its clips an animation is sampled at: one rule for rigs and point caches.
#include <string>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

struct ClipTimes {
    std::string name;
    double begin = 0, end = 0;  // seconds
    std::vector<double> keys;   // ascending; at least one where end > begin
};

// Every chosen clip (names; empty: all) at begin, begin + 1/fps, ... up to its end, or, with fps 0, at its keys, of
// which those closer than 1e-5 s are one. A clip without duration has one frame, at its begin. UsageError: an unknown
// name (lists the known ones of `owner`, "the rig"), a name given twice, an fps that is negative or gives more than 1e7
// frames.
FrameList sampleClips(const std::vector<ClipTimes>& known, const std::vector<std::string>& chosen, double fps,
                      const std::string& owner);

}  // namespace penumbra
