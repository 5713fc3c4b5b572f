#include "formats/common/frame_range.h"

#include <algorithm>
#include <charconv>

#include "formats/common/errors.h"

namespace penumbra {

FrameRange parseFrameRange(const std::string& text) {
    const auto bad = [&]() {
        return std::invalid_argument("must be A:B or A:B:S with whole numbers A < B and S >= 1, not '" + text + "'");
    };
    std::size_t numbers[3] = {0, 0, 1};
    int count = 0;
    for (const char *at = text.data(), *end = at + text.size(); count < 3;) {
        const auto [next, error] = std::from_chars(at, end, numbers[count]);
        if (error != std::errc()) throw bad();
        ++count;
        if (next == end) break;
        if (*next != ':' || count == 3) throw bad();
        at = next + 1;
    }
    if (count < 2 || numbers[0] >= numbers[1] || numbers[2] == 0) throw bad();
    return {numbers[0], numbers[1], std::min(numbers[2], numbers[1] - numbers[0])};  // keeps later sums from
                                                                                     // overflowing
}

void checkFrameRange(const FrameRange& range, std::size_t count) {
    if (range.end > count)
        throw BadOption("frames", "must end at most at " + std::to_string(count) +
                                      ", the number of sampled frames, not " + std::to_string(range.end));
}

}  // namespace penumbra
