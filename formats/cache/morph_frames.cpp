// Tells a point cache from a face.
//
// Problem: glTF has no point caches. Exporters write each frame of a cloth as a morph target, and a clip that plays the
// targets. A face without a skeleton has targets and a clip of their weights, too, but there every weight means
// something by itself, and a pose is any mixture of them.
//
// Here: the keys tell. Frames are played in order, so that at each key one target has the weight 1, or two neighbours
// share it where a key lies between two frames. The clip is then at a place p: 0 is the rest, k is target k - 1, and
// the weights are those of linear interpolation at p. It grows from key to key, or starts again, and reaches the last
// target.
#include "formats/cache/morph_frames.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

constexpr std::size_t kFewestFrames = 8;  // fewer targets, shown one after the other, may well be those of a face
constexpr double kRounding = 0.01;        // in weights: files may store them in bytes

// Returns the place p of a key with these weights, or nothing where they are not those of a place.
std::optional<double> placeOf(const float* weights, std::size_t targets) {
    double place = 0, sum = 0;
    std::size_t first = targets, last = 0;
    for (std::size_t t = 0; t < targets; ++t) {
        if (std::abs(weights[t]) <= kRounding) continue;
        first = std::min(first, t);
        last = t;
        sum += weights[t];
        place += double(t + 1) * weights[t];
    }
    if (first == targets) return 0;
    const bool from_rest = first == 0 && last == 0 && sum > 0 && sum < 1;
    const bool is_mean = last <= first + 1 && weights[first] > 0 && weights[last] > 0;
    if (!from_rest && !(is_mean && std::abs(sum - 1) <= 2 * kRounding)) return std::nullopt;
    return from_rest ? place : place / sum;  // over hundreds of frames the rounding of the sum would add up
}

// Returns the last target that the channel reaches in order, counted from 1, or nothing where it plays no frames.
std::optional<double> lastFrame(const MorphChannel& channel) {
    const std::size_t per_key = channel.interpolation == Interpolation::kCubicSpline ? 3 : 1;
    if (channel.times.empty()) return std::nullopt;
    const std::size_t targets = channel.values.size() / (per_key * channel.times.size());
    double before = 0, most = 0;
    for (std::size_t key = 0; key < channel.times.size(); ++key) {
        const float* weights = &channel.values[(per_key * key + per_key / 2) * targets];
        const std::optional<double> place = placeOf(weights, targets);
        const bool starts_again = place && *place <= 1;
        if (!place || (*place < before - kRounding && !starts_again)) return std::nullopt;
        before = *place;
        most = std::max(most, *place);
    }
    return most;
}

std::size_t targetsOf(const RigSource& source, int node) {
    std::size_t most = 0;
    for (const SourcePart& part : source.parts)
        if (part.node == node) most = std::max(most, part.targets.size());
    return most;
}

}  // namespace

bool playsMorphFrames(const std::filesystem::path& path) try {
    if (!hasOnlyMorphClips(path)) return false;
    const RigSource source = readGltf(path);
    bool reaches_last = false;
    for (const MorphChannel& channel : source.morphs) {
        const std::size_t targets = targetsOf(source, channel.node);
        if (targets == 0) continue;  // the mesh is not drawn
        const std::optional<double> last = targets < kFewestFrames ? std::nullopt : lastFrame(channel);
        if (!last) return false;
        reaches_last = reaches_last || *last > double(targets) - kRounding;
    }
    return reaches_last;
} catch (const InvalidInput&) {
    return false;
} catch (const Unsupported&) {
    return false;
} catch (const IoError&) {
    return false;
}

}  // namespace penumbra
