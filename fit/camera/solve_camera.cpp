// Finds f, the principal point and the lens from pictures of a grid.
//
// Problem: the distances of all points in all pictures are least over five numbers of the camera and six of each pose.
// They have many local minima, so the start matters.
//
// Start: Zhang's closed form for f fails for small or level grids. A search over 25 focal lengths, without a lens,
// needs no such care: each gives the poses of some shots by homographies, and the one with the least median error wins.
//
// Then Ceres, first without the lens and with the principal point in the middle, then with all. Points that are off by
// more than a pixel (a wrongly read tag) count less, and in the end those far beyond the others not at all.
#include "fit/camera/solve_camera.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "formats/common/errors.h"
#include "sh/quaternion.h"

namespace penumbra {

namespace {

constexpr double kLooseError = 1;  // pixels
constexpr double kMinTilt = 5;     // degrees; below it f and distance cannot be told apart
constexpr std::size_t kStartShots = 8;

// What Ceres moves.
struct Unknowns {
    std::array<double, 3> pinhole{};           // f, cx, cy
    std::array<double, 2> lens{};              // k1, k2
    std::vector<std::array<double, 6>> poses;  // rotation vector, translation
};

// The distance between where a point of the plane is seen and where the camera puts it.
struct PointError {
    SeenPoint seen;

    template <class T>
    bool operator()(const T* pinhole, const T* lens, const T* pose, T* error) const {
        const T point[3] = {T(seen.point.x), T(seen.point.y), T(seen.point.z)};
        T at[3];
        ceres::AngleAxisRotatePoint(pose, point, at);
        for (int i = 0; i < 3; ++i) at[i] += pose[3 + i];
        if (!(at[2] > T(1e-9))) return false;
        const T x = at[0] / at[2], y = at[1] / at[2], square = x * x + y * y;
        const T scale = pinhole[0] * (T(1) + square * (lens[0] + square * lens[1]));
        error[0] = pinhole[1] + scale * x - seen.pixel.x;
        error[1] = pinhole[2] + scale * y - seen.pixel.y;
        return true;
    }
};

std::array<double, 6> parametersOf(const CameraPose& pose) {
    const Vec3d turn = rotationVector(quaternionOf(pose.rotation)), t = pose.translation;
    return {turn.x, turn.y, turn.z, t.x, t.y, t.z};
}

CameraPose poseOfParameters(const std::array<double, 6>& x) {
    return {matrixOf(rotationOf(Vec3d{x[0], x[1], x[2]})), {x[3], x[4], x[5]}};
}

PinholeCamera middleCamera(int width, int height, double f) {
    PinholeCamera camera;
    camera.width = width;
    camera.height = height;
    camera.f = f;
    camera.cx = (width - 1) / 2.0;
    camera.cy = (height - 1) / 2.0;
    return camera;
}

// Median error of some shots under a focal length; infinite where one has no pose.
double startError(const PinholeCamera& camera, std::span<const GridShot> shots) {
    const std::size_t step = (shots.size() + kStartShots - 1) / kStartShots;
    std::vector<double> errors;
    for (std::size_t i = 0; i < shots.size(); i += step) {
        const std::optional<PoseEstimate> pose = estimatePose(camera, shots[i].points);
        errors.push_back(pose ? pose->residual : 1e9);
    }
    std::ranges::nth_element(errors, errors.begin() + std::ptrdiff_t(errors.size() / 2));
    return errors[errors.size() / 2];
}

double findStart(int width, int height, std::span<const GridShot> shots) {
    double best = 0, least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 25; ++i) {
        const double f = 0.3 * std::max(width, height) * std::pow(1.18, i);
        const double error = startError(middleCamera(width, height, f), shots);
        if (error < least) least = error, best = f;
    }
    return best;
}

Unknowns startOf(int width, int height, std::span<const GridShot> shots) {
    const PinholeCamera camera = middleCamera(width, height, findStart(width, height, shots));
    Unknowns out;
    out.pinhole = {camera.f, camera.cx, camera.cy};
    for (const GridShot& shot : shots) {
        const std::optional<PoseEstimate> pose = estimatePose(camera, shot.points);
        if (!pose) throw InvalidInput(shot.file + ": its tags fit no pose of a camera");
        out.poses.push_back(parametersOf(pose->pose));
    }
    return out;
}

void addPoints(std::span<const GridShot> shots, Unknowns& x, ceres::Problem& problem) {
    for (std::size_t s = 0; s < shots.size(); ++s)
        for (const SeenPoint& seen : shots[s].points)
            problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PointError, 2, 3, 2, 6>(new PointError{seen}),
                                     new ceres::HuberLoss(kLooseError), x.pinhole.data(), x.lens.data(),
                                     x.poses[s].data());
}

void minimise(std::span<const GridShot> shots, Unknowns& x, std::array<double, 5>& deviations) {
    [[maybe_unused]] static const int quiet = FLAGS_minloglevel = google::GLOG_ERROR;  // Ceres prints of its own
    ceres::Problem problem;
    addPoints(shots, x, problem);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    options.num_threads = 1;  // the same sums for any machine
    ceres::Solver::Summary summary;
    problem.SetParameterBlockConstant(x.lens.data());
    problem.SetManifold(x.pinhole.data(), new ceres::SubsetManifold(3, {1, 2}));
    ceres::Solve(options, &problem, &summary);
    problem.SetParameterBlockVariable(x.lens.data());
    problem.SetManifold(x.pinhole.data(), nullptr);
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable()) throw InvalidInput(shots.front().file + ": no camera fits these pictures");
    // 1. The covariance of the camera's numbers for errors of one pixel; a singular one is no failure but no answer.
    ceres::Covariance::Options how;
    how.num_threads = 1;
    ceres::Covariance covariance(how);
    const double* pinhole = x.pinhole.data();
    const double* lens = x.lens.data();
    deviations.fill(std::numeric_limits<double>::infinity());
    if (!covariance.Compute({{pinhole, pinhole}, {lens, lens}}, &problem)) return;
    double of_pinhole[9], of_lens[4];
    covariance.GetCovarianceBlock(pinhole, pinhole, of_pinhole);
    covariance.GetCovarianceBlock(lens, lens, of_lens);
    deviations = {std::sqrt(of_pinhole[0]), std::sqrt(of_pinhole[4]), std::sqrt(of_pinhole[8]), std::sqrt(of_lens[0]),
                  std::sqrt(of_lens[3])};
}

double distanceOf(const PinholeCamera& camera, const CameraPose& pose, const SeenPoint& seen) {
    const std::optional<PixelPoint> at = project(camera, pose.rotation * seen.point + pose.translation);
    return at ? std::hypot(at->x - seen.pixel.x, at->y - seen.pixel.y) : 1e6;
}

// Leaves out the points that are off by more than six times the median, and half a pixel: corners that were refined
// towards something else. A shot keeps at least eight.
std::vector<GridShot> withoutStrays(std::span<const GridShot> shots, const PinholeCamera& camera, const Unknowns& x) {
    std::vector<std::vector<double>> distances;
    std::vector<double> all;
    for (std::size_t s = 0; s < shots.size(); ++s) {
        const CameraPose pose = poseOfParameters(x.poses[s]);
        std::vector<double>& here = distances.emplace_back();
        for (const SeenPoint& seen : shots[s].points) here.push_back(distanceOf(camera, pose, seen));
        all.insert(all.end(), here.begin(), here.end());
    }
    std::ranges::nth_element(all, all.begin() + std::ptrdiff_t(all.size() / 2));
    const double most = std::max(6 * all[all.size() / 2], 0.5);
    std::vector<GridShot> out;
    for (std::size_t s = 0; s < shots.size(); ++s) {
        GridShot& kept = out.emplace_back(GridShot{shots[s].file, {}});
        for (std::size_t i = 0; i < shots[s].points.size(); ++i)
            if (distances[s][i] <= most) kept.points.push_back(shots[s].points[i]);
        if (kept.points.size() < 8) kept.points = shots[s].points;
    }
    return out;
}

PinholeCamera cameraOf(int width, int height, const Unknowns& x) {
    PinholeCamera camera = middleCamera(width, height, x.pinhole[0]);
    camera.cx = x.pinhole[1];
    camera.cy = x.pinhole[2];
    camera.k1 = x.lens[0];
    camera.k2 = x.lens[1];
    return camera;
}

void measureResiduals(std::span<const GridShot> shots, SolvedCamera& out) {
    double all = 0;
    for (std::size_t s = 0; s < shots.size(); ++s) {
        double sum = 0;
        for (const SeenPoint& seen : shots[s].points) {
            const double distance = distanceOf(out.camera, out.poses[s], seen);
            sum += distance * distance;
        }
        out.residuals.push_back(std::sqrt(sum / double(shots[s].points.size())));
        out.points += shots[s].points.size();
        all += sum;
    }
    out.residual = std::sqrt(all / double(out.points));
    // Each of the two coordinates of a point has half of the square.
    for (double& deviation : out.deviations) deviation *= out.residual / std::sqrt(2.0);
}

void measureViews(std::span<const GridShot> shots, SolvedCamera& out) {
    std::set<int> fields;
    for (const GridShot& shot : shots)
        for (const SeenPoint& seen : shot.points) {
            const int column = std::clamp(int(8 * (seen.pixel.x + 0.5) / out.camera.width), 0, 7);
            fields.insert(8 * std::clamp(int(6 * (seen.pixel.y + 0.5) / out.camera.height), 0, 5) + column);
        }
    out.coverage = double(fields.size()) / 48;
    for (const CameraPose& pose : out.poses)
        out.tilt = std::max(out.tilt, std::acos(std::min(std::abs(pose.rotation(2, 2)), 1.0)) * 180 / std::numbers::pi);
}

}  // namespace

SolvedCamera solveCamera(int width, int height, std::span<const GridShot> shots) {
    if (shots.empty()) throw InvalidInput("no picture shows the grid");
    Unknowns x = startOf(width, height, shots);
    SolvedCamera out;
    minimise(shots, x, out.deviations);
    const std::vector<GridShot> kept = withoutStrays(shots, cameraOf(width, height, x), x);
    minimise(kept, x, out.deviations);
    out.camera = cameraOf(width, height, x);
    for (const std::array<double, 6>& pose : x.poses) out.poses.push_back(poseOfParameters(pose));
    measureResiduals(kept, out);
    measureViews(kept, out);
    for (const GridShot& shot : shots) out.strays += shot.points.size();
    out.strays -= out.points;
    if (out.tilt < kMinTilt)
        throw InvalidInput(shots.front().file + ": the grid is level with all pictures (" +
                           std::to_string(out.tilt).substr(0, 3) +
                           " degrees at most), which tells no focal length: tilt it by 20 to 45 degrees");
    if (const std::string problem = findProblem(out.camera); !problem.empty())
        throw InvalidInput(shots.front().file + ": the camera that fits best " + problem +
                           ": is the grid flat, and are its columns, rows, side and gap as given?");
    return out;
}

}  // namespace penumbra
