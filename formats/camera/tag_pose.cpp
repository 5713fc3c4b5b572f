#include "formats/camera/tag_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <span>

#include "sh/quaternion.h"
#include "sh/symmetric_eigen.h"

namespace penumbra {

namespace {

using Matrix3 = Eigen::Matrix3d;
using Step = Eigen::Matrix<double, 6, 1>;
constexpr int kMaxSteps = 60;
constexpr double kFarOff = 1e6;  // pixels: the error of a point behind the camera

Matrix3 toEigen(const Mat3d& m) { return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.m.data()); }
Mat3d fromEigen(const Matrix3& m) {
    Mat3d out;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) out(i, j) = m(i, j);
    return out;
}
Vec3d fromEigen(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// Row j of `vectors` is the eigenvector of values[j], which are in no particular order. Eigen's decompositions would
// take ten times as long to compile as the rest of this file.
template <int n>
struct Axes {
    Eigen::Matrix<double, n, 1> values;
    Eigen::Matrix<double, n, n, Eigen::RowMajor> vectors;
};
template <int n>
Axes<n> axesOf(const Eigen::Matrix<double, n, n>& matrix) {
    Eigen::Matrix<double, n, n, Eigen::RowMajor> symmetric = matrix;
    Axes<n> out;
    constexpr std::size_t kNumbers = std::size_t(n) * n;
    diagonalise(n, std::span(symmetric.data(), kNumbers), std::span(out.vectors.data(), kNumbers));
    out.values = symmetric.diagonal();
    return out;
}

// The rotation that is nearest to a matrix of positive determinant: m (m^T m)^(-1/2).
Matrix3 nearestTurn(const Matrix3& m) {
    const Axes<3> axes = axesOf<3>(m.transpose() * m);
    Matrix3 root = Matrix3::Zero();
    for (int j = 0; j < 3; ++j) {
        const Eigen::Vector3d axis = axes.vectors.row(j).transpose();
        root += axis * axis.transpose() / std::sqrt(axes.values[j]);
    }
    return m * root;
}

// Turns the pose by step[0..2] about the camera and moves it by step[3..5] there.
CameraPose moved(const CameraPose& pose, const Step& step) {
    return {matrixOf(rotationOf(Vec3d{step[0], step[1], step[2]})) * pose.rotation,
            pose.translation + Vec3d{step[3], step[4], step[5]}};
}

Eigen::VectorXd errorsOf(const PinholeCamera& camera, std::span<const SeenPoint> points, const CameraPose& pose) {
    Eigen::VectorXd out(2 * Eigen::Index(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto at = project(camera, pose.rotation * points[i].point + pose.translation);
        out[2 * Eigen::Index(i)] = at ? at->x - points[i].pixel.x : kFarOff;
        out[2 * Eigen::Index(i) + 1] = at ? at->y - points[i].pixel.y : kFarOff;
    }
    return out;
}

// Central differences: the errors are smooth, and there are few points.
Eigen::MatrixXd slopesOf(const PinholeCamera& camera, std::span<const SeenPoint> points, const CameraPose& pose) {
    Eigen::MatrixXd out(2 * Eigen::Index(points.size()), 6);
    const double distance = length(pose.translation);
    for (int k = 0; k < 6; ++k) {
        Step step = Step::Zero();
        step[k] = k < 3 ? 1e-6 : 1e-6 * distance;
        out.col(k) = (errorsOf(camera, points, moved(pose, step)) - errorsOf(camera, points, moved(pose, -step))) /
                     (2 * step[k]);
    }
    return out;
}

double rms(const Eigen::VectorXd& errors) { return std::sqrt(2 * errors.squaredNorm() / double(errors.size())); }

// The homography from the plane z = 0 to the camera's plane z = 1, up to a factor: the null vector of two equations a
// point, whose points are scaled to a size near 1.
Matrix3 homographyOf(const PinholeCamera& camera, std::span<const SeenPoint> points) {
    Vec3d middle;
    for (const SeenPoint& one : points) middle += one.point / double(points.size());
    double size = 0;
    for (const SeenPoint& one : points) size = std::max(size, length(one.point - middle));
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2 * Eigen::Index(points.size()), 9);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d ray = viewRay(camera, points[i].pixel);
        const Eigen::RowVector3d p((points[i].point.x - middle.x) / size, (points[i].point.y - middle.y) / size, 1);
        const Eigen::Index r = 2 * Eigen::Index(i);
        rows.block<1, 3>(r, 0) = p;
        rows.block<1, 3>(r, 6) = -ray.x / ray.z * p;
        rows.block<1, 3>(r + 1, 3) = p;
        rows.block<1, 3>(r + 1, 6) = -ray.y / ray.z * p;
    }
    const Axes<9> axes = axesOf<9>(rows.transpose() * rows);
    Eigen::Index least;
    axes.values.minCoeff(&least);
    const Eigen::Matrix<double, 9, 1> h = axes.vectors.row(least).transpose();
    Matrix3 scaled, to_unit;
    scaled << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
    to_unit << 1 / size, 0, -middle.x / size, 0, 1 / size, -middle.y / size, 0, 0, 1;
    return scaled * to_unit;
}

// H is, up to a factor, (r1 r2 t): the first two columns of R, and t.
std::optional<CameraPose> poseOfHomography(Matrix3 h) {
    if (h(2, 2) < 0) h = -h;  // the marker's origin is in front of the camera
    const double scale = std::sqrt(h.col(0).norm() * h.col(1).norm());
    if (!(scale > 0) || !std::isfinite(scale)) return std::nullopt;
    h /= scale;
    const Vec3d third = cross(fromEigen(Eigen::Vector3d(h.col(0))), fromEigen(Eigen::Vector3d(h.col(1))));
    Matrix3 turn;
    turn << h.col(0), h.col(1), Eigen::Vector3d(third.x, third.y, third.z);
    return CameraPose{fromEigen(nearestTurn(turn)), fromEigen(Eigen::Vector3d(h.col(2)))};
}

// The pose whose plane is the mirror image of this one's about the line of sight to the middle of the points.
CameraPose mirrored(const CameraPose& pose, std::span<const SeenPoint> points) {
    Vec3d middle;
    for (const SeenPoint& one : points) middle += one.point / double(points.size());
    const Vec3d seen = pose.rotation * middle + pose.translation;
    const Vec3d sight = normalized(seen);
    const Vec3d normal{pose.rotation(0, 2), pose.rotation(1, 2), pose.rotation(2, 2)};
    const Vec3d other = sight * (2 * dot(normal, sight)) - normal;
    const Vec3d axis = cross(normal, other);
    const double sine = length(axis);
    if (sine == 0) return pose;  // seen along its normal, where both are one
    const Mat3d turn = matrixOf(rotationOf(axis * (std::atan2(sine, dot(normal, other)) / sine))) * pose.rotation;
    return {turn, seen - turn * middle};
}

}  // namespace

std::array<Vec3d, 4> tagCorners(double side) {
    const double s = side / 2;
    return {Vec3d{-s, -s, 0}, Vec3d{s, -s, 0}, Vec3d{s, s, 0}, Vec3d{-s, s, 0}};
}

std::vector<SeenPoint> seenCorners(const DetectedTag& tag, double side) {
    const std::array<Vec3d, 4> corners = tagCorners(side);
    std::vector<SeenPoint> out;
    for (std::size_t i = 0; i < 4; ++i) out.push_back({corners[i], tag.corners[i]});
    return out;
}

PoseEstimate refinePose(const PinholeCamera& camera, std::span<const SeenPoint> points, const CameraPose& start) {
    CameraPose pose = start;
    Eigen::VectorXd errors = errorsOf(camera, points, pose);
    double damping = 1e-4;
    for (int step = 0; step < kMaxSteps && damping < 1e10; ++step) {
        const Eigen::MatrixXd slopes = slopesOf(camera, points, pose);
        Eigen::Matrix<double, 6, 6> normal = slopes.transpose() * slopes;
        normal.diagonal() *= 1 + damping;
        const Step change = normal.ldlt().solve(-slopes.transpose() * errors);
        if (!change.allFinite()) break;
        const CameraPose next = moved(pose, change);
        const Eigen::VectorXd next_errors = errorsOf(camera, points, next);
        if (!(next_errors.squaredNorm() < errors.squaredNorm())) {
            damping *= 10;
            continue;
        }
        const double gain = 1 - next_errors.squaredNorm() / errors.squaredNorm();
        pose = next;
        errors = next_errors;
        damping = std::max(damping / 10, 1e-12);
        if (gain < 1e-10) break;
    }
    pose.rotation = fromEigen(nearestTurn(toEigen(pose.rotation)));  // many small turns drift
    return {pose, rms(errors), 0};
}

std::optional<PoseEstimate> estimatePose(const PinholeCamera& camera, std::span<const SeenPoint> points) {
    const std::optional<CameraPose> start = poseOfHomography(homographyOf(camera, points));
    if (!start) return std::nullopt;
    PoseEstimate best = refinePose(camera, points, *start);
    PoseEstimate other = refinePose(camera, points, mirrored(best.pose, points));
    if (other.residual < best.residual) std::swap(best, other);
    if (!(best.residual < kFarOff / 2) || !std::isfinite(best.residual)) return std::nullopt;
    // Where both starts end in one pose, there is no second one.
    const Mat3d turn = best.pose.rotation * transposed(other.pose.rotation);
    const double cosine = (turn(0, 0) + turn(1, 1) + turn(2, 2) - 1) / 2;
    best.margin = cosine > 0.99999 ? 1 : 1 - best.residual / std::max(other.residual, 1e-12);
    return best;
}

}  // namespace penumbra
