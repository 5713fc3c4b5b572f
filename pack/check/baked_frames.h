#pragma once
// Frames of bakes as `penumbra-pack check` reads them side by side.
#include <map>
#include <string>
#include <utility>

#include "formats/stage/visibility_file.h"
#include "runtime/evaluate/evaluator.h"

namespace penumbra {

// Finds frames of another file by clip and time.
class FrameFinder {
public:
    FrameFinder(const VisibilityReader* reader, std::string name);
    bool has(const std::string& clip, double time) const { return frame_of_.contains({clip, time}); }
    // Returns an empty frame without a reader. Throws InvalidInput when the frame is not there.
    VisibilityFrame read(const std::string& clip, double time) const;

private:
    const VisibilityReader* reader_;
    std::string name_;
    std::map<std::pair<std::string, double>, std::size_t> frame_of_;
};

// One frame as the files have it.
struct BakedFrames {
    VisibilityFrame truth, predicted, second;
};

// Throws InvalidInput unless two bakes have the same pose: bones (for a deforming mesh: positions) of one animation are
// the same numbers. 1e-4 leaves room for another rounding of them.
void checkSamePose(const VisibilityFrame& truth, const VisibilityFrame& second, const std::string& clip, double time);

// Poses the evaluator as the bake was. The inputs are the last numbers of a baked pose.
void poseAs(Evaluator& evaluator, const VisibilityFrame& baked);

}  // namespace penumbra
