// How far radiance moves from light to light while a sun fades, gives way to another one or sets. Radiance is that of
// a sun with a hard shadow plus the SH product with the remainder, as docs/formulas.md section 11 has it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "sh/brdf/brdf.h"
#include "sh/light/dominant_light.h"
#include "sh/quadrature.h"
#include "sh/sh_rotation.h"
#include "tests/difference.h"
#include "tests/sh/slice_transfer.h"

namespace penumbra::test_hand_over {
namespace {

using Sweep = std::function<std::vector<double>(double t)>;  // SH of order 6, [36, 3], for t from 0 to 1

// The sky's radiance is horizon + (zenith - horizon) z above the horizon, and ground below it.
struct Sky {
    double horizon, zenith, ground;
};

void addSun(Vec3d direction, Vec3d irradiance, std::vector<double>& sh) {
    const SunD sun{normalized(direction), -1.0 * irradiance, 0};
    subtractSuns(std::span(&sun, 1), {}, sh);
}

std::vector<double> lightOfSky(const Sky& sky) {
    constexpr Vec3d kColor{0.6, 0.8, 1};
    std::vector<double> sh(108);
    for (const auto& [d, w] : gaussHemisphere(8, 16)) {
        addSun(d, w * (sky.horizon + (sky.zenith - sky.horizon) * d.z) * kColor, sh);
        addSun(-1.0 * d, w * sky.ground * kColor, sh);
    }
    return sh;
}

// The sky and two suns. Suns have colours of their own.
std::vector<double> lightOf(const std::vector<double>& sky, Vec3d direction, double irradiance, double other) {
    std::vector<double> sh = sky;
    addSun(direction, irradiance * Vec3d{1, 0.9, 0.75}, sh);
    addSun({-0.7, 0.5, 0.35}, other * Vec3d{0.8, 0.9, 1}, sh);
    return sh;
}

constexpr Vec3d kSun{0.6, 0.2, 0.7};

Sweep sweepOf(const std::string& name) {
    if (name == "fading")
        return [sky = lightOfSky({1, 0.8, 0.2})](double t) { return lightOf(sky, kSun, 5 - 5 * t, 0); };
    if (name == "crossing")
        return [sky = lightOfSky({0.2, 0.2, 0.2})](double t) { return lightOf(sky, kSun, 5 - 2 * t, 3 + 2 * t); };
    EXPECT_EQ(name, "sunset");
    return [sky = lightOfSky({1, 0.5, 0.3})](double t) {
        const double elevation = 0.8 - t;
        return lightOf(sky, {std::cos(elevation), 0, std::sin(elevation)}, 4 * std::max(std::sin(elevation), 0.0), 0);
    };
}

// Points with one occluder, three normals and two materials, seen from one local direction.
class Receivers {
public:
    explicit Receivers(const nlohmann::json& golden) : to_eye_(normalized(vec3(golden.at("to_eye")))) {
        for (const auto& frame : golden.at("frames"))
            frames_.push_back(localFrame(vec3(frame.at("normal")), vec3(frame.at("tangent"))));
        const nlohmann::json slices = readGolden("cast_and_self.json").at("slices");
        for (const auto& [name, spec] : {std::pair{"lambert", "lambert"}, {"ggx_.3", "ggx:alpha=0.3,f0=0.9"}})
            materials_.push_back({transferOf(golden.at("d5"), sliceOf(slices.at(name), to_eye_)), parseBrdf(spec)});
    }

    // Radiance of every point in the sun's shadow and in the sun, under the remainder `soft`, [16, 3].
    std::vector<double> radiance(const SunD& sun, const std::vector<double>& soft) const {
        std::vector<double> out, local(16), channel(16);
        for (const Mat3d& frame : frames_) {
            const Vec3d to_sun = frame * sun.direction;
            const ShRotationD rotation = makeShRotation(4, frame);
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t i = 0; i < 16; ++i) channel[i] = soft[3 * i + c];
                apply(rotation, channel, local);
                for (const auto& [transfer, brdf] : materials_) {
                    const double shadowed = std::inner_product(local.begin(), local.end(), transfer.begin(), 0.0);
                    const double direct = brdfFunction(brdf)(to_sun, to_eye_) * std::max(to_sun.z, 0.0);
                    out.insert(out.end(), {shadowed, shadowed + sun.irradiance[int(c)] * direct});
                }
            }
        }
        return out;
    }

private:
    struct Material {
        std::vector<double> transfer;
        BrdfSpec brdf;
    };
    Vec3d to_eye_;
    std::vector<Mat3d> frames_;
    std::vector<Material> materials_;
};

struct Steps {
    double largest, median;
};

// A step is the largest change of any radiance from one light to the next, as a part of the mean of all.
Steps stepsOf(const std::vector<std::vector<double>>& radiance) {
    std::vector<double> steps;
    double sum = 0;
    for (std::size_t i = 0; i < radiance.size(); ++i) {
        sum += std::accumulate(radiance[i].begin(), radiance[i].end(), 0.0);
        if (i == 0) continue;
        steps.push_back(largestDifference(radiance[i], radiance[i - 1]));
    }
    const double mean = sum / double(radiance.size() * radiance[0].size());
    std::sort(steps.begin(), steps.end());
    const std::size_t half = steps.size() / 2;
    return {steps.back() / mean, (steps[half - 1] + steps[half]) / 2 / mean};
}

// The sun comes from the first `order` bands of the light, and L_g has the first 4.
Steps stepsAlong(const Sweep& sweep, const Receivers& receivers, int order, bool hand_over) {
    constexpr int kLights = 251;
    LightFactor factor(order);
    std::vector<std::vector<double>> radiance;
    for (int i = 0; i < kLights; ++i) {
        std::vector<double> sh = sweep(double(i) / (kLights - 1));
        const SunCandidate found = factor.factor(std::span(sh).first(std::size_t(3 * order * order))).candidates[0];
        SunD sun = found.sun;
        for (int c = 0; c < 3 && !hand_over; ++c)
            sun.irradiance[c] = std::clamp(found.least_squares[c], 0.0, found.most[c]);
        sh.resize(48);
        subtractSuns(std::span(&sun, 1), {}, sh);
        radiance.push_back(receivers.radiance(sun, sh));
    }
    return stepsOf(radiance);
}

// The file says how each figure came about, and asks for 0.2%. Measured within 0.05%. Without the hand-over two lights
// that cross make a step of 1.46.
TEST(HandOver, RadianceMovesInTheStepsOfTheGolden) {
    const nlohmann::json golden = readGolden("handover_steps.json");
    const Receivers receivers(golden);
    ASSERT_EQ(golden.at("cases").size(), 12u);
    for (const auto& item : golden.at("cases")) {
        const Steps found = stepsAlong(sweepOf(item.at("sweep")), receivers, item.at("order"), item.at("hand_over"));
        for (const auto& [actual, expected] : {std::pair{found.largest, item.at("largest").get<double>()},
                                               {found.median, item.at("median").get<double>()}})
            EXPECT_NEAR(actual, expected, golden.at("tol").get<double>() * expected) << item;
    }
}

}  // namespace
}  // namespace penumbra::test_hand_over
