#pragma once
// Tells at which times of its clips an animation is sampled. Rigs and point caches follow the same rule.
#include <string>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

struct ClipTimes {
    std::string name;
    double begin = 0, end = 0;  // seconds
    std::vector<double> keys;   // ascending; at least one where end > begin
};

// Samples every chosen clip (names; empty: all) at begin, begin + 1/fps, ... up to its end. With fps 0 it takes the
// clip's keys, of which those closer than 1e-5 s count as one. A clip without duration has one frame, at its begin.
// Throws UsageError for an unknown name (it lists those that `owner`, "the rig", knows), for a name given twice, and
// for an fps that is negative or gives more than 1e7 frames.
FrameList sampleClips(const std::vector<ClipTimes>& known, const std::vector<std::string>& chosen, double fps,
                      const std::string& owner);

}  // namespace penumbra
