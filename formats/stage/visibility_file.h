#pragma once
// x.vis.h5: per-vertex SH visibility over an animation (HDF5, format "penumbra.visibility";
// formats/README.md lists every dataset). It is written frame by frame in bounded memory, and read by frame or by
// vertex range.
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/common/drawn_mesh.h"
#include "formats/common/file_format.h"
#include "formats/common/mesh.h"
#include "formats/common/provenance.h"
#include "formats/stage/visibility_shard.h"
#include "sh/dihedral_angles.h"

namespace penumbra {

constexpr FileFormat kVisibilityFormat{"penumbra.visibility", 1};

// The moments of what nearby parts of the skeleton block (/visibility/local). They are hemisphere moments like the
// coefficients, but only the local triangles of the mesh block rays: those whose part lies within `steps` of the
// vertex' part (formats/common/part_table.h). Without a skin all triangles of the mesh are local. The ground and
// occluders never are.
struct LocalMoments {
    int order = 5;  // SH bands, kMinLocalOrder..kMaxLocalOrder
    int steps = 2;  // 1..kMaxLocalSteps

    std::size_t coefficientCount() const { return std::size_t(order) * std::size_t(order); }
    bool operator==(const LocalMoments&) const = default;
};
constexpr int kMinLocalOrder = 5, kMaxLocalOrder = 6, kMaxLocalSteps = 8;

// What a file holds of each vertex and frame: V is the visibility of a direction s, N the normal.
constexpr const char* kHemisphereVisibility = "hemisphere_visibility";  // integral over s.N >= 0 of V y_i
constexpr const char* kMirroredVisibility = "mirrored_visibility";      // of predictions of D models
// t0_i, the integral over s.N >= 0 of V cos y_i, and with bounces the indirect transfer ("Light that
// bounces" in docs/formulas.md).
constexpr const char* kDiffuseTransfer = "diffuse_transfer";
constexpr int kMaxBounces = 16;

// What a surface does with the light that reaches it, in linear RGB: it reflects `albedo` and lets `transmission`
// through to its other side, both diffusely. Only two-sided meshes transmit.
struct SurfaceColors {
    std::vector<Vec3> albedo;             // [V] 0 <= albedo < 1; empty: nothing is known
    std::vector<Vec3> transmission = {};  // [V] >= 0, albedo + transmission <= 1; empty: none

    bool operator==(const SurfaceColors&) const = default;
};

// Returns "" when the colours, each empty or one a vertex of `mesh`, can be, and otherwise what is wrong with them.
std::string findProblem(const SurfaceColors& colors, const Mesh& mesh);

struct VisibilityHeader {
    int order = 5;
    std::string quantity = kHemisphereVisibility;
    int rays = 0;  // directions above the horizon
    std::uint64_t seed = 0;
    int bounces = 0;                    // of diffuse transfer: how often light is reflected, 0..kMaxBounces; else 0
    SurfaceColors colors;               // of diffuse transfer with bounces, else empty
    std::optional<LocalMoments> local;  // set when the file has local moments
    std::optional<float> ground_y;      // height of the ground plane that blocked rays, if there was one
    std::optional<float> distance;  // metres at which occluders ceased to count (bake/trace/ray_reach.h), if they did
    Mesh mesh;
    std::optional<Skin> skin;
    // [V] rest normals that skinVertices() turned into the frames' normals (/mesh/rest_normals)
    std::vector<Vec3> rest_normals;
    std::optional<DrawnMesh> drawn;  // set where the mesh is a choice of points of a denser one, which blocked the rays
    FrameList frames;
    std::optional<ShardPlace> shard;  // set for a bake of some frames
    int pose_size = 0;                // P, inputs included
    std::string pose_parameterisation = kJointRotationVectors;
    std::vector<InnerEdge> edges;          // [E] edges of the fronts, only with kDihedralAngles: P = E + X
    std::vector<std::string> input_names;  // [X] names of the last numbers of the pose, which the mesh does not know
    Provenance provenance;

    std::size_t coefficientCount() const { return std::size_t(order) * order; }
    bool hasBounces() const { return quantity == kDiffuseTransfer && bounces > 0; }
    std::size_t indirectCount() const { return hasBounces() ? 3 * coefficientCount() : 0; }
    // All numbers of one vertex in one frame that the bake traces.
    std::size_t coefficientsOfVertex() const {
        return coefficientCount() + (local ? local->coefficientCount() : 0) + indirectCount();
    }
};

// One frame; the sizes are V, V, J (0 without skin), P, V n^2, V m^2 with the order m of the local moments (0
// without them), V 3 n^2 and 2 (0 without bounces).
struct VisibilityFrame {
    std::vector<Vec3> positions, normals;
    std::vector<Affine> bones;
    std::vector<float> pose;
    std::vector<float> coefficients;             // [V, n^2], model frame
    std::vector<float> local_coefficients = {};  // [V, m^2], model frame
    std::vector<float> indirect = {};            // [V, 3, n^2], model frame: light that bounced, a row a colour channel
    // The share of the traced rays that hit a surface, and the share of these hits that were backs of a one-sided
    // mesh, which reflect nothing.
    std::vector<float> hit_shares = {};
};

enum class Precision { kFloat32, kFloat16 };

// Returns how many frames the writer collects before it writes them: 64, or fewer where they take more than 96 MB.
std::size_t framesOfBlock(const VisibilityHeader& header);

class VisibilityWriter {
public:
    VisibilityWriter(const std::filesystem::path& path, const VisibilityHeader& header, Precision precision);
    ~VisibilityWriter();                            // without finish(), nothing is left
    void writeFrame(const VisibilityFrame& frame);  // frames come in order
    void finish();  // call it after frameCount() frames; only then the file gets its name

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

// Tells in which file a frame of a whole lies.
struct FrameSource {
    std::uint32_t file = 0, frame = 0;
};

// Describes a file without frames of its own: they stay in others, which its name goes with. Other programs see them
// through HDF5 virtual datasets (NaN where a file is missing). VisibilityReader refuses a file that is missing or has
// changed.
struct VirtualSources {
    std::vector<std::string> files;             // relative to the folder of the virtual file
    std::vector<std::string> sha256;            // one for each file
    std::vector<std::uint32_t> frames_of_file;  // how many frames each has
    std::vector<FrameSource> source;            // [F]
};
void writeVirtualVisibility(const std::filesystem::path& path, const VisibilityHeader& header, Precision precision,
                            const VirtualSources& sources);

class VisibilityReader {
public:
    explicit VisibilityReader(const std::filesystem::path& path);  // throws IoError and InvalidInput
    ~VisibilityReader();
    const VisibilityHeader& header() const;
    Precision precision() const;
    bool isVirtual() const;
    VisibilityFrame readFrame(std::size_t frame) const;
    // Reads a frame without its coefficients and local moments, which is all that features and renderers need.
    VisibilityFrame readPose(std::size_t frame) const;
    // Reads the coefficients of vertices [begin, end) in all frames: out is [F, end - begin, n^2].
    void readVertices(std::size_t begin, std::size_t end, std::span<float> out) const;
    // Reads the local moments of vertices [begin, end) in all frames: out is [F, end - begin, m^2] with the order m of
    // header().local, which must be set.
    void readLocalVertices(std::size_t begin, std::size_t end, std::span<float> out) const;
    // Reads the indirect transfer of vertices [begin, end) in all frames: out is [F, end - begin, 3, n^2].
    // header().hasBounces() must be true.
    void readIndirectVertices(std::size_t begin, std::size_t end, std::span<float> out) const;
    // Reads a frame's hit shares. header().hasBounces() must be true.
    std::array<float, 2> readHitShares(std::size_t frame) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace penumbra
