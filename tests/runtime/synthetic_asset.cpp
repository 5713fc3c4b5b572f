#include "tests/runtime/synthetic_asset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "formats/common/fp16.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/exact_light_lobes.h"
#include "runtime/shade/shading.h"
#include "sh/brdf/brdf.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"
#include "sh/sh_rotation.h"
#include "sh/zonal.h"
#include "tests/sh/sh_project.h"

namespace penumbra::player_test {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kJoints = 3, kClusters = 5, kComponents = 6, kInputs = 3, kTruthOrder = 5;
constexpr int kSliceOrder = 5, kSliceViewOrder = 5;

// Returns the hemisphere moments of an unoccluded vertex in the local frame.
std::vector<float> openMoments(int order) {
    std::vector<double> moments(std::size_t(coefficientCount(order)));
    project(
        order, gaussHemisphere(16, 32), [](Vec3d) { return 1.0; }, moments);
    return {moments.begin(), moments.end()};
}

}  // namespace

std::vector<float> fitSlices(const BrdfSpec& spec, int grid) {
    constexpr int kCount = coefficientCount(kSliceOrder), kEven = kSliceViewOrder * (kSliceViewOrder + 1) / 2;
    std::vector<double> gram(kEven * kEven), right(std::size_t(kEven) * kCount);
    const std::vector<WeightedDirection> incoming = gaussHemisphere(2 * grid, 4 * grid);
    for (const WeightedDirection& view : gaussHemisphere(grid, 2 * grid)) {
        std::array<double, coefficientCount(kSliceViewOrder)> basis;
        evalBasis(kSliceViewOrder, view.direction, basis);
        std::vector<double> even;
        for (const int i : evenIndices(kSliceViewOrder)) even.push_back(basis[std::size_t(i)]);
        std::vector<double> slice(kCount);
        project(
            kSliceOrder, incoming, [&](Vec3d wi) { return brdfFunction(spec)(wi, view.direction) * wi.z; }, slice);
        const double weight = view.weight * view.direction.z;
        for (int e = 0; e < kEven; ++e) {
            for (int g = 0; g < kEven; ++g) gram[e * kEven + g] += weight * even[e] * even[g];
            for (int i = 0; i < kCount; ++i) right[e * kCount + i] += weight * even[e] * slice[i];
        }
    }
    for (int p = 0; p < kEven; ++p)  // Gauss-Jordan; the Gram matrix has condition 4.9
        for (int r = 0; r < kEven; ++r) {
            if (r == p) continue;
            const double factor = gram[r * kEven + p] / gram[p * kEven + p];
            for (int c = p; c < kEven; ++c) gram[r * kEven + c] -= factor * gram[p * kEven + c];
            for (int i = 0; i < kCount; ++i) right[r * kCount + i] -= factor * right[p * kCount + i];
        }
    std::vector<float> slices(std::size_t(kCount) * kEven);
    for (int i = 0; i < kCount; ++i)
        for (int e = 0; e < kEven; ++e) slices[i * kEven + e] = float(right[e * kCount + i] / gram[e * kEven + e]);
    return slices;
}

SyntheticAsset::SyntheticAsset(const AssetRecipe& recipe) {
    asset.has_mesh = asset.has_model = true;
    makeMesh(recipe);
    makeAnimation();
    makeClusters(recipe);
    makeMaterials();
    addOperators();
    makeLights(recipe);
    addLobes();
    makeSlots(recipe);
    makeTruth();
}

void SyntheticAsset::makeMesh(const AssetRecipe& recipe) {
    const int rings = recipe.rings, segments = 2 * rings;
    for (int r = 1; r < rings; ++r)
        for (int s = 0; s < segments; ++s) {
            const double theta = kPi * r / rings, phi = 2 * kPi * s / segments;
            positions_.push_back(
                toFloat({std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)}));
        }
    const std::uint32_t top = std::uint32_t(positions_.size()), bottom = top + 1;
    positions_.push_back({0, 1, 0});
    positions_.push_back({0, -1, 0});
    for (int s = 0; s < segments; ++s) {
        const std::uint32_t a = std::uint32_t(s), b = std::uint32_t((s + 1) % segments);
        triangles_.insert(triangles_.end(), {top, b, a});
        for (int r = 0; r + 2 < rings; ++r) {
            const std::uint32_t upper = std::uint32_t(r * segments), lower = upper + std::uint32_t(segments);
            triangles_.insert(triangles_.end(), {upper + a, upper + b, lower + a, upper + b, lower + b, lower + a});
        }
        const std::uint32_t last = std::uint32_t((rings - 2) * segments);
        triangles_.insert(triangles_.end(), {last + a, last + b, bottom});
    }
    for (std::size_t v = 0; v < positions_.size(); ++v) {
        const Vec3 p = positions_[v];
        const Vec3 along = std::abs(p.y) < 0.9f ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
        tangents_.push_back(normalized(cross(along, p)));
        shading_point_.push_back(std::uint32_t(positions_.size() - 1 - v));
        const float upper = std::clamp(0.5f + p.y, 0.0f, 1.0f);
        skin_joints_.insert(skin_joints_.end(), {std::uint16_t(1), std::uint16_t(2)});
        skin_weights_.insert(skin_weights_.end(), {upper, 1 - upper});
    }
    MeshView& mesh = asset.mesh;
    mesh.positions = mesh.normals = positions_;  // a unit sphere
    mesh.tangents = tangents_;
    mesh.triangles = triangles_;
    mesh.shading_point = shading_point_;
    mesh.influences = 2;
    mesh.skin_joints = skin_joints_;
    mesh.skin_weights = skin_weights_;
}

namespace {

Affine rotationAboutZ(double angle) {
    const float c = float(std::cos(angle)), s = float(std::sin(angle));
    return {{c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0}};
}

}  // namespace

void SyntheticAsset::makeAnimation() {
    for (const double swing : {0.0, 0.3, -0.4, 0.0}) {
        bones_.push_back({});
        bones_.push_back(rotationAboutZ(swing));
        Affine slid;
        slid.m[7] = float(0.1 * swing);
        bones_.push_back(slid);
    }
    times_ = {0, 0.5, 1, 0};
    AnimationView& animation = asset.animation;
    animation.joint_names = {"root", "upper", "lower"};
    animation.clips = {{"swing", 0, 3, false}, {"still", 3, 1, true}};
    animation.times = times_;
    animation.bones = bones_;
}

namespace {

NumbersView plainNumbers(const std::vector<float>& coefficients) {
    return {AssetPrecision::kF32, coefficients.size(), 0, reinterpret_cast<const std::byte*>(coefficients.data()), {}};
}

NumbersView halfNumbers(const std::vector<float>& coefficients, std::vector<std::uint16_t>& stored) {
    stored.resize(coefficients.size());
    floatToHalf(coefficients, stored);
    return {AssetPrecision::kF16, stored.size(), 0, reinterpret_cast<const std::byte*>(stored.data()), {}};
}

NumbersView byteNumbers(const std::vector<float>& coefficients, std::size_t row_length, std::vector<float>& scale,
                        std::vector<std::int8_t>& stored) {
    for (std::size_t k = 0; k < kComponents; ++k) scale.push_back((1 + 0.1f * float(k)) / 127);
    for (std::size_t i = 0; i < coefficients.size(); ++i)
        stored.push_back(std::int8_t(std::lround(coefficients[i] / scale[i / row_length])));
    return {AssetPrecision::kI8, stored.size(), row_length, reinterpret_cast<const std::byte*>(stored.data()), scale};
}

}  // namespace

// Fills in the regression of one cluster with made-up numbers of ordinary size.
void SyntheticAsset::fillRegression(ClusterData& data, std::mt19937& random) {
    std::uniform_real_distribution<float> uniform(-1, 1);
    const auto fill = [&](std::vector<float>& values, std::size_t count, float size) {
        for (std::size_t i = 0; i < count; ++i) values.push_back(size * uniform(random));
    };
    constexpr std::size_t kFeatures = 12 * (kJoints - 1);
    fill(data.feature_mean, kFeatures, 0.1f);
    fill(data.input_basis, kInputs * kFeatures, 0.3f);
    data.input_min.assign(kInputs, -1);
    data.input_max.assign(kInputs, 1);
    fill(data.weights, kComponents * kInputs, 1);
    fill(data.bias, kComponents, 1);
}

ClusterView SyntheticAsset::makeCluster(const AssetRecipe& recipe, std::span<const float> open, ClusterData& data,
                                        std::uint32_t count, std::mt19937& random) {
    std::uniform_real_distribution<float> uniform(-1, 1);
    const std::size_t stride = std::size_t(asset.model.stride);
    for (std::uint32_t v = 0; v < count; ++v) {
        const float dim = recipe.open ? 1 : 0.6f + 0.4f * std::cos(float(v));
        for (std::size_t i = 0; i < stride; ++i) data.mean.push_back(i < open.size() ? dim * open[i] : 0);
    }
    for (std::size_t i = 0; i < kComponents * count * stride; ++i)
        data.basis.push_back(i % stride < open.size() ? recipe.basis_size * uniform(random) : 0);

    ClusterView view;
    view.vertex_count = count;
    view.feature_mean = data.feature_mean;
    view.input_basis = plainNumbers(data.input_basis);
    view.input_min = data.input_min;
    view.input_max = data.input_max;
    view.units = kInputs;
    view.weights = plainNumbers(data.weights);
    view.bias = data.bias;
    view.mean =
        recipe.precision == AssetPrecision::kF32 ? plainNumbers(data.mean) : halfNumbers(data.mean, data.mean_half);
    if (recipe.precision == AssetPrecision::kI8)
        view.basis = byteNumbers(data.basis, count * stride, data.scale, data.basis_bytes);
    else if (recipe.precision == AssetPrecision::kF16)
        view.basis = halfNumbers(data.basis, data.basis_half);
    else
        view.basis = plainNumbers(data.basis);
    return view;
}

void SyntheticAsset::makeClusters(const AssetRecipe& recipe) {
    ModelView& model = asset.model;
    model.convention = parseConvention(recipe.convention);
    model.stride = (model.convention.size() + 3) / 4 * 4;
    model.features = FeatureKind::kRelativeBones;
    joint_spreads_.resize(3);
    joint_centers_ = {{0, 0, 0}, {0, 0.5f, 0}, {0, -0.5f, 0}};
    model.joint_centers = joint_centers_;
    model.joint_spreads = joint_spreads_;
    std::vector<float> open(std::size_t(model.convention.size()));
    fromMoments(model.convention, openMoments(model.convention.order), open);
    std::mt19937 random(7);
    clusters_.resize(kClusters);
    std::uint32_t first = 0;
    for (std::size_t c = 0; c < kClusters; ++c) {
        const std::uint32_t end = std::uint32_t(positions_.size() * (c + 1) / kClusters);
        fillRegression(clusters_[c], random);
        AssetRecipe own = recipe;
        if (recipe.mixed) own.precision = AssetPrecision(c % 3);
        model.clusters.push_back(makeCluster(own, open, clusters_[c], end - first, random));
        model.clusters.back().joint = int(c % kJoints);
        model.clusters.back().first_vertex = first;
        first = end;
    }
}

void SyntheticAsset::makeTruth() {
    truth.has_mesh = truth.has_truth = true;
    truth.mesh = asset.mesh;
    truth.animation = asset.animation;
    const std::size_t count = std::size_t(coefficientCount(kTruthOrder)), vertices = positions_.size();
    const std::vector<float> open = openMoments(kTruthOrder);
    truth_.resize(times_.size() * vertices * count);
    Evaluator evaluator(asset);
    std::vector<Vec3> p(vertices), n(vertices), t(vertices);
    for (std::size_t frame = 0; frame < times_.size(); ++frame) {
        evaluator.setPose(asset.animation.bonesOf(frame), {});
        evaluator.skin(0, vertices, p, n, t);
        for (std::size_t v = 0; v < vertices; ++v) {
            const ShRotation to_local = makeShRotation(kTruthOrder, toLocalFrame(n[v], t[v]));
            applyTransposed(to_local, open,
                            std::span(truth_).subspan((frame * vertices + shading_point_[v]) * count, count));
        }
    }
    truth.truth = {kTruthOrder, false, AssetPrecision::kF32, std::as_bytes(std::span(truth_))};
}

void SyntheticAsset::makeMaterials() {
    lambert_ = fitSlices(parseBrdf("lambert"));
    ggx_ = fitSlices(parseBrdf("ggx:alpha=0.3,f0=0.9"));
    for (const float tint : {1.0f, 0.6f, 0.2f})
        for (std::size_t i = 0; i < ggx_.size(); ++i) tinted_.push_back(tint * ggx_[i] + (1 - tint) * lambert_[i]);
    asset.materials = {{"lambert", kSliceOrder, kSliceViewOrder, 1, {1, 1, 1}, lambert_},
                       {"ggx", kSliceOrder, kSliceViewOrder, 1, {0.9f, 0.8f, 0.7f}, ggx_},
                       {"tinted", kSliceOrder, kSliceViewOrder, 3, {1, 1, 1}, tinted_}};
}

void SyntheticAsset::makeLights(const AssetRecipe& recipe) {
    const Vec3d from = normalized(toDouble(recipe.light_from));
    std::vector<double> lobe(std::size_t(recipe.light_order));
    std::vector<double> sh(std::size_t(coefficientCount(recipe.light_order)));
    clampedCosineZonal(lobe);
    rotateZonal(lobe, from, sh);
    for (std::size_t i = 0; i < sh.size(); ++i)
        for (const float tint : {1.0f, 0.9f, 0.8f})
            sky_.push_back(float(recipe.light_lobe * tint * sh[i]) +
                           (i == 0 ? recipe.light_ambient * float(std::sqrt(4 * kPi)) : 0.0f));
    even_.assign(12, 0);
    std::fill_n(even_.begin(), 3, float(std::sqrt(4 * kPi)));
    asset.lights = {{"sky", recipe.light_order, sky_}, {"even", 2, even_}};
}

// u^b is the column of C that belongs to view function b, and w^b is that view function. The sum over b is C y_even.
void SyntheticAsset::addOperators() {
    constexpr std::size_t kCount = coefficientCount(kSliceOrder), kEven = kSliceViewOrder * (kSliceViewOrder + 1) / 2;
    operators_.resize(2 * asset.materials.size());
    for (std::size_t m = 0; m < asset.materials.size(); ++m) {
        MaterialView& material = asset.materials[m];
        std::vector<float>&u = operators_[2 * m], &w = operators_[2 * m + 1];
        for (std::size_t c = 0; c < std::size_t(material.channels); ++c)
            for (std::size_t b = 0; b < kEven; ++b) {
                for (std::size_t k = 0; k < kCount; ++k) u.push_back(material.slices[(c * kCount + k) * kEven + b]);
                for (std::size_t e = 0; e < kEven; ++e) w.push_back(e == b);
            }
        material.operators = {int(kEven), kSliceOrder, u, w};
    }
}

// z = g sqrt((2l+1)/4pi).
void SyntheticAsset::addLobes() {
    lobes_.resize(asset.lights.size());
    lobe_numbers_.resize(asset.lights.size());
    for (std::size_t l = 0; l < asset.lights.size(); ++l) {
        LightView& light = asset.lights[l];
        lobes_[l] = makeLightLobes(light);
        for (std::size_t i = 0; i < lobes_[l].weights.size(); ++i) {
            const double band = double(i % std::size_t(light.order));
            const Vec3 z = lobes_[l].weights[i] * float(std::sqrt((2 * band + 1) / (4 * kPi)));
            lobe_numbers_[l].insert(lobe_numbers_[l].end(), {z.x, z.y, z.z});
        }
        light.lobes = {lobes_[l].directions, lobe_numbers_[l]};
    }
}

void SyntheticAsset::makeSlots(const AssetRecipe& recipe) {
    if (recipe.slots == 0) return;
    for (int s = 0; s < recipe.slots; ++s) slot_names_.push_back("part" + std::to_string(s));
    for (std::size_t v = 0; v < positions_.size(); ++v)
        slot_of_vertex_.push_back(std::uint16_t(v % slot_names_.size()));
    asset.mesh.slots.assign(slot_names_.begin(), slot_names_.end());
    asset.mesh.slot_of_vertex = slot_of_vertex_;
    for (std::size_t s = 0; s < slot_names_.size(); ++s)
        asset.slot_material.push_back(std::uint16_t(s % asset.materials.size()));
}

}  // namespace penumbra::player_test
