// penumbra-fit light ENV.(exr|hdr) -o E.light.h5: an environment picture as SH and as zonal lobes.
#include <chrono>
#include <cstdio>
#include <memory>

#include "fit/fit_light.h"
#include "fit/fit_verbs.h"
#include "fit/light_lobes.h"
#include "formats/errors.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

struct LightCommand {
    std::filesystem::path picture, output;
    std::string layout;  // "": by the picture's shape
    int order = 4, lobes = 3;
    std::string lobe_fit = "joint";
    const CLI::Option* lobes_option = nullptr;
};

void define(CLI::App& app, LightCommand& command) {
    app.add_option("picture", command.picture, "environment, OpenEXR or Radiance HDR")->required();
    app.add_option(
           "--layout", command.layout,
           "lat-long, angular map (light probe), mirror ball or cross of cube faces; by the shape when not given")
        ->check(CLI::IsMember({"latlong", "angular", "ball", "cube"}));
    app.add_option("-o,--output", command.output, "E.light.h5")->required();
    app.add_option("--order", command.order, "SH bands")->check(CLI::Range(1, kMaxOrder));
    command.lobes_option =
        app.add_option("--lobes", command.lobes, "zonal lobes, 0 for none")->check(CLI::Range(0, kMaxFittedLobes));
    app.add_option("--lobe-fit", command.lobe_fit,
                   "one lobe after the other; directions refined together; 2 ORDER - 1 fixed directions, exact")
        ->check(CLI::IsMember({"greedy", "joint", "fixed"}));
}

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void addLobes(const LightCommand& command, LightFile& light, Report& report, bool quiet) {
    if (command.lobes == 0 && command.lobe_fit != "fixed") return;
    report.phase("lobes");
    const auto start = std::chrono::steady_clock::now();
    light.lobes = fitLobes(light.order, light.sh, command.lobes, parseLobeFit(command.lobe_fit));
    const double seconds = secondsSince(start);
    report.figures["lobes"] = {{"fit", light.lobes.mode},
                               {"count", light.lobes.directions.size()},
                               {"residual", light.lobes.residual},
                               {"irradiance_error", light.lobes.irradiance_error},
                               {"seconds", seconds}};
    if (!quiet)
        std::printf("%s: %zu %s lobes, residual %.4f of the SH, irradiance error %.4f, %.1f ms\n", light.name.c_str(),
                    light.lobes.directions.size(), light.lobes.mode.c_str(), light.lobes.residual,
                    light.lobes.irradiance_error, 1000 * seconds);
}

void checkOptions(const LightCommand& command) {
    if (command.lobe_fit == "fixed" && command.lobes_option->count() > 0 &&
        command.lobes != fixedLobeCount(command.order))
        throw UsageError("--lobes: --lobe-fit fixed has " + std::to_string(fixedLobeCount(command.order)) +
                         " lobes at order " + std::to_string(command.order) + ", not " + std::to_string(command.lobes));
}

void run(const LightCommand& command, const CommonOptions& common, Report& report) {
    checkOptions(command);
    report.phase("read");
    const EnvironmentMap map = readEnvironmentMap(command.picture, command.layout);
    report.phase("fit");
    LightFile light = fitLight(map, command.picture.string(), command.order, common.threads);
    if (common.dry_run) {
        std::printf("would fit order %d to %d x %d pixels, layout %s, and write %s\n", command.order, map.image.width,
                    map.image.height, std::string(nameOf(map.layout)).c_str(), command.output.c_str());
        return;
    }
    nlohmann::ordered_json options;
    options["layout"] = nameOf(map.layout);
    options["order"] = command.order;
    options["lobes"] = command.lobes;
    options["lobe_fit"] = command.lobe_fit;
    light.provenance = makeProvenance("penumbra-fit light", options.dump(), {command.picture});
    report.figures["layout"] = nameOf(map.layout);
    report.figures["negative_pixels"] = map.negative_pixels;
    report.figures["negative_share"] = map.negative_share;
    report.figures["order"] = light.order;
    report.figures["residual"] = light.residual;
    // Mean radiance: SH_0 / sqrt(4pi) = SH_0 y_0.
    const double y0 = 0.28209479177387814;
    report.figures["mean_radiance"] = {light.sh[0] * y0, light.sh[1] * y0, light.sh[2] * y0};
    if (!common.quiet)
        std::printf("%s: order %d, residual %.4f of the picture, mean radiance %.4g %.4g %.4g\n", light.name.c_str(),
                    light.order, light.residual, light.sh[0] * y0, light.sh[1] * y0, light.sh[2] * y0);
    if (map.negative_share > 1e-5 && !common.quiet)
        std::printf("%s: %zu pixels below 0 made 0, %.2g%% of the light, taken from the bright ones beside them\n",
                    light.name.c_str(), map.negative_pixels, 100 * map.negative_share);
    addLobes(command, light, report, common.quiet);
    report.phase("write");
    writeLight(command.output, light);
}

}  // namespace

Verb lightVerb() {
    const auto command = std::make_shared<LightCommand>();
    return {"light",
            "An environment picture as SH and as zonal lobes.",
            [command](CLI::App& app) { define(app, *command); },
            [command] { return std::vector<std::filesystem::path>{command->picture}; },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { run(*command, common, report); }};
}

}  // namespace penumbra
