#pragma once
// x.lobes.h5: visibility as zonal lobes of every vertex, whose parameters are linear in the joint angles (HDF5, format
// "penumbra.lobes"). It is the model of Nowrouzezahrai 2008, section 3.1: a reference to compare with.
#include <filesystem>
#include <string>
#include <vector>

#include "formats/common/file_format.h"
#include "formats/common/mesh.h"
#include "formats/common/provenance.h"
#include "formats/stage/model_file.h"

namespace penumbra {

constexpr FileFormat kLobesFormat{"penumbra.lobes", 1};
constexpr int kMaxVisibilityLobes = 3;  // three jointly fitted lobes have as many numbers as SH of order 4

// Visibility is that of convention B in the local frames of the vertices. The principal components of the joint angles
// a, x = pose_basis (a - pose_mean), give the numbers of the lobes of a vertex, y = (x, 1) weights. Lobe c has 2 +
// order of them: where its axis is in the tangent plane of axes[c] (LobeChart), then its zonal coefficients z_l. The
// lobes add up to g_lm = sum over c of sqrt(4 pi / (2 l + 1)) z_l y_lm(axis) (Nowrouzezahrai 2008, equation 1).
// V counts vertices, C lobes of a vertex, I components, P numbers of a pose.
struct LobeModel {
    int order = 4;
    std::size_t lobes = 2;
    Mesh mesh;
    std::vector<Vec3> rest_normals;   // [V]
    std::vector<Vec3> rest_tangents;  // [V] as in Model
    Skin skin;
    std::vector<std::string> input_names;          // of the last numbers of the pose
    std::vector<std::uint32_t> cluster_of_vertex;  // [V]
    std::vector<int> joint_of_cluster;             // carries the tangents of the cluster
    std::vector<float> pose_mean;                  // [P]
    std::vector<float> pose_basis;                 // [I, P]
    std::vector<Vec3> axes;                        // [V, C], unit
    std::vector<float> weights;                    // [V, I + 1, C (2 + order)]; the last row is the bias
    double input_variance = 0.9;
    double ridge = 0;  // pulled the lobes of a frame to those of the mean; folds of the training frames chose it
    std::vector<std::string> holdout_clips;
    std::vector<ClipError> clip_errors;
    Provenance provenance;

    std::size_t inputs() const { return pose_mean.empty() ? 0 : pose_basis.size() / pose_mean.size(); }
    std::size_t valuesOfVertex() const { return lobes * (2 + std::size_t(order)); }
};

// The bytes of the floats that a run time would need. Nowrouzezahrai 2008 counts its models so: 6 numbers a lobe for
// each joint angle.
std::size_t modelBytes(const LobeModel& model);

void writeLobes(const std::filesystem::path& path, const LobeModel& model);
LobeModel readLobes(const std::filesystem::path& path);  // throws IoError and InvalidInput

}  // namespace penumbra
