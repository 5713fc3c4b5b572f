#pragma once
// Lights without a picture. "NAME[:key=value,...]", several joined by '+'; colours are R/G/B or one number for all
// three, directions x/y/z point towards the light (model frame, +y up, any length), angles are degrees.
//   uniform:radiance=1                                the same from everywhere
//   directional:direction=0/1/0,irradiance=1          a delta; irradiance at normal incidence
//   disc:direction=0/1/0,angle=0.267,radiance=1       a disc at infinity; angle from its centre to its rim
//   sun:direction=0/1/0,angle=0.267,irradiance=1      the same by its irradiance at normal incidence
//   overcast:radiance=1,albedo=0                      CIE overcast sky (Moon and Spencer 1942), radiance at the zenith;
//                                                     below the horizon a ground of this albedo, lit by it
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
    std::map<std::string, Vec3d> parameters;  // every one of the light, defaults filled in; numbers in x

    bool operator==(const AnalyticLight&) const = default;
};

// Throws std::invalid_argument: one sentence that names the key, its range and the value.
std::vector<AnalyticLight> parseLights(std::string_view text);
std::string toString(std::span<const AnalyticLight> lights);  // canonical; parseLights(toString(l)) == l
std::vector<std::string> analyticLightNames();
// A line for every light with its parameters, their defaults and ranges: for --help.
std::string describeAnalyticLights();

// What lights are made of, for those who integrate them.
struct DirectionalLight {
    Vec3d direction;   // unit, towards the light
    Vec3d irradiance;  // at normal incidence
};
struct DiscLight {
    Vec3d direction;   // unit, to the centre
    double angle = 0;  // radians from the centre to the rim
    Vec3d radiance;

    bool covers(Vec3d d) const;
    double solidAngle() const;
};
// Radiance that changes slowly but at the horizon, and its SH at any order.
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

// SH of the sum, [order^2, 3]: closed forms, but for the sky quadrature to 1e-6. 1 <= order <= kMaxOrder.
std::vector<double> projectLights(const LightParts& parts, int order);
// Integral of |L|^2 over the sphere, channels summed, by quadrature; infinite with a directional light.
double energyOf(const LightParts& parts);

}  // namespace penumbra
