// penumbra-player bench X.pnb | --scene S.json: milliseconds a frame on this machine.
#include <cstdio>

#include "formats/common/errors.h"
#include "player/bench/bench_report.h"
#include "player/bench/bench_scene.h"
#include "player/frame/open_asset.h"
#include "player/look_flags.h"
#include "player/picture_flags.h"
#include "player/player_verbs.h"

namespace penumbra {

namespace {

struct BenchCommand {
    std::filesystem::path asset, scene;
    RenderOptions options;
    int runs = 50;
    std::vector<int> characters;

    std::vector<std::filesystem::path> inputs() const { return namedFiles({asset, scene}); }
};

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
    if (command.asset.empty() && command.scene.empty())
        throw UsageError("an asset, X.pnb, or a --scene S.json is required");
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
    CLI::Option* asset = app.add_option("asset", command.asset, "X.pnb with a model");
    CLI::Option* scene = app.add_option(
        "--scene", command.scene,
        "S.json instead of an asset: characters that cast on a ground and on one another (docs/scene.md)");
    app.add_option("--runs", command.runs, "frames to time; the median counts")->check(within(1, 100000));
    app.add_option("--characters", command.characters,
                   "also so many characters of the asset at once, as 10,100; 1 is always measured with them. For a "
                   "scene: so many copies of its first character")
        ->delimiter(',')
        ->check(within(1, 10000));
    addMaterialFlags(app, command.options);
    addShadingFlags(app, command.options.shading);
    addTargetFlags(app, command.options);
    scene->excludes(asset);
    // The scene itself says these.
    for (const char* option : {"--brdf", "--slot", "--light"}) scene->excludes(app.get_option(option));
}

}  // namespace

Verb benchVerb() {
    return verbOf<BenchCommand>("bench", "Time evaluation, shading and drawing of an asset or a scene.", defineBench,
                                runBench);
}

}  // namespace penumbra
