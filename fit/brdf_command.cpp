// penumbra-fit brdf --analytic SPEC -o M.brdf.h5: a material as reflectance slices.
#include <cstdio>
#include <memory>

#include "fit/fit_brdf.h"
#include "fit/fit_verbs.h"
#include "formats/errors.h"

namespace penumbra {

namespace {

struct BrdfCommand {
    std::string analytic;
    std::filesystem::path output;
};

std::string modelNames() {
    std::string names;
    for (const std::string& name : brdfNames()) names += (names.empty() ? "" : ", ") + name;
    return names;
}

void define(CLI::App& app, BrdfCommand& command) {
    app.add_option("--analytic", command.analytic,
                   "NAME[:key=value,...][,color=R/G/B], as in ggx:alpha=0.3,f0=0.9; NAME is one of " + modelNames())
        ->required();
    app.add_option("-o,--output", command.output, "M.brdf.h5")->required();
}

BrdfSpec parseSpec(const std::string& text) {
    try {
        return parseBrdf(text);
    } catch (const std::invalid_argument& error) {
        throw UsageError(std::string("--analytic: ") + error.what());
    }
}

void run(const BrdfCommand& command, const CommonOptions& common, Report& report) {
    const BrdfSpec spec = parseSpec(command.analytic);
    const SliceOrders orders;
    if (common.dry_run) {
        std::printf("would fit %s and write %s\n", toString(spec).c_str(), command.output.c_str());
        return;
    }
    report.phase("fit");
    BrdfFile brdf = fitBrdf(rgbBrdf(spec), orders, common.threads);
    nlohmann::ordered_json options;
    options["analytic"] = toString(spec);
    options["slice_order"] = orders.slice_order;
    options["view_order"] = orders.view_order;
    brdf.provenance = makeProvenance("penumbra-fit brdf", options.dump(), {});
    report.phase("write");
    writeBrdf(command.output, brdf);
    report.figures["name"] = brdf.name;
    for (const auto& [name, value] : brdf.errors) report.figures[name] = value;
    if (!common.quiet)
        std::printf("%s: fit %.4f, mean albedo %.3f %.3f %.3f (largest of any view %.3f)\n", brdf.name.c_str(),
                    brdf.errors.at("fit"), brdf.errors.at("albedo_r"), brdf.errors.at("albedo_g"),
                    brdf.errors.at("albedo_b"), brdf.errors.at("albedo_max"));
}

}  // namespace

Verb brdfVerb() {
    const auto command = std::make_shared<BrdfCommand>();
    return {"brdf",
            "A material as reflectance slices.",
            [command](CLI::App& app) { define(app, *command); },
            [] { return std::vector<std::filesystem::path>{}; },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { run(*command, common, report); }};
}

}  // namespace penumbra
