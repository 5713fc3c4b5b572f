#pragma once
// --frames A:B[:S]
#include <cstddef>
#include <string>

namespace penumbra {

// Half-open, over the sampled frames of all chosen clips in order: begin, begin + step, ... < end.
struct FrameRange {
    std::size_t begin = 0, end = 0, step = 1;
};

// "A:B" or "A:B:S". Throws UsageError.
FrameRange parseFrameRange(const std::string& text);

// UsageError when the range ends beyond a list of `count` frames.
void checkFrameRange(const FrameRange& range, std::size_t count);

}  // namespace penumbra
