#pragma once
// x.transfer.h5: diffuse transfer as a linear function of the joint angles (HDF5, format "penumbra.transfer").
// These are the linear models of transfer, one linear map for each SH coefficient.
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "formats/common/file_format.h"
#include "formats/common/mesh.h"
#include "formats/common/provenance.h"

namespace penumbra {

constexpr FileFormat kTransferFormat{"penumbra.transfer", 1};

enum class TransferModelKind { kLinear, kPca };
constexpr std::array<TransferModelKind, 2> kTransferModelKinds{TransferModelKind::kLinear, TransferModelKind::kPca};
constexpr const char* nameOf(TransferModelKind kind) { return kind == TransferModelKind::kLinear ? "linear" : "pca"; }

// Transfer vectors lie in the model frame. With the angles a of a pose, coefficient c of all vertices is
//   linear: a X^c + bias,
//   pca:    mean + ((a pose_basis) X^c + bias) basis.
// n counts SH coefficients, V vertices, A angles, k and m the inputs and outputs of the maps.
struct TransferModel {
    int order = 6;
    TransferModelKind kind = TransferModelKind::kPca;
    Mesh mesh;
    std::vector<Vec3> rest_normals;  // [V]
    Skin skin;
    FrameList frames;                      // all frames of the bake, training and held out
    std::vector<Affine> bones;             // [F, J]
    int pose_size = 0;                     // P, the length of a pose
    std::vector<float> pose;               // [F, P]
    std::vector<std::string> input_names;  // [X] names of the last numbers of the pose
    std::vector<std::uint32_t> angles;     // [A] the numbers of the pose that the model sees, ascending, < P
    std::vector<float> pose_basis;         // [A, k] of pca, else empty: k = A
    std::vector<float> weights;            // [n, k + 1, m] X^c; the last row is the bias
    std::vector<float> basis;              // [m, V] of pca, else empty: m = V
    std::vector<float> mean;               // [V] of pca, else empty
    double alpha = 0;                      // ridge parameter (Nowrouzezahrai 2007, section 4.2)
    std::vector<std::string> holdout_clips;
    Provenance provenance;

    std::size_t coefficients() const { return std::size_t(order) * std::size_t(order); }
    std::size_t outputs() const {
        return kind == TransferModelKind::kLinear ? mesh.vertexCount() : basis.size() / mesh.vertexCount();
    }
    std::size_t inputs() const {
        return kind == TransferModelKind::kLinear ? angles.size() : pose_basis.size() / angles.size();
    }
};

// The bytes of a model as Nowrouzezahrai 2007 counts them in table 2: a linear model without its bias, and a PCA model
// without the mean of its vertices. A mesh is what the transfer of one pose takes.
std::size_t paperBytes(const TransferModel& model);
std::size_t paperMeshBytes(const TransferModel& model);
// The bytes of all floats that the model consists of.
std::size_t modelBytes(const TransferModel& model);

void writeTransfer(const std::filesystem::path& path, const TransferModel& model);
TransferModel readTransfer(const std::filesystem::path& path);  // throws IoError and InvalidInput

}  // namespace penumbra
