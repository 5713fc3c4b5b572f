#pragma once
// A mirror ball that a camera photographs from nearby: which point of it shows which light.
//
// All happens in the plane of the camera, the ball's center and the direction of the light. Angles there, from the
// axis center -> camera: the normal of the mirroring point stands at i - b, where i is the angle of incidence and b the
// angle at the camera between the axis and the point, sin b = (r / d) sin i. So the light comes from the angle
// t = 2 i - b. The largest i is pi / 2, at the outline; beyond t = pi - asin(r / d) lies what the ball hides.
#include <optional>

#include "sh/vec3.h"

namespace penumbra {

struct MirrorBall {
    Vec3d center;
    double radius = 0;       // > 0
    double reflectance = 1;  // (0, 1], the part of the light that the ball reflects
};

// --- Angles, k = r / d -----------------------------------------------------------------------------------------------
// Returns t, from which the light comes that is mirrored at this angle of incidence.
double lightAngle(double incidence, double k);
// Inverts it by Newton's method; `angle` in [0, pi - asin k].
double incidenceOf(double angle, double k);
// Returns the solid angle of light that a unit of area of a picture at distance 1 shows. It has no bound at the
// outline.
double steradiansPerArea(double incidence, double k);

// Returns the direction of the light that a ray from `eye` sees in the ball. None where it passes by.
std::optional<Vec3d> reflectedDirection(const MirrorBall& ball, Vec3d eye, Vec3d ray);

// A ball as one camera sees it, which must stand outside of it.
class BallView {
public:
    // Where the angle of incidence is above `most_incidence`, the point of that angle stands for the one outside of it.
    BallView(const MirrorBall& ball, Vec3d eye, double most_incidence);

    // Return the unit direction from the camera to the point that mirrors what lies in this unit direction at
    // infinity, or at this place. None where the ball hides it. A place inside of the ball is hidden.
    std::optional<Vec3d> rayToDirection(Vec3d direction) const;
    std::optional<Vec3d> rayToPlace(Vec3d place) const;

    double distance() const { return distance_; }

private:
    MirrorBall ball_;
    Vec3d axis_;  // from the ball's center to the camera
    double distance_, k_, most_incidence_;

    Vec3d rayAt(double incidence, Vec3d beside) const;
};

}  // namespace penumbra
