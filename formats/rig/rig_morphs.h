#pragma once
// Morph targets of a rig: which weights it has, how clips drive them, and what they change.
//
// A weight belongs to a target of a node's mesh, and all primitives of the mesh share it. Targets of several nodes are
// one weight where the nodes draw the same mesh or the file gives both targets one name (the "jaw" of a head and of its
// teeth), and where rest pose and every clip give both the same weights. Otherwise each node has its own.
#include <map>
#include <span>
#include <string>
#include <vector>

#include "formats/common/morph_targets.h"
#include "formats/rig/rig_file.h"

namespace penumbra {

// The change of one vertex of the source for one weight. `turn` is what it adds to the normal that the file gives.
struct MorphChange {
    std::uint32_t weight = 0;
    Vec3 move, turn;
};

// The weights of a source, and the changes of its vertices in the order of the parts.
struct SourceMorphs {
    std::vector<std::string> names;                   // [M], unique
    std::vector<float> rest_weights;                  // [M]
    std::vector<std::vector<std::uint32_t>> of_node;  // [nodes] the weight of each target of the node's mesh
    std::vector<std::uint32_t> first;                 // [R + 1] vertex r has the changes first[r] <= i < first[r + 1]
    std::vector<MorphChange> changes;                 // changes of a vertex, by ascending weight
    // [R] the file's normal in the space of rest positions, at the scale of the turns; 0 where the file gives none
    std::vector<Vec3> normals;

    bool empty() const { return names.empty(); }
    std::span<const MorphChange> of(std::size_t vertex) const {
        return std::span(changes).subspan(first[vertex], first[vertex + 1] - first[vertex]);
    }
};

struct RigSource;
struct SourcePart;
// Takes the channels of morph weights of clip number `clip` of another file for the next clip of `rig`, whose nodes
// `node_of_name` finds. A node must have as many weights in both. Notes those that drive nothing. Returns whether any
// drives something.
bool addWeightChannels(const RigSource& from, int clip, const std::map<std::string, int>& node_of_name, RigSource& rig);
// Chooses the weights. Throws InvalidInput where the primitives of a mesh have different numbers of targets.
SourceMorphs planMorphs(const RigSource& source);
// Appends the vertices of the next part. `placement` maps its positions to rest positions (rig_matrix.h).
void appendMorphs(const SourcePart& part, const std::array<double, 12>& placement, SourceMorphs& out);
// Tells whether all targets change two vertices alike: their moves agree within `radius`, and their normals within
// some 20 degrees.
bool sameMorphs(const SourceMorphs& morphs, std::size_t a, std::size_t b, double radius);
// The vertices of the source that shading points [V] take their moves and their turns from. Points of one place move
// alike, so that no crack opens between them.
struct PointSources {
    std::span<const std::size_t> of_moves, of_turns;
};
// Sets mesh.morphs. Where the file gives no normals for targets, what a target adds to a rest normal is the change of
// the normal of vertexNormals().
void setMorphs(const SourceMorphs& source, const PointSources& from, const std::vector<Vec3>& rest_normals, Mesh& mesh);
// Returns the curves of all clips for the rig.
std::vector<WeightCurve> weightCurves(const RigSource& source, const SourceMorphs& morphs);

// Returns the weights [M] at a time of a clip, -1 being the rest pose. Times outside of the keys are clamped to these.
std::vector<float> weightsAt(const Rig& rig, int clip, double time);
// Adds weights [K, M] to clip number `clip`: row k counts from k seconds on, as the poses of rig_poses.h.
void addWeightKeys(int clip, std::vector<float> weights, Rig& rig);

}  // namespace penumbra
