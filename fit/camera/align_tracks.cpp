// Finds the similarity between the frames of reference of two tracks.
//
// Problem: with x_b = s R x_a + o, pose (R^, t^) of track b means in frame a the pose (R^ R, (R^ o + t^) / s). Find s,
// R and o that bring these to the poses of track a.
//
// Naive: compare the cameras' places alone (Umeyama), or two views (Nowrouzezahrai 2011, section 3.2). A marker tells
// the direction to itself ten times as well as its turn, and a turn that is off moves the camera's place by its whole
// distance; so places are the worst numbers to compare.
//
// Here: all is compared as the camera sees it. The residuals are the marker's place across the line of sight, along it,
// and the turn; each kind has a noise of its own, which is estimated from its residuals, and solved for again. Pictures
// that disagree with all others lose weight (Huber).
#include "fit/camera/align_tracks.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>

#include "formats/common/errors.h"
#include "sh/quaternion.h"

namespace penumbra {

namespace {

constexpr int kAlignRounds = 6;
constexpr double kMinNoise = 1e-9;  // as a part of the distance, and radians: for tracks without noise
constexpr double kHuberNoises = 2;  // residuals beyond so many times their noise count less
constexpr double kMinSpread = 0.1;  // degrees

// Standard deviations: of the marker's place across and along the line of sight, as a part of its distance, and of the
// turn in radians.
struct TrackNoise {
    double across = 1e-3, along = 5e-3, turn = 3e-3;
};

// Seven numbers: rotation vector of R, ln s, o.
using MapParameters = std::array<double, 7>;

// How far the pose of b, seen in a, is off that of a: two across, one along, three of the turn.
struct PairError {
    PosePair pair;
    TrackNoise noise;

    template <class T>
    bool operator()(const T* x, T* error) const {
        const T scale = ceres::exp(x[3]);
        const Vec3d seen = pair.a.translation, sight = normalized(seen);
        const double distance = length(seen);
        const Vec3d helper = std::abs(sight.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0};
        const Vec3d right = normalized(cross(helper, sight)), up = cross(sight, right);
        T off[3];
        for (int i = 0; i < 3; ++i) {
            off[i] = T(pair.b.translation[i]);
            for (int j = 0; j < 3; ++j) off[i] += pair.b.rotation(i, j) * x[4 + j];
            off[i] = off[i] / scale - seen[i];
        }
        const auto along = [&](Vec3d axis) { return off[0] * axis.x + off[1] * axis.y + off[2] * axis.z; };
        error[0] = along(right) / (distance * noise.across);
        error[1] = along(up) / (distance * noise.across);
        error[2] = along(sight) / (distance * noise.along);
        // turn = R_a^T R^ R, which is 1 where both agree.
        T turn[9], rest[3];
        ceres::AngleAxisToRotationMatrix(x, ceres::RowMajorAdapter3x3(turn));
        T product[9];
        const Mat3d between = transposed(pair.a.rotation) * pair.b.rotation;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                product[3 * i + j] =
                    between(i, 0) * turn[j] + between(i, 1) * turn[3 + j] + between(i, 2) * turn[6 + j];
        const T* shown = product;
        ceres::RotationMatrixToAngleAxis(ceres::RowMajorAdapter3x3(shown), rest);
        for (int i = 0; i < 3; ++i) error[3 + i] = rest[i] / noise.turn;
        return true;
    }
};

MapParameters parametersOf(const FrameMap& map) {
    const Vec3d turn = rotationVector(quaternionOf(map.rotation));
    return {turn.x, turn.y, turn.z, std::log(map.scale), map.origin.x, map.origin.y, map.origin.z};
}

FrameMap mapOf(const MapParameters& x) {
    return {std::exp(x[3]), matrixOf(rotationOf(Vec3d{x[0], x[1], x[2]})), {x[4], x[5], x[6]}};
}

// The turn of the pair in the middle of the order of agreement, then scale and origin from all places.
FrameMap startOf(std::span<const PosePair> pairs) {
    FrameMap out;
    double least = std::numeric_limits<double>::infinity();
    for (const PosePair& candidate : pairs) {
        const Mat3d turn = transposed(candidate.b.rotation) * candidate.a.rotation;
        double sum = 0;
        for (const PosePair& other : pairs) {
            const Mat3d rest = transposed(other.a.rotation) * (other.b.rotation * turn);
            sum += std::acos(std::clamp((rest(0, 0) + rest(1, 1) + rest(2, 2) - 1) / 2, -1.0, 1.0));
        }
        if (sum < least) least = sum, out.rotation = turn;
    }
    Vec3d middle_a, middle_b;
    for (const PosePair& pair : pairs) {
        middle_a += pair.a.place() / double(pairs.size());
        middle_b += pair.b.place() / double(pairs.size());
    }
    double product = 0, squares = 0;
    for (const PosePair& pair : pairs) {
        const Vec3d a = out.rotation * (pair.a.place() - middle_a), b = pair.b.place() - middle_b;
        product += dot(a, b);
        squares += dot(a, a);
    }
    out.scale = product > 0 && squares > 0 ? product / squares : 1;
    out.origin = middle_b - out.scale * (out.rotation * middle_a);
    return out;
}

// The standard deviation of values whose middle is 0, from their median, so that a few wrong poses do not count.
double noiseOf(std::vector<double> sizes) {
    std::ranges::nth_element(sizes, sizes.begin() + std::ptrdiff_t(sizes.size() / 2));
    return std::max(1.4826 * sizes[sizes.size() / 2], kMinNoise);
}

TrackNoise measuredNoise(std::span<const PosePair> pairs, const MapParameters& x) {
    std::vector<double> across, along, turn;
    for (const PosePair& pair : pairs) {
        double error[6];
        PairError{pair, {1, 1, 1}}(x.data(), error);
        across.insert(across.end(), {std::abs(error[0]), std::abs(error[1])});
        along.push_back(std::abs(error[2]));
        for (int i = 3; i < 6; ++i) turn.push_back(std::abs(error[i]));
    }
    return {noiseOf(across), noiseOf(along), noiseOf(turn)};
}

void solve(std::span<const PosePair> pairs, const TrackNoise& noise, MapParameters& x) {
    [[maybe_unused]] static const int quiet = FLAGS_minloglevel = google::GLOG_ERROR;  // Ceres prints of its own
    ceres::Problem problem;
    for (const PosePair& pair : pairs)
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PairError, 6, 7>(new PairError{pair, noise}),
                                 new ceres::HuberLoss(kHuberNoises * std::sqrt(6.0)), x.data());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 100;
    options.function_tolerance = options.parameter_tolerance = 1e-14;
    options.logging_type = ceres::SILENT;
    options.num_threads = 1;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable()) throw InvalidInput("no map between the two frames fits the poses");
}

std::map<std::string, std::size_t> framesByName(const CameraTrack& track) {
    std::map<std::string, std::size_t> out;
    for (std::size_t i = 0; i < track.frames.size(); ++i) {
        const std::string name = std::filesystem::path(track.frames[i].file).filename().string();
        if (!name.empty() && !out.try_emplace(name, i).second) throw InvalidInput("has two frames of the file " + name);
    }
    return out;
}

}  // namespace

CameraPose poseInA(const FrameMap& map, const CameraPose& b) {
    return {b.rotation * map.rotation, (b.rotation * map.origin + b.translation) / map.scale};
}

double spreadOf(std::span<const PosePair> pairs) {
    double most = 0;
    for (const PosePair& one : pairs)
        for (const PosePair& other : pairs) {
            const double cosine = dot(normalized(one.a.place()), normalized(other.a.place()));
            most = std::max(most, std::acos(std::clamp(cosine, -1.0, 1.0)));
        }
    return most * 180 / std::numbers::pi;
}

AlignedFrames alignFrames(std::span<const PosePair> pairs) {
    if (pairs.size() < 2)
        throw InvalidInput("have " + std::to_string(pairs.size()) + " pictures in common, and an alignment needs 2");
    AlignedFrames out;
    out.spread = spreadOf(pairs);
    double farthest = 0, distance = 0;
    for (const PosePair& pair : pairs) {
        farthest = std::max(farthest, length(pair.a.place() - pairs[0].a.place()));
        distance = std::max(distance, length(pair.a.translation));
    }
    if (!(farthest > distance * kMinSpread * std::numbers::pi / 180))
        throw InvalidInput("have all their cameras at one place, which tells no scale: move the camera");
    MapParameters x = parametersOf(startOf(pairs));
    TrackNoise noise;
    for (int round = 0; round < kAlignRounds; ++round) {
        solve(pairs, noise, x);
        noise = measuredNoise(pairs, x);
    }
    out.map = mapOf(x);
    for (const PosePair& pair : pairs) {
        const CameraPose mapped = poseInA(out.map, pair.b);
        const Vec3d off = mapped.place() - pair.a.place();
        const Vec3d turn = rotationVector(quaternionOf(transposed(pair.a.rotation) * mapped.rotation));
        out.place_rms += dot(off, off) / double(pairs.size());
        out.turn_rms += dot(turn, turn) / double(pairs.size());
    }
    out.place_rms = std::sqrt(out.place_rms);
    out.turn_rms = std::sqrt(out.turn_rms) * 180 / std::numbers::pi;
    return out;
}

std::vector<FramePair> pairFrames(const CameraTrack& a, const CameraTrack& b) {
    const std::map<std::string, std::size_t> in_a = framesByName(a), in_b = framesByName(b);
    std::vector<FramePair> out;
    const auto add = [&](std::size_t i, std::size_t j) {
        if (a.frames[i].pose && b.frames[j].pose && !a.frames[i].filled && !b.frames[j].filled) out.push_back({i, j});
    };
    if (in_a.empty() && in_b.empty()) {
        for (std::size_t i = 0; i < std::min(a.frames.size(), b.frames.size()); ++i) add(i, i);
        return out;
    }
    for (std::size_t i = 0; i < a.frames.size(); ++i) {
        const auto found = in_b.find(std::filesystem::path(a.frames[i].file).filename().string());
        if (found != in_b.end()) add(i, found->second);
    }
    return out;
}

}  // namespace penumbra
