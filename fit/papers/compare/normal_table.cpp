#include "fit/papers/compare/normal_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fit/papers/compare/paper_forms.h"
#include "fit/papers/lobes/lobe_maps.h"
#include "formats/common/parallel_for.h"
#include "sh/sh_product.h"
#include "sh/zonal.h"

namespace penumbra {

namespace {

constexpr std::size_t kSampledVertices = 96, kSampledFrames = 8, kViews = 4;
constexpr double kExponent = 10;   // of the Phong lobe
constexpr int kOperatorTerms = 8;  // the papers' factorisation

// Returns unit directions that are evenly spread over the sphere (Fibonacci).
std::vector<Vec3d> evenDirections(std::size_t count) {
    std::vector<Vec3d> out;
    for (std::size_t i = 0; i < count; ++i) {
        const double z = 1 - (2 * double(i) + 1) / double(count), r = std::sqrt(1 - z * z);
        const double angle = double(i) * std::numbers::pi * (3 - std::sqrt(5.0));
        out.push_back({r * std::cos(angle), r * std::sin(angle), z});
    }
    return out;
}

// Writes z_l of (e + 1) / 2 pi cos^e, whose integral is 1: A_l = A_(l-2) (e - l + 2) / (e + l + 1).
std::vector<double> phongZonal(int order) {
    std::vector<double> zonal(std::size_t(order), 1.0);
    if (order > 1) zonal[1] = (kExponent + 1) / (kExponent + 2);
    for (int l = 2; l < order; ++l)
        zonal[std::size_t(l)] = zonal[std::size_t(l) - 2] * (kExponent - l + 2) / (kExponent + l + 1);
    for (int l = 0; l < order; ++l) zonal[std::size_t(l)] *= std::sqrt((2 * l + 1) / (4 * std::numbers::pi));
    return zonal;
}

// Multiplies functions by a zonal one that is turned to an axis.
struct ZonalProduct {
    int order, order_u;
    std::vector<double> zonal;

    std::vector<double> apply(Vec3d axis, std::span<const double> function) const {
        std::vector<double> turned(std::size_t(coefficientCount(order_u))), out(function.size());
        rotateZonal(zonal, axis, turned);
        multiply(order, turned, order_u, function, order, out);
        return out;
    }
};

// Visibility of one vertex in one frame, in the model frame.
struct Sample {
    Vec3d normal;
    std::vector<double> visibility;
};

// Copies posed normals of some vertices: by skinning, or from the poses of a deforming mesh.
std::vector<Vec3> posedNormals(const CompareInput& input, std::size_t frame) {
    const PoseTable& poses = input.poses;
    if (poses.deforming) {
        const std::size_t fronts = poses.normals.size() / poses.frameCount();
        const auto first = poses.normals.begin() + std::ptrdiff_t(frame * fronts);
        std::vector<Vec3> normals(first, first + std::ptrdiff_t(fronts));
        if (input.reader.header().mesh.two_sided) appendBackNormals(normals);
        return normals;
    }
    const VisibilityHeader& header = input.reader.header();
    const std::vector<Affine> bones(poses.bonesOf(frame).begin(), poses.bonesOf(frame).end());
    const std::vector<float> weights =
        morphWeights(poses.input_joints, bones, header.input_names.size(), header.mesh.morphs.count());
    RestShape vertices;
    skinMorphed(header.mesh, poses.skin, header.rest_normals, {bones, weights}, vertices);
    return std::move(vertices.normals);
}

std::vector<Sample> readSamples(const CompareInput& input, const CompareCharacter& character,
                                const Convention& convention, int threads) {
    const std::vector<std::uint32_t> chosen =
        sampleVertices(input.reader.header().mesh.vertexCount(), kSampledVertices);
    ClusterCoefficientsRequest request = requestFor(character, convention, threads);
    request.form = &kModelFrameForm;
    request.vertices_of_cluster = std::span(&chosen, 1);
    const MatrixF coefficients = std::move(readClusterCoefficients(input.reader, input.poses, request).front());
    const std::vector<std::size_t>& frames = character.held_out.empty() ? character.train : character.held_out;
    const std::size_t n = std::size_t(convention.size());
    std::vector<Sample> samples;
    for (std::size_t i = 0; i < frames.size(); i += (frames.size() + kSampledFrames - 1) / kSampledFrames) {
        const std::vector<Vec3> normals = posedNormals(input, frames[i]);
        for (std::size_t c = 0; c < chosen.size(); ++c) {
            const std::span<const float> row = coefficients.row(frames[i]).subspan(c * n, n);
            samples.push_back({normalized(toDouble(normals[chosen[c]])), {row.begin(), row.end()}});
        }
    }
    return samples;
}

void addAll(std::span<const double> near, std::span<const double> exact, RelativeRms& error) {
    for (std::size_t i = 0; i < near.size(); ++i) error.add(near[i], exact[i]);
}

// The transfers of one sample with an operator for the given normal: Lambertian, then one for each view.
std::vector<std::vector<double>> transfers(const Sample& sample, Vec3d normal, const ZonalProduct& cosine,
                                           const ZonalProduct& lobe) {
    std::vector<std::vector<double>> out{cosine.apply(normal, sample.visibility)};
    for (Vec3d view : evenDirections(kViews)) {
        if (dot(view, sample.normal) < 0) view = -view;  // seen from the front
        out.push_back(lobe.apply(2 * dot(view, normal) * normal - view, out[0]));
    }
    return out;
}

NormalTable measure(std::size_t count, const std::vector<Sample>& samples, const ZonalProduct& cosine,
                    const ZonalProduct& lobe, int threads) {
    const std::vector<Vec3d> normals = evenDirections(count);
    struct Part {
        RelativeRms diffuse, glossy;
        double angle = 0;
    };
    std::vector<Part> parts(samples.size());
    parallelFor(samples.size(), threads, [&](std::size_t i) {
        const auto nearest = *std::max_element(normals.begin(), normals.end(), [&](Vec3d a, Vec3d b) {
            return dot(a, samples[i].normal) < dot(b, samples[i].normal);
        });
        const auto exact = transfers(samples[i], samples[i].normal, cosine, lobe);
        const auto near = transfers(samples[i], nearest, cosine, lobe);
        addAll(near[0], exact[0], parts[i].diffuse);
        for (std::size_t v = 1; v < exact.size(); ++v) addAll(near[v], exact[v], parts[i].glossy);
        parts[i].angle = std::acos(std::clamp(dot(nearest, samples[i].normal), -1.0, 1.0));
    });
    RelativeRms diffuse, glossy;
    NormalTable out;
    for (const Part& part : parts) {
        diffuse.add(part.diffuse);
        glossy.add(part.glossy);
        out.angle += part.angle / double(parts.size());
    }
    out.normals = int(count);
    out.diffuse = diffuse.value();
    out.glossy = glossy.value();
    const double n = double(samples.front().visibility.size());
    out.kilobytes = double(count) * kOperatorTerms * n * (1 + n) * 4 / 1000;
    return out;
}

}  // namespace

std::vector<NormalTable> measureNormalTables(const CompareInput& input, const CompareCharacter& character,
                                             const Convention& convention, int threads) {
    const std::vector<Sample> samples = readSamples(input, character, convention, threads);
    const int order_u = std::min(2 * convention.order - 1, kMaxOrder);
    ZonalProduct cosine{convention.order, order_u, std::vector<double>(std::size_t(order_u))};
    clampedCosineZonal(cosine.zonal);
    const ZonalProduct lobe{convention.order, order_u, phongZonal(order_u)};
    std::vector<NormalTable> tables;
    for (std::size_t count = 16; count <= 4096; count *= 4)
        tables.push_back(measure(count, samples, cosine, lobe, threads));
    return tables;
}

}  // namespace penumbra
