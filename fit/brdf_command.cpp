// penumbra-fit brdf (--analytic SPEC | --merl FILE | --table FILE) -o M.brdf.h5 [--operators K]: a material as
// reflectance slices, with the papers' operators beside them where asked for.
#include <cstdio>
#include <memory>

#include "fit/brdf_operators.h"
#include "fit/fit_brdf.h"
#include "fit/fit_verbs.h"
#include "formats/brdf_source.h"
#include "formats/errors.h"

namespace penumbra {

namespace {

struct BrdfCommand {
    BrdfSource source;
    std::filesystem::path output;
    int operators = 0;  // k; 0: none
    std::string operators_from = "slices";
};

std::string modelNames() {
    std::string names;
    for (const std::string& name : brdfNames()) names += (names.empty() ? "" : ", ") + name;
    return names;
}

void define(CLI::App& app, BrdfCommand& command) {
    app.add_option("--analytic", command.source.analytic,
                   "NAME[:key=value,...][,color=R/G/B], as in ggx:alpha=0.3,f0=0.9; NAME is one of " + modelNames());
    app.add_option("--merl", command.source.merl, "measurements of the MERL database (.binary)");
    app.add_option("--table", command.source.table,
                   "scattered measurements (Cornell's .brdf), fits (.csv) or a Penumbra BRDF table");
    app.add_option("--material", command.source.material, "which row of a --table of fits");
    CLI::Option* operators =
        app.add_option(
               "--operators", command.operators,
               "also K reflection product operators (paper 000), 1..16; one more or less where K would cut a pair")
            ->check(CLI::Range(1, kMaxOperators));
    app.add_option("--operators-from", command.operators_from,
                   "slices (default), table (SVD of the BRDF itself), literal (the paper as printed, for comparisons)")
        ->check(CLI::IsMember({"slices", "table", "literal"}))
        ->needs(operators);
    app.add_option("-o,--output", command.output, "M.brdf.h5")->required();
}

nlohmann::ordered_json optionsOf(const BrdfCommand& command, const SliceOrders& orders, const RgbBrdf& brdf) {
    nlohmann::ordered_json options;
    if (!command.source.analytic.empty()) options["analytic"] = brdf.name;
    if (!command.source.merl.empty()) options["merl"] = command.source.merl.filename();
    if (!command.source.table.empty()) options["table"] = command.source.table.filename();
    if (!command.source.material.empty()) options["material"] = command.source.material;
    options["slice_order"] = orders.slice_order;
    options["view_order"] = orders.view_order;
    if (command.operators > 0) {
        options["operators"] = command.operators;
        options["operators_from"] = command.operators_from;
    }
    return options;
}

// More than slices that still change by kSettled can make of an albedo of 1.
constexpr double kMostAlbedo = 1.001;

void warn(const BrdfReading& reading, const BrdfFile& brdf) {
    const auto count = [&](const char* figure) {
        const auto found = reading.figures.find(figure);
        return found == reading.figures.end() ? 0 : found->second;
    };
    const char* name = brdf.name.c_str();
    if (const double clamped = count("clamped"); clamped > 0)
        std::fprintf(stderr, "penumbra-fit: warning: %s: %.0f negative values were set to 0\n", name, clamped);
    if (const double unmeasured = count("unmeasured"); unmeasured > 0)
        std::fprintf(stderr,
                     "penumbra-fit: warning: %s: %.0f cells above the horizon have no measurement and were filled\n",
                     name, unmeasured);
    if (const double albedo = brdf.errors.at("albedo_max"); albedo > kMostAlbedo)
        std::fprintf(stderr, "penumbra-fit: warning: %s gains energy: its largest directional albedo is %.3f\n", name,
                     albedo);
}

void addOperators(const BrdfCommand& command, const RgbBrdf& source, BrdfFile& brdf, const CommonOptions& common,
                  Report& report) {
    const OperatorSource from = parseOperatorSource(command.operators_from);
    brdf.operators = fitOperators(source, brdf, from, command.operators, common.threads);
    report.figures["operators"] = brdf.operators.count;
    report.figures["operators_asked"] = command.operators;
    report.figures["operators_from"] = command.operators_from;
    const Convention a4{BelowHorizon::kOpen, 4};
    report.figures["operators_bytes"] = expandedBytes(brdf.operators, a4.order, a4) / 3;  // of M^b and w of a channel
    if (brdf.operators.count != command.operators && !common.quiet)
        std::printf("%d operators instead of %d: %s\n", brdf.operators.count, command.operators,
                    brdf.operators.count < command.operators - 1 ? "the BRDF has no more terms"
                                                                 : "no pair of equal singular values is cut");
}

void run(const BrdfCommand& command, const CommonOptions& common, Report& report) {
    const SliceOrders orders;
    report.phase("read");
    const BrdfReading reading = readBrdfSource(command.source, common.threads);
    if (common.dry_run) {
        std::printf("would fit %s and write %s\n", reading.brdf.name.c_str(), command.output.c_str());
        return;
    }
    report.phase("fit");
    BrdfFile brdf = fitBrdf(reading.brdf, orders, common.threads);
    brdf.provenance =
        makeProvenance("penumbra-fit brdf", optionsOf(command, orders, reading.brdf).dump(), command.source.files());
    if (command.operators > 0) {
        report.phase("operators");
        addOperators(command, reading.brdf, brdf, common, report);
    }
    report.phase("shading error");
    measureShading(reading.brdf, brdf, common.threads);
    report.phase("write");
    writeBrdf(command.output, brdf);
    report.figures["name"] = brdf.name;
    for (const auto& [name, value] : reading.figures) report.figures[name] = value;
    for (const auto& [name, value] : brdf.errors) report.figures[name] = value;
    warn(reading, brdf);
    if (!common.quiet)
        std::printf("%s: shading error %.4f, fit %.4f, mean albedo %.3f %.3f %.3f (largest of any view %.3f)\n",
                    brdf.name.c_str(), brdf.errors.at("shading_d5"), brdf.errors.at("fit"), brdf.errors.at("albedo_r"),
                    brdf.errors.at("albedo_g"), brdf.errors.at("albedo_b"), brdf.errors.at("albedo_max"));
}

}  // namespace

Verb brdfVerb() {
    const auto command = std::make_shared<BrdfCommand>();
    return {"brdf",
            "A material as reflectance slices.",
            [command](CLI::App& app) { define(app, *command); },
            [command] { return command->source.files(); },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { run(*command, common, report); }};
}

}  // namespace penumbra
