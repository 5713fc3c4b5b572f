#include "fit/papers/align/two_views.h"

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

// A determinant below this part of |d1| |d2| is that of rays at one azimuth, within a degree.
constexpr double kParallelRays = 0.017;

Eigen::Matrix3d turnOf(const CameraPose& pose) {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.rotation.m.data());
}
Eigen::Vector3d placeOf(const CameraPose& pose) {
    const Vec3d place = pose.place();
    return {place.x, place.y, place.z};
}

Eigen::Matrix3d nearestTurnOf(const Eigen::Matrix3d& m) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
    return svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

FrameMap mapFrom(double scale, const Eigen::Matrix3d& turn, const Eigen::Vector3d& origin) {
    FrameMap out;
    out.scale = scale;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) out.rotation(i, j) = turn(i, j);
    out.origin = {origin.x(), origin.y(), origin.z()};
    return out;
}

}  // namespace

FrameMap alignTwoViews(const PosePair& first, const PosePair& second) {
    const PosePair both[] = {first, second};
    if (const double degrees = spreadOf(both); !(degrees >= kMinTwoViewDegrees)) {
        char text[160];
        std::snprintf(text, sizeof text,
                      "the two views are %.1f degrees apart as seen from the marker, and the closed form needs %.0f",
                      degrees, kMinTwoViewDegrees);
        throw InvalidInput(text);
    }
    const Eigen::Matrix3d turn = turnOf(first.b).transpose() * turnOf(first.a);
    const Eigen::Vector3d p2 = placeOf(second.a), d1 = turn * -placeOf(first.a), d2 = turn * -p2;
    const Eigen::Vector3d seen1 = placeOf(first.b), seen2 = placeOf(second.b), between = seen2 - seen1;
    const double determinant = d1.y() * d2.x() - d1.x() * d2.y();
    if (!(std::abs(determinant) > kParallelRays * d1.norm() * d2.norm()))
        throw InvalidInput("the two views share an azimuth about the marker, where the closed form has no answer");
    const double t = (d1.x() * between.y() - d1.y() * between.x()) / determinant;
    return mapFrom(t * d2.norm() / p2.norm(), turn, seen2 + t * d2);
}

FrameMap alignByAlternation(std::span<const PosePair> pairs, double place_noise, double turn_noise) {
    const double count = double(pairs.size());
    Eigen::Vector3d middle = Eigen::Vector3d::Zero(), seen_middle = Eigen::Vector3d::Zero();
    Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();
    for (const PosePair& pair : pairs) {
        middle += placeOf(pair.a) / count;
        seen_middle += placeOf(pair.b) / count;
        turns += turnOf(pair.b).transpose() * turnOf(pair.a);
    }
    Eigen::Matrix3d places = Eigen::Matrix3d::Zero();  // sum of p^ p^T about their middles
    double squares = 0;
    for (const PosePair& pair : pairs) {
        const Eigen::Vector3d p = placeOf(pair.a) - middle;
        places += (placeOf(pair.b) - seen_middle) * p.transpose();
        squares += p.squaredNorm();
    }
    Eigen::Matrix3d turn = nearestTurnOf(turns);
    const auto scaleOf = [&] { return (turn.transpose() * places).trace() / squares; };
    for (int round = 0; round < 20; ++round) {
        const double scale = scaleOf(), noise = scale * place_noise;
        turn = nearestTurnOf(scale * places / (noise * noise) + turns / (turn_noise * turn_noise));
    }
    const double scale = scaleOf();
    return mapFrom(scale, turn, seen_middle - scale * (turn * middle));
}

}  // namespace penumbra
