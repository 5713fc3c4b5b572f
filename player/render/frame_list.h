#pragma once
// Chooses the frames of an asset that a run draws or measures, and names their files.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/common/frame_range.h"

namespace penumbra {

struct FrameChoice {
    // Names of clips, or beginnings of one name. "all" alone means all clips, unless a clip is called so. Empty means
    // all for a sequence, and the first for one frame.
    std::vector<std::string> clips = {};
    std::optional<int> frame = {};          // in the one clip, from 0; >= 0
    std::optional<FrameRange> frames = {};  // over the frames of all chosen clips in order
    bool sequence = false;                  // without `frame` and `frames`: all frames instead of frame 0
};

struct ListedFrame {
    std::size_t clip = 0;    // index in AnimationView::clips
    std::size_t number = 0;  // in the clip
    std::size_t frame = 0;   // index in the animation
    std::size_t listed =
        0;  // place among the frames of all chosen clips, which FrameChoice::frames counts and a pattern writes
};

struct ChosenFrames {
    std::vector<std::size_t> clips;
    std::vector<ListedFrame> frames;  // at least one
    ListedFrame first = {};           // first frame of these clips, even if it is not in `frames`
};

// Throws BadOption for an unknown clip, one given twice and a frame beyond the last. Throws InvalidInput for an
// asset without clips.
ChosenFrames chooseFrames(const AssetView& asset, const FrameChoice& choice);

// A name such as "out.%04d.png", with one %d or %0Nd (N 1..9) in the name of the file. %% stands for a percent sign.
class FramePattern {
public:
    // Throws BadOption, which names what is wrong. Nothing in the folder's name is read as a pattern.
    explicit FramePattern(const std::filesystem::path& path);
    // Tells whether the name has a percent sign, so that it can only be a pattern.
    static bool looksLikeOne(const std::filesystem::path& path);
    std::filesystem::path name(std::size_t number) const;

private:
    std::filesystem::path folder_;
    std::string before_, after_;
    std::size_t digits_ = 1;  // least number of digits
};

}  // namespace penumbra
