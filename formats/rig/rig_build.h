#pragma once
// The importers hand this to the rig: what a file draws, before joints are chosen and vertices welded.
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/rig/rig_file.h"
#include "formats/rig/rig_matrix.h"
#include "formats/rig/rig_morphs.h"
#include "formats/rig/rig_options.h"
#include "formats/rig/source_look.h"

namespace penumbra {

struct SourceSkin {
    std::vector<int> nodes;
    std::vector<Matrix> inverse_bind;  // one for each node
};

// The name of parts that have no material.
constexpr const char* kDefaultSlot = "default";

// Hidden nodes and slots take part only if --nodes has their exact name.
enum class Visible : std::uint8_t { kShown, kHidden };

// The triangles that one node draws with one list of vertices.
struct SourcePart {
    int node = 0;
    int skin = -1;  // -1: the part moves rigidly with its node
    Visible visible = Visible::kShown;
    std::string material = kDefaultSlot;
    PartColor color;
    SourceLook look;  // glTF's default if there is no material
    std::vector<Vec3> positions;
    std::vector<Vec3> normals;          // [vertices] unit, in the space of positions; empty: the file has none
    std::vector<Triangle> triangles;    // indices into positions
    int influences = 0;                 // influences of a vertex; 0 without skin
    std::vector<std::uint32_t> joints;  // [vertices, influences], indices into the skin; free where the weight is 0
    std::vector<double> weights;        // [vertices, influences], not yet normalised
    // Only with morph targets: what each adds to the positions at weight 1 (empty: nothing), and the weights at rest.
    std::vector<std::vector<Vec3>> targets;
    std::vector<std::vector<Vec3>> target_normals;  // offset of each target's normals; may be empty, too
    std::vector<double> rest_weights;               // one for each target
    std::vector<std::string> target_names;          // one for each target, or none; "" where it has none
    GltfPlace gltf = {};
    Matrix instance = kIdentityMatrix;  // from the positions of the file to `positions`
    int mesh = -1;                      // parts of equal numbers draw the same mesh; -1: of no other
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

// Whether a format tells which of its axes is up.
enum class SourceAxes : std::uint8_t { kStated, kUnstated };

struct RigSource {
    std::filesystem::path file;  // for messages
    SourceAxes axes = SourceAxes::kStated;
    std::vector<Node> nodes;  // parents before children
    std::vector<SourceSkin> skins;
    std::vector<SourcePart> parts;
    std::vector<Clip> clips;
    std::vector<MorphChannel> morphs;
    std::vector<std::filesystem::path> files_read;
    std::vector<RigNote> notes;
    // Only of FBX files that FBX2glTF converted: what it made, and who did it how, for -v.
    std::shared_ptr<const std::vector<std::byte>> converted;
    std::vector<std::string> log;
};

// The importers check nodes, clips, indices and numbers. What is drawn may still be empty.
RigSource readGltf(const std::filesystem::path& path);
// Tells whether the clips of a glTF file animate morph targets and nothing else, and no node has a skin. It reads only
// the JSON, and returns false where that is damaged. playsMorphFrames() (morph_frames.h) tells what the weights are.
bool hasOnlyMorphClips(const std::filesystem::path& path);
// Reads FBX, Collada and .x (rig_import.h), whatever assimp makes of them.
RigSource readWithAssimp(const std::filesystem::path& path);
// Reads a motion capture file (rig_bvh.cpp), which has no mesh.
RigSource readBvh(const std::filesystem::path& path);
void collapseFbxPivots(RigSource& source);
// Reads Collada with assimp. Throws InvalidInput, and Unsupported for curves that are not read.
RigSource readCollada(const std::filesystem::path& path);
// Reads FBX with FBX2glTF or assimp, whichever reads the file right. Throws InvalidInput where it is damaged, and
// Unsupported where neither does.
RigSource readFbx(const std::filesystem::path& path);
// `extension` is in lower case, with its dot. The file's may be in any case.
bool isExtension(const std::filesystem::path& file, const char* extension);

// A rig of more vertices than this is refused before memory is taken for them.
constexpr std::size_t kMaxSourceVertices = std::size_t(1) << 24;
// Texture coordinates as large as this are refused: a float that large does not tell which texel it means.
constexpr double kFarthestUv = 1e6;

// Gives back the memory of a list, which an assignment of {} would keep.
template <class T>
void giveBack(std::vector<T>& list) {
    std::vector<T>().swap(list);
}

// Throw InvalidInput "FILE: WHAT" and "FILE: node 'NAME': WHAT".
[[noreturn]] void failAtFile(const std::filesystem::path& file, const std::string& what);
[[noreturn]] void failAtNode(const RigSource& source, int node, const std::string& what);

// Makes one rig of what the paths bring: the first brings mesh and skin. formats/source/source_readers.h reads them.
Rig joinRig(std::vector<RigSource> sources, const RigOptions& options);

// Leaves the parts that the options choose (rig_select.cpp). Throws BadOption for a pattern that matches no part.
void selectParts(RigSource& source, const RigOptions& options);
// Moves the keys of clips that begin before 0 s to begin there. Of keys at the time of a channel's first one only the
// last stays; elsewhere two keys at one time are a jump. Both are said.
void tidyClips(RigSource& source);
// Moves the keys of a clip to begin at 0 s where its first key comes after 1 s, or after more than half of the clip. A
// note tells it, and also tells which clips stand still for half a second or longer.
void trimLateClips(RigSource& source);
// Leaves out clips that move nothing that is drawn, with a note.
void dropIdleClips(RigSource& source);

// Moves the clips of another file to the rig (rig_clips.cpp). Joints are matched by their names (rig_names.h), and keys
// are moved to the rig's rest pose (rig_retarget.h). Throws InvalidInput where less than half of the moved nodes match,
// and where the rest poses do not fit. What is left out becomes notes.
void addClips(RigSource& rig, RigSource&& from);
// Gives a node with a matrix the translation, rotation and scale that it is made of. Throws InvalidInput, which names
// the node and who animates it, where the matrix has shear.
void makeAnimatable(RigSource& source, int node, const std::string& by);

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

// A vertex has at most so many influences, the largest ones. An asset counts them in a byte, and a row of the table of
// all vertices is as long as that of the busiest.
constexpr std::size_t kMaxInfluences = 64;
// A vertex whose weights sum to less has none.
constexpr double kNoWeight = 1e-6;
// Pushes a note for each part with vertices of triangles that have no weights, and for those with more influences than
// kMaxInfluences.
void sayInfluences(RigSource& source);

// The vertices of all parts in order, with sorted and normalised weights. Welding then makes equal ones one shading
// point.
struct SourceVertices {
    std::vector<Vec3> positions;  // in the space that bone matrices map from
    std::vector<Vec3> normals;    // [vertices] unit, in the same space; 0 where the file has none; empty: nowhere any
    std::vector<Triangle> triangles;
    int influences = 0;  // K
    std::vector<std::uint16_t> joints;
    std::vector<float> weights;
    std::vector<std::string> slots;  // "NODE/MATERIAL", in the order of first use
    std::vector<std::uint16_t> slot_of_vertex;
    std::vector<ColoredPart> part_colors;
    SourceMorphs morphs;
};
// Returns the number of the part's "NODE/MATERIAL" in `slots`, and adds it where it is new.
std::uint16_t slotOf(const RigSource& source, const SourcePart& part, std::vector<std::string>& slots);
SourceVertices gatherVertices(const RigSource& source, const JointTable& table);
// Further results of welding.
struct WeldedPoints {
    std::vector<Vec3> rest_normals;            // [V] unit
    std::vector<std::size_t> vertex_of_point;  // [V] the first vertex of each shading point
    std::vector<std::size_t> first_of_place;   // [V] the first vertex of its place, which gives position and skin row
    std::vector<std::size_t> against_winding;  // vertices whose normal the triangles' winding contradicts, ascending
    std::vector<Triangle> source_corners;      // Rig::source_corners
};
// Fills mesh and the joints and weights of skin, and drops triangles without area. A place with several normals has
// several shading points (rig_normals.h), and so has one of several slots; their rest positions and skin rows have the
// same bits. Of `vertices` only morphs, slots and parts are left, as a scan would not fit twice.
WeldedPoints weldVertices(SourceVertices& vertices, const RigOptions& options, Mesh& mesh, Skin& skin);

// Gives the triangles of double-sided materials backs, which are points and triangles like any other, behind all
// others. rest_normals and morph targets are known. A triangle that has one in the file gets none, nor does a surface
// that is closed but for small holes: nobody sees its inside.
void addBacks(Rig& rig);
// Tells whether a triangle is more than a line, by its double area against the square of its longest edge.
bool hasArea(const std::vector<Vec3>& positions, const Triangle& triangle);

// Adds notes to the source about meshes that stand for others (rig_twins.cpp). `posed` [V] are the rig's shading points
// at rest in the scene.
void noteTwins(RigSource& source, const Rig& rig, const std::vector<Vec3>& posed);

// Replaces control characters by "_": names go into messages of one line, and into HDF5, which ends them at a NUL.
std::string cleanText(std::string text);
// Makes names unique: the second "arm" becomes "arm#2".
std::vector<std::string> uniqueNames(std::vector<std::string> names);

}  // namespace penumbra
