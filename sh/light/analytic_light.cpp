#include "sh/light/analytic_light.h"

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sh/angles.h"
#include "sh/key_values.h"
#include "sh/light/sky.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "sh/zonal.h"

namespace penumbra {

namespace {

using std::numbers::pi;

// --- The language ---

struct LightParameter {
    const char* name;
    Vec3d fallback;
    double least, most;
    enum class Kind { kNumber, kColor, kDirection } kind;
};
struct LightKind {
    const char* name;
    std::vector<LightParameter> parameters;
};

const std::vector<LightKind>& lightKinds() {
    using Kind = LightParameter::Kind;
    static const LightParameter direction{"direction", {0, 1, 0}, -1e6, 1e6, Kind::kDirection},
        angle{"angle", {0.267, 0, 0}, 0.01, 180, Kind::kNumber}, radiance{"radiance", {1, 1, 1}, 0, 1e9, Kind::kColor},
        irradiance{"irradiance", {1, 1, 1}, 0, 1e9, Kind::kColor}, albedo{"albedo", {}, 0, 1, Kind::kColor};
    static const std::vector<LightKind> kinds = {
        {"uniform", {radiance}},
        {"directional", {direction, irradiance}},
        {"disc", {direction, angle, radiance}},
        {"sun", {direction, angle, irradiance}},
        {"overcast", {radiance, albedo}},
        {"sky",
         {{"turbidity", {3, 0, 0}, 2, 10, Kind::kNumber},
          {"elevation", {30, 0, 0}, 0, 90, Kind::kNumber},
          {"azimuth", {}, -360, 360, Kind::kNumber},
          albedo,
          {"intensity", {0.3, 0, 0}, 0, 1e6, Kind::kNumber},
          {"sun", {1, 0, 0}, 0, 1e6, Kind::kNumber}}},
    };
    return kinds;
}

}  // namespace

std::vector<std::string> analyticLightNames() {
    std::vector<std::string> names;
    for (const LightKind& kind : lightKinds()) names.push_back(kind.name);
    return names;
}

namespace {

const LightKind& findKind(std::string_view name) {
    std::string known;
    for (const LightKind& kind : lightKinds()) {
        if (kind.name == name) return kind;
        known += (known.empty() ? "" : ", ") + std::string(kind.name);
    }
    throw std::invalid_argument("no light '" + std::string(name) + "': use one of " + known);
}

Vec3d parseValue(const std::string& what, const LightParameter& parameter, std::string_view text) {
    if (parameter.kind == LightParameter::Kind::kNumber)
        return {parseNumber(what, text, parameter.least, parameter.most), 0, 0};
    const Vec3d value = parseTriple(what, text, parameter.least, parameter.most);
    if (parameter.kind == LightParameter::Kind::kColor) return value;
    const Vec3d unit = normalized(value);
    if (text.find('/') == std::string_view::npos || length(unit) == 0)
        throw std::invalid_argument(what + " must be three numbers like 0/1/0 that are not all 0, not '" +
                                    std::string(text) + "'");
    return unit;
}

void setParameter(AnalyticLight& light, const LightKind& kind, const KeyValue& item) {
    std::string known;
    for (const LightParameter& parameter : kind.parameters) {
        if (item.key == parameter.name) {
            light.parameters[parameter.name] = parseValue(light.name + " " + parameter.name, parameter, item.value);
            return;
        }
        known += (known.empty() ? "" : ", ") + std::string(parameter.name);
    }
    throw std::invalid_argument("light " + light.name + " has no '" + std::string(item.key) + "': use " + known);
}

AnalyticLight parseLight(std::string_view text) {
    const std::size_t colon = text.find(':');
    const LightKind& kind = findKind(text.substr(0, colon));
    AnalyticLight light{kind.name, {}};
    for (const LightParameter& parameter : kind.parameters) light.parameters[parameter.name] = parameter.fallback;
    if (colon + 1 == text.size()) throw std::invalid_argument("expected key=value after '" + std::string(text) + "'");
    if (colon != std::string_view::npos)
        for (const KeyValue& item : splitKeyValues(text.substr(colon + 1))) setParameter(light, kind, item);
    return light;
}

}  // namespace

// A '+' before a letter starts another light. The '+' in 1e+5 does not.
std::vector<AnalyticLight> parseLights(std::string_view text) {
    std::vector<AnalyticLight> lights;
    std::size_t begin = 0;
    for (std::size_t i = 0; i <= text.size(); ++i) {
        const bool joint = i < text.size() && text[i] == '+' &&
                           (i + 1 == text.size() || !std::isdigit(static_cast<unsigned char>(text[i + 1])));
        if (i < text.size() && !joint) continue;
        lights.push_back(parseLight(text.substr(begin, i - begin)));
        begin = i + 1;
    }
    return lights;
}

std::string toString(std::span<const AnalyticLight> lights) {
    std::string text;
    for (const AnalyticLight& light : lights) {
        text += (text.empty() ? "" : "+") + light.name;
        char separator = ':';
        for (const LightParameter& parameter : findKind(light.name).parameters) {
            const Vec3d value = light.parameters.at(parameter.name);
            text += separator + std::string(parameter.name) + "=" + shortest(value.x);
            if (parameter.kind != LightParameter::Kind::kNumber)
                text += "/" + shortest(value.y) + "/" + shortest(value.z);
            separator = ',';
        }
    }
    return text;
}

std::string describeAnalyticLights() {
    std::string text =
        "Lights, NAME:key=default (least..most); angles in degrees, colours R/G/B or one number, directions x/y/z "
        "towards the light (+y is up):\n";
    for (const LightKind& kind : lightKinds()) {
        text += std::string("  ") + kind.name;
        char separator = ':';
        for (const LightParameter& p : kind.parameters) {
            const bool direction = p.kind == LightParameter::Kind::kDirection;
            text += separator + std::string(p.name) + "=" + shortest(p.fallback.x);
            if (direction) text += "/" + shortest(p.fallback.y) + "/" + shortest(p.fallback.z);
            if (!direction) text += " (" + shortest(p.least) + ".." + shortest(p.most) + ")";
            separator = ',';
        }
        text += "\n";
    }
    return text;
}

// --- Parts ---

bool DiscLight::covers(Vec3d d) const { return std::atan2(length(cross(d, direction)), dot(d, direction)) < angle; }

double DiscLight::solidAngle() const {
    const double s = std::sin(angle / 2);
    return 4 * pi * s * s;
}

namespace {

// Adds a function that is zonal about `axis`, times a colour.
void addZonal(std::span<const double> zonal, Vec3d axis, Vec3d color, std::span<double> sh) {
    std::vector<double> one(sh.size() / 3);
    rotateZonal(zonal, axis, one);
    for (std::size_t i = 0; i < one.size(); ++i)
        for (int c = 0; c < 3; ++c) sh[3 * i + std::size_t(c)] += color[c] * one[i];
}

SmoothLight uniformLight(Vec3d radiance) {
    return {[radiance](Vec3d) { return radiance; },
            [radiance](int order) {
                std::vector<double> sh(3 * std::size_t(coefficientCount(order)), 0.0);
                for (int c = 0; c < 3; ++c) sh[std::size_t(c)] = std::sqrt(4 * pi) * radiance[c];
                return sh;
            },
            true};
}

// L = zenith (1 + 2 cos t) / 3. Its irradiance on the ground is 7 pi / 9 zenith.
SmoothLight overcastLight(Vec3d zenith, Vec3d albedo) {
    const Vec3d ground = albedo * zenith * (7.0 / 9);
    return {[=](Vec3d d) { return d.y < 0 ? ground : zenith * ((1 + 2 * d.y) / 3); },
            [=](int order) {
                std::vector<double> sh(3 * std::size_t(coefficientCount(order)), 0.0), below(std::size_t(order), 0.0),
                    cosine(below.size());
                belowPlaneZonal(0, below);
                clampedCosineZonal(cosine);
                addZonal(below, {0, -1, 0}, zenith / 3, sh);
                addZonal(cosine, {0, 1, 0}, zenith * (2.0 / 3), sh);
                addZonal(below, {0, 1, 0}, ground, sh);
                return sh;
            },
            false};
}

void addSky(const AnalyticLight& light, LightParts& parts) {
    const auto number = [&](const char* key) { return light.parameters.at(key).x; };
    SkyOptions options;
    options.turbidity = number("turbidity");
    options.elevation = radians(number("elevation"));
    options.azimuth = radians(number("azimuth"));
    options.albedo = light.parameters.at("albedo");
    options.intensity = number("intensity");
    options.sun = number("sun");
    const Sky sky = makeSky(options);
    parts.smooth.push_back(
        {[sky](Vec3d d) { return skyRadiance(sky, d); }, [sky](int order) { return projectSky(sky, order); }, false});
    if (options.sun == 0) return;
    DiscLight disc{sky.sun_direction, radians(0.267), {}};
    disc.radiance = sky.sun_irradiance / (pi * std::pow(std::sin(disc.angle), 2));
    parts.discs.push_back(disc);
}

}  // namespace

LightParts partsOf(std::span<const AnalyticLight> lights) {
    LightParts parts;
    for (const AnalyticLight& light : lights) {
        const auto value = [&](const char* key) { return light.parameters.at(key); };
        if (light.name == "uniform") parts.smooth.push_back(uniformLight(value("radiance")));
        if (light.name == "overcast") parts.smooth.push_back(overcastLight(value("radiance"), value("albedo")));
        if (light.name == "directional") parts.directional.push_back({value("direction"), value("irradiance")});
        if (light.name == "disc")
            parts.discs.push_back({value("direction"), radians(value("angle").x), value("radiance")});
        if (light.name == "sun") {
            // The irradiance is pi sin^2 a times the radiance. A disc larger than a half sphere counts as a half sphere
            // here.
            const double angle = radians(value("angle").x), sine = std::sin(std::min(angle, pi / 2));
            parts.discs.push_back({value("direction"), angle, value("irradiance") / (pi * sine * sine)});
        }
        if (light.name == "sky") addSky(light, parts);
    }
    return parts;
}

// --- Integrals ---

std::vector<double> projectLights(const LightParts& parts, int order) {
    std::vector<double> sh(3 * std::size_t(coefficientCount(order)), 0.0), zonal(std::size_t(order), 0.0);
    for (const SmoothLight& light : parts.smooth) {
        const std::vector<double> one = light.project(order);
        for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += one[i];
    }
    for (const DiscLight& disc : parts.discs) {
        capVisibilityZonal(disc.angle, zonal);  // the sphere without the disc
        for (double& z : zonal) z = -z;
        zonal[0] = disc.solidAngle() / std::sqrt(4 * pi);
        addZonal(zonal, disc.direction, disc.radiance, sh);
    }
    for (const DirectionalLight& light : parts.directional) {
        // A delta in direction d has the coefficients y_i(d).
        for (std::size_t l = 0; l < zonal.size(); ++l) zonal[l] = std::sqrt((2.0 * double(l) + 1) / (4 * pi));
        addZonal(zonal, light.direction, light.irradiance, sh);
    }
    return sh;
}

namespace {

Vec3d smoothRadiance(const LightParts& parts, Vec3d d) {
    Vec3d sum;
    for (const SmoothLight& light : parts.smooth) sum += light.radiance(d);
    return sum;
}

}  // namespace

double energyOf(const LightParts& parts) {
    if (!parts.directional.empty()) return std::numeric_limits<double>::infinity();
    double energy = 0;
    if (!parts.smooth.empty())
        for (const auto& [d, weight] : gaussHemisphere(96, 192))
            for (const Vec3d side : {Vec3d{d.x, d.z, d.y}, Vec3d{d.x, -d.z, d.y}}) {
                const Vec3d radiance = smoothRadiance(parts, side);
                energy += weight * dot(radiance, radiance);
            }
    // Each disc adds its own square, its cross terms with smooth light (both of them) and its cross terms with other
    // discs (one of the two; the other disc adds the other one).
    for (std::size_t a = 0; a < parts.discs.size(); ++a) {
        const DiscLight& disc = parts.discs[a];
        const Vec3d side = normalized(
                        cross(disc.direction, std::abs(disc.direction.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})),
                    other = cross(disc.direction, side);
        // Uniform nodes over the disc, made by mapping z to it.
        for (const auto& [d, weight] : gaussHemisphere(24, 48)) {
            const double cosine = 1 - d.z * disc.solidAngle() / (2 * pi),
                         sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
            const double q = std::atan2(d.y, d.x);
            const Vec3d at = disc.direction * cosine + (side * std::cos(q) + other * std::sin(q)) * sine;
            Vec3d sum = disc.radiance + 2 * smoothRadiance(parts, at);
            for (std::size_t b = 0; b < parts.discs.size(); ++b)
                if (b != a && parts.discs[b].covers(at)) sum += parts.discs[b].radiance;
            energy += weight / (2 * pi) * disc.solidAngle() * dot(disc.radiance, sum);
        }
    }
    return energy;
}

}  // namespace penumbra
