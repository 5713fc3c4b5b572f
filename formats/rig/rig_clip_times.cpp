// Clips that begin before 0 s or long after it, and clips that move nothing that is drawn.
#include <algorithm>
#include <cstdio>
#include <limits>

#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

constexpr double kSaidStart = 0.5;      // s: a clip that begins later stands still at first, which is said
constexpr double kTrimmedStart = 1.0;   // s: a clip that begins later begins at its first key
constexpr double kShortestStart = 0.1;  // s: earlier first keys are those of exporters that count frames from 1

std::string seconds(double time) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g s", time);
    return text;
}

// Returns the time of the first key of a clip, or infinity where it has none.
double firstKey(const RigSource& source, std::size_t clip) {
    double first = std::numeric_limits<double>::infinity();
    for (const Channel& channel : source.clips[clip].channels) first = std::min(first, channel.times.front());
    for (const MorphChannel& channel : source.morphs)
        if (std::size_t(channel.clip) == clip) first = std::min(first, channel.times.front());
    return first;
}

void moveKeys(RigSource& source, std::size_t clip, double by) {
    for (Channel& channel : source.clips[clip].channels)
        for (double& time : channel.times) time += by;
    for (MorphChannel& channel : source.morphs)
        if (std::size_t(channel.clip) == clip)
            for (double& time : channel.times) time += by;
    source.clips[clip].duration += by;
    source.clips[clip].moved_by += by;
}

void say(RigSource& source, std::size_t clip, std::string effect) {
    source.notes.push_back({source.file.string(), "", "clip '" + source.clips[clip].name + "'", std::move(effect)});
}

// Tells whether two keys are at one time. Of those at the time of the first key only the last stays.
bool tidyKeys(std::vector<double>& times, std::vector<float>& values) {
    if (std::adjacent_find(times.begin(), times.end()) == times.end()) return false;
    const std::size_t width = values.size() / times.size();
    const auto last = std::upper_bound(times.begin(), times.end(), times.front()) - 1;
    values.erase(values.begin(), values.begin() + (last - times.begin()) * std::ptrdiff_t(width));
    times.erase(times.begin(), last);
    return true;
}

// Marks the nodes that move something that is drawn: those of skins and meshes, and all above them.
std::vector<bool> nodesOfParts(const RigSource& source) {
    std::vector<bool> marked(source.nodes.size());
    const auto mark = [&](int n) {
        for (; n >= 0 && !marked[std::size_t(n)]; n = source.nodes[std::size_t(n)].parent)
            marked[std::size_t(n)] = true;
    };
    for (const SourcePart& part : source.parts) {
        mark(part.node);
        if (part.skin >= 0)
            for (const int n : source.skins[std::size_t(part.skin)].nodes) mark(n);
    }
    return marked;
}

}  // namespace

void tidyClips(RigSource& source) {
    std::vector<bool> jumps(source.clips.size());
    for (std::size_t c = 0; c < source.clips.size(); ++c)
        for (Channel& channel : source.clips[c].channels)
            if (tidyKeys(channel.times, channel.values)) jumps[c] = true;
    for (MorphChannel& channel : source.morphs)
        if (tidyKeys(channel.times, channel.values)) jumps[std::size_t(channel.clip)] = true;
    for (std::size_t c = 0; c < source.clips.size(); ++c)
        if (jumps[c]) say(source, c, "has two keys at one time, where its value jumps");
    for (std::size_t c = 0; c < source.clips.size(); ++c) {
        const double first = firstKey(source, c);
        if (!(first < 0)) continue;
        say(source, c, "begins at " + seconds(first) + ", its keys are moved to begin at 0 s");
        moveKeys(source, c, -first);
    }
}

void trimLateClips(RigSource& source) {
    for (std::size_t c = 0; c < source.clips.size(); ++c) {
        const double first = firstKey(source, c), rest = source.clips[c].duration - first;
        if (!(first > kShortestStart && first < std::numeric_limits<double>::infinity())) continue;
        if (first >= kTrimmedStart || first >= rest) {
            say(source, c, "would stand still up to its first key at " + seconds(first) + ", so it begins there");
            moveKeys(source, c, -first);
        } else if (first >= kSaidStart) {
            say(source, c, "stands still up to its first key at " + seconds(first));
        }
    }
}

void dropIdleClips(RigSource& source) {
    if (source.parts.empty()) return;  // a file of clips, which the caller refuses
    const std::vector<bool> moves = nodesOfParts(source);
    std::vector<int> new_of_old;
    std::vector<Clip> kept;
    for (std::size_t c = 0; c < source.clips.size(); ++c) {
        const std::vector<Channel>& channels = source.clips[c].channels;
        const bool moves_nodes =
            std::any_of(channels.begin(), channels.end(), [&](const Channel& x) { return moves[std::size_t(x.node)]; });
        const bool morphs = std::any_of(source.morphs.begin(), source.morphs.end(),
                                        [&](const MorphChannel& x) { return std::size_t(x.clip) == c; });
        new_of_old.push_back(moves_nodes || morphs ? int(kept.size()) : -1);
        if (new_of_old.back() < 0)
            say(source, c, "moves nothing that is drawn (a camera or a light), left out");
        else
            kept.push_back(std::move(source.clips[c]));
    }
    source.clips = std::move(kept);
    for (MorphChannel& channel : source.morphs) channel.clip = new_of_old[std::size_t(channel.clip)];
}

}  // namespace penumbra
