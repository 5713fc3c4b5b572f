#include "formats/brdf/half_difference_table.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

namespace penumbra {

constexpr double kRightAngle = std::numbers::pi / 2;

HalfDifference halfDifference(Vec3d wi, Vec3d wo) {
    const Vec3d h = normalized(wi + wo);
    const double sine_h = std::hypot(h.x, h.y);
    // The axes of the half vector's frame are y = (-sin phi_h, cos phi_h, 0) and x = y x h.
    const Vec3d y = sine_h > 0 ? Vec3d{-h.y / sine_h, h.x / sine_h, 0} : Vec3d{0, 1, 0}, x = cross(y, h);
    const double dx = std::abs(dot(wi, x)), dy = std::abs(dot(wi, y));
    return {std::atan2(sine_h, h.z), std::atan2(std::hypot(dx, dy), dot(wi, h)), std::atan2(dy, dx)};
}

std::pair<Vec3d, Vec3d> directionsOf(const HalfDifference& angles) {
    const double ch = std::cos(angles.theta_h), sh = std::sin(angles.theta_h);
    const double cd = std::cos(angles.theta_d), sd = std::sin(angles.theta_d);
    const Vec3d d{sd * std::cos(angles.phi_d), sd * std::sin(angles.phi_d), cd};
    const auto toNormal = [&](Vec3d v) { return Vec3d{ch * v.x + sh * v.z, v.y, -sh * v.x + ch * v.z}; };
    return {toNormal(d), toNormal({-d.x, -d.y, d.z})};
}

HalfDifference HalfDifferenceTable::center(std::size_t cell) const {
    const auto at = [](std::size_t k, int n) { return (double(k) + 0.5) / n; };
    const double root = at(cell / (std::size_t(phi_d) * std::size_t(theta_d)), theta_h);
    return {kRightAngle * root * root, kRightAngle * at(cell / std::size_t(phi_d) % std::size_t(theta_d), theta_d),
            kRightAngle * at(cell % std::size_t(phi_d), phi_d)};
}

namespace {
// The two centers around a place, which is 0..1 along an axis of n cells.
struct BetweenSamples {
    std::size_t below, above;
    float share;  // weight of `above`

    BetweenSamples(double place, int n) {
        const double at = std::clamp(place * n - 0.5, 0.0, double(n - 1));
        below = std::size_t(at);
        above = std::min(below + 1, std::size_t(n - 1));
        share = float(at - double(below));
    }
};

Vec3 lookUp(const HalfDifferenceTable& table, const HalfDifference& angles) {
    const BetweenSamples h(std::sqrt(angles.theta_h / kRightAngle), table.theta_h),
        d(angles.theta_d / kRightAngle, table.theta_d), p(angles.phi_d / kRightAngle, table.phi_d);
    const auto alongPhi = [&](std::size_t ih, std::size_t id) {
        const Vec3* row = &table.values[(ih * std::size_t(table.theta_d) + id) * std::size_t(table.phi_d)];
        return row[p.below] * (1 - p.share) + row[p.above] * p.share;
    };
    const auto alongTheta = [&](std::size_t ih) {
        return alongPhi(ih, d.below) * (1 - d.share) + alongPhi(ih, d.above) * d.share;
    };
    return alongTheta(h.below) * (1 - h.share) + alongTheta(h.above) * h.share;
}

}  // namespace

RgbBrdf interpolated(std::string name, HalfDifferenceTable table) {
    const auto shared = std::make_shared<const HalfDifferenceTable>(std::move(table));
    return {std::move(name), BrdfSymmetry::kIsotropic, [shared](Vec3d wi, Vec3d wo) {
                if (wi.z <= 0 || wo.z <= 0) return Vec3d{};
                return toDouble(lookUp(*shared, halfDifference(wi, wo)));
            }};
}

}  // namespace penumbra
