#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fit/papers/compare/paper_forms.h"
#include "tests/fit/synthetic_character.h"

namespace penumbra::test_local_coefficients {
namespace {

using std::numbers::pi;

// For an open hemisphere, the moments times z are those of the clamped cosine (docs/formulas.md section 1).
TEST(TimesZ, OfAnOpenHemisphereIsTheClampedCosine) {
    std::vector<float> open(25), cosine(16);
    std::vector<double> below(25);
    belowHorizonCoefficients(5, below);  // 1 below the horizon; 1 everywhere is sqrt(4 pi) y_0
    for (std::size_t i = 0; i < open.size(); ++i) open[i] = float((i == 0 ? std::sqrt(4 * pi) : 0) - below[i]);
    timesZ(4, open, cosine);
    const double zonal[] = {std::sqrt(pi) / 2, std::sqrt(pi / 3), std::sqrt(5 * pi) / 8, 0};
    for (int l = 0; l < 4; ++l)
        for (int m = -l; m <= l; ++m)
            EXPECT_NEAR(cosine[std::size_t(shIndex(l, m))], m == 0 ? zonal[l] : 0, 2e-7) << "l " << l << " m " << m;
}

// A function of bands 0..2 times z has bands 0..3. Both are equal at every point.
TEST(TimesZ, IsTheProductAtEveryPoint) {
    std::mt19937 random{3};
    std::normal_distribution<float> normal;
    std::vector<float> f(25), zf(16), basis(25);
    for (std::size_t i = 0; i < 9; ++i) f[i] = normal(random);
    timesZ(4, f, zf);
    for (int k = 0; k < 50; ++k) {
        const Vec3 s = normalized(Vec3{normal(random), normal(random), normal(random)});
        evalBasis(5, s, basis);
        double value = 0, product = 0;
        for (std::size_t i = 0; i < f.size(); ++i) value += double(f[i]) * basis[i];
        for (std::size_t i = 0; i < zf.size(); ++i) product += double(zf[i]) * basis[i];
        EXPECT_NEAR(product, s.z * value, 5e-7);  // 9e-8 measured
    }
}

struct Coefficients {
    VisibilityReader reader;
    PoseTable poses;
    VertexClusters clusters;
    std::vector<Vec3> tangents;

    explicit Coefficients(const std::filesystem::path& path)
        : reader(path),
          poses(readPoses(reader, {.threads = 2})),
          clusters(clusterVertices(reader.header().mesh, *reader.header().skin, 4, 2)),
          tangents(restTangents(reader.header().mesh, reader.header().rest_normals, clusters, 2)) {}
    std::vector<MatrixF> read(const char* convention, const NumberForm& form) const {
        ClusterCoefficientsRequest request;
        request.convention = parseConvention(convention);
        request.frames = {&tangents, &clusters.cluster_of_vertex, clusters.joint};
        request.vertices_of_cluster = clusters.vertices;
        request.form = &form;
        return readClusterCoefficients(reader, poses, request);
    }
};

TEST(ClusterCoefficients, InTheModelFrameAreTheBakedMoments) {
    const synthetic::TemporaryFile file("global.vis.h5");
    synthetic::writeCharacter(file.path, {});
    const Coefficients coefficients(file.path);
    const std::vector<MatrixF> global = coefficients.read("B3", kModelFrameForm);
    const std::vector<float> baked = coefficients.reader.readFrame(17).coefficients;
    for (std::size_t c = 0; c < global.size(); ++c)
        for (std::size_t i = 0; i < global[c].columns; ++i)
            EXPECT_NEAR(global[c](17, i), baked[coefficients.clusters.vertices[c][i / 9] * 9 + i % 9],
                        2e-6);  // 4e-7 measured
}

// Convention A adds 1 below the horizon in the vertex' own frame. The two frames therefore differ by a rotation only.
TEST(ClusterCoefficients, AreAsLongInEitherFrame) {
    const synthetic::TemporaryFile file("frames.vis.h5");
    synthetic::writeCharacter(file.path, {});
    const Coefficients coefficients(file.path);
    const std::vector<MatrixF> local = coefficients.read("A3", kVisibilityForm);
    const std::vector<MatrixF> global = coefficients.read("A3", kModelFrameForm);
    const auto norm = [](std::span<const float> band) {
        double sum = 0;
        for (float x : band) sum += double(x) * x;
        return std::sqrt(sum);
    };
    for (std::size_t f : {3, 40})
        for (std::size_t i = 0; i < local[2].columns; i += 9)
            for (auto [begin, size] : {std::pair<std::size_t, std::size_t>{0, 1}, {1, 3}, {4, 5}})
                EXPECT_NEAR(norm(local[2].row(f).subspan(i + begin, size)),
                            norm(global[2].row(f).subspan(i + begin, size)), 1e-6);  // 2e-7 measured
}

TEST(ClusterCoefficients, CosineWeightedStartWithTheAmbientTerm) {
    const synthetic::TemporaryFile file("cosine.vis.h5");
    synthetic::writeCharacter(file.path, {});
    const Coefficients coefficients(file.path);
    const std::vector<MatrixF> plain = coefficients.read("B2", kVisibilityForm);
    const std::vector<MatrixF> cosine = coefficients.read("B2", kCosineForm);
    for (std::size_t f : {0, 50})
        for (std::size_t i = 0; i < plain[1].columns;
             i += 4)  // integral of V z: b_10 / sqrt(3), as z = sqrt(4 pi/3) y_10
            EXPECT_NEAR(cosine[1](f, i), plain[1](f, i + 2) / std::sqrt(3.0), 1e-5);
}

}  // namespace
}  // namespace penumbra::test_local_coefficients
