#pragma once
// Which frames of an asset a run draws or measures, and the names of their files.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/common/frame_range.h"

namespace penumbra {

struct FrameChoice {
    // Names, or how only one clip begins; "all" alone: all, unless a clip is called so. Empty: all for a sequence, the
    // first for one frame.
    std::vector<std::string> clips = {};
    std::optional<int> frame = {};          // of the one clip, from 0; >= 0
    std::optional<FrameRange> frames = {};  // over the frames of all chosen clips in order
    bool sequence = false;                  // without `frame` and `frames`: all frames, else frame 0
};

struct ListedFrame {
    std::size_t clip = 0;    // of AnimationView::clips
    std::size_t number = 0;  // in the clip
    std::size_t frame = 0;   // of the animation
    std::size_t listed = 0;  // among the frames of all chosen clips: what --frames counts and a pattern writes
};

struct ChosenFrames {
    std::vector<std::size_t> clips;
    std::vector<ListedFrame> frames;  // at least one
};

// UsageError: an unknown clip, one given twice, a frame beyond the last. InvalidInput: an asset without clips.
ChosenFrames chooseFrames(const AssetView& asset, const FrameChoice& choice);

// "out.%04d.png": one %d or %0Nd (N 1..9) in the name of the file, %% for a percent sign.
class FramePattern {
public:
    // UsageError names what is wrong; nothing of the folder is read as a pattern.
    explicit FramePattern(const std::filesystem::path& path);
    // Whether the name has a percent sign, so that it can only be a pattern.
    static bool looksLikeOne(const std::filesystem::path& path);
    std::filesystem::path name(std::size_t number) const;

private:
    std::filesystem::path folder_;
    std::string before_, after_;
    std::size_t digits_ = 1;  // at least
};

}  // namespace penumbra
