#pragma once
// Writes the sections of an asset. The caller has checked what it writes; openAsset() checks it again on reading.
#include <flatbuffers/flatbuffers.h>

#include <array>
#include <span>
#include <string>
#include <vector>

#include "asset_generated.h"
#include "formats/asset/asset_file.h"
#include "formats/common/mesh.h"
#include "formats/common/sphere_blockers.h"
#include "pack/compress/quantize.h"

namespace penumbra {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

// Writes a vector that starts at a multiple of 16 in the file. T is the stored element; values are any struct of
// them.
template <class T, class Value>
Offset<flatbuffers::Vector<T>> writeVector(FlatBufferBuilder& builder, std::span<const Value> values) {
    const std::size_t count = values.size_bytes() / sizeof(T);
    builder.ForceVectorAlignment(count, sizeof(T), 16);
    return builder.CreateVector(reinterpret_cast<const T*>(values.data()), count);
}
template <class T, class Value>
Offset<flatbuffers::Vector<T>> writeVector(FlatBufferBuilder& builder, const std::vector<Value>& values) {
    return writeVector<T>(builder, std::span<const Value>(values));
}

Offset<fbs::Numbers> writeNumbers(FlatBufferBuilder& builder, const StoredNumbers& numbers);

struct MeshSection {
    std::vector<Vec3> positions, normals, tangents;
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> shading_point, source_vertex;
    int influences = 0;
    std::vector<std::uint16_t> skin_joints;
    std::vector<float> skin_weights;
    std::vector<std::string> slots;
    std::vector<std::uint16_t> slot_of_vertex;
    bool two_sided = false, cull_backs = false;
    std::vector<Triangle> casting = {};  // asset.fbs; empty: all triangles
    MorphTargets morphs = {};
    // Points that the last vertices follow; asset.fbs has the rule.
    std::vector<Triangle> point_corners = {};
    std::vector<std::array<float, 3>> point_weights = {};
};
// Tells what of a mesh lets light through and what has two sides. Vertex v of the mesh is vertex new_of_old[v] of the
// section.
void addSurface(const Mesh& mesh, const Skin* skin, std::span<const std::uint32_t> new_of_old, MeshSection& section);
Offset<fbs::Mesh> writeMesh(FlatBufferBuilder& builder, const MeshSection& mesh);

// The positions of every frame of a deforming mesh, in 16 bits a coordinate.
struct PlaybackSection {
    std::vector<std::uint16_t> positions;  // [F,Vs,3], or empty
    Vec3 origin;
    float step = 0, error = 0;  // error: the largest distance, measured on the numbers that readers compute
};
// Quantises positions [F,Vs]. The box of all frames is cut into 65535 steps of its longest side. Throws InvalidInput
// where a number is not finite.
PlaybackSection quantizePositions(std::span<const Vec3> positions);

struct AnimationSection {
    std::vector<std::string> joint_names;
    std::vector<std::int32_t> parents;
    std::vector<ClipView> clips;
    std::vector<double> times;
    std::vector<Affine> bones;
    int pose_size = 0;
    std::vector<float> pose;
    std::vector<Affine> rest_transforms, inverse_bind;  // empty where the model has none
    std::vector<std::string> input_names = {};
    std::vector<float> inputs = {};
    PlaybackSection playback = {};
};
Offset<fbs::Animation> writeAnimation(FlatBufferBuilder& builder, const AnimationSection& animation);

// Returns the clips of a list of frames; the names still belong to `frames`.
std::vector<ClipView> clipsOf(const FrameList& frames, std::span<const std::string> held_out);

// Finishes the asset with its hash. A section that is missing is a null offset. The builder then owns the finished
// bytes.
struct AssetSections {
    Offset<fbs::Mesh> mesh;
    Offset<fbs::Animation> animation;
    Offset<fbs::Model> model;
    Offset<fbs::Truth> truth;
    std::vector<Offset<fbs::Material>> materials;
    std::vector<Offset<fbs::Light>> lights;
    // The number of the material of each slot of the mesh. If this is empty, all slots have the first material.
    std::vector<std::uint16_t> slot_material;
    SphereBlockers blockers;  // empty where there are none
    Offset<fbs::Transfer> transfer = {};
    Offset<fbs::Surface> surface = {};
};
std::span<std::byte> finishAsset(FlatBufferBuilder& builder, const AssetSections& sections, int sh_order,
                                 const std::string& provenance);

}  // namespace penumbra
