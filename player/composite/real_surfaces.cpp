#include "player/composite/real_surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/common/parallel_for.h"
#include "player/scene/cast_on.h"
#include "sh/sh_basis.h"
#include "sh/tangent.h"
#include "sh/visibility_convention.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxTriangles = 200000;

// The cosine lobe's factors of bands 0 to 4 (Ramamoorthi and Hanrahan 2001, equation 8).
constexpr std::array<double, 5> kCosineBands = {std::numbers::pi, 2 * std::numbers::pi / 3, std::numbers::pi / 4, 0,
                                                -std::numbers::pi / 24};

// Irradiance of a light's SH [n^2, 3] on a surface that nothing hides. `normal` is in the light's frame.
Vec3 irradianceAt(std::span<const float> sh, Vec3d normal) {
    std::array<double, 25> y;
    evalBasis(5, normal, y);
    Vec3d sum;
    for (std::size_t i = 0; i < std::min(sh.size() / 3, y.size()); ++i) {
        const auto band = std::size_t(std::sqrt(double(i)));
        for (int c = 0; c < 3; ++c) sum[c] += kCosineBands[band] * y[i] * double(sh[3 * i + std::size_t(c)]);
    }
    for (int c = 0; c < 3; ++c) sum[c] = std::max(sum[c], 0.0);
    return toFloat(sum);
}

// Share of a white sky that each vertex sees past a cast.
std::vector<float> skyShare(const CastShadow* cast, CasterChoice choice, const RealSurface& surface, int threads) {
    std::vector<float> share(surface.positions.size(), 1.0f), mirrored;
    if (!cast) return share;
    castOn(*cast, choice, {surface.positions, surface.normals, surface.tangents}, threads, mirrored);
    std::array<float, kFarCoefficients> weights;
    ambientWeights(parseConvention("D" + std::to_string(kFieldOrder)), weights);
    for (std::size_t v = 0; v < share.size(); ++v) {
        share[v] = 0;
        for (std::size_t i = 0; i < kFarCoefficients; ++i) share[v] += weights[i] * mirrored[v * kFarCoefficients + i];
    }
    return share;
}

// The irradiance below which nothing can be told: a part of the mean of the sky over all normals, which is
// sqrt(pi) / 2 times coefficient 0, and of what the suns give at most. Exposures have any unit, and so has light.
Vec3 leastIrradiance(const GroundLight& light, std::span<const float> light_sh) {
    constexpr float kDark = 1e-5f;
    Vec3 out;
    for (std::size_t c = 0; c < 3; ++c)
        out[int(c)] = std::max(0.5f * std::sqrt(std::numbers::pi_v<float>) * light_sh[c], 0.0f);
    for (const Sun& sun : light.suns) out += sun.irradiance;
    return out * kDark;
}

}  // namespace

RealSurface surfaceOf(const RealMesh& mesh, double edge) {
    std::vector<std::array<Vec3, 3>> waiting;
    for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3)
        waiting.push_back({mesh.positions[mesh.triangles[t]], mesh.positions[mesh.triangles[t + 1]],
                           mesh.positions[mesh.triangles[t + 2]]});
    RealSurface out;
    while (!waiting.empty()) {
        const std::array<Vec3, 3> triangle = waiting.back();
        waiting.pop_back();
        std::size_t longest = 0;
        std::array<float, 3> lengths;
        for (std::size_t k = 0; k < 3; ++k) {
            lengths[k] = length(triangle[(k + 1) % 3] - triangle[k]);
            if (lengths[k] > lengths[longest]) longest = k;
        }
        const Vec3 a = triangle[longest], b = triangle[(longest + 1) % 3], c = triangle[(longest + 2) % 3];
        if (double(lengths[longest]) > edge && waiting.size() + out.triangles.size() / 3 < kMaxTriangles) {
            const Vec3 middle = (a + b) * 0.5f;
            waiting.push_back({a, middle, c});
            waiting.push_back({middle, b, c});
            continue;
        }
        const Vec3 normal = normalized(cross(b - a, c - a));
        if (normal == Vec3{}) continue;
        for (const Vec3 p : {a, b, c}) {
            out.triangles.push_back(std::uint32_t(out.positions.size()));
            out.positions.push_back(p);
            out.normals.push_back(normal);
            out.tangents.push_back(tangentOf(normal, {1, 0, 0}));
        }
    }
    return out;
}

void shadeSurface(const PosedScene& scene, const GroundLight& light, std::span<const float> light_sh, int threads,
                  RealSurface& surface) {
    const std::vector<float> past = skyShare(light.all, {.except = surface.caster}, surface, threads),
                             without = skyShare(light.real, {.except = surface.real_caster}, surface, threads);
    const Mat3d to_light = transposed(scene.lightRotation());
    const Vec3 least = leastIrradiance(light, light_sh);
    surface.ratio.resize(surface.positions.size());
    parallelFor(surface.positions.size(), threads, [&](std::size_t v) {
        const Vec3 p = surface.positions[v], n = surface.normals[v];
        const Vec3 soft = irradianceAt(light_sh, to_light * toDouble(n));
        Vec3 with = soft * past[v] + meanRadiance(light.emitters, p, n) *
                                         (std::numbers::pi_v<float> * std::max(without[v] - past[v], 0.0f));
        Vec3 before = soft * without[v];
        for (std::size_t s = 0; s < light.suns.size(); ++s) {
            const Vec3 full = light.suns[s].irradiance * std::max(dot(n, light.suns[s].direction), 0.0f);
            if (full == Vec3{}) continue;
            with += full * light.sun_maps[s].visibility(p, n);
            before += full * light.real_sun_maps[s].visibility(p, n);
        }
        for (int c = 0; c < 3; ++c)
            surface.ratio[v][c] = before[c] > least[c] ? std::max(with[c], 0.0f) / before[c] : 1.0f;
    });
}

}  // namespace penumbra
