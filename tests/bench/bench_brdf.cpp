// bench_brdf [COMMIT]: seven BRDFs as the paper's operators and as slices: shading error on the reference scenes,
// bytes, multiply-adds and time a vertex of the run-time's own kernel, and what the fit took. A table, then CSV rows
// (tests/bench/results). Variants:
//   paper literal    M^b as Nowrouzezahrai 2009 prints the recipe, k = 8, A4
//   operators table  M^b of the weighted SVD, w by least squares, k = 8, A4
//   operators slices M^b made from C, k = 8, A4
//   C A4, C D4, C D5 slices with 16, 10 and 15 numbers of visibility a vertex
// One channel of colour (all seven are grey), light of order 4 rotated into every vertex' frame exactly. bytes: of the
// operators M^b and w (as the paper counts), of C as an asset stores it (an isotropic C has 32 different numbers, 128
// bytes; an orthotropic one 102). ns: minimum of 400 runs over 13,380 vertices on one thread. The kernel knows no view
// functions that are odd in z, so the time of `paper literal` is that of its u with even w: 15 instead of 16 of them.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>

#include "fit/papers/operators/brdf_operators.h"
#include "fit/reflectance/fit_brdf.h"
#include "formats/common/parallel_for.h"
#include "pack/pack_asset.h"
#include "runtime/shade/shading.h"
#include "tests/fit/multiply_adds.h"
#include "tests/fit/reference_brdfs.h"
#include "tests/synthetic_model.h"

namespace {

using namespace penumbra;

const Convention kA4{BelowHorizon::kOpen, 4};
constexpr int kRepeats = 400;
constexpr std::size_t kVertices = 13380;

double milliseconds(const std::function<void()>& run, int repeats) {
    double least = 1e30;
    for (int i = 0; i < repeats; ++i) {
        const auto start = std::chrono::steady_clock::now();
        run();
        least = std::min(least,
                         std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    return least;
}

struct Vertices {
    std::vector<Vec3> positions, normals, tangents, radiance;
    std::vector<float> coefficients;
    int stride = 16;
};

Vertices someVertices() {
    Vertices v;
    synthetic::Noise noise(5);
    synthetic::fillNoise(v.coefficients, kVertices, std::size_t(v.stride), noise);
    for (std::size_t i = 0; i < kVertices; ++i) {
        const Vec3 n = normalized(Vec3{float(noise()), float(noise()), float(noise()) + 0.1f});
        v.positions.push_back({float(noise()), float(noise()), float(noise())});
        v.normals.push_back(n);
        v.tangents.push_back(normalized(cross(n, std::abs(n.x) < 0.5f ? Vec3{1, 0, 0} : Vec3{0, 1, 0})));
    }
    v.radiance.resize(kVertices);
    return v;
}

// Returns the ns a vertex on the fastest path of this processor.
double timeOf(const BrdfFile& brdf, Reflectance reflectance, const Convention& convention, Vertices& v) {
    const std::vector<BrdfFile> materials = {brdf};
    const std::vector<LightFile> lights = {synthetic::light(4, 0.3)};
    const Packed packed = packAsset(synthetic::tubeModel({.clusters = 1}), materials, lights, {}, "{}", 1);
    const AssetView asset = openAsset(packed.bytes);
    const VertexShader shader(convention, v.stride, asset.materials[0], asset.lights[0],
                              {reflectance, LightForm::kRotation});
    const auto shade = [&] {
        shader.shade({v.positions, v.normals, v.tangents, v.coefficients, 0, kVertices}, {0, 1, 4}, v.radiance);
    };
    return milliseconds(shade, kRepeats) * 1e6 / double(kVertices);
}

struct Row {
    std::string brdf, variant;
    double error;
    std::size_t bytes, multiply_adds, dense;
    double ns, fit_ms;
};

Row operatorRow(const RgbBrdf& source, BrdfFile& brdf, OperatorSource from, double slice_ms, int threads,
                Vertices& vertices) {
    Row row;
    row.brdf = source.name;
    row.variant = from == OperatorSource::kLiteral ? "paper literal" : "operators " + std::string(nameOf(from));
    row.fit_ms = milliseconds([&] { brdf.operators = fitOperators(source, brdf, from, 8, threads); }, 3) +
                 (from == OperatorSource::kSlices ? slice_ms : 0);
    measureOperators(shadingTruth(source, threads), brdf);
    row.error = brdf.errors.at("shading_operators");
    row.bytes = expandedBytes(brdf.operators, 4, kA4) / 3;
    row.multiply_adds = multiplyAdds(brdf.operators, 4, kA4, false).total(4);
    row.dense = multiplyAdds(brdf.operators, 4, kA4, true).total(4);
    BrdfFile timed = brdf;
    if (from == OperatorSource::kLiteral) {
        timed.operators.view_index = brdf.even_index;
        const BrdfOperators even = fitOperators(source, brdf, OperatorSource::kTable, brdf.operators.count, threads);
        timed.operators.w = even.w;
        timed.operators.w.resize(std::size_t(timed.operators.count) * brdf.even_index.size() * 3);
    }
    row.ns = timeOf(timed, Reflectance::kOperators, kA4, vertices);
    return row;
}

std::vector<Row> rowsOf(const char* spec, int threads, Vertices& vertices) {
    const RgbBrdf source = rgbBrdf(parseBrdf(spec));
    BrdfFile brdf;
    const double slice_ms = milliseconds([&] { brdf = fitBrdf(source, {}, threads); }, 3);
    std::vector<Row> rows;
    for (OperatorSource from : {OperatorSource::kLiteral, OperatorSource::kTable, OperatorSource::kSlices})
        rows.push_back(operatorRow(source, brdf, from, slice_ms, threads, vertices));
    brdf.operators = {};
    const ShadingTest test = makeShadingTest(referenceScenes(), threads);
    const std::vector<double> truth = bruteForceRadiance(test, source, threads),
                              slices = slicesOfViews(test.scenes.views, brdf.slices, brdf.even_index);
    for (const char* name : {"A4", "D4", "D5"}) {
        const Convention convention = parseConvention(name);
        const std::size_t work = multiplyAdds(brdf, 4, convention).total(4);
        rows.push_back({source.name, std::string("C ") + name,
                        shadingError({test, truth}, convention, slices, brdf.slice_order),
                        brdf.slices.size() / 3 * sizeof(float), work, work,
                        timeOf(brdf, Reflectance::kSlices, convention, vertices), slice_ms});
    }
    return rows;
}

}  // namespace

int main(int argc, char** argv) {
    const int threads = hardwareThreads();
    Vertices vertices = someVertices();
    std::vector<Row> rows;
    std::printf("%-46s %-16s %7s %6s %9s %6s %8s %8s   (%s, %d threads)\n", "", "", "error", "bytes", "mul-adds",
                "dense", "ns", "fit ms", shadePaths().back().name, threads);
    for (const char* spec : kReferenceBrdfs)
        for (Row& row : rowsOf(spec, threads, vertices)) {
            std::printf("%-46s %-16s %7.4f %6zu %9zu %6zu %8.1f %8.1f\n", row.brdf.c_str(), row.variant.c_str(),
                        row.error, row.bytes, row.multiply_adds, row.dense, row.ns, row.fit_ms);
            rows.push_back(std::move(row));
        }
    std::printf("\ncommit,brdf,variant,shading_error,bytes,multiply_adds,multiply_adds_dense,ns_a_vertex,fit_ms\n");
    for (const Row& row : rows) {
        std::string name = row.brdf;
        std::replace(name.begin(), name.end(), ',', '+');
        std::printf("%s,%s,%s,%.4f,%zu,%zu,%zu,%.1f,%.1f\n", argc > 1 ? argv[1] : "", name.c_str(), row.variant.c_str(),
                    row.error, row.bytes, row.multiply_adds, row.dense, row.ns, row.fit_ms);
    }
    return 0;
}
