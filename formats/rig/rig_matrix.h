#pragma once
// Double-precision transforms for the rig importer: affine 3x4 matrices.
#include <array>
#include <optional>

#include "formats/rig/rig_file.h"
#include "sh/quaternion.h"

namespace penumbra {

using Matrix = std::array<double, 12>;  // row-major 3x4; the last row is 0 0 0 1

constexpr Matrix kIdentityMatrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

Matrix toMatrix(const Affine& a);
Matrix multiply(const Matrix& a, const Matrix& b);
Vec3d transformPoint(const Matrix& a, Vec3d p);
double determinant(const Matrix& a);  // determinant of the linear part
// Returns nothing where the columns of the linear part are linearly dependent to 1e-12 (for instance a scale of 0).
std::optional<Matrix> inverse(const Matrix& a);
bool allFinite(const Matrix& a);

// Returns translation x rotation x scale.
Matrix composeTransform(const std::array<double, 3>& translation, const Quaternion& rotation,
                        const std::array<double, 3>& scale);
struct Decomposition {
    std::array<double, 3> translation{};
    Quaternion rotation{0, 0, 0, 1};
    std::array<double, 3> scale{};
    bool exact = true;  // composeTransform() of the three gives the matrix back to 1e-6: there is no shear
};
// Takes the scale from the lengths of the columns (x is negative for a mirror), and the rotation from their
// directions.
Decomposition decompose(const Matrix& a);
// Returns the node's transform to its parent as it stands in the file.
Matrix restTransform(const Node& node);
// Returns every node's transform to its parent at a time of `clip`; null: at rest.
std::vector<Matrix> localTransforms(const std::vector<Node>& nodes, const Clip* clip, double time);
// Returns for every node the transform from the node to model space at rest. Parents come before children.
std::vector<Matrix> restGlobals(const std::vector<Node>& nodes);

}  // namespace penumbra
