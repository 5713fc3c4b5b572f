#include "sh/light/sky.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "sh/zonal.h"

namespace penumbra {

namespace {

using std::numbers::pi;

// Perez' function of the direction, with t from the zenith and the angle from the sun.
double perezOf(const double (&p)[5], double cos_zenith, double sun_angle) {
    const double cosine = std::cos(sun_angle);
    return (1 + p[0] * std::exp(p[1] / cos_zenith)) * (1 + p[2] * std::exp(p[3] * sun_angle) + p[4] * cosine * cosine);
}

// The paper's table 2 has A .. E for Y, x and y: slope times turbidity plus offset.
constexpr double kSlopes[3][5] = {{0.1787, -0.3554, -0.0227, 0.1206, -0.0670},
                                  {-0.0193, -0.0665, -0.0004, -0.0641, -0.0033},
                                  {-0.0167, -0.0950, -0.0079, -0.0441, -0.0109}};
constexpr double kOffsets[3][5] = {{-1.4630, 0.4275, 5.3251, -2.5771, 0.3703},
                                   {-0.2592, 0.0008, 0.2125, -0.8989, 0.0452},
                                   {-0.2608, 0.0092, 0.2102, -1.6537, 0.0529}};
// Chromaticity of the zenith. Rows belong to T^2, T, 1, and columns to a^3, a^2, a, 1 of the sun's angle a from the
// zenith.
constexpr double kZenithX[3][4] = {
    {0.00166, -0.00375, 0.00209, 0}, {-0.02903, 0.06377, -0.03202, 0.00394}, {0.11693, -0.21196, 0.06052, 0.25886}};
constexpr double kZenithY[3][4] = {
    {0.00275, -0.00610, 0.00317, 0}, {-0.04214, 0.08970, -0.04153, 0.00516}, {0.15346, -0.26756, 0.06670, 0.26688}};

double zenithChromaticity(const double (&m)[3][4], double t, double a) {
    const auto row = [&](int i) { return ((m[i][0] * a + m[i][1]) * a + m[i][2]) * a + m[i][3]; };
    return (row(0) * t + row(1)) * t + row(2);
}

// Returns the luminance of the zenith in kcd/m^2.
double zenithLuminance(double t, double a) {
    return (4.0453 * t - 4.9710) * std::tan((4.0 / 9 - t / 120) * (pi - 2 * a)) - 0.2155 * t + 2.4192;
}

Vec3d toRec709(double luminance, double x, double y) {
    const double xx = x / y * luminance, zz = (1 - x - y) / y * luminance;
    return {3.2406 * xx - 1.5372 * luminance - 0.4986 * zz, -0.9689 * xx + 1.8758 * luminance + 0.0415 * zz,
            0.0557 * xx - 0.2040 * luminance + 1.0570 * zz};
}

// Returns what Rayleigh scattering and aerosol let through. The air mass is that of Kasten 1965, and the wavelengths
// (um) are those of the Rec.709 primaries.
Vec3d transmittance(double turbidity, double zenith_angle) {
    const double mass = 1 / (std::cos(zenith_angle) + 0.15 * std::pow(93.885 - zenith_angle * 180 / pi, -1.253));
    const double haze = 0.04608 * turbidity - 0.04586;
    Vec3d out;
    const double wavelength[3] = {0.611, 0.549, 0.464};
    for (int c = 0; c < 3; ++c)
        out[c] = std::exp(-mass * (0.008735 * std::pow(wavelength[c], -4.08) + haze * std::pow(wavelength[c], -1.3)));
    return out;
}

// Calls visit(direction, steradians) for nodes over the upper hemisphere. They lie on circles of angle g around the
// sun: whole circles for g below the sun's elevation h, then arcs down to the horizon. As functions of g, the arcs end
// like square roots at h and pi - h; the substitution g(s) with s^2 (3 - 2s) takes those away.
void visitSky(const Sky& sky, const std::function<void(Vec3d, double)>& visit) {
    static const std::vector<WeightedDirection> nodes = gaussSphere(48, 1);
    const Vec3d sun = sky.sun_direction, up{0, 1, 0};
    const double h = sky.options.elevation;
    const Vec3d flat = normalized(Vec3d{-std::cos(sky.options.azimuth), 0, -std::sin(sky.options.azimuth)});
    const Vec3d towards_zenith = flat * std::sin(h) + up * std::cos(h), side = cross(sun, towards_zenith);
    const auto circle = [&](double g, double weight) {
        const double tilt = std::cos(g) * std::sin(h), swing = std::sin(g) * std::cos(h);
        const double half = swing <= tilt ? pi : std::acos(std::clamp(-tilt / swing, -1.0, 1.0));
        for (const auto& [node, node_weight] : nodes) {
            const double q = half * node.z;
            const Vec3d d = std::cos(g) * sun + std::sin(g) * (std::cos(q) * towards_zenith + std::sin(q) * side);
            visit(d, weight * std::sin(g) * half * node_weight / (2 * pi));
        }
    };
    // First the whole circles, then the arcs.
    for (const auto& [node, node_weight] : nodes) {
        const double s = (node.z + 1) / 2, w = node_weight / (4 * pi);
        if (h > 0) circle(h * s, h * w);
        if (h < pi / 2) circle(h + (pi - 2 * h) * s * s * (3 - 2 * s), (pi - 2 * h) * 6 * s * (1 - s) * w);
    }
}

}  // namespace

Sky makeSky(const SkyOptions& options) {
    Sky sky;
    sky.options = options;
    // 1. Perez' coefficients, scaled so that the zenith has its luminance and colour.
    const double t = options.turbidity, h = options.elevation, zenith_angle = pi / 2 - h;
    sky.sun_direction = {std::cos(h) * std::cos(options.azimuth), std::sin(h), std::cos(h) * std::sin(options.azimuth)};
    const double zenith[3] = {zenithLuminance(t, zenith_angle) / 10, zenithChromaticity(kZenithX, t, zenith_angle),
                              zenithChromaticity(kZenithY, t, zenith_angle)};
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < 5; ++i) sky.perez[c][i] = kSlopes[c][i] * t + kOffsets[c][i];
        sky.scale[c] = zenith[c] / perezOf(sky.perez[c], 1, zenith_angle);
    }
    // 2. The sun.
    sky.sun_irradiance = 13.38 * options.intensity * options.sun * transmittance(t, zenith_angle);
    // 3. The ground reflects the irradiance of sky and sun.
    Vec3d irradiance;
    visitSky(sky, [&](Vec3d d, double weight) { irradiance += skyRadiance(sky, d) * (weight * d.y); });
    irradiance += sky.sun_irradiance * std::sin(h);
    sky.ground = options.albedo * irradiance / pi;
    return sky;
}

Vec3d skyRadiance(const Sky& sky, Vec3d d) {
    if (d.y < 0) return sky.ground;
    const double cos_zenith = std::max(d.y, 1e-9),
                 sun_angle = std::atan2(length(cross(d, sky.sun_direction)), dot(d, sky.sun_direction));
    double value[3];
    for (int c = 0; c < 3; ++c) value[c] = sky.scale[c] * perezOf(sky.perez[c], cos_zenith, sun_angle);
    const Vec3d rgb = toRec709(value[0], value[1], value[2]) * sky.options.intensity;
    return {std::max(0.0, rgb.x), std::max(0.0, rgb.y), std::max(0.0, rgb.z)};
}

std::vector<double> projectSky(const Sky& sky, int order) {
    const auto count = std::size_t(coefficientCount(order));
    std::vector<double> sh(3 * count, 0.0), y(count);
    visitSky(sky, [&](Vec3d d, double weight) {
        const Vec3d flux = skyRadiance(sky, d) * weight;
        evalBasis(order, d, y);
        for (std::size_t i = 0; i < count; ++i)
            for (int c = 0; c < 3; ++c) sh[3 * i + std::size_t(c)] += flux[c] * y[i];
    });
    std::vector<double> zonal(std::size_t(order), 0.0);
    belowPlaneZonal(0, zonal);
    rotateZonal(zonal, {0, 1, 0}, y);
    for (std::size_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) sh[3 * i + std::size_t(c)] += sky.ground[c] * y[i];
    return sh;
}

}  // namespace penumbra
