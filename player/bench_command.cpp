#include "player/bench_command.h"

#include <cstdio>

#include "formats/errors.h"
#include "player/bench.h"
#include "player/open_asset.h"

namespace penumbra {

struct BenchCommand {
    std::filesystem::path asset;
    RenderOptions options;
    std::string size, backend = "auto", reflectance = "slices", light_form = "auto";
    int runs = 50;
};

static void printSwitching(const char* what, const BenchResult::Switching& s) {
    if (s.steady == 0) return;
    std::printf("%s %8.3f ms, worst %.3f; without %.3f ms, worst %.3f: ratio %.3f, worst %.3f\n", what, s.switched,
                s.switched_worst, s.steady, s.steady_worst, s.switched / s.steady, s.switched_worst / s.steady_worst);
}

static nlohmann::json figuresOf(const BenchResult::Switching& s) {
    return {{"switched_ms", s.switched},
            {"switched_worst_ms", s.switched_worst},
            {"steady_ms", s.steady},
            {"steady_worst_ms", s.steady_worst}};
}

static void printResult(const BenchResult& r, int threads) {
    std::printf("%zu vertices, %zu triangles, %d threads; %s\n", r.vertices, r.triangles, threads, r.gl.c_str());
    std::printf("CPU  pose and skin       %8.3f ms\n", r.skin);
    std::printf("CPU  evaluate visibility %8.3f ms  %6.2f GB/s  %7.2f Mvertices/s\n", r.evaluate,
                double(r.bytes_read) / r.evaluate * 1e-6, double(r.vertices) / r.evaluate * 1e-3);
    if (r.shade > 0)
        std::printf("CPU  shade               %8.3f ms  %18.2f Mvertices/s  %.1f ns a vertex\n", r.shade,
                    double(r.vertices) / r.shade * 1e-3, r.shade * 1e6 / double(r.vertices));
    else
        std::printf("CPU  shade                      -     (no material or no light in the asset)\n");
    std::printf("GL   draw CPU's values   %8.3f ms\n", r.draw_values);
    std::printf("GL   evaluate and draw   %8.3f ms  (the first time, with upload and shader compilation: %.0f ms)\n",
                r.draw_model, r.first_frame);
    printSwitching("CPU  shade, switched    ", r.switch_cpu);
    printSwitching("GL   draw, switched     ", r.switch_gl);
    std::printf("the asset's frames are out of the training range by %.4f on average, at most %.4f\n",
                r.out_of_range_mean, r.out_of_range_max);
}

static void runBench(BenchCommand& command, const CommonOptions& common, Report& report) {
    command.options.backend = parseGlBackend(command.backend);
    command.options.shading = {parseReflectance(command.reflectance), parseLightForm(command.light_form)};
    if (!command.size.empty()) parseSize(command.size, command.options.width, command.options.height);
    if (const std::string problem = findProblem(command.options); !problem.empty()) throw UsageError(problem);
    const OpenAsset asset(command.asset);
    if (common.dry_run) {
        std::printf("would time %d frames of %zu vertices\n", command.runs, asset.view.mesh.positions.size());
        return;
    }
    const BenchResult r = benchAsset(command.options, asset.view, command.runs, common.threads);
    report.figures = {{"gl", r.gl},
                      {"vertices", r.vertices},
                      {"triangles", r.triangles},
                      {"bytes_read", r.bytes_read},
                      {"skin_ms", r.skin},
                      {"evaluate_ms", r.evaluate},
                      {"shade_ms", r.shade},
                      {"draw_values_ms", r.draw_values},
                      {"draw_model_ms", r.draw_model},
                      {"first_frame_ms", r.first_frame},
                      {"switch_cpu", figuresOf(r.switch_cpu)},
                      {"switch_gl", figuresOf(r.switch_gl)},
                      {"out_of_range_mean", r.out_of_range_mean},
                      {"out_of_range_max", r.out_of_range_max}};
    if (!common.quiet) printResult(r, common.threads);
}

static void defineBench(CLI::App& app, BenchCommand& command) {
    app.add_option("asset", command.asset, "X.pnb with a model")->required();
    app.add_option("--runs", command.runs, "frames to time; the median counts")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    app.add_option("--brdf", command.options.brdf,
                   "name of one material for all parts (default: what the asset gives each)");
    app.add_option("--slot", command.options.slots,
                   "SLOT=NAME: the material of a part of the mesh; any number of them");
    app.add_option("--light-form", command.light_form, "auto, lobes (as fitted), fixed or rotation (both exact)")
        ->capture_default_str();
    app.add_option("--reflectance", command.reflectance, "slices, or the paper's operators")->capture_default_str();
    app.add_option("--light", command.options.light, "name of the light (default: the first)");
    app.add_option("--size", command.size, "WIDTHxHEIGHT in pixels (default: 512x512)");
    app.add_option("--aa", command.options.samples, "samples a pixel: 1, 2, 4 or 8")->capture_default_str();
    app.add_option("--gl", command.backend, "auto (a GPU, else software), egl or osmesa")->capture_default_str();
}

Verb benchVerb() {
    const auto command = std::make_shared<BenchCommand>();
    return {"bench",
            "Time evaluation, shading and drawing of an asset.",
            [command](CLI::App& app) { defineBench(app, *command); },
            [command] { return std::vector<std::filesystem::path>{command->asset}; },
            {},
            [command](const CommonOptions& common, Report& report) { runBench(*command, common, report); }};
}

}  // namespace penumbra
