#include "bake/reference/bake_reference.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <mutex>

#include "bake/reference/direct_light.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

std::string findProblem(const ReferenceOptions& options) {
    const auto outside = [](const char* option, const char* range, int value) {
        return std::string(option) + " must be " + range + ", not " + std::to_string(value);
    };
    if (options.width < 1 || options.width > 16384) return outside("--size", "1..16384 pixels wide", options.width);
    if (options.height < 1 || options.height > 16384) return outside("--size", "1..16384 pixels high", options.height);
    if (options.samples < 4 || options.samples > 1 << 20)
        return outside("--samples", "4..1048576 shadow rays a pixel", options.samples);
    if (options.camera_rays < 1 || options.camera_rays > 64)
        return outside("--aa", "1..64 camera rays a pixel", options.camera_rays);
    return "";
}

namespace {

// The frame in the ray tracer's own coordinates.
struct ReferenceScene {
    const ReferenceFrame& input;
    SceneScale scale;
    std::vector<Vec3> positions;
    OcclusionScene scene;                   // what the camera sees
    std::optional<OcclusionScene> shadows;  // what shadow rays meet, where that is more than the camera sees
    std::vector<SampledBrdf> materials;

    const OcclusionScene& blocking() const { return shadows ? *shadows : scene; }
};

ReferenceScene makeScene(const ReferenceFrame& input, const std::vector<RgbBrdf>& brdfs, int threads) {
    const std::vector<Vec3>& model = input.frame.positions;
    const double diagonal = boxDiagonal(model);
    const SceneScale scale = sceneScale(model, diagonal > 0 ? diagonal : 1);
    std::vector<Vec3> positions;
    for (Vec3 p : model) positions.push_back(scale.apply(p));
    OcclusionScene scene(positions, input.mesh.frontTriangles());
    std::optional<OcclusionScene> shadows;
    if (input.blockers) {
        std::vector<Vec3> all(positions.begin(), positions.begin() + std::ptrdiff_t(input.mesh.frontVertexCount()));
        for (Vec3 p : input.occluder_positions) all.push_back(scale.apply(p));
        shadows.emplace(all, input.blockers->triangles, true);
    }
    if (input.casting_triangles)
        shadows.emplace(positions, std::span(input.mesh.triangles).first(*input.casting_triangles));
    std::vector<SampledBrdf> materials(brdfs.size());
    parallelFor(brdfs.size(), threads, [&](std::size_t i) { materials[i] = sampledBrdf(brdfs[i]); });
    return {input, scale, std::move(positions), std::move(scene), std::move(shadows), std::move(materials)};
}

// The corners of the triangle that a camera ray meets, and where between them the point lies.
struct Corners {
    Triangle vertex;
    std::array<double, 3> weight;  // barycentric

    std::uint32_t nearest() const {
        return vertex[std::size_t(std::max_element(weight.begin(), weight.end()) - weight.begin())];
    }
};

// Returns the frame of the BRDF at a point. Tangents of another cluster than the nearest corner's do not take part.
Mat3d frameAt(const ReferenceFrame& input, const Corners& corners, Vec3d normal) {
    if (!input.tangents) return shadingFrame(normal);
    const PosedTangents& field = *input.tangents;
    Vec3d tangent;
    for (std::size_t k = 0; k < 3; ++k)
        if (field.cluster_of_vertex[corners.vertex[k]] == field.cluster_of_vertex[corners.nearest()])
            tangent += toDouble(field.tangents[corners.vertex[k]]) * corners.weight[k];
    return shadingFrame(normal, tangent);
}

// Returns where the rays of a point of a triangle start. `wanted` is the start where nothing is near.
RayStart startOfShadowRays(const ReferenceScene& scene, const Corners& corners, Vec3d point, Vec3d wanted,
                           double bias) {
    if (!scene.input.blockers) return {toFloat(wanted), false};
    const auto fronts = std::uint32_t(scene.input.mesh.frontVertexCount());
    const Triangle own{corners.vertex[0] % fronts, corners.vertex[1] % fronts, corners.vertex[2] % fronts};
    // On a crumpled sheet the interpolated normal may point behind the triangle.
    const Vec3d a = toDouble(scene.positions[own[0]]), b = toDouble(scene.positions[own[1]]),
                c = toDouble(scene.positions[own[2]]);
    const Vec3d flat = normalized(cross(b - a, c - a)) * (corners.vertex[0] < fronts ? 1.0 : -1.0);
    Vec3d way = wanted - point;
    if (!(dot(way, flat) > 0)) way = flat * std::max(length(way), bias);
    return startOverSheet(scene.blocking(), *scene.input.blockers,
                          {toFloat(point), toFloat(normalized(way)), float(length(way)), own,
                           scene.input.blockers->solid_of_vertex[own[0]]});
}

// Makes the shaded point. Its normal is interpolated. Its shadow rays start on the smooth surface that the normals
// suggest, not on the flat triangle below it, so that triangles do not shadow themselves (Hanika 2021, "Hacking the
// shadow terminator").
SurfacePoint surfacePoint(const ReferenceScene& scene, const Corners& corners, Vec3d to_eye, double bias) {
    const auto& [corner, weight] = corners;
    Vec3d p[3], n[3], point, normal;
    for (std::size_t k = 0; k < 3; ++k) {
        p[k] = toDouble(scene.positions[corner[k]]);
        n[k] = toDouble(scene.input.frame.normals[corner[k]]);
        point += p[k] * weight[k];
        normal += n[k] * weight[k];
    }
    normal = normalized(normal);
    if (dot(normal, normal) == 0) normal = normalized(cross(p[1] - p[0], p[2] - p[0]));
    Vec3d lifted = point;
    for (std::size_t k = 0; k < 3; ++k) lifted += n[k] * (-weight[k] * std::min(0.0, dot(point - p[k], n[k])));
    const RayStart start = startOfShadowRays(scene, corners, point, lifted + normal * bias, bias);
    return {start.position, frameAt(scene.input, corners, normal), to_eye, start.closed};
}

std::size_t materialAt(const ReferenceFrame& input, const Corners& corners) {
    return input.brdf_of_vertex.empty() ? 0 : input.brdf_of_vertex[corners.nearest()];
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
            if (point.closed) return {};
            return directLight(caster, point, light, scene.materials[materialAt(scene.input, corners)], samples, seed);
    }
}

// Returns the fixed points inside a pixel that its camera rays go through: a Hammersley set, or the centre for one
// ray.
double pixelOffset(int i, int n, bool vertical) {
    if (!vertical) return (i + 0.5) / n;
    double inverse = 0.5 / n, digit = 0.5;
    for (int rest = i; rest > 0; rest /= 2, digit /= 2) inverse += (rest % 2) * digit;
    return inverse;
}

// Returns the corners of the triangle on the side that a camera ray meets.
Corners cornersOf(const ReferenceFrame& input, const SurfaceHit& hit, Vec3d ray_direction) {
    const Mesh& mesh = input.mesh;
    Corners corners{mesh.triangles[hit.triangle], {1.0 - double(hit.u) - double(hit.v), hit.u, hit.v}};
    if (dot(toDouble(hit.normal), ray_direction) <= 0) return corners;
    for (std::uint32_t& corner : corners.vertex) {
        if (mesh.two_sided) corner += std::uint32_t(mesh.frontVertexCount());
        if (!input.back_of_vertex.empty()) corner = input.back_of_vertex[corner];
    }
    return corners;
}

// Renders one pixel: the mean over its camera rays, whose seeds depend on the pixel alone.
void renderPixel(const ReferenceScene& scene, const Camera& camera, const EnvironmentLight& light,
                 const ReferenceOptions& options, std::size_t index, Image& image) {
    const int x = int(index % std::size_t(options.width)), y = int(index / std::size_t(options.width));
    const Vec3 eye = toFloat((cameraPosition(camera) - scene.scale.centre) / scene.scale.diagonal);
    Vec3d sum;
    int covered = 0;
    for (int i = 0; i < options.camera_rays; ++i) {
        const Vec3d direction =
            pixelDirection(camera, x + pixelOffset(i, options.camera_rays, false),
                           y + pixelOffset(i, options.camera_rays, true), options.width, options.height);
        const std::optional<SurfaceHit> hit = scene.scene.closestHit(eye, toFloat(direction));
        if (!hit) continue;
        ++covered;
        const std::uint64_t seed = index * std::uint64_t(options.camera_rays) + std::uint64_t(i);
        const Corners corners = cornersOf(scene.input, *hit, direction);
        const SurfacePoint point = surfacePoint(scene, corners, -direction, options.bias);
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
    const ReferenceScene scene = makeScene(frame, options.brdfs, threads);
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
