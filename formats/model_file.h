#pragma once
// x.model.h5: visibility as a function of the pose (HDF5, format "penumbra.model", version 1; README.md lists every
// dataset).
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/mesh.h"
#include "formats/provenance.h"
#include "sh/visibility_convention.h"

namespace penumbra {

constexpr int kModelVersion = 1;

enum class FeatureKind { kJointAngles, kRelativeBones };
enum class ModelKind { kLinear };
inline constexpr std::array kModelKinds{ModelKind::kLinear};
inline constexpr std::array kFeatureKinds{FeatureKind::kJointAngles, FeatureKind::kRelativeBones};
// The words of files and command lines.
const char* nameOf(ModelKind kind);
const char* nameOf(FeatureKind features);

// Raw features of a cluster, in this order (fit/features.h says the same, the run-time evaluator repeats it):
//   kJointAngles: the frame's pose vector, P numbers.
//   kRelativeBones: for every joint j != the cluster's own joint c, ascending, 12 numbers: position of j's centre in
//   c's rest frame, M_c^-1 M_j centre_j - centre_j, divided by `feature_scale`; then the 9 entries, row-major, of R_c^T
//   R_j - I, R = nearestRotation(M.linear()). M are the frame's skinning matrices.
// They are centred by feature_mean and projected on input_basis: x = input_basis (raw - feature_mean).
struct ClusterModel {
    std::vector<std::uint32_t> vertices;      // [Vc], ascending
    int joint = 0;                            // the cluster's own joint
    std::vector<float> feature_mean;          // [N]
    std::vector<float> input_basis;           // [I, N] row-major (rows: PCA directions)
    std::vector<float> input_min, input_max;  // [I], range of x over training frames
    std::vector<float> weights;               // [K, I] row-major: y = weights x + bias
    std::vector<float> bias;                  // [K]
    std::vector<float> mean;                  // [Vc, n], n = convention.size()
    std::vector<float> basis;                 // [K, Vc, n]: numbers = mean + sum_k y_k basis_k
    double ridge = 0;                         // alpha that cross-validation chose
    double train_error = 0,
           holdout_error = 0;  // sums of squares over variance, as relative error squared; holdout NaN if none

    int inputs() const { return int(input_min.size()); }
    int components() const { return int(bias.size()); }
    // Of all arrays above but `vertices`: what a run-time needs of this cluster.
    std::size_t numberCount() const {
        return feature_mean.size() + input_basis.size() + input_min.size() + input_max.size() + weights.size() +
               bias.size() + mean.size() + basis.size();
    }
};

struct ClipError {
    std::string clip;
    bool held_out = false;
    double relative_error = 0, rms_v = 0, ambient_error = 0;  // docs/formulas.md section 5
};

struct Model {
    Mesh mesh;
    Skin skin;
    std::vector<Vec3> rest_normals;   // [V]
    std::vector<Vec3> rest_tangents;  // [V], unit, orthogonal to rest_normals, carried by the cluster joint's rotation
    FrameList frames;                 // all frames of the visibility file, training and held out
    std::vector<Affine> bones;        // [F, J]
    int pose_size = 0;
    std::vector<float> pose;  // [F, P]
    std::vector<std::string> holdout_clips;

    Convention convention;
    ModelKind kind = ModelKind::kLinear;
    FeatureKind features = FeatureKind::kRelativeBones;
    double feature_scale = 1;         // box diagonal of the rest positions
    std::vector<Vec3> joint_centers;  // [J], weighted centroid of the rest positions that j moves
    double input_variance = 0.9, output_variance = 0.95;
    std::vector<std::uint32_t> cluster_of_vertex;  // [V]
    std::vector<ClusterModel> clusters;
    std::vector<ClipError> clip_errors;
    Provenance provenance;
};

void writeModel(const std::filesystem::path& path, const Model& model);
Model readModel(const std::filesystem::path& path);  // IoError, InvalidInput

}  // namespace penumbra
