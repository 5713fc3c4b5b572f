#pragma once
// Collects all triangles that block the rays of a bake: the fronts of the mesh first, then the --occluder meshes. It
// holds what does not change from frame to frame.
#include <cstdint>
#include <span>
#include <vector>

#include "bake/source/bake_source.h"
#include "bake/trace/see_through.h"
#include "bake/trace/vertex_side.h"

namespace penumbra {

struct Blockers {
    // indices count the front vertices of the mesh first, then the vertices of each occluder
    std::vector<Triangle> triangles;
    // The closed surface that each triangle is part of: +-1, +-2, ..., negative where its fronts face inwards; 0 =
    // none.
    std::vector<std::int32_t> solid;
    // [Vs] the closed surface that each vertex of the mesh is part of; 0 = none
    std::vector<std::int32_t> solid_of_vertex;

    // Inputs of SeeThrough, for all meshes together.
    Opacity opacity;
    std::vector<std::uint32_t> twins;  // twinTriangles(); empty: no triangle has one
    // [V] the vertex of the traced side of each vertex of the mesh: that of the first twin, for one that only second
    // twins use; else the vertex itself. Empty without twins.
    std::vector<std::uint32_t> front_of_vertex;

    VertexFans fans;  // fans of the mesh's vertices
    // [Vs] the first vertex of each vertex' place (firstOfSides()), which triangles, fans and solids use in its stead:
    // a hard edge is no border. Empty: every vertex has a place of its own.
    std::vector<std::uint32_t> place_of_vertex;
    std::uint32_t placeOf(std::uint32_t vertex) const {
        return place_of_vertex.empty() ? vertex : place_of_vertex[vertex];
    }

    // [Vs] 1 at the places whose rays start by the rules for sheets. Empty: at all places.
    std::vector<std::uint8_t> of_sheet;
    bool startsOverSheet(std::uint32_t place) const { return of_sheet.empty() || of_sheet[place] != 0; }
    // Keeps the rules for sheets to the corners of twins. The other points of `mesh` start as those of a rig without
    // twins: one that has sunk into another part is dark, and does not look out of it.
    void keepToTwins(const Mesh& mesh);

    SeeThrough through() const { return {&opacity, twins}; }
    // Tells the opacity of the triangles that are added next, and which of them lie on one another. Points without a
    // skin move as they like, and have no twins.
    void addSurface(const Mesh& mesh, const Skin* skin);

    // The vertex of the traced side of a vertex [V] of the mesh.
    std::uint32_t frontOf(std::uint32_t vertex) const {
        return front_of_vertex.empty() ? vertex % std::uint32_t(solid_of_vertex.size()) : front_of_vertex[vertex];
    }

    // Adds the triangles of a mesh, whose vertices get the next indices. The mesh of the bake comes first. `places`
    // has firstOfSides() of a rig, and is empty for a cache, which has one vertex for each place.
    void add(std::span<const Triangle> more, std::span<const Vec3> rest_positions,
             std::vector<std::uint32_t> places = {});
    std::size_t vertices = 0;  // vertices of all meshes added so far
    std::int32_t solids = 0;   // closed surfaces so far
};

// --- Occluders ------------------------------------------------------------------------------------------------------
// A mesh that blocks rays and has no shading points. It stands still when it has no clip or only one frame. Otherwise
// it moves with the clip of the same name, or with its only clip when the bake has only one clip too.
struct Occluder {
    BakeSource source;
    std::string name;        // name as given on the command line
    std::vector<int> clips;  // the occluder's clip for each name that readOccluders() was given; -1 = at rest
};
// Splits "body.obj:body.mdd" into "body.obj" and "body.mdd", the files of one --occluder. One of them brings the mesh
// and the others what moves it, in any order, as the files of a bake do. A path that exists is one file, whatever its
// name is. A path with nothing before or after a colon is one file too.
std::vector<std::filesystem::path> filesOfOccluder(const std::filesystem::path& occluder);
// Returns the files of all occluders that can be named before they are read. Patterns and folders of numbered files
// cannot.
std::vector<std::filesystem::path> singleFilesOf(const std::vector<std::filesystem::path>& occluders);

// Reads the occluders. `clips` are those of what is baked. Throws UsageError for a moving occluder that has no clip
// of one of these names, and the errors of readSource().
std::vector<Occluder> readOccluders(const std::vector<std::filesystem::path>& paths, const PointCacheOptions& options,
                                    const std::vector<std::string>& clips);

// Appends the occluder's positions at a time of clips[clip]. Throws InvalidInput when its clip ends before that time,
// or when a vertex is not finite.
void appendPositions(const Occluder& occluder, std::size_t clip, double time, std::vector<Vec3>& positions);

}  // namespace penumbra
