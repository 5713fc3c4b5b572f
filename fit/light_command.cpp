// penumbra-fit light ENV.(exr|hdr) -o E.light.h5: an environment picture as SH.
#include <cstdio>
#include <memory>

#include "fit/fit_light.h"
#include "fit/fit_verbs.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

struct LightCommand {
    std::filesystem::path picture, output;
    int order = 4;
};

void define(CLI::App& app, LightCommand& command) {
    app.add_option("picture", command.picture, "lat-long environment, OpenEXR or Radiance HDR")->required();
    app.add_option("-o,--output", command.output, "E.light.h5")->required();
    app.add_option("--order", command.order, "SH bands")->check(CLI::Range(1, kMaxOrder));
}

void run(const LightCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    const Image image = readImage(command.picture);
    report.phase("fit");
    LightFile light = fitLight(image, command.picture.string(), command.order);
    if (common.dry_run) {
        std::printf("would fit order %d to %d x %d pixels and write %s\n", command.order, image.width, image.height,
                    command.output.c_str());
        return;
    }
    nlohmann::ordered_json options;
    options["layout"] = "latlong";
    options["order"] = command.order;
    light.provenance = makeProvenance("penumbra-fit light", options.dump(), {command.picture});
    report.phase("write");
    writeLight(command.output, light);
    report.figures["order"] = light.order;
    report.figures["residual"] = light.residual;
    // Mean radiance: SH_0 / sqrt(4pi) = SH_0 y_0.
    const double y0 = 0.28209479177387814;
    report.figures["mean_radiance"] = {light.sh[0] * y0, light.sh[1] * y0, light.sh[2] * y0};
    if (!common.quiet)
        std::printf("%s: order %d, residual %.4f of the picture, mean radiance %.4g %.4g %.4g\n", light.name.c_str(),
                    light.order, light.residual, light.sh[0] * y0, light.sh[1] * y0, light.sh[2] * y0);
}

}  // namespace

Verb lightVerb() {
    const auto command = std::make_shared<LightCommand>();
    return {"light",
            "An environment picture as SH.",
            [command](CLI::App& app) { define(app, *command); },
            [command] { return std::vector<std::filesystem::path>{command->picture}; },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { run(*command, common, report); }};
}

}  // namespace penumbra
