#pragma once
// What moves in a bake: a rig, or a point cache.
#include <optional>

#include "formats/cache/point_cache.h"
#include "formats/rig/rig_file.h"

namespace penumbra {

struct BakeSource {
    std::optional<Rig> rig;  // one of the two is there
    std::optional<PointCache> cache;

    const Mesh& mesh() const { return rig ? rig->mesh : cache->mesh; }
    std::vector<std::filesystem::path>& filesRead() { return rig ? rig->files_read : cache->files_read; }
    const std::vector<std::filesystem::path>& filesRead() const { return rig ? rig->files_read : cache->files_read; }
    std::vector<std::string> clipNames() const;
};

// A cache where the first path is one (isPointCache()), else a rig. Errors of readPointCache() and readRig().
BakeSource readSource(const std::vector<std::filesystem::path>& paths, const PointCacheOptions& options);

FrameList sampleFrames(const BakeSource& source, const std::vector<std::string>& clips, double fps);

// Index of the clip of every name; -1 (the rest) for a name that the source does not have.
std::vector<int> clipIndices(const BakeSource& source, const std::vector<std::string>& names);

struct SourcePose {
    std::vector<Vec3> positions, normals;  // [V]; of a rig they may be infinite
    std::vector<Affine> bones;             // [J] of a rig
    std::vector<float> pose;               // [3J] of a rig, RigPose::pose
};
// `clip` -1: at rest.
SourcePose poseSource(const BakeSource& source, int clip, double time);

// Positions alone.
std::vector<Vec3> sourcePositions(const BakeSource& source, int clip, double time);

}  // namespace penumbra
