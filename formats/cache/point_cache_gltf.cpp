// Reads glTF with animated morph targets and no skin as positions of all that is drawn, with node transforms applied.
#include <algorithm>
#include <array>
#include <memory>

#include "formats/cache/point_cache_build.h"
#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"
#include "formats/rig/rig_keys.h"
#include "formats/rig/rig_matrix.h"

namespace penumbra {

namespace {

double weightAt(const MorphChannel& channel, std::size_t targets, std::size_t target, const KeySpan& span) {
    const bool cubic = channel.interpolation == Interpolation::kCubicSpline;
    const std::size_t stride = cubic ? 3 * targets : targets;
    const float *from = &channel.values[span.from * stride], *to = &channel.values[span.to * stride];
    if (cubic) return cubicSpline(from, to, targets, target, span);
    if (channel.interpolation == Interpolation::kStep) return from[target];
    return from[target] + span.fraction * (double(to[target]) - from[target]);
}

// Returns a part's positions in its node's space.
std::vector<Vec3d> morphed(const RigSource& source, const SourcePart& part, int clip, double time) {
    std::vector<Vec3d> positions;
    positions.reserve(part.positions.size());
    for (const Vec3 p : part.positions) positions.push_back(toDouble(p));
    const MorphChannel* channel = nullptr;
    for (const MorphChannel& m : source.morphs)
        if (m.clip == clip && m.node == part.node) channel = &m;
    const KeySpan span = channel == nullptr ? KeySpan{} : findKeys(channel->times, time);
    for (std::size_t t = 0; t < part.targets.size(); ++t) {
        const double weight =
            channel == nullptr ? part.rest_weights[t] : weightAt(*channel, part.targets.size(), t, span);
        if (weight == 0) continue;
        for (std::size_t v = 0; v < part.targets[t].size(); ++v) positions[v] += weight * toDouble(part.targets[t][v]);
    }
    return positions;
}

// Returns the positions of all parts in the scene. `clip` -1 is the rest.
std::vector<Vec3d> positionsAt(const RigSource& source, int clip, double time) {
    std::vector<Matrix> globals =
        localTransforms(source.nodes, clip < 0 ? nullptr : &source.clips[std::size_t(clip)], time);
    for (std::size_t n = 0; n < globals.size(); ++n)
        if (source.nodes[n].parent >= 0)
            globals[n] = multiply(globals[std::size_t(source.nodes[n].parent)], globals[n]);
    std::vector<Vec3d> all;
    for (const SourcePart& part : source.parts)
        for (const Vec3d p : morphed(source, part, clip, time))
            all.push_back(transformPoint(globals[std::size_t(part.node)], p));
    return all;
}

void checkParts(const RigSource& source) {
    for (const SourcePart& part : source.parts)
        if (part.skin >= 0)
            throw Unsupported(source.file.string() + ": node '" + source.nodes[std::size_t(part.node)].name +
                              "' has a skin; it is a rig, and no point cache");
    for (const MorphChannel& channel : source.morphs)
        for (const SourcePart& part : source.parts)
            if (part.node == channel.node && part.targets.size() * channel.times.size() *
                                                     (channel.interpolation == Interpolation::kCubicSpline ? 3 : 1) !=
                                                 channel.values.size())
                failAtNode(source, part.node, "its primitives have different numbers of morph targets");
    if (source.morphs.empty())
        throw InvalidInput(source.file.string() + ": has no animation of morph targets, and a point cache needs one");
}

// Sets triangles and parts. Where a node mirrors at rest, its triangles are turned so that they keep their outside.
void setMesh(const RigSource& source, CacheFile& cache) {
    const std::vector<Matrix> globals = restGlobals(source.nodes);
    for (const SourcePart& part : source.parts) {
        const std::uint32_t first = std::uint32_t(cache.slot_of_vertex.size());
        const bool mirrored = determinant(globals[std::size_t(part.node)]) < 0;
        for (const Triangle& t : part.triangles)
            cache.triangles.push_back({first + t[0], first + t[mirrored ? 2 : 1], first + t[mirrored ? 1 : 2]});
        cache.slot_of_vertex.resize(first + part.positions.size(), slotOf(source, part, cache.slots));
    }
    cache.vertex_count = cache.slot_of_vertex.size();
}

std::vector<double> keysOf(const RigSource& source, std::size_t clip) {
    std::vector<double> times;
    for (const Channel& channel : source.clips[clip].channels)
        times.insert(times.end(), channel.times.begin(), channel.times.end());
    for (const MorphChannel& channel : source.morphs)
        if (std::size_t(channel.clip) == clip) times.insert(times.end(), channel.times.begin(), channel.times.end());
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    return times;
}

}  // namespace

CacheFile readGltfCache(const std::filesystem::path& path, double fps) {
    const auto source = std::make_shared<RigSource>(readGltf(path));
    if (fps > 0) throw BadOption("cache_fps", path.string() + " has key times of its own");
    selectParts(*source, {});
    checkParts(*source);
    CacheFile cache;
    cache.file = path;
    cache.files_read = source->files_read;
    setMesh(*source, cache);
    cache.rest = positionsAt(*source, -1, 0);
    for (std::size_t c = 0; c < source->clips.size(); ++c)
        cache.clips.push_back({source->clips[c].name, keysOf(*source, c)});
    cache.sample = [source](std::size_t clip, double time) { return positionsAt(*source, int(clip), time); };
    cache.read = [source, clips = cache.clips](std::size_t clip, std::size_t key) {
        return positionsAt(*source, int(clip), clips[clip].times[key]);
    };
    cache.frame_name = [source](std::size_t clip, std::size_t key) {
        return source->file.string() + ": clip '" + source->clips[clip].name + "': frame " + std::to_string(key);
    };
    return cache;
}

}  // namespace penumbra
