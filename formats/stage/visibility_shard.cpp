#include "formats/stage/visibility_shard.h"

#include <algorithm>

namespace penumbra {

int ShardPlace::clipNamed(const std::string& name) const {
    const auto found = std::find(clip_names.begin(), clip_names.end(), name);
    return found == clip_names.end() ? -1 : int(found - clip_names.begin());
}

std::vector<std::uint32_t> numberInClip(const FrameList& frames) {
    std::vector<std::uint32_t> numbers(frames.frameCount());
    for (std::size_t f = 1; f < numbers.size(); ++f)
        numbers[f] = frames.clip[f] == frames.clip[f - 1] ? numbers[f - 1] + 1 : 0;
    return numbers;
}

std::vector<std::uint32_t> framesOfClips(const FrameList& frames) {
    std::vector<std::uint32_t> counts(frames.clip_names.size());
    for (const std::uint16_t clip : frames.clip) ++counts[clip];
    return counts;
}

std::string rangesText(const std::vector<ClipFrame>& frames, std::size_t most) {
    std::string text;
    std::size_t ranges = 0, more = 0;
    for (std::size_t begin = 0, end = 0; begin < frames.size(); begin = end) {
        const ClipFrame& first = frames[begin];
        for (end = begin + 1; end < frames.size() && frames[end].clip == first.clip &&
                              frames[end].number == first.number + (end - begin);)
            ++end;
        if (ranges++ >= most) {
            ++more;
            continue;
        }
        text += (text.empty() ? "'" : ", '") + first.clip + "' " + std::to_string(first.number) + ":" +
                std::to_string(first.number + (end - begin));
    }
    return more > 0 ? text + " and " + std::to_string(more) + " more" : text;
}

}  // namespace penumbra
