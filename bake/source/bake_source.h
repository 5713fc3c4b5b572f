#pragma once
// Reads what moves in a bake: a rig or a point cache.
#include <optional>

#include "formats/cache/point_cache.h"
#include "formats/rig/rig_file.h"
#include "formats/rig/rig_options.h"

namespace penumbra {

struct BakeSource {
    std::optional<Rig> rig;  // exactly one of rig and cache is set
    std::optional<PointCache> cache;

    const Mesh& mesh() const { return rig ? rig->mesh : cache->mesh; }
    std::vector<std::filesystem::path>& filesRead() { return rig ? rig->files_read : cache->files_read; }
    const std::vector<std::filesystem::path>& filesRead() const { return rig ? rig->files_read : cache->files_read; }
    std::vector<std::string> clipNames() const;
    std::vector<std::string> notes() const;  // notes of its reader, one line each
    // firstOfSides() of a rig that has hard edges, else empty.
    std::vector<std::uint32_t> places() const;
};

// Reads a point cache where the first path is one (isPointCache()), and a rig otherwise. Throws the errors of
// readPointCache() and readRig().
BakeSource readSource(const std::vector<std::filesystem::path>& paths, const PointCacheOptions& options,
                      const RigOptions& rig_options = {});

// Lists the frames of these clips (all if empty) at `fps` samples a second, or at the clips' own keys for 0.
FrameList sampleFrames(const BakeSource& source, const std::vector<std::string>& clips, double fps);

// Returns for every name the index of the clip, or -1 (the rest pose) where the source has no clip of this name.
std::vector<int> clipIndices(const BakeSource& source, const std::vector<std::string>& names);

struct SourcePose {
    std::vector<Vec3> positions, normals;  // [V]; those of a rig may be infinite
    std::vector<Affine> bones;             // [J] of a rig, else empty
    std::vector<float> pose;               // [3J] of a rig, RigPose::pose; else empty
    std::vector<float> morph_weights;      // [M] of a rig with morph targets, else empty
};
// Poses the source at a time of a clip, in seconds. `clip` -1 is the rest pose.
SourcePose poseSource(const BakeSource& source, int clip, double time);

// Returns the positions alone.
std::vector<Vec3> sourcePositions(const BakeSource& source, int clip, double time);

}  // namespace penumbra
