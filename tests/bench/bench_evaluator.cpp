// bench_evaluator [ASSET.pnb] [--threads N] [--write OUT.pnb]: what a frame costs on the CPU. Without an asset: a
// made-up one of a real character's size (13,380 vertices, 31 joints, 31 clusters, 10 components, D5), at every
// precision. Minimum and median of 200 runs; ratios are against one thread on the portable path of the same run.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>

#include "formats/asset/mapped_file.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "pack/pack_asset.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading.h"
#include "tests/synthetic_model.h"

namespace {

using namespace penumbra;

struct Timing {
    double minimum, median;  // ms
};

Timing measure(const std::function<void()>& run) {
    std::vector<double> ms;
    for (int i = 0; i < 200; ++i) {
        const auto start = std::chrono::steady_clock::now();
        run();
        ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    std::sort(ms.begin(), ms.end());
    return {ms.front(), ms[ms.size() / 2]};
}

void print(const char* precision, const char* path, const char* what, Timing t, double baseline, double bytes) {
    std::printf("%-4s %-9s %-22s %8.4f %8.4f %8.2f", precision, path, what, t.minimum, t.median, baseline / t.minimum);
    if (bytes > 0) std::printf(" %8.2f", bytes / t.minimum * 1e-6);
    std::printf("\n");
}

// Every way to shade that tests/bench times.
const ShadingChoice choices[] = {{Reflectance::kSlices, LightForm::kFixed},
                                 {Reflectance::kSlices, LightForm::kLobes},
                                 {Reflectance::kSlices, LightForm::kRotation},
                                 {Reflectance::kOperators, LightForm::kRotation}};

std::string nameOf(const ShadingChoice& choice) {
    static const char* const forms[] = {"lobes", "fixed", "rotation"};
    return std::string(choice.reflectance == Reflectance::kSlices ? " slices " : " operators ") +
           forms[int(choice.light_form)];
}

void benchAsset(std::span<const std::byte> bytes, int threads) {
    const AssetView asset = openAsset(bytes);
    Evaluator evaluator(asset);
    const std::size_t count = evaluator.vertexCount(), clusters = evaluator.clusterCount();
    std::vector<float> coefficients(count * std::size_t(asset.model.stride));
    std::vector<Vec3> positions(count), normals(count), tangents(count), radiance(count);
    double stored = double(coefficients.size()) * 4;  // bytes a frame reads and writes
    for (const ClusterView& c : asset.model.clusters)
        stored += double(c.mean.count) * double(bytesPerNumber(c.mean.precision)) +
                  double(c.basis.count) * double(bytesPerNumber(c.basis.precision));
    const char* precision = nameOf(asset.model.clusters[0].basis.precision);
    const auto pose = [&] { evaluator.setPose(asset.animation.bonesOf(0), asset.animation.poseOf(0)); };
    const auto visibility = [&](int n) {
        parallelFor(clusters, n, [&](std::size_t c) { evaluator.evaluateCluster(c, coefficients); });
    };
    pose();
    double evaluate_base = 0, shade_base = 0;
    for (const EvaluatorPath& path : evaluatorPaths()) {
        evaluator.usePath(path);
        const Timing one = measure([&] { visibility(1); });
        if (evaluate_base == 0) evaluate_base = one.minimum;
        print(precision, path.name, "visibility, 1 thread", one, evaluate_base, stored);
        print(precision, path.name, "visibility, threads", measure([&] { visibility(threads); }), evaluate_base,
              stored);
    }
    const Timing pose_time = measure(pose);
    print(precision, "", "pose to scores", pose_time, pose_time.minimum, 0);
    print(precision, "", "pose and visibility", measure([&] { pose(), visibility(threads); }), evaluate_base, stored);
    const auto skin = [&] { evaluator.skin(0, count, positions, normals, tangents); };
    const Timing skin_time = measure(skin);
    print(precision, "", "skinning, 1 thread", skin_time, skin_time.minimum, 0);
    for (const MaterialView& material : asset.materials)
        for (const ShadingChoice& choice : choices) {
            if (!hasReflectance(material, choice.reflectance) || !hasForm(asset.lights.at(0), choice.light_form))
                continue;
            VertexShader shader(asset.model.convention, asset.model.stride, material, asset.lights.at(0), choice);
            for (const ShadePath& path : shadePaths()) {
                shader.usePath(path);
                const Timing t = measure([&] {
                    shader.shade({positions, normals, tangents, coefficients, 0, count}, {0, 1, 4}, radiance);
                });
                if (shade_base == 0) shade_base = t.minimum;
                const std::string what = "shade " + std::string(material.name.substr(0, 12)) + nameOf(choice);
                print(precision, path.name, what.c_str(), t, shade_base, 0);
                std::printf("%50s %.1f ns a vertex\n", "", t.minimum * 1e6 / double(count));
            }
        }
}

// A material whose slices have the pattern of an isotropic BRDF: only equal m couple.
BrdfFile isotropicNoise() {
    BrdfFile brdf = synthetic::lambert();
    brdf.name = "isotropic";
    synthetic::Noise noise(2);
    const std::size_t even = brdf.even_index.size();
    for (std::size_t k = 0; k < 25; ++k)
        for (std::size_t e = 0; e < even; ++e) {
            const int bk = bandOfIndex(int(k)), be = bandOfIndex(brdf.even_index[e]);
            const bool coupled = int(k) - bk * (bk + 1) == brdf.even_index[e] - be * (be + 1);
            const double value = coupled ? noise() : 0;
            for (std::size_t c = 0; c < 3; ++c) brdf.slices[(k * even + e) * 3 + c] = value;
        }
    return brdf;
}

// A lobe without slices.
BrdfFile live() {
    BrdfFile brdf;
    brdf.name = "phong-live";
    brdf.slice_order = brdf.view_order = 1;
    brdf.even_index = {0};
    brdf.lobes = {lobeOf(parseBrdf("phong-live"))};
    return brdf;
}

}  // namespace

int main(int argc, char** argv) {
    int threads = hardwareThreads();
    const char *asset = nullptr, *write = nullptr;
    for (int i = 1; i < argc; ++i) {
        if (!std::strcmp(argv[i], "--threads") && i + 1 < argc)
            threads = std::atoi(argv[++i]);
        else if (!std::strcmp(argv[i], "--write") && i + 1 < argc)
            write = argv[++i];
        else
            asset = argv[i];
    }
    std::printf("%-4s %-9s %-22s %8s %8s %8s %8s   (%d threads)\n", "", "path", "what", "min ms", "median", "ratio",
                "GB/s", threads);
    if (asset) {
        const MappedFile file(asset);
        benchAsset(file.bytes(), threads);
        return 0;
    }
    synthetic::TubeOptions tube{
        .rings = 223, .segments = 60, .joints = 31, .clusters = 31, .components = 10, .inputs = 20};
    const Model model = synthetic::tubeModel(tube);
    const std::vector<BrdfFile> brdfs = {synthetic::lambert(), isotropicNoise(), live()};
    const std::vector<LightFile> lights = {synthetic::light(4, 0.3)};
    for (AssetPrecision precision : {AssetPrecision::kF32, AssetPrecision::kF16, AssetPrecision::kI8}) {
        const Packed packed = packAsset(model, brdfs, lights, {.precision = precision, .max_error = {}}, "{}", 0);
        if (write && precision == AssetPrecision::kI8) writeWholeFile(std::filesystem::path(write), packed.bytes);
        benchAsset(packed.bytes, threads);
    }
    return 0;
}
