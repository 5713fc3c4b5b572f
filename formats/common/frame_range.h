#pragma once
// Ranges of frames, A:B[:S].
#include <cstddef>
#include <string>

namespace penumbra {

// A half-open range over the sampled frames of all chosen clips in order: begin, begin + step, ... < end.
struct FrameRange {
    std::size_t begin = 0, end = 0, step = 1;
};

// Parses "A:B" or "A:B:S". Throws std::invalid_argument.
FrameRange parseFrameRange(const std::string& text);

// Throws BadOption when the range ends beyond a list of `count` frames.
void checkFrameRange(const FrameRange& range, std::size_t count);

}  // namespace penumbra
