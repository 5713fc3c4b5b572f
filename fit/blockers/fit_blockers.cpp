// Fits sphere blockers.
//
// Problem: k spheres, each rigid with one bone, whose shadows on other things are those of the character.
//
// Naive (Nowrouzezahrai 2009): k-means of the vertices, and spheres that hold their vertices. Such spheres stick out of
// the body, and its shadow is far too dark: they hide 8 times the error of what is used here (docs/formulas.md, section
// 9).
//
// Here: what a distant receiver sees of a character is its silhouette, so its area is what must be right on average.
// The points to group are spread evenly over the surface, radii are mean distances, and one factor for all radii makes
// the mean silhouette over poses and views as large as that of the mesh.
#include "fit/blockers/fit_blockers.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "fit/blockers/find_feet.h"
#include "fit/blockers/k_means.h"
#include "fit/blockers/refine_radii.h"
#include "fit/blockers/silhouette.h"
#include "fit/blockers/surface_samples.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

constexpr int kSamples = 8000;      // points on the surface: 500 a sphere where there are 15
constexpr std::size_t kPoses = 24;  // training frames, evenly spaced
constexpr int kViews = 24;
constexpr float kMinRadius = 1e-4f;  // in diagonals of the rest positions: a group may be a single point

// --- Groups ---------------------------------------------------------------------------------------------------------

// The points of a limb, or of the whole, that get `count` spheres of their own.
struct Region {
    std::vector<std::uint32_t> points;
    int count = 0;
};

std::vector<Region> regionsOf(const SurfaceSamples& samples, std::span<const int> foot_of_joint, int count) {
    const int feet = foot_of_joint.empty() ? 0 : 1 + *std::max_element(foot_of_joint.begin(), foot_of_joint.end());
    std::vector<Region> regions(std::size_t(feet) + 1);  // the first is all that is no foot
    const int least = feet > 0 ? std::min(2, (count - 1) / feet) : 0;
    for (std::uint32_t i = 0; i < samples.joint.size(); ++i) {
        const int foot = least > 0 ? foot_of_joint[samples.joint[i]] : -1;
        regions[std::size_t(foot + 1)].points.push_back(i);
    }
    int left = count;
    for (std::size_t r = 1; r < regions.size(); ++r) {
        if (regions[r].points.empty()) continue;
        const double share = double(regions[r].points.size()) / double(samples.joint.size());
        const int others = int(regions.size() - 1 - r) * least + 1;  // least count for later feet and the rest
        regions[r].count = std::clamp(int(std::lround(share * count)), least, std::max(least, left - others));
        left -= regions[r].count;
    }
    regions[0].count = left;
    return regions;
}

// Returns the joint that most of the points have; the lower one of two that are equal.
std::uint16_t commonJoint(const SurfaceSamples& samples, std::span<const std::uint32_t> points) {
    std::vector<std::uint16_t> joints;
    for (const std::uint32_t i : points) joints.push_back(samples.joint[i]);
    std::sort(joints.begin(), joints.end());
    std::uint16_t best = joints.front();
    std::size_t most = 0;
    for (std::size_t begin = 0, end = 0; begin < joints.size(); begin = end) {
        while (end < joints.size() && joints[end] == joints[begin]) ++end;
        if (end - begin > most) most = end - begin, best = joints[begin];
    }
    return best;
}

enum class Radius { kMean, kBound };

// Groups the points of a region, and adds a sphere for each group.
void addSpheres(const SurfaceSamples& samples, const Region& region, Radius radius, std::uint64_t seed,
                GroupedBlockers& grouped) {
    if (region.points.empty() || region.count < 1) return;
    std::vector<Vec3d> points;
    for (const std::uint32_t i : region.points) points.push_back(samples.points[i]);
    const PointGroups groups = groupPoints(points, region.count, seed);
    for (std::uint32_t g = 0; g < groups.centers.size(); ++g) {
        std::vector<std::uint32_t> members;
        double sum = 0, most = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (groups.group_of_point[i] != g) continue;
            members.push_back(region.points[i]);
            const double distance = length(points[i] - groups.centers[g]);
            sum += distance;
            most = std::max(most, distance);
        }
        for (const std::uint32_t i : members)
            grouped.sphere_of_point[i] = std::uint32_t(grouped.blockers.spheres.size());
        const double mean = sum / double(members.size());
        grouped.blockers.spheres.push_back({toFloat(groups.centers[g]), float(radius == Radius::kMean ? mean : most)});
        grouped.blockers.joints.push_back(commonJoint(samples, members));
    }
}

double rigidShare(const SurfaceSamples& samples, const GroupedBlockers& grouped) {
    std::size_t rigid = 0;
    for (std::size_t i = 0; i < samples.joint.size(); ++i)
        rigid += samples.joint[i] == grouped.blockers.joints[grouped.sphere_of_point[i]];
    return double(rigid) / double(samples.joint.size());
}

// --- Silhouettes ----------------------------------------------------------------------------------------------------

std::vector<std::size_t> trainingFrames(const Model& model) {
    std::vector<std::size_t> frames;
    for (std::size_t f = 0; f < model.frames.frameCount(); ++f) {
        const std::string& clip = model.frames.clip_names[model.frames.clip[f]];
        if (std::find(model.holdout_clips.begin(), model.holdout_clips.end(), clip) == model.holdout_clips.end())
            frames.push_back(f);
    }
    return frames;
}

SilhouettePoses choosePoses(const Model& model) {
    const std::vector<std::size_t> frames = trainingFrames(model);
    const std::size_t joints = model.skin.jointCount(), count = std::min(kPoses, frames.size());
    SilhouettePoses poses;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t frame = frames[(2 * i + 1) * frames.size() / (2 * count)];
        const auto first = model.bones.begin() + std::ptrdiff_t(frame * joints);
        poses.bones.emplace_back(first, first + std::ptrdiff_t(joints));
        poses.positions.emplace_back();
        if (model.deforming) {
            const std::size_t points = model.mesh.frontVertexCount();
            const auto begin = model.positions.begin() + std::ptrdiff_t(frame * points);
            poses.positions.back().assign(begin, begin + std::ptrdiff_t(points));
        } else {
            const std::vector<float> weights = morphWeights(model.input_joints, poses.bones.back(),
                                                            model.input_names.size(), model.mesh.morphs.count());
            RestShape vertices;
            skinMorphed(model.mesh, model.skin, model.rest_normals, {poses.bones.back(), weights}, vertices);
            poses.positions.back() = std::move(vertices.positions);
        }
    }
    if (count > 0) return poses;
    poses.bones.assign(1, std::vector<Affine>(joints));
    poses.positions.assign(1, model.mesh.rest_positions);
    return poses;
}

double meanOf(std::span<const double> values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / double(values.size());
}

// Returns the areas of all poses and views, [poses, views].
std::vector<double> meshAreas(const Model& model, const SilhouettePoses& poses, std::span<const Vec3d> views,
                              int threads) {
    std::vector<double> areas(poses.bones.size() * views.size());
    parallelFor(areas.size(), threads, [&](std::size_t i) {
        areas[i] =
            silhouetteArea(model.mesh.frontTriangles(), poses.positions[i / views.size()], views[i % views.size()]);
    });
    return areas;
}

std::vector<double> sphereAreas(const SphereBlockers& blockers, double scale, const SilhouettePoses& poses,
                                std::span<const Vec3d> views, int threads) {
    std::vector<double> areas(poses.bones.size() * views.size());
    parallelFor(areas.size(), threads, [&](std::size_t i) {
        std::vector<CasterSphere> spheres = blockers.spheres;
        for (std::size_t s = 0; s < spheres.size(); ++s) {
            spheres[s].radius *= float(scale);
            spheres[s] = movedBy(poses.bones[i / views.size()][blockers.joints[s]], spheres[s]);
        }
        areas[i] = silhouetteArea(spheres, views[i % views.size()]);
    });
    return areas;
}

// Returns the factor of all radii that makes the mean silhouette of the spheres that of the mesh. The area grows with
// the factor, so halving an interval finds it. The interval is one of ratios.
double areaScale(const SphereBlockers& blockers, double mesh_area, const SilhouettePoses& poses,
                 std::span<const Vec3d> views, int threads) {
    double low = 1.0 / 16, high = 16;
    for (int round = 0; round < 24; ++round) {
        const double middle = std::sqrt(low * high);
        const bool small = meanOf(sphereAreas(blockers, middle, poses, views, threads)) < mesh_area;
        (small ? low : high) = middle;
    }
    return std::sqrt(low * high);
}

double errorOfAreas(std::span<const double> areas, std::span<const double> expected, double mean) {
    double squares = 0;
    for (std::size_t i = 0; i < areas.size(); ++i) squares += (areas[i] - expected[i]) * (areas[i] - expected[i]);
    return std::sqrt(squares / double(areas.size())) / mean;
}

// --- The two methods ------------------------------------------------------------------------------------------------

GroupedBlockers groupByArea(const Model& model, const SurfaceSamples& samples, const SilhouettePoses& poses,
                            const BlockerOptions& options, BlockerFit& fit) {
    std::vector<std::uint16_t> feet;
    std::vector<Affine> bones;
    for (const std::vector<Affine>& pose : poses.bones) bones.insert(bones.end(), pose.begin(), pose.end());
    if (!model.deforming) feet = findFeet(samples, model.skin.parents, bones);
    const std::vector<int> foot_of_joint = footOfJoint(feet, model.skin.parents);
    GroupedBlockers grouped = groupBlockers(samples, foot_of_joint, options.spheres, options.seed);
    for (std::size_t foot = 0; foot < feet.size(); ++foot) {
        FootBlockers of_foot{model.skin.joint_names[feet[foot]]};
        for (const std::uint16_t joint : grouped.blockers.joints) of_foot.spheres += foot_of_joint[joint] == int(foot);
        fit.feet.push_back(of_foot);
    }
    return grouped;
}

}  // namespace

GroupedBlockers groupBlockers(const SurfaceSamples& samples, std::span<const int> foot_of_joint, int count,
                              std::uint64_t seed) {
    GroupedBlockers grouped{{}, std::vector<std::uint32_t>(samples.points.size())};
    for (const Region& region : regionsOf(samples, foot_of_joint, count))
        addSpheres(samples, region, Radius::kMean, seed, grouped);
    return grouped;
}

GroupedBlockers boundVertices(const SurfaceSamples& samples, int count, std::uint64_t seed) {
    GroupedBlockers grouped{{}, std::vector<std::uint32_t>(samples.points.size())};
    Region all{{}, count};
    for (std::uint32_t i = 0; i < samples.points.size(); ++i) all.points.push_back(i);
    addSpheres(samples, all, Radius::kBound, seed, grouped);
    return grouped;
}

BlockerFit fitBlockers(const Model& model, const BlockerOptions& options, int threads) {
    assert(options.spheres >= 1 && options.spheres <= int(kMaxBlockers));
    const bool paper = options.method == BlockerMethod::kPaper;
    const SurfaceSamples samples =
        paper ? sampleVertices(model.mesh, model.skin) : sampleSurface(model.mesh, model.skin, kSamples, options.seed);
    if (samples.points.empty()) throw InvalidInput("the rest mesh has no area that spheres could stand for");
    // 1. Group the points, and make a sphere of each group.
    const SilhouettePoses poses = choosePoses(model);
    BlockerFit fit;
    GroupedBlockers grouped = paper ? boundVertices(samples, options.spheres, options.seed)
                                    : groupByArea(model, samples, poses, options, fit);
    const float least = kMinRadius * float(characterDiagonal(model.mesh));
    for (CasterSphere& sphere : grouped.blockers.spheres) sphere.radius = std::max(sphere.radius, least);
    fit.rigid_share = rigidShare(samples, grouped);
    fit.blockers = std::move(grouped.blockers);
    // 2. Scale all radii by one factor.
    const std::vector<Vec3d> views = silhouetteViews(kViews);
    const std::vector<double> mesh_areas = meshAreas(model, poses, views, threads);
    fit.mesh_area = meanOf(mesh_areas);
    if (!(fit.mesh_area > 0)) throw InvalidInput("the mesh has no silhouette in any training frame");
    if (!paper) fit.scale = areaScale(fit.blockers, fit.mesh_area, poses, views, threads);
    for (CasterSphere& sphere : fit.blockers.spheres) sphere.radius *= float(fit.scale);
    if (options.refine) fit.refinement = refineRadii(model.mesh.frontTriangles(), poses, views, threads, fit.blockers);
    // 3. Measure what came out.
    const std::vector<double> areas = sphereAreas(fit.blockers, 1, poses, views, threads);
    fit.area = meanOf(areas);
    fit.silhouette_error = errorOfAreas(areas, mesh_areas, fit.mesh_area);
    fit.poses = poses.bones.size();
    fit.views = views.size();
    return fit;
}

}  // namespace penumbra
