#pragma once
// x.pnb (FlatBuffers, formats/asset.fbs): the view that readers use, checked once when it is opened. From then on every
// index, count and number is trusted. Nothing is copied: the view is valid as long as the bytes are.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sh/vec3.h"
#include "sh/visibility_convention.h"

namespace penumbra {

constexpr int kAssetVersion = 1;
constexpr std::string_view kAssetIdentifier = "PNB1";

enum class AssetPrecision : std::uint8_t { kF32 = 0, kF16 = 1, kI8 = 2 };
enum class AssetFeatures : std::uint8_t { kJointAngles = 0, kRelativeBones = 1 };

struct NumbersView {
    AssetPrecision precision = AssetPrecision::kF32;
    std::size_t count = 0, row_length = 1;
    const std::byte* data = nullptr;  // 16-byte aligned
    std::span<const float> scale;     // I8: count / row_length
};
// out.size() == numbers.count
void decode(const NumbersView& numbers, std::span<float> out);

struct MeshView {
    std::span<const Vec3> positions, normals, tangents;  // [V]; tangents may be empty
    std::span<const std::uint32_t> triangles;            // [3T]
    std::span<const std::uint32_t> shading_point;        // [V]
    std::span<const std::uint32_t> source_vertex;        // [R]
    int influences = 0;
    std::span<const std::uint16_t> skin_joints;  // [V,K]
    std::span<const float> skin_weights;         // [V,K]
};

struct ClipView {
    std::string_view name;
    std::uint32_t first_frame, frame_count;
    bool held_out;
};

struct AnimationView {
    std::vector<std::string_view> joint_names;
    std::vector<ClipView> clips;
    std::span<const double> times;  // [F]
    std::span<const Affine> bones;  // [F,J]
    std::uint32_t pose_size = 0;
    std::span<const float> pose;  // [F,P] or empty
    std::size_t jointCount() const { return joint_names.size(); }
    std::span<const Affine> bonesOf(std::size_t frame) const {
        return bones.subspan(frame * jointCount(), jointCount());
    }
    std::span<const float> poseOf(std::size_t frame) const {
        return pose.empty() ? pose : pose.subspan(frame * pose_size, pose_size);
    }
};

struct ClusterView {
    int joint;
    std::uint32_t first_vertex, vertex_count;
    std::span<const float> feature_mean;          // [N]
    NumbersView input_basis;                      // [I,N]
    std::span<const float> input_min, input_max;  // [I]
    std::span<const float> weights, bias;         // [K,I], [K]
    NumbersView mean, basis;                      // [vertex_count, stride], [K, vertex_count, stride]
};

struct ModelView {
    Convention convention;
    int stride = 0;
    AssetFeatures features = AssetFeatures::kRelativeBones;
    float feature_scale = 1;
    std::span<const Vec3> joint_centers;  // [J]
    std::vector<ClusterView> clusters;
    float quantization_error = 0;
};

struct TruthView {
    int order = 0;
    AssetPrecision precision = AssetPrecision::kF32;
    const std::byte* data = nullptr;  // [F,V,order^2]
};

struct MaterialView {
    std::string_view name;
    int slice_order, view_order, channels;
    Vec3 color;
    std::span<const float> slices;  // [channels, J^2, E]
};

struct LightView {
    std::string_view name;
    int order;
    std::span<const float> sh;  // [n^2, 3]
};

struct AssetView {
    std::string_view provenance;
    bool has_mesh = false, has_model = false, has_truth = false;
    MeshView mesh;
    AnimationView animation;
    ModelView model;
    TruthView truth;
    std::vector<MaterialView> materials;
    std::vector<LightView> lights;
};

// Verifier, version, content hash, then every count, index, range and finite number; InvalidInput says what is wrong.
AssetView openAsset(std::span<const std::byte> bytes);

// Moments of one vertex of one frame, [order^2].
void readTruth(const AssetView& asset, std::size_t frame, std::size_t vertex, std::span<float> out);

// A read-only memory map that lives as long as the object; IoError.
class MappedFile {
public:
    explicit MappedFile(const std::filesystem::path& path);
    ~MappedFile();
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;
    std::span<const std::byte> bytes() const;

private:
    void* address_ = nullptr;
    std::size_t size_ = 0;
};

}  // namespace penumbra
