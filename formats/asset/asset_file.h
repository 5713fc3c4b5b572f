#pragma once
// Opens x.pnb (FlatBuffers, formats/asset.fbs). Everything is checked once, when the file is opened. From then on
// readers trust every index, count and number. Only compact slices are copied, so the view is valid as long as the
// bytes are.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/common/file_format.h"
#include "formats/common/model_kind.h"
#include "formats/common/surface.h"
#include "sh/brdf/brdf_lobe.h"
#include "sh/brdf/membrane.h"
#include "sh/brdf/reflection_operator.h"
#include "sh/brdf/slice_form.h"
#include "sh/cast/caster_sphere.h"
#include "sh/far/part_field.h"
#include "sh/indirect_coefficients.h"
#include "sh/light/dominant_light.h"
#include "sh/morph_rows.h"
#include "sh/vec3.h"
#include "sh/visibility_convention.h"

namespace penumbra {

constexpr FileFormat kAssetFormat{"penumbra.asset", 1};
constexpr int kMaxLobes = 2 * kMaxOrder - 1;  // lobes of a light: as many as an exact one needs
constexpr int kMaxPictureWidth = 4096;        // pixels of a light's picture
constexpr std::size_t kMaxMaterials = 4096;   // materials of an asset; bounds what compact slices unfold to
constexpr std::string_view kAssetIdentifier = "PNB1";

enum class AssetPrecision : std::uint8_t { kF32 = 0, kF16 = 1, kI8 = 2 };
const char* nameOf(AssetPrecision precision);  // "f32", "f16", "i8"

struct NumbersView {
    AssetPrecision precision = AssetPrecision::kF32;
    std::size_t count = 0, row_length = 0;
    const std::byte* data = nullptr;  // 16-byte aligned
    std::span<const float> scale;     // I8: count / row_length
};
std::size_t bytesPerNumber(AssetPrecision precision);
// out.size() == numbers.count
void decode(const NumbersView& numbers, std::span<float> out);

// Morph targets of a mesh: asset.fbs has the rule. The weights are the last count() inputs of a pose, and in a model
// each has an input joint of one column.
struct MorphsView {
    std::span<const float> rest_weights;             // [M]
    std::span<const std::uint32_t> first, vertices;  // [M + 1], [R]
    std::span<const Vec3> positions, normals;        // [R]

    std::size_t count() const { return rest_weights.size(); }
    bool empty() const { return rest_weights.empty(); }
    MorphRows rowsOf(std::size_t target) const {
        const std::size_t begin = first[target], size = first[target + 1] - begin;
        return {vertices.subspan(begin, size), positions.subspan(begin, size), normals.subspan(begin, size)};
    }
};

// In a file with a model, vertices are in cluster order, every joint index is < J, and every row of weights sums to
// 1.
struct MeshView {
    std::span<const Vec3> positions, normals, tangents;  // [V]; tangents empty in a file without model
    std::span<const std::uint32_t> triangles;            // [3T]
    std::span<const std::uint32_t> shading_point;        // [V], < V: a permutation
    std::span<const std::uint32_t> source_vertex;        // [R]
    int influences = 0;
    std::span<const std::uint16_t> skin_joints;     // [V,K]
    std::span<const float> skin_weights;            // [V,K]
    std::vector<std::string_view> slots;            // the parts of the mesh that may have a material of their own
    std::span<const std::uint16_t> slot_of_vertex;  // [V], < slots; empty without slots
    bool two_sided = false;                         // asset.fbs has the rule; then V and T are even
    MorphsView morphs;
    bool cull_backs = false;                 // two_sided, or some triangles lie on others that face the other way
    std::span<const std::uint32_t> casting;  // [3S] as asset.fbs has it; empty: all triangles
    std::span<const std::uint32_t> castingTriangles() const { return casting.empty() ? triangles : casting; }
    // [Q] of the last Q vertices, which are of no cluster but follow three vertices that are; asset.fbs has the rule.
    std::span<const std::array<std::uint32_t, 3>> follower_corners;
    std::span<const std::array<float, 3>> follower_weights;
    std::size_t firstFollower() const { return positions.size() - follower_corners.size(); }
    // Returns the vertex itself, or the one that a follower has most of.
    std::size_t leaderOf(std::size_t vertex) const {
        if (vertex < firstFollower()) return vertex;
        const std::size_t q = vertex - firstFollower();
        const std::array<float, 3>& w = follower_weights[q];
        return follower_corners[q][w[0] >= w[1] && w[0] >= w[2] ? 0 : w[1] >= w[2] ? 1 : 2];
    }
    // Vs counts the shading points that are no backs. They come first in the bake's order, and their triangles come
    // first here.
    std::size_t pointCount() const { return positions.size() / (two_sided ? 2 : 1); }
    std::span<const std::uint32_t> frontTriangles() const {
        return triangles.first(triangles.size() / (two_sided ? 2 : 1));
    }
    // Returns the shading point that has the position of a vertex; for a back this is its front's.
    std::uint32_t pointOf(std::size_t vertex) const { return std::uint32_t(shading_point[vertex] % pointCount()); }
    bool isBack(std::size_t vertex) const { return shading_point[vertex] >= pointCount(); }
};

// Positions of the vertices of a deforming mesh in every frame.
struct PlaybackView {
    std::span<const std::uint16_t> positions;  // [F,Vs,3], or empty
    Vec3 origin;
    float step = 0, error = 0;  // metres
};

// Clips follow one another and cover all frames.
struct ClipView {
    std::string_view name;
    std::uint32_t first_frame = 0, frame_count = 0;
    bool held_out = false;
};

struct AnimationView {
    std::vector<std::string_view> joint_names;  // [J]
    std::span<const std::int32_t> parents;      // [J], -1 for roots, no cycles
    std::vector<ClipView> clips;
    std::span<const double> times;  // [F]
    std::span<const Affine> bones;  // [F,J]; may be empty for a deforming mesh
    std::uint32_t pose_size = 0;
    std::span<const float> pose;                            // [F,P] or empty
    std::span<const Affine> rest_transforms, inverse_bind;  // [J], or both empty
    std::vector<std::string_view> input_names;              // [X]
    std::span<const float> inputs;                          // [F,X]
    PlaybackView playback;
    std::size_t jointCount() const { return joint_names.size(); }
    std::size_t frameCount() const { return times.size(); }
    std::span<const Affine> bonesOf(std::size_t frame) const {
        return bones.empty() ? bones : bones.subspan(frame * jointCount(), jointCount());
    }
    std::span<const float> poseOf(std::size_t frame) const {
        return pose.empty() ? pose : pose.subspan(frame * pose_size, pose_size);
    }
    std::span<const float> inputsOf(std::size_t frame) const {
        return inputs.subspan(frame * input_names.size(), input_names.size());
    }
};

// Clusters follow one another and cover all vertices but the followers.
struct ClusterView {
    int joint = 0;
    std::uint32_t first_vertex = 0, vertex_count = 0;
    Vec3 center;
    std::span<const float> feature_mean;          // [N]
    NumbersView input_basis;                      // [I,N]
    std::span<const float> input_min, input_max;  // [I]
    std::span<const std::uint16_t> groups;        // [G]
    std::span<const float> group_weight;          // [G]
    NumbersView group_min, group_max;             // [G,D]
    std::size_t units = 0;                        // H
    NumbersView hidden;                           // [H,I+1], [H,D] or empty
    std::span<const std::uint16_t> unit_group;    // [H] or empty
    NumbersView weights;                          // [K,H]
    std::span<const float> bias;                  // [K]
    NumbersView mean, basis;                      // [vertex_count, stride], [K, vertex_count, stride]
    std::size_t inputs() const { return input_min.size(); }
    std::size_t components() const { return bias.size(); }
};

// A joint that stands for inputs; see asset.fbs.
struct InputJointView {
    int joint = 0;
    std::size_t column = 0, columns = 1;  // column: first among the inputs; columns: 1 or 3
    float offset = 0, scale = 1;
    bool absolute() const { return columns == 1; }
};

struct PartFieldView {
    PartField field;
    FieldBytes bytes;
};

// What makes a model a composed one; asset.fbs has the rule.
struct CompositionView {
    int local_steps = 0;
    bool floor = false;
    std::span<const std::uint8_t> steps;            // [P,P]
    std::span<const std::uint16_t> part_of_vertex;  // [V] < P
    std::vector<PartFieldView> parts;               // [P], at least one; joints < J
    float fade = 0;
    std::vector<ClusterView> residual;  // joints and vertices of the model's clusters, one for one; or empty
    // Near parts (sh/far/near_parts.h).
    std::size_t near_count = 0;                 // N <= kMaxNear; 0: none
    std::span<const std::uint16_t> near_parts;  // [P,N]
    std::span<const std::uint8_t> near_gains;   // [MeshView::firstFollower(),N]
    std::size_t byteCount() const;              // of the fields
};

// Light that bounces; see asset.fbs.
struct IndirectView {
    int bounces = 0;
    ColorAxes axes;
    std::vector<ClusterView> clusters;  // joints and vertices of the model's clusters, one for one
    float train_share = 0, holdout_share = -1, packing_error = 0;
};

struct ModelView {
    Convention convention;
    int stride = 0;
    ModelKind kind = ModelKind::kLinear;
    FeatureKind features = FeatureKind::kRelativeBones;
    float feature_scale = 1;
    std::span<const Vec3> joint_centers;  // [J]
    std::span<const Mat3> joint_spreads;  // [J]
    std::vector<ClusterView> clusters;
    float quantization_error = 0;
    bool deforming = false;                    // vertices are given, not skinned
    std::vector<InputJointView> input_joints;  // one for each of the last joints, in their order
    std::span<const float> pose_mean;          // [E], only for kDihedrals
    NumbersView pose_basis;                    // [P - X, E]
    std::optional<CompositionView> composition;
    std::optional<IndirectView> indirect;
};

// A model of Nowrouzezahrai 2007; asset.fbs has the formulas.
struct TransferView {
    int order = 0;
    std::span<const std::uint32_t> angles;  // [A] ascending, < pose_size; at least one
    std::span<const float> pose_basis;      // [A, k], or empty: k = A
    NumbersView weights;                    // [n (k + 1), m], at least one output
    NumbersView basis;                      // [m, V], or empty: m = V
    std::span<const float> mean;            // [V] with a basis
    float alpha = 0;
    bool reduced() const { return basis.count > 0; }
    std::size_t coefficients() const { return std::size_t(order) * std::size_t(order); }
    std::size_t inputs() const { return pose_basis.empty() ? angles.size() : pose_basis.size() / angles.size(); }
    std::size_t outputs() const { return weights.row_length; }
};

struct TruthView {
    int order = 0;
    bool is_transfer = false;  // else moments of visibility
    AssetPrecision precision = AssetPrecision::kF32;
    std::span<const std::byte> data;  // [F,V,order^2], V in the bake's order whatever the mesh's order is
};

// formats/asset.fbs has the formulas of operators and lobes.
struct OperatorsView {
    int count = 0, order = 0;     // count 0: the material has none
    std::span<const float> u, w;  // [channels, k, order^2], [channels, k, E]
};

struct MaterialView {
    std::string_view name;
    int slice_order = 0, view_order = 0, channels = 0;
    Vec3 color{1, 1, 1};
    std::span<const float> slices;  // [channels, J^2, E] for every form
    OperatorsView operators = {};
    SliceForm slice_form = SliceForm::kGeneral;
    std::span<const float> stored_slices = {};                     // as in the file: [channels, entries of the form]
    std::shared_ptr<const std::vector<float>> unfolded = nullptr;  // the numbers behind `slices` if the form is compact
    std::span<const BrdfLobe> lobes = {};                          // 1..kMaxBrdfLobes, for light from one direction
    float lobe_error = 0;  // of the lobes against the material, fit/reflectance/shading_error.h; 0: exact
    std::optional<Membrane> membrane = {};  // set: slices and lobes are those of a white Lambertian surface

    // Slices at steps of a parameter of some lobes; asset.fbs has the rule.
    std::span<const double> steps = {};                                  // [S] ascending; empty: there are none
    std::span<const float> step_slices = {};                             // [S, channels, J^2, E] for every form
    std::span<const float> stored_step_slices = {};                      // as in the file
    std::shared_ptr<const std::vector<float>> unfolded_steps = nullptr;  // the numbers behind `step_slices`, if compact
    std::size_t step_parameter = 0;
    float step_error = 0;
    std::uint8_t step_lobes = 1;  // bit i: lobe i has the parameter
    Vec3 emission = {};           // radiance of the surface itself
    bool hasSteps() const { return !steps.empty(); }

    // A live material is one lobe about the mirror direction (sh/brdf/mirror_lobe.h) and has no slices.
    bool isLive() const { return slices.empty() && !lobes.empty(); }
};

struct LobesView {
    std::span<const Vec3> directions;     // [D], unit; empty: the light has none
    std::span<const float> coefficients;  // [D, order, 3]
};

// A lat-long picture of half floats.
struct PictureView {
    int width = 0, height = 0;              // width = 2 height; 0: the light has none
    std::span<const std::uint16_t> texels;  // [height, width, 3]
};

struct LightView {
    std::string_view name;
    int order = 0;
    std::span<const float> sh;  // [n^2, 3], with the suns
    LobesView lobes = {};
    std::span<const Sun> suns = {};      // [S], at most kMaxSuns
    std::span<const float> window = {};  // [n] factors that the bands of sh have been multiplied by; empty: none
    PictureView picture = {};            // without the suns
};

// Spheres that cast in the place of the character: sphere s moves with bone joints[s] (movedBy(),
// sh/cast/caster_sphere.h).
struct BlockersView {
    std::span<const CasterSphere> spheres;  // [S], none or 1..kMaxBlockers
    std::span<const std::uint16_t> joints;  // [S], < J
    std::size_t byteCount() const { return spheres.size_bytes() + joints.size_bytes(); }
};

struct TextureView {
    std::string_view name, file;
    std::span<const std::byte> bytes;  // where `file` is empty
};

// Pictures on the mesh, as asset.fbs has it.
struct SurfaceView {
    std::span<const std::uint32_t> seam_vertices;                 // [E], < V
    std::span<const std::uint32_t> seam_corners, seam_of_corner;  // [S], < 3T ascending, and < E
    std::size_t uv_sets = 0;
    std::span<const Uv> uv;               // [uv_sets, V + E]
    std::span<const VertexColor> colors;  // [V + E], or empty: white
    std::span<const TangentTurn> turns;   // [V + E], or empty: none
    std::span<const SlotSurface> slots;   // [max(1, slots)]
    std::vector<TextureView> textures;

    // Returns the texture coordinates of a set, [V + E].
    std::span<const Uv> uvOf(std::size_t set) const {
        return uv.subspan(set * (uv.size() / uv_sets), uv.size() / uv_sets);
    }
    // Returns the corners of `triangles`, those of the mesh, with the copies in their places.
    std::vector<std::uint32_t> drawnTriangles(std::span<const std::uint32_t> triangles, std::size_t vertices) const {
        std::vector<std::uint32_t> out(triangles.begin(), triangles.end());
        for (std::size_t s = 0; s < seam_corners.size(); ++s)
            out[seam_corners[s]] = std::uint32_t(vertices + seam_of_corner[s]);
        return out;
    }
    std::size_t byteCount() const;
};

struct AssetView {
    std::string_view provenance;
    bool has_mesh = false, has_model = false, has_truth = false;
    // An asset of transfer has no model. Its `model` then says how the transfer of vertices lies in memory: stride, and
    // clusters that are pieces of the mesh without components.
    std::optional<TransferView> transfer;
    bool hasCharacter() const { return has_model || transfer.has_value(); }  // it can be posed and drawn
    MeshView mesh;
    AnimationView animation;
    ModelView model;
    TruthView truth;
    std::vector<MaterialView> materials;
    std::vector<LightView> lights;
    std::optional<SurfaceView> surface;
    std::vector<std::uint16_t> slot_material;  // [slots], < materials; empty without slots or materials
    BlockersView blockers;                     // empty where the file has none
    std::string name = "asset";                // the file's name, for messages
};

// Checks the bytes by FlatBuffers' verifier, the version and the content hash, then every count, index, range and
// finite number. Throws InvalidInput, which starts with `name` and says what is wrong. `bytes` must begin at a
// multiple of 16, as those of MappedFile and of new do.
AssetView openAsset(std::span<const std::byte> bytes, std::string_view name = "asset");

// Computes FNV-1a in steps of 8 bytes instead of one: h = (h ^ word) * 0x100000001b3 from 0xcbf29ce484222325, over
// the file's little-endian 64-bit words (the last one filled up with zeros) and then over its length. The word of
// content_hash counts as 0.
std::uint64_t assetHash(std::span<const std::byte> bytes, std::size_t hash_offset);
// Stores the hash in a finished file. Returns false when the verifier refuses the file or it has no hash field.
bool sealAsset(std::span<std::byte> bytes);

// Writes the positions of the shading points of a frame, [Vs]. The asset must have playback positions.
void readPositions(const AssetView& asset, std::size_t frame, std::span<Vec3> out);

// Writes the moments of one shading point of one frame, [order^2].
void readTruth(const AssetView& asset, std::size_t frame, std::size_t shading_point, std::span<float> out);

}  // namespace penumbra
