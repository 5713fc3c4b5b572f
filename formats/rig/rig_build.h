#pragma once
// The importers hand this to the rig: what a file draws, before joints are chosen and vertices welded.
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/rig/rig_file.h"
#include "formats/rig/rig_matrix.h"
#include "formats/rig/rig_options.h"

namespace penumbra {

struct SourceSkin {
    std::vector<int> nodes;
    std::vector<Matrix> inverse_bind;  // one for each node
};

// The name of parts that have no material.
constexpr const char* kDefaultSlot = "default";

// The triangles that one node draws with one list of vertices.
struct SourcePart {
    int node = 0;
    int skin = -1;  // -1: the part moves rigidly with its node
    std::string material = kDefaultSlot;
    PartColor color;
    std::vector<Vec3> positions;
    std::vector<Vec3> normals;          // [vertices] unit, in the space of positions; empty: the file has none
    std::vector<Triangle> triangles;    // indices into positions
    int influences = 0;                 // influences of a vertex; 0 without skin
    std::vector<std::uint32_t> joints;  // [vertices, influences], indices into the skin; free where the weight is 0
    std::vector<double> weights;        // [vertices, influences], not yet normalised
    // Only with morph targets: what each adds to the positions at weight 1 (empty: nothing), and the weights at rest.
    std::vector<std::vector<Vec3>> targets;
    std::vector<std::vector<Vec3>> target_normals;  // what each adds to the normals; empty as above
    std::vector<double> rest_weights;               // one for each target
};

// The weights of a node's morph targets over time. They are interpolated as in Channel.
struct MorphChannel {
    int clip = 0;  // indexes RigSource::clips
    int node = 0;
    Interpolation interpolation = Interpolation::kLinear;
    std::vector<double> times;
    // for each key as many as the node's mesh has targets; three times as many with kCubicSpline
    std::vector<float> values;
};

struct RigSource {
    std::filesystem::path file;  // for messages
    std::vector<Node> nodes;     // parents before children
    std::vector<SourceSkin> skins;
    std::vector<SourcePart> parts;
    std::vector<Clip> clips;
    std::vector<MorphChannel> morphs;  // only if asked for
    std::vector<std::filesystem::path> files_read;
    std::vector<RigNote> notes;
};

// The importers check nodes, clips, indices and numbers. What is drawn may still be empty.
enum class Morphs : std::uint8_t { kIgnored, kRead };
RigSource readGltf(const std::filesystem::path& path, Morphs morphs = Morphs::kIgnored);
// Tells whether a glTF file animates morph targets and has no node with a skin. It reads only the JSON, and returns
// false where that is damaged.
bool hasOnlyMorphClips(const std::filesystem::path& path);
// Reads FBX, Collada and .x (rig_import.h).
RigSource readWithAssimp(const std::filesystem::path& path);
void collapseFbxPivots(RigSource& source);
// `extension` is in lower case, with its dot. The file's may be in any case.
bool isExtension(const std::filesystem::path& file, const char* extension);

// A rig of more vertices than this is refused before memory is taken for them.
constexpr std::size_t kMaxSourceVertices = std::size_t(1) << 24;
// Texture coordinates as large as this are refused: a float that large does not tell which texel it means.
constexpr double kFarthestUv = 1e6;

// Throw InvalidInput "FILE: WHAT" and "FILE: node 'NAME': WHAT".
[[noreturn]] void failAtFile(const std::filesystem::path& file, const std::string& what);
[[noreturn]] void failAtNode(const RigSource& source, int node, const std::string& what);

// Makes one rig of what the paths bring: the first brings mesh and skin. formats/source/source_readers.h reads them.
Rig joinRig(std::vector<RigSource> sources, const RigOptions& options);

// Takes the notes of all sources, each once.
std::vector<RigNote> takeNotes(std::vector<RigSource>& sources);
// Throws Unsupported with the first note where there is one.
void refuseNotes(const std::vector<RigNote>& notes);

// The joints of the rig, and which of them moves each part.
struct JointTable {
    std::vector<int> nodes;
    std::vector<Matrix> inverse_bind;
    std::vector<std::vector<int>> joint_of_skin;  // [skin][index in the skin]
    std::vector<int> joint_of_part;               // [part] for parts that move rigidly, else -1
    std::vector<Matrix> placement_of_part;        // [part] from the part's positions to rest_positions
};
// Chooses the joints. It may add a node for what stands still in the scene.
JointTable chooseJoints(RigSource& source);

// The vertices of all parts in order, with sorted and normalised weights. Welding then makes equal ones one shading
// point.
struct SourceVertices {
    std::vector<Vec3> positions;  // in the space that bone matrices map from
    std::vector<Triangle> triangles;
    int influences = 0;  // K
    std::vector<std::uint16_t> joints;
    std::vector<float> weights;
    std::vector<std::string> slots;  // "NODE/MATERIAL", in the order of first use
    std::vector<std::uint16_t> slot_of_vertex;
    std::vector<bool> used;          // [vertices] by a triangle of its part; empty: all are
    std::vector<std::uint8_t> side;  // [vertices] 1: of the layer behind another one; empty: 0
    std::vector<ColoredPart> part_colors;
};
// Returns the number of the part's "NODE/MATERIAL" in `slots`, and adds it where it is new.
std::uint16_t slotOf(const RigSource& source, const SourcePart& part, std::vector<std::string>& slots);
SourceVertices gatherVertices(const RigSource& source, const JointTable& table);
// What welding knows besides the mesh.
struct Welded {
    std::vector<Triangle> source_corners;      // Rig::source_corners
    std::vector<std::uint32_t> twin_of_point;  // [V] the first point that differs from this one in its slot alone
};
// Fills mesh and the joints and weights of skin, and drops triangles without area. Points have one slot, that of the
// triangles that use them, and one side: a place that two slots share has two points.
Welded weldVertices(const SourceVertices& vertices, Mesh& mesh, Skin& skin);

// Finds the places where two layers lie on one another with opposite faces, and tells which vertices are of the layer
// behind (SourceVertices::side). A vertex that both layers use becomes two: the second one stands behind all others,
// and so has no entry in the file. Returns for each of these the vertex that it is a copy of.
std::vector<std::uint32_t> splitLayers(SourceVertices& vertices);

// Gives the triangles of double-sided materials backs, which are points and triangles like any other, behind all
// others. rest_normals are known. A triangle that has one in the file gets none, nor does a surface that is closed but
// for small holes: nobody sees its inside.
void addBacks(Rig& rig);
// Tells whether a triangle is more than a line, by its double area against the square of its longest edge.
bool hasArea(const std::vector<Vec3>& positions, const Triangle& triangle);

// Replaces control characters by "_": names go into messages of one line, and into HDF5, which ends them at a NUL.
std::string cleanText(std::string text);
// Makes names unique: the second "arm" becomes "arm#2".
std::vector<std::string> uniqueNames(std::vector<std::string> names);

}  // namespace penumbra
