#include "bake/source/bake_source.h"

#include <algorithm>

#include "bake/source/surface_opacity.h"
#include "formats/common/errors.h"
#include "formats/common/mesh_places.h"
#include "formats/rig/rig_build.h"
#include "formats/source/source_readers.h"

namespace penumbra {

std::vector<std::string> BakeSource::clipNames() const {
    std::vector<std::string> names;
    if (rig)
        for (const Clip& clip : rig->clips) names.push_back(clip.name);
    else
        for (const PointCacheClip& clip : cache->clips) names.push_back(clip.name);
    return names;
}

std::vector<std::string> BakeSource::notes() const {
    if (cache) return cache->notes;
    std::vector<std::string> lines;
    for (const RigNote& note : rig->notes) lines.push_back(textOf(note));
    return lines;
}

std::vector<std::uint32_t> BakeSource::places() const {
    if (!rig) return {};
    std::vector<std::uint32_t> first = firstOfSides(rig->mesh, rig->skin);
    for (std::size_t v = 0; v < first.size(); ++v)
        if (first[v] != v) return first;
    return {};
}

BakeSource readSource(const std::vector<std::filesystem::path>& paths, const PointCacheOptions& options,
                      const RigOptions& rig_options) {
    BakeSource source;
    const bool is_cache = isPointCache(paths.front());
    if (is_cache && !(rig_options.nodes.empty() && rig_options.without.empty()))
        throw BadOption(rig_options.nodes.empty() ? "without" : "nodes",
                        "is for rigs, and " + paths.front().string() + " is a point cache");
    if (is_cache)
        source.cache = readPointCache(paths, options);
    else
        source.rig = readRig(paths, rig_options);
    if (!source.rig) return source;
    readOpacity(*source.rig);
    if (rig_options.strict) refuseNotes(source.rig->notes);
    return source;
}

FrameList sampleFrames(const BakeSource& source, const std::vector<std::string>& clips, double fps) {
    return source.rig ? sampleFrames(*source.rig, clips, fps) : sampleFrames(*source.cache, clips, fps);
}

std::vector<int> clipIndices(const BakeSource& source, const std::vector<std::string>& names) {
    const std::vector<std::string> known = source.clipNames();
    std::vector<int> indices;
    for (const std::string& name : names) {
        const auto found = std::find(known.begin(), known.end(), name);
        indices.push_back(found == known.end() ? -1 : int(found - known.begin()));
    }
    return indices;
}

std::vector<Vec3> sourcePositions(const BakeSource& source, int clip, double time) {
    if (source.rig) return poseSource(source, clip, time).positions;
    return clip < 0 ? source.cache->mesh.rest_positions : samplePositions(*source.cache, std::size_t(clip), time);
}

SourcePose poseSource(const BakeSource& source, int clip, double time) {
    SourcePose out;
    if (source.rig) {
        RigPose pose = evaluatePose(*source.rig, clip, time);
        RestShape skinned;
        skinMorphed(source.rig->mesh, source.rig->skin, source.rig->rest_normals, {pose.bones, pose.weights}, skinned);
        out.positions = std::move(skinned.positions);
        out.normals = std::move(skinned.normals);
        out.bones = std::move(pose.bones);
        out.pose = std::move(pose.pose);
        out.morph_weights = std::move(pose.weights);
    } else {
        out.positions = sourcePositions(source, clip, time);
        out.normals = meshNormals(source.cache->mesh, out.positions);
    }
    return out;
}

}  // namespace penumbra
