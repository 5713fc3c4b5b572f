#include "bake/reference/bake_reference.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <mutex>
#include <numbers>

#include "bake/common/random_numbers.h"
#include "bake/reference/bounced_light.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

std::size_t materialAt(const ReferenceFrame& input, const Corners& corners) {
    return input.brdf_of_vertex.empty() ? 0 : input.brdf_of_vertex[corners.nearest()];
}

// Returns the radiance of a point that light reaches, directly and by reflections, without what comes through it.
Vec3d reflectedFrom(const ReferenceScene& scene, const Corners& corners, const SurfacePoint& point,
                    const EnvironmentLight& light, int samples, std::uint64_t seed) {
    if (point.closed) return {};
    const SampledBrdf& material = scene.materials[materialAt(scene.input, corners)];
    const ShadowCaster caster{scene.blocking(), scene.input.ground};
    Vec3d sum = directLight(caster, point, light, material, samples, seed);
    if (scene.bounces > 0) sum += bouncedLight(scene, point, light, material, samples, seed);
    return sum;
}

// Returns the radiance of a point with the material of its pictures. Light from below the surface is stopped by the
// surface itself, also where the normal of the picture leans.
Vec3d picturedFrom(const ReferenceScene& scene, const PictureSurface& pictures, const SurfacePlace& place,
                   const Corners& corners, SurfacePoint point, const EnvironmentLight& light, int samples,
                   std::uint64_t seed) {
    const PointMaterial material = pictures.materialAt(place);
    if (point.closed) return material.emissive;
    if (material.picture_normal) {
        const Triangle& front = scene.input.mesh.triangles[corners.triangle];
        std::array<Vec3d, 3> at;
        for (std::size_t k = 0; k < 3; ++k) at[k] = toDouble(scene.positions[front[k]]);
        const Vec3d level{point.frame(2, 0), point.frame(2, 1), point.frame(2, 2)};
        point.frame = shadingFrame(pictures.bentNormal(place, at, level, *material.picture_normal));
    }
    const SampledBrdf brdf = scene.point_brdfs->brdfOf(material);
    const ShadowCaster caster{scene.blocking(), scene.input.ground};
    Vec3d sum = directLight(caster, point, light, brdf, samples, seed);
    if (scene.bounces > 0) sum += bouncedLight(scene, point, light, brdf, samples, seed);
    return sum * material.occlusion + material.emissive;
}

// A membrane mixes what falls on its two sides, each by rays of its own.
Vec3d litFrom(const ReferenceScene& scene, const Corners& corners, const SurfacePoint& point,
              const EnvironmentLight& light, int samples, std::uint64_t seed) {
    SurfacePlace place;
    if (const PictureSurface* pictures = picturesAt(scene.input, corners, place))
        return picturedFrom(scene, *pictures, place, corners, point, light, samples, seed);
    const std::size_t material = materialAt(scene.input, corners);
    const Vec3d own = reflectedFrom(scene, corners, point, light, samples, seed);
    if (scene.membranes.empty() || !scene.membranes[material]) return own;
    const Membrane& membrane = *scene.membranes[material];
    const Corners behind = otherSide(scene.input, corners);
    const SurfacePoint other = surfacePoint(scene, behind, -point.to_eye);
    constexpr std::uint64_t kOther = std::uint64_t(1) << 40;  // other random numbers than those of the own side
    return toDouble(membrane.rho) * own +
           toDouble(membrane.tau) * reflectedFrom(scene, behind, other, light, samples, seed + kOther);
}

// Returns the emission factor of the slot at a point. A surface with pictures returns 0 here, because its pictures say
// what it emits; a slot without a picture of its emission emits by its factor there, too.
Vec3d emissionOf(const ReferenceScene& scene, const Corners& corners, const ReferenceOptions& options) {
    SurfacePlace place;
    if (options.emissions.empty() || picturesAt(scene.input, corners, place)) return {};
    return toDouble(options.emissions[materialAt(scene.input, corners)]);
}

// Returns what one camera ray sees at a point.
Vec3d shade(const ReferenceScene& scene, const Corners& corners, const SurfacePoint& point,
            const EnvironmentLight& light, const ReferenceOptions& options, std::uint64_t seed) {
    const ShadowCaster caster{scene.blocking(), scene.input.ground};
    const int samples = std::max(4, options.samples / options.camera_rays);
    switch (options.channel) {
        case ReferenceChannel::kNormals:
            return Vec3d{point.frame(2, 0), point.frame(2, 1), point.frame(2, 2)} * 0.5 + Vec3d{0.5, 0.5, 0.5};
        case ReferenceChannel::kAmbient: {
            const double v = point.closed ? 0 : ambientVisibility(caster, point, samples, seed);
            return {v, v, v};
        }
        default:
            return litFrom(scene, corners, point, light, samples, seed) + emissionOf(scene, corners, options);
    }
}

// Returns the fixed points inside a pixel that its camera rays go through: a Hammersley set, or the center for one
// ray.
double pixelOffset(int i, int n, bool vertical) {
    if (!vertical) return (i + 0.5) / n;
    double inverse = 0.5 / n, digit = 0.5;
    for (int rest = i; rest > 0; rest /= 2, digit /= 2) inverse += (rest % 2) * digit;
    return inverse;
}

// A number in [0, 1) for a surface that a camera ray meets. The rays of a pixel have numbers that are evenly spread,
// and other surfaces and pixels other ones.
double chanceOf(std::size_t pixel, int ray, std::size_t triangle) {
    std::uint64_t state = std::uint64_t(pixel) << 32 ^ std::uint64_t(triangle);
    const double at = nextUniform(state) + ray * (std::numbers::phi - 1);
    return at - std::floor(at);
}

// A camera ray, and its number in its pixel.
struct CameraRay {
    Vec3 eye;
    Vec3d direction;
    std::size_t pixel = 0;
    int number = 0;
};

// Tells whether a camera ray goes on behind what it met: through a hole of a picture, or the back of a triangle that is
// seen from its front alone.
bool passes(const ReferenceScene& scene, const CameraRay& ray, const SurfaceHit& hit) {
    const std::span<const std::uint8_t> front_alone = scene.input.front_alone;
    if (hit.triangle < front_alone.size() && front_alone[hit.triangle] && dot(toDouble(hit.normal), ray.direction) > 0)
        return true;
    SurfacePlace place;
    const PictureSurface* pictures = picturesAt(scene.input, cornersOf(scene.input, hit, ray.direction), place);
    return pictures && pictures->isHole(place, chanceOf(ray.pixel, ray.number, place.triangle));
}

// Returns what a camera ray sees.
std::optional<SurfaceHit> seenBy(const ReferenceScene& scene, const CameraRay& ray) {
    const Vec3d direction = ray.direction;
    Vec3 eye = ray.eye;
    constexpr int kMaxPassed = 64;
    constexpr double kBehind = 1e-5;  // in the ray tracer's frame
    std::optional<SurfaceHit> hit = scene.scene.closestHit(eye, toFloat(direction));
    for (int passed = 0; hit && passed < kMaxPassed; ++passed) {
        if (!passes(scene, ray, *hit)) return hit;
        eye = toFloat(toDouble(eye) + direction * (double(hit->distance) + kBehind));
        hit = scene.scene.closestHit(eye, toFloat(direction));
    }
    return hit;
}

// Renders one pixel: the mean over its camera rays, whose seeds depend on the pixel alone.
void renderPixel(const ReferenceScene& scene, const Camera& camera, const EnvironmentLight& light,
                 const ReferenceOptions& options, std::size_t index, Image& image) {
    const int x = int(index % std::size_t(options.width)), y = int(index / std::size_t(options.width));
    const Vec3 eye = toFloat((cameraPosition(camera) - scene.scale.center) / scene.scale.diagonal);
    Vec3d sum;
    int covered = 0;
    for (int i = 0; i < options.camera_rays; ++i) {
        const Vec3d direction =
            pixelDirection(camera, x + pixelOffset(i, options.camera_rays, false),
                           y + pixelOffset(i, options.camera_rays, true), options.width, options.height);
        const std::optional<SurfaceHit> hit = seenBy(scene, {eye, direction, index, i});
        if (!hit) continue;
        ++covered;
        const std::uint64_t seed = index * std::uint64_t(options.camera_rays) + std::uint64_t(i);
        const Corners corners = cornersOf(scene.input, *hit, direction);
        const SurfacePoint point = surfacePoint(scene, corners, -direction);
        sum += shade(scene, corners, point, light, options, seed);
    }
    double alpha = double(covered) / options.camera_rays;
    sum = sum / options.camera_rays;
    if (options.background) {
        sum += toDouble(*options.background) * (1 - alpha);
        alpha = 1;
    }
    image.pixels[index] = toFloat(sum);
    image.alpha[index] = float(alpha);
}

}  // namespace

Image renderReference(const ReferenceFrame& frame, const Camera& camera, const EnvironmentLight& light,
                      const ReferenceOptions& options, int threads, ProgressStyle style) {
    constexpr std::size_t kPixelsPerTask = 16;
    assert(!options.brdfs.empty());
    const ReferenceScene scene = makeReferenceScene(frame, options, threads);
    const std::size_t count = std::size_t(options.width) * std::size_t(options.height);
    Image image{options.width, options.height, std::vector<Vec3>(count), std::vector<float>(count)};
    Progress progress(style, "rendering", "pixels", double(count));
    std::mutex printing;
    std::atomic<std::size_t> done = 0;
    parallelFor((count + kPixelsPerTask - 1) / kPixelsPerTask, threads, [&](std::size_t task) {
        throwIfInterrupted();
        const std::size_t begin = task * kPixelsPerTask, end = std::min(count, begin + kPixelsPerTask);
        for (std::size_t i = begin; i < end; ++i) renderPixel(scene, camera, light, options, i, image);
        done += end - begin;
        if (const std::unique_lock lock(printing, std::try_to_lock); lock) progress.update(double(done));
    });
    return image;
}

}  // namespace penumbra
