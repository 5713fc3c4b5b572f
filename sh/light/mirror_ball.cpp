#include "sh/light/mirror_ball.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace penumbra {

namespace {

constexpr double kQuarter = std::numbers::pi / 2;

// d t / d i = 2 - k cos i / cos b
double angleSlope(double incidence, double k) {
    const double sine = k * std::sin(incidence);
    return 2 - k * std::cos(incidence) / std::sqrt(1 - sine * sine);
}

// The part of v that is orthogonal to the unit axis, of length 1. Any such vector where v is parallel to it.
Vec3d besideAxis(Vec3d v, Vec3d axis) {
    const Vec3d beside = v - dot(v, axis) * axis;
    if (dot(beside, beside) > 1e-24 * dot(v, v)) return normalized(beside);
    return normalized(cross(axis, std::abs(axis.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
}

}  // namespace

double lightAngle(double incidence, double k) { return 2 * incidence - std::asin(k * std::sin(incidence)); }

double incidenceOf(double angle, double k) {
    double i = std::min(angle / (2 - k), kQuarter);
    for (int step = 0; step < 8; ++step) {
        const double change = (lightAngle(i, k) - angle) / angleSlope(i, k);
        i = std::clamp(i - change, 0.0, kQuarter);
        if (std::abs(change) < 1e-13) break;
    }
    return i;
}

double steradiansPerArea(double incidence, double k) {
    const double sine = k * std::sin(incidence), cosine = std::sqrt(1 - sine * sine);
    if (incidence < 1e-6) return (2 / k - 1) * (2 / k - 1);
    const double slope = 2 * cosine / (k * std::cos(incidence)) - 1;  // d t / d b
    return std::sin(lightAngle(incidence, k)) / sine * slope * cosine * cosine * cosine;
}

std::optional<Vec3d> reflectedDirection(const MirrorBall& ball, Vec3d eye, Vec3d ray) {
    const Vec3d center = ball.center - eye;
    const double along = dot(ray, center);
    const double discriminant = along * along - dot(center, center) + ball.radius * ball.radius;
    if (along <= 0 || discriminant < 0) return std::nullopt;
    const Vec3d normal = ((along - std::sqrt(discriminant)) * ray - center) / ball.radius;
    return ray - 2 * dot(ray, normal) * normal;
}

BallView::BallView(const MirrorBall& ball, Vec3d eye, double most_incidence)
    : ball_(ball),
      axis_(normalized(eye - ball.center)),
      distance_(length(eye - ball.center)),
      k_(ball.radius / distance_),
      most_incidence_(std::min(most_incidence, kQuarter)) {
    assert(distance_ > ball.radius);
}

Vec3d BallView::rayAt(double incidence, Vec3d beside) const {
    const double sine = k_ * std::sin(incidence);
    return std::sqrt(1 - sine * sine) * -axis_ + sine * beside;
}

std::optional<Vec3d> BallView::rayToDirection(Vec3d direction) const {
    const Vec3d beside = besideAxis(direction, axis_);
    const double angle = std::atan2(dot(direction, beside), dot(direction, axis_));
    if (angle > std::numbers::pi - std::asin(k_)) return std::nullopt;
    return rayAt(std::min(incidenceOf(angle, k_), most_incidence_), beside);
}

// Solves: the angle at the mirroring point from its normal to the place is i. Newton's method inside of an interval
// that shrinks. The difference grows with i wherever the point sees the place.
std::optional<Vec3d> BallView::rayToPlace(Vec3d place) const {
    const Vec3d from_center = place - ball_.center;
    const Vec3d beside = besideAxis(from_center, axis_);
    const double along = dot(from_center, axis_), across = dot(from_center, beside), r = ball_.radius;
    if (along * along + across * across <= r * r) return std::nullopt;
    const auto difference = [&](double i, double& slope) {
        const double sine = k_ * std::sin(i), cosine = std::sqrt(1 - sine * sine);
        // angle of the normal, and its derivative
        const double turn = i - std::asin(sine), turning = 1 - k_ * std::cos(i) / cosine;
        const double up_along = std::cos(turn), up_across = std::sin(turn);
        const double x = along - r * up_along, y = across - r * up_across;
        const double up = x * up_along + y * up_across, aside = y * up_along - x * up_across;
        slope = 1 + turning + r * up / (x * x + y * y) * turning;
        return i - std::atan2(aside, up);
    };
    double low = 0, high = kQuarter, slope = 0;
    if (difference(high, slope) < 0) return std::nullopt;
    double i = incidenceOf(std::clamp(std::atan2(across, along), 0.0, lightAngle(kQuarter, k_)), k_);
    for (int step = 0; step < 60; ++step) {
        const double error = difference(i, slope);
        (error < 0 ? low : high) = i;
        double next = i - error / slope;
        if (!(next > low && next < high)) next = (low + high) / 2;
        const bool close = std::abs(next - i) < 1e-10;
        i = next;
        if (close) break;
    }
    return rayAt(std::min(i, most_incidence_), beside);
}

}  // namespace penumbra
