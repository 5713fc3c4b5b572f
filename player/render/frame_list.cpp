#include "player/render/frame_list.h"

#include <algorithm>

#include "formats/common/find_by_name.h"

namespace penumbra {

namespace {

std::vector<std::size_t> chooseClips(const std::vector<ClipView>& clips, const FrameChoice& choice) {
    std::vector<std::size_t> chosen;
    const bool named_all = std::any_of(clips.begin(), clips.end(), [](const ClipView& c) { return c.name == "all"; });
    const bool all = choice.clips.empty() ? choice.sequence : choice.clips == std::vector<std::string>{"all"};
    if (all && !named_all) {
        for (std::size_t c = 0; c < clips.size(); ++c) chosen.push_back(c);
        return chosen;
    }
    for (const std::string& name : choice.clips) {
        if (name == "all" && !named_all) throw BadOption("clip", "all cannot be combined with another clip");
        chosen.push_back(findByName(clips, name, "clip"));
        if (std::count(chosen.begin(), chosen.end(), chosen.back()) > 1)
            throw BadOption("clip", name + " is given twice");
    }
    if (chosen.empty()) chosen.push_back(0);
    return chosen;
}

std::vector<ListedFrame> framesOf(const std::vector<ClipView>& clips, const std::vector<std::size_t>& chosen) {
    std::vector<ListedFrame> frames;
    for (const std::size_t c : chosen)
        for (std::size_t number = 0; number < clips[c].frame_count; ++number)
            frames.push_back({c, number, clips[c].first_frame + number, frames.size()});
    return frames;
}

void checkFrame(const ClipView& clip, int frame) {
    if (std::size_t(frame) >= clip.frame_count)
        throw BadOption("frame", "must be 0.." + std::to_string(clip.frame_count - 1) + " for clip \"" +
                                     std::string(clip.name) + "\", not " + std::to_string(frame));
}

}  // namespace

ChosenFrames chooseFrames(const AssetView& asset, const FrameChoice& choice) {
    const std::vector<ClipView>& clips = asset.animation.clips;
    if (clips.empty()) throw InvalidInput(asset.name + ": holds no clip");
    ChosenFrames list{chooseClips(clips, choice), {}};
    const std::vector<ListedFrame> all = framesOf(clips, list.clips);
    if (all.empty()) throw InvalidInput(asset.name + ": the chosen clips have no frames");
    list.first = all.front();
    if (choice.frames) {
        checkFrameRange(*choice.frames, all.size());
        for (std::size_t f = choice.frames->begin; f < choice.frames->end; f += choice.frames->step)
            list.frames.push_back(all[f]);
    } else if (choice.sequence && !choice.frame) {
        list.frames = all;
    } else {
        if (list.clips.size() > 1)
            throw BadOption("frame", std::to_string(choice.frame.value_or(0)) + " is of one clip, and " +
                                         std::to_string(list.clips.size()) + " are chosen");
        checkFrame(clips[list.clips[0]], choice.frame.value_or(0));
        list.frames = {all[std::size_t(choice.frame.value_or(0))]};
    }
    return list;
}

// --- Names ----------------------------------------------------------------------------------------------------------

bool FramePattern::looksLikeOne(const std::filesystem::path& path) {
    return path.filename().string().find('%') != std::string::npos;
}

namespace {

// Reads "d" or "0Nd" after a percent sign. Returns the digits, or 0 where it is neither.
std::size_t readConversion(const std::string& name, std::size_t& at) {
    std::size_t digits = 1;
    if (at + 1 < name.size() && name[at] == '0' && name[at + 1] >= '1' && name[at + 1] <= '9') {
        digits = std::size_t(name[at + 1] - '0');
        at += 2;
    }
    return at < name.size() && name[at++] == 'd' ? digits : 0;
}

}  // namespace

FramePattern::FramePattern(const std::filesystem::path& path) : folder_(path.parent_path()) {
    const std::string name = path.filename();
    std::size_t conversions = 0;
    std::string* part = &before_;
    for (std::size_t at = 0; at < name.size();) {
        if (name[at] != '%') {
            *part += name[at++];
        } else if (at + 1 < name.size() && name[at + 1] == '%') {
            *part += '%';
            at += 2;
        } else {
            digits_ = readConversion(name, ++at);
            if (digits_ == 0 || ++conversions > 1) break;
            part = &after_;
        }
    }
    if (digits_ == 0 || conversions != 1)
        throw BadOption("output", path.string() +
                                      ": the files of a sequence need one %d or %0Nd (N 1..9) in their "
                                      "name, as out.%04d.png has");
}

std::filesystem::path FramePattern::name(std::size_t number) const {
    const std::string text = std::to_string(number);
    return folder_ / (before_ + std::string(digits_ - std::min(digits_, text.size()), '0') + text + after_);
}

}  // namespace penumbra
