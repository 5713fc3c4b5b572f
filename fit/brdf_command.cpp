// penumbra-fit brdf (--analytic SPEC | --merl FILE | --table FILE) -o M.brdf.h5 [--operators K]: fits a material as
// reflectance slices, and beside them the papers' operators when they are asked for.
#include <bit>
#include <cstdio>
#include <memory>

#include "fit/fit_verbs.h"
#include "fit/papers/papers.h"
#include "fit/reflectance/fit_brdf.h"
#include "fit/reflectance/fit_steps.h"
#include "fit/reflectance/live_shading_error.h"
#include "fit/reflectance/shading_error.h"
#include "formats/brdf/brdf_source.h"
#include "formats/brdf/fit_lobes.h"
#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "formats/common/name_option.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "sh/brdf/mirror_lobe.h"
#include "sh/reflectance.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr int kDefaultSteps = int(kMaxBrdfSteps);

struct BrdfCommand {
    BrdfSource source{.takes_ranges = true};
    std::filesystem::path output;
    OperatorsCommand operators;
    SliceOrders orders;
    int steps = 0;                                // most steps of a range; 0: kDefaultSteps
    std::string name;                             // empty: the name of the source
    std::vector<const CLI::Option*> of_tables{};  // options of slices, which live materials and membranes do not choose

    std::vector<std::filesystem::path> inputs() const { return source.files(); }
};

void define(CLI::App& app, BrdfCommand& command) {
    app.add_option("--analytic", command.source.analytic,
                   "NAME[:key=value,...][,color=R/G/B], as in ggx:alpha=0.3,f0=0.9; NAME is one of " +
                       joined(brdfNames()) +
                       ", membrane (docs/cloth.md) or principled (glTF's material); models add up, as in "
                       "lambert:color=0.2+ggx; one "
                       "parameter may have a range, as alpha=0.1..0.6, for a slider");
    app.add_option("--merl", command.source.merl, "measurements of the MERL database (.binary)");
    app.add_option("--table", command.source.table,
                   "scattered measurements (Cornell's .brdf), fits (.csv) or a Penumbra BRDF table");
    app.add_option("--material", command.source.material, "which row of a --table of fits");
    addOperatorOptions(app, command.operators);
    app.add_option("--slice-order", command.orders.slice_order, "bands of the slices over the incident direction")
        ->check(within(1, kMaxOrder));
    app.add_option("--view-order", command.orders.view_order, "bands of the slices over the view")
        ->check(within(1, kMaxOrder));
    app.add_option("--steps", command.steps,
                   "tables that a range has at most (" + std::to_string(kDefaultSteps) +
                       "); it has as many as its error asks for")
        ->check(within(3, int(kMaxBrdfSteps)));
    for (const char* option : {"--slice-order", "--view-order", "--operators"})
        command.of_tables.push_back(app.get_option(option));
    addNameOption(app, command.name);
    app.add_option("-o,--output", command.output, "M.brdf.h5")->required();
    app.footer(describeBrdfs() + "\n" + app.get_footer());
}

nlohmann::ordered_json optionsOf(const BrdfCommand& command, const RgbBrdf& brdf) {
    nlohmann::ordered_json options;
    if (!command.source.analytic.empty()) options["analytic"] = brdf.name;
    if (!command.source.merl.empty()) options["merl"] = command.source.merl.filename();
    if (!command.source.table.empty()) options["table"] = command.source.table.filename();
    if (!command.source.material.empty()) options["material"] = command.source.material;
    if (command.steps > 0) options["steps"] = command.steps;
    options["slice_order"] = command.orders.slice_order;
    options["view_order"] = command.orders.view_order;
    if (!command.name.empty()) options["name"] = command.name;
    if (command.operators.count > 0) {
        options["operators"] = command.operators.count;
        options["operators_from"] = nameOf(command.operators.from);
    }
    return options;
}

// Slices that still change by kSettled cannot turn an albedo of 1 into more than this.
constexpr double kMaxAlbedo = 1.001;

std::string rounded(double value, int digits) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

void warn(const BrdfReading& reading, const BrdfFile& brdf) {
    const auto count = [&](const char* figure) {
        const auto found = reading.figures.find(figure);
        return found == reading.figures.end() ? 0 : found->second;
    };
    const auto say = [](const std::string& message) { reportWarning("penumbra-fit", message); };
    if (brdf.steps && brdf.steps->error > kMaxStepError)
        say(brdf.name + ": " + std::to_string(brdf.steps->values.size()) + " steps have an error of " +
            rounded(brdf.steps->error, 4) + ", above " + rounded(kMaxStepError, 4) +
            ": more --steps or a smaller range help");
    if (const double clamped = count("clamped"); clamped > 0)
        say(brdf.name + ": " + std::to_string(std::size_t(clamped)) + " negative values were set to 0");
    if (const double unmeasured = count("unmeasured"); unmeasured > 0)
        say(brdf.name + ": " + std::to_string(std::size_t(unmeasured)) +
            " cells above the horizon have no measurement and were filled");
    if (const double albedo = brdf.isLive() ? 0 : brdf.errors.at("albedo_max"); albedo > kMaxAlbedo)
        say(brdf.name + " gains energy: its largest directional albedo is " + rounded(albedo, 3));
}

// A live material has no slices to fit.
BrdfFile liveFile(const BrdfReading& reading) {
    BrdfFile brdf;
    brdf.name = reading.brdf.name;
    brdf.slice_order = brdf.view_order = 1;
    brdf.even_index = evenIndices(1);
    brdf.lobes = reading.lobes;
    return brdf;
}

// Measures the errors, fits lobes to a material that is no analytic model (which is its own lobe), and the papers'
// operators where they are asked for.
void measure(const BrdfCommand& command, const BrdfReading& reading, BrdfFile& brdf, const CommonOptions& common,
             Report& report) {
    report.phase("shading error");
    const ShadingTruth truth = shadingTruth(reading.brdf, common.threads);
    measureShading(truth, brdf);
    report.phase("lobes");
    brdf.lobes = reading.lobes;
    if (brdf.lobes.empty()) {
        brdf.lobes = fitLobes(samplesOf(reading.brdf));
        brdf.lobe_error = lobeError(truth, brdf.lobes, common.threads);
    }
    if (command.operators.count > 0) addOperators(command.operators, truth, reading.brdf, brdf, common, report);
}

// The parameter that steps change.
const BrdfParameter* parameterOf(const BrdfFile& brdf) {
    const std::size_t lobe = std::size_t(std::countr_zero(brdf.steps->lobes));
    return &parametersOf(brdf.lobes[lobe].model)[brdf.steps->parameter];
}

void describe(const BrdfFile& brdf) {
    const auto error = [&](const char* name) { return brdf.errors.at(name); };
    if (brdf.isLive()) {
        std::printf("%s: shading error %.4f, no table\n", brdf.name.c_str(), error("shading_d5"));
        return;
    }
    if (brdf.membrane) {
        std::printf("%s: shading error %.4f of a white side\n", brdf.name.c_str(), error("shading_d5"));
        return;
    }
    std::printf("%s: shading error %.4f, fit %.4f, mean albedo %.3f %.3f %.3f (largest of any view %.3f)\n",
                brdf.name.c_str(), error("shading_d5"), error("fit"), error("albedo_r"), error("albedo_g"),
                error("albedo_b"), error("albedo_max"));
    std::printf("%zu %s for light from one direction, error %.4f\n", brdf.lobes.size(),
                brdf.lobes.size() == 1 ? "lobe" : "lobes", brdf.lobe_error);
    if (brdf.steps)
        std::printf("%zu steps of %s, error between them at most %.4f\n", brdf.steps->values.size(),
                    parameterOf(brdf)->name, brdf.steps->error);
    if (brdf.operators.count > 0) describeOperators(brdf);
}

void run(const BrdfCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    const BrdfReading reading = readBrdfSource(command.source, common.threads);
    const bool is_live = reading.lobes.size() == 1 && isMirrorLobe(reading.lobes[0].model);
    if (!reading.range && command.steps > 0) throw UsageError("--steps needs a range, as alpha=0.1..0.6");
    if (reading.range && command.operators.count > 0)
        throw UsageError("--operators: " + reading.brdf.name + " has a range, and operators are not interpolated");
    for (const CLI::Option* option : command.of_tables)
        if ((is_live || reading.membrane) && option->count() > 0)
            throw UsageError(option->get_name() + ": " + reading.brdf.name +
                             (is_live ? " has no table" : " has the exact cosine of two sides"));
    if (common.dry_run) {
        std::printf("would fit %s and write %s\n", reading.brdf.name.c_str(), command.output.c_str());
        return;
    }
    report.phase("fit");
    // The light of a membrane's two sides is exact with all bands of the cosine; no view changes it.
    const SliceOrders orders = reading.membrane ? SliceOrders{kMaxOrder, 1} : command.orders;
    BrdfFile brdf = is_live ? liveFile(reading) : fitBrdf(reading.brdf, orders, common.threads);
    brdf.membrane = reading.membrane;
    brdf.emission = toFloat(reading.emission);
    if (reading.range) {
        report.phase("steps");
        brdf.steps =
            fitSteps(*reading.range, orders, command.steps > 0 ? command.steps : kDefaultSteps, common.threads);
    }
    if (!command.name.empty()) brdf.name = command.name;
    brdf.provenance = makeProvenance("penumbra-fit brdf", optionsOf(command, reading.brdf).dump(), command.inputs());
    if (is_live) {
        report.phase("shading error");
        brdf.errors["shading_d5"] = liveShadingError(reading.brdf, brdf.lobes[0], common.threads);
    } else {
        measure(command, reading, brdf, common, report);
    }
    report.phase("write");
    writeBrdf(command.output, brdf);
    report.figures["name"] = brdf.name;
    report.figures["lobes"] = brdf.lobes.size();
    report.figures["lobe_error"] = brdf.lobe_error;
    if (brdf.steps) {
        report.figures["steps"] = brdf.steps->values;
        report.figures["step_error"] = brdf.steps->error;
    }
    for (const auto& [name, value] : reading.figures) report.figures[name] = value;
    for (const auto& [name, value] : brdf.errors) report.figures[name] = value;
    warn(reading, brdf);
    if (!common.quiet) describe(brdf);
}

}  // namespace

Verb brdfVerb() {
    return verbOf<BrdfCommand, const BrdfCommand>("brdf", "A material as reflectance slices.", define, run);
}

}  // namespace penumbra
