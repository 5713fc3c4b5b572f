#include "formats/image/factor_light.h"

#include <algorithm>
#include <cmath>

#include "formats/image/area_lights.h"
#include "formats/image/project_map.h"
#include "sh/angles.h"

namespace penumbra {

namespace {

const char* nameOfMode(FactorMode mode) { return mode == FactorMode::kPaper ? "paper" : "hand-over"; }

// The suns that shine, as the SH have them.
LightSuns sunsOfSh(std::span<const double> sh, const LightFactorChoice& choice) {
    LightSuns light;
    LightFactor factor(kFactorOrder, choice.suns, choice.mode);
    const FactoredLight found = factor.factor(sh);
    for (std::size_t i = 0; i < std::size_t(found.count); ++i) {
        const SunCandidate& candidate = found.candidates[i];
        if (!(luminance(candidate.sun.irradiance) > 0)) continue;
        light.suns.push_back(candidate.sun);
        light.report.suns.push_back({candidate.dominance, candidate.share, 0});
    }
    light.factor = nameOfMode(choice.mode);
    return light;
}

// How much of a disc of this radius is a sun. A shadow map looks at few places of a wide penumbra and misses limbs in
// it, and SH hold a wide disc well. Against brute force the two are even at 20 degrees.
double partOfSun(double radius) {
    const double t = std::clamp((radius / kDegree - 15) / 10, 0.0, 1.0);
    return 1 - t * t * (3 - 2 * t);
}

void removeSuns(EnvironmentMap map, int width, LightSuns& light) {
    for (SunD& sun : light.suns) removeSun(map, sun);
    if (width > 0) light.picture = smallPicture(map, width, light.report.clamped);
}

// Several suns: the lamps and windows of the picture itself.
LightSuns factorAreaLights(const EnvironmentMap& map, const LightFactorChoice& choice) {
    LightSuns light;
    light.factor = nameOfMode(choice.mode);
    const AreaLights found = findAreaLights(map, choice.suns);
    for (const AreaLight& area : found.lights) {
        light.suns.push_back(area.sun);
        light.report.suns.push_back({area.worth, area.share, measureSun(map, area.sun.direction).flat_pixels});
    }
    if (choice.picture_width > 0) light.picture = smallPicture(found.rest, choice.picture_width, light.report.clamped);
    return light;
}

}  // namespace

LightSuns factorLight(const EnvironmentMap& map, const LightFactorChoice& choice, int threads) {
    if (choice.suns > 1 && choice.mode == FactorMode::kHandOver) return factorAreaLights(map, choice);
    return factorLight(map, projectMap(map, kFactorOrder, threads).sh, choice);
}

LightSuns factorLight(const EnvironmentMap& map, std::span<const double> sh, const LightFactorChoice& choice) {
    if (choice.suns > 1 && choice.mode == FactorMode::kHandOver) return factorAreaLights(map, choice);
    LightSuns light = sunsOfSh(sh.first(std::size_t(3 * coefficientCount(kFactorOrder))), choice);
    constexpr double kNear = 5 * kDegree;  // farther away the brightest pixels are another lamp
    for (std::size_t i = 0; i < light.suns.size(); ++i) {
        SunD& sun = light.suns[i];
        const SunDisc disc = measureSun(map, sun.direction);
        sun.radius = std::min(disc.radius, 35 * kDegree);  // no sun is larger than what measureSun() looks at
        light.report.suns[i].flat_pixels = disc.flat_pixels;
        if (choice.mode == FactorMode::kHandOver && dot(disc.direction, sun.direction) > std::cos(kNear))
            sun.direction = disc.direction;
        if (choice.mode == FactorMode::kPaper) continue;
        light.report.suns[i].share *= partOfSun(sun.radius);
        sun.irradiance = partOfSun(sun.radius) * sun.irradiance;
    }
    for (std::size_t i = light.suns.size(); i-- > 0;)
        if (luminance(light.suns[i].irradiance) == 0) {
            light.suns.erase(light.suns.begin() + std::ptrdiff_t(i));
            light.report.suns.erase(light.report.suns.begin() + std::ptrdiff_t(i));
        }
    removeSuns(map, choice.picture_width, light);
    return light;
}

namespace {

// Moves the brightest lights that are small enough out of `parts`.
std::vector<SunD> takeSuns(LightParts& parts, int most) {
    std::vector<SunD> suns;
    while (int(suns.size()) < most) {
        SunD best;
        const auto brighter = [&](const SunD& sun) {
            const bool yes = luminance(sun.irradiance) > luminance(best.irradiance);
            if (yes) best = sun;
            return yes;
        };
        auto directional = parts.directional.end();
        auto disc = parts.discs.end();
        for (auto it = parts.directional.begin(); it != parts.directional.end(); ++it)
            if (brighter({it->direction, it->irradiance, 0})) directional = it;
        for (auto it = parts.discs.begin(); it != parts.discs.end(); ++it)
            if (it->angle <= kMaxSunRadius * kDegree &&
                brighter({it->direction, it->solidAngle() * it->radiance, it->angle}))
                disc = it, directional = parts.directional.end();
        if (!(luminance(best.irradiance) > 0)) break;
        if (directional != parts.directional.end())
            parts.directional.erase(directional);
        else
            parts.discs.erase(disc);
        suns.push_back(best);
    }
    return suns;
}

}  // namespace

LightSuns factorLight(std::span<const AnalyticLight> lights, const LightFactorChoice& choice) {
    LightParts parts = partsOf(lights);
    const int width = std::max(512, 4 * choice.picture_width);  // width at which the picture is painted before it is
                                                                // reduced
    if (choice.mode == FactorMode::kPaper) {
        LightSuns light = sunsOfSh(projectLights(parts, kFactorOrder), choice);
        removeSuns(paintLights(parts, width), choice.picture_width, light);
        return light;
    }
    LightSuns light;
    light.suns = takeSuns(parts, choice.suns);
    light.factor = "exact";
    light.report.suns.resize(light.suns.size());
    if (choice.picture_width > 0)
        light.picture = smallPicture(paintLights(parts, width), choice.picture_width, light.report.clamped);
    return light;
}

}  // namespace penumbra
