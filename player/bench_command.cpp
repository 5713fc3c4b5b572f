// penumbra-player bench X.pnb | --scene S.json: milliseconds a frame on this machine.
#include <cstdio>

#include "formats/common/errors.h"
#include "player/bench/bench_report.h"
#include "player/bench/bench_scene.h"
#include "player/frame/open_asset.h"
#include "player/player_verbs.h"

namespace penumbra {

namespace {

struct BenchCommand {
    std::filesystem::path asset, scene;
    RenderOptions options;
    std::string size, backend = "auto", reflectance = "slices", light_form = "auto";
    int runs = 50;
    std::vector<int> characters;
    std::vector<const CLI::Option*> asset_only;  // what a scene says itself
};

void refuseForScenes(const BenchCommand& command) {
    if (command.asset.empty() == command.scene.empty())
        throw UsageError(command.asset.empty() ? "an asset, X.pnb, or a --scene S.json is required"
                                               : "an asset or a --scene: one or the other");
    if (command.scene.empty()) return;
    for (const CLI::Option* option : command.asset_only)
        if (option->count() > 0) throw UsageError(option->get_name() + " is of no use with --scene");
}

void runSceneBench(const BenchCommand& command, const CommonOptions& common, Report& report) {
    const SceneDescription scene = readScene(command.scene);
    report.willRead(filesNamedIn(scene));
    if (common.dry_run) {
        const std::size_t members = PosedScene(scene).members().size();
        std::printf("would time %d frames of %zu characters and props\n", command.runs, members);
        return;
    }
    const SceneBench bench = benchScene(command.options, scene, command.runs, common.threads, command.characters);
    report.figures = figuresOf(bench);
    if (!common.quiet) printScene(bench);
}

void runBench(BenchCommand& command, const CommonOptions& common, Report& report) {
    refuseForScenes(command);
    command.options.backend = parseGlBackend(command.backend);
    command.options.shading = {parseReflectance(command.reflectance), parseLightForm(command.light_form)};
    if (!command.size.empty()) parseSize(command.size, command.options.width, command.options.height);
    if (const std::string problem = findProblem(command.options); !problem.empty()) throw UsageError(problem);
    if (!command.scene.empty()) return runSceneBench(command, common, report);
    const OpenAsset asset(command.asset);
    if (common.dry_run) {
        std::printf("would time %d frames of %zu vertices\n", command.runs, asset.view.mesh.positions.size());
        return;
    }
    const BenchResult r = benchAsset(command.options, asset.view, command.runs, common.threads, command.characters);
    report.figures = figuresOf(r);
    if (!common.quiet) printBench(r);
}

void defineBench(CLI::App& app, BenchCommand& command) {
    app.add_option("asset", command.asset, "X.pnb with a model");
    app.add_option("--scene", command.scene,
                   "S.json instead of an asset: characters that cast on a ground and on one another (docs/scene.md)");
    app.add_option("--runs", command.runs, "frames to time; the median counts")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    app.add_option("--characters", command.characters,
                   "also so many characters of the asset at once, as 10,100; 1 is always measured with them. Of a "
                   "scene: so many "
                   "copies of its first character")
        ->delimiter(',')
        ->check(CLI::Range(1, 10000));
    command.asset_only = {app.add_option("--brdf", command.options.brdf,
                                         "name of one material for all parts (default: what the asset gives each)"),
                          app.add_option("--slot", command.options.slots,
                                         "SLOT=NAME: the material of a part of the mesh; any number of them"),
                          app.add_option("--light", command.options.light, "name of the light (default: the first)")};
    app.add_option("--light-form", command.light_form, "auto, lobes (as fitted), fixed or rotation (both exact)")
        ->capture_default_str();
    app.add_option("--reflectance", command.reflectance, "slices, or the paper's operators")->capture_default_str();
    app.add_option("--size", command.size, "WIDTHxHEIGHT in pixels (default: 512x512)");
    app.add_option("--aa", command.options.samples, "samples a pixel: 1, 2, 4 or 8")->capture_default_str();
    app.add_option("--gl", command.backend, "auto (a GPU, else software), egl or osmesa")->capture_default_str();
}

}  // namespace

Verb benchVerb() {
    const auto command = std::make_shared<BenchCommand>();
    return {"bench",
            "Time evaluation, shading and drawing of an asset or a scene.",
            [command](CLI::App& app) { defineBench(app, *command); },
            [command] {
                std::vector<std::filesystem::path> inputs;
                for (const std::filesystem::path& file : {command->asset, command->scene})
                    if (!file.empty()) inputs.push_back(file);
                return inputs;
            },
            {},
            [command](const CommonOptions& common, Report& report) { runBench(*command, common, report); }};
}

}  // namespace penumbra
