#include "bake/bake_options.h"

#include <charconv>
#include <sstream>

#include "formats/errors.h"
#include "sh/sh_basis.h"

namespace penumbra {

template <class T>
static std::string outOfRange(const char* option, const char* range, T value) {
    std::ostringstream text;
    text << option << " must be " << range << ", not " << value;
    return text.str();
}

std::string findProblem(const BakeOptions& options) {
    // Written as "not inside" so that NaN is a problem too.
    if (!(options.fps >= 0 && options.fps <= 1000)) return outOfRange("--fps", "0..1000 samples a second", options.fps);
    if (options.poses && options.fps > 0 && options.clips.empty())
        return "--fps goes with --clips when there is --poses, which has times of its own";
    if (options.order < 1 || options.order > kMaxOrder) return outOfRange("--order", "1..8 bands", options.order);
    if (options.rays < 16 || options.rays > 1 << 16)
        return outOfRange("--rays", "16..65536 directions above the horizon", options.rays);
    if (!(options.bias >= 1e-7 && options.bias <= 0.1))
        return outOfRange("--bias", "1e-7..0.1 diagonals of the rest pose", options.bias);
    return "";
}

FrameRange parseFrameRange(const std::string& text) {
    const auto bad = [&]() {
        return UsageError("--frames must be A:B or A:B:S with whole numbers A < B and S >= 1, not '" + text + "'");
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
    return {numbers[0], numbers[1], numbers[2]};
}

}  // namespace penumbra
