#pragma once
// All triangles that block the rays of a bake: the fronts of the mesh, then --occluder meshes. What does not change
// from frame to frame.
#include <cstdint>
#include <span>
#include <vector>

#include "bake/bake_source.h"
#include "bake/vertex_side.h"

namespace penumbra {

struct Blockers {
    std::vector<Triangle> triangles;  // indices: fronts of the mesh, then the vertices of each occluder
    // Of each triangle: 0, or a closed surface that it is part of: +-1, +-2, ..., negative where its fronts face
    // inwards.
    std::vector<std::int32_t> solid;
    std::vector<std::int32_t> solid_of_vertex;  // [Vs] of the mesh, positive or 0

    VertexFans fans;  // of the mesh

    void add(std::span<const Triangle> more, std::span<const Vec3> rest_positions);  // of the next vertices
    std::size_t vertices = 0;
    std::int32_t solids = 0;
};

// --- Occluders ------------------------------------------------------------------------------------------------------
// A mesh that blocks rays and has no shading points. It stands still when it has no clip or a single frame; else it
// moves with the clip of the same name, or with its only clip when what is baked has one clip too.
struct Occluder {
    BakeSource source;
    std::string name;        // as it was given
    std::vector<int> clips;  // its clip for each of the names that readOccluders() was given; -1: as at rest
};
// "body.obj:body.mdd" as "body.obj" and "body.mdd": the files of one --occluder, of which one brings the mesh and
// others what moves it, in any order, as those of a bake. A path that exists is one file, whatever its name is, and so
// is one with nothing before or after a colon.
std::vector<std::filesystem::path> filesOfOccluder(const std::filesystem::path& occluder);
// Of all of them what can be named before it is read: no pattern or folder of numbered files.
std::vector<std::filesystem::path> singleFilesOf(const std::vector<std::filesystem::path>& occluders);

// `clips`: of what is baked. UsageError for an occluder that has several clips but none of a name; errors of
// readSource().
std::vector<Occluder> readOccluders(const std::vector<std::filesystem::path>& paths, const PointCacheOptions& options,
                                    const std::vector<std::string>& clips);

// Adds its positions at a time of clips[clip]. InvalidInput when its clip ends before, or a vertex is not finite.
void appendPositions(const Occluder& occluder, std::size_t clip, double time, std::vector<Vec3>& positions);

}  // namespace penumbra
