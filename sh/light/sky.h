#pragma once
// A clear sky from turbidity and the sun's height (Preetham, Shirley and Smits, A Practical Analytic Model for
// Daylight, 1999). Radiance 1 stands for 10,000 cd/m^2 (irradiance 1 for 10,000 lux), in linear Rec.709.
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

struct SkyOptions {
    double turbidity = 3;       // 2 (very clear) .. 10 (hazy)
    double elevation = 0.5236;  // elevation of the sun above the horizon, radians, 0 .. pi/2
    double azimuth = 0;         // azimuth of the sun, radians from +x towards +z
    Vec3d albedo;               // albedo of the ground, which fills what is below the horizon; sky and sun light it
    double intensity = 1;       // factor on all of the light
    double sun = 1;             // factor on the sun alone
};

struct Sky {
    SkyOptions options;
    Vec3d sun_direction;
    // Irradiance at normal incidence: 133,800 lux less what Rayleigh scattering and aerosol take (paper's appendix).
    Vec3d sun_irradiance;
    Vec3d ground;  // radiance below the horizon
    // Perez' coefficients A .. E of Y, x and y = scale (1 + A e^(B / cos t)) (1 + C e^(D g) + E cos^2 g), where t is
    // the angle from the zenith and g the angle from the sun.
    double perez[3][5] = {}, scale[3] = {};
};
Sky makeSky(const SkyOptions& options);
Vec3d skyRadiance(const Sky& sky, Vec3d direction);  // without the sun's disc; never below 0
// Projects the sky, [order^2, 3], by quadrature in circles around the sun, where the sky has a cusp. It is right to
// 1e-6 of the mean.
std::vector<double> projectSky(const Sky& sky, int order);

}  // namespace penumbra
