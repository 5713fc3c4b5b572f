#pragma once
// Lights without a picture. A text "NAME[:key=value,...]" describes one, and '+' joins several. Colours are R/G/B or
// one number for all three. Directions are x/y/z, point towards the light (model frame, +y up) and may have any length.
// Angles are in degrees.
//   uniform:radiance=1                                the same from everywhere
//   directional:direction=0/1/0,irradiance=1          a delta; irradiance at normal incidence
//   disc:direction=0/1/0,angle=0.267,radiance=1       a disc at infinity; angle from its center to its rim
//   sun:direction=0/1/0,angle=0.267,irradiance=1      a disc, given by its irradiance at normal incidence
//   overcast:radiance=1,albedo=0                      CIE overcast sky (Moon and Spencer 1942), radiance at the zenith;
//                                                     below the horizon a ground of this albedo, which the sky lights
//   sky:turbidity=3,elevation=30,azimuth=0,albedo=0,intensity=0.3,sun=1  sky.h; white paper in a high sun is about 1
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

struct AnalyticLight {
    std::string name = "uniform";
    // Every parameter of the light, with defaults filled in; numbers stand in x.
    std::map<std::string, Vec3d> parameters;

    bool operator==(const AnalyticLight&) const = default;
};

// Throws std::invalid_argument with one sentence that names the key, its range and the value.
std::vector<AnalyticLight> parseLights(std::string_view text);
std::string toString(std::span<const AnalyticLight> lights);  // canonical: parseLights(toString(l)) == l
std::vector<std::string> analyticLightNames();
// Returns a line for every light with its parameters, their defaults and ranges, for --help.
std::string describeAnalyticLights();

// The parts that lights are made of, for code that integrates them.
struct DirectionalLight {
    Vec3d direction;   // unit, towards the light
    Vec3d irradiance;  // at normal incidence
};
struct DiscLight {
    Vec3d direction;   // unit, towards the center
    double angle = 0;  // radians from the center to the rim
    Vec3d radiance;

    bool covers(Vec3d d) const;
    double solidAngle() const;
};
// Radiance that changes slowly except at the horizon, and its SH at any order.
struct SmoothLight {
    std::function<Vec3d(Vec3d direction)> radiance;
    std::function<std::vector<double>(int order)> project;  // [order^2, 3]
    bool constant = false;                                  // the same from everywhere
};
struct LightParts {
    std::vector<DirectionalLight> directional;
    std::vector<DiscLight> discs;
    std::vector<SmoothLight> smooth;
};
LightParts partsOf(std::span<const AnalyticLight> lights);

// Returns the SH of the sum, [order^2, 3], with 1 <= order <= kMaxOrder. All are closed forms but the sky, whose
// quadrature is right to 1e-6.
std::vector<double> projectLights(const LightParts& parts, int order);
// Returns the integral of |L|^2 over the sphere, summed over the channels, by quadrature. It is infinite with a
// directional light.
double energyOf(const LightParts& parts);

}  // namespace penumbra
