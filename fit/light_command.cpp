// penumbra-fit light (ENV.(exr|hdr) | --analytic SPEC) -o E.light.h5: fits a light as SH and as zonal lobes.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>

#include "fit/fit_verbs.h"
#include "fit/light/fit_light.h"
#include "fit/light/light_lobes.h"
#include "fit/light/light_window.h"
#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "formats/common/name_option.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "formats/image/factor_light.h"
#include "formats/image/light_picture_flags.h"
#include "formats/image/picture_light.h"
#include "sh/angles.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

struct LightCommand {
    std::vector<std::filesystem::path> pictures;  // one, or six that are the faces of a cube
    PictureOptions reading;
    std::filesystem::path output;
    std::string name;                // empty: the name of the file or of the analytic lights
    std::vector<std::string> words;  // arguments of --analytic
    std::vector<AnalyticLight> analytic;
    std::string window_text = "auto";
    WindowChoice window;
    LobeFit lobe_fit = LobeFit::kJoint;
    int order = 4, lobes = 3;
    bool factor = false;
    LightFactorChoice factor_choice;
    CLI::Option *lobes_option = nullptr, *window_option = nullptr;

    std::vector<std::filesystem::path> inputs() const {
        return pictures.size() == 1 ? filesOfPicture(pictures.front(), reading) : pictures;
    }
};

constexpr Word<FactorMode> kFactorWords[] = {{"hand-over", FactorMode::kHandOver}, {"paper", FactorMode::kPaper}};

// Reads "128x64", or "0".
int readPictureWidth(const std::string& text) {
    if (text == "0") return 0;
    const std::optional<PictureSize> size = parseSize(text);
    if (!size || size->width != 2 * size->height || size->width < 2 || size->width > kMaxLightPicture)
        throw std::invalid_argument("must be WxH with W = 2 H, from 2x1 to 4096x2048, or 0; not '" + text + "'");
    return size->width;
}

void define(CLI::App& app, LightCommand& command) {
    CLI::Option* picture = app.add_option("environment", command.pictures,
                                          "environment, OpenEXR or Radiance HDR; six files are the faces of a cube");
    app.add_option(
           "--analytic", command.words,
           "light without a picture, as in sky:elevation=20+sun:direction=0/1/1,irradiance=3; joined by + or given "
           "again; NAME[:key=value,...], NAME one of " +
               joined(analyticLightNames()))
        ->allow_extra_args(false)
        ->excludes(picture);
    app.add_option("-o,--output", command.output, "E.light.h5")->required();
    addNameOption(app, command.name);
    app.add_option("--order", command.order, "SH bands")->check(within(1, kMaxOrder));
    const auto window = [&command](const std::string& text) { return parseWindow(command.window_text = text); };
    command.window_option = addParsed(
        app, "--window", command.window, window,
        "window against negative radiance beside bright sources, at the price of accuracy: none; always, the least "
        "that leaves -1% of the mean; auto, the same but only where one pixel or a sharp spot of few outshines its "
        "picture; or LAMBDA of 1 / (1 + LAMBDA l^2 (l+1)^2)");
    command.window_option->default_str("auto");
    command.lobes_option =
        app.add_option("--lobes", command.lobes, "zonal lobes, 0 for none")->check(within(0, kMaxFittedLobes));
    addChoice(app, "--lobe-fit", command.lobe_fit, kLobeFitWords,
              "one lobe after the other; directions refined together; 2 ORDER - 1 fixed directions, exact");
    CLI::Option* factor =
        app.add_flag("--factor", command.factor,
                     "also find the suns of the light, for shadows with edges; the SH stay the whole light");
    LightFactorChoice& choice = command.factor_choice;
    app.add_option("--suns", choice.suns,
                   "suns at most; 1 is for skies, 2 or more find lamps and windows in the picture, as many as their "
                   "shadows are worth")
        ->check(within(1, kMaxSuns))
        ->needs(factor);
    addChoice(app, "--factor-mode", choice.mode, kFactorWords,
              "suns that fade where the light has no dominant direction; or one sun as Nowrouzezahrai 2011 prints it")
        ->needs(factor);
    addParsed(app, "--picture", choice.picture_width, readPictureWidth,
              "size WxH, W = 2 H, of a picture of the light without its suns; 0 for none")
        ->default_str("128x64")
        ->needs(factor);
    addLightPictureOptions(app, command.reading);
    app.footer(describeAnalyticLights() + "\n" + app.get_footer());
}

void checkOptions(LightCommand& command) {
    if (command.pictures.empty() && command.words.empty())
        throw UsageError("a light is a picture or --analytic: give one of them");
    if (command.pictures.size() > 1 && command.pictures.size() != 6)
        throw UsageError("a light is one picture, or six that are the faces of a cube; " +
                         std::to_string(command.pictures.size()) + " are given");
    if (command.pictures.empty()) refuseReading(command.reading, "--analytic");
    for (const std::string& word : command.words)
        if (std::error_code error; std::filesystem::is_regular_file(word, error))
            throw UsageError("--analytic: " + word + " is a file: a picture is given without an option");
    if (command.lobe_fit == LobeFit::kFixed && command.lobes_option->count() > 0 &&
        command.lobes != fixedLobeCount(command.order))
        throw UsageError("--lobes: --lobe-fit fixed has " + std::to_string(fixedLobeCount(command.order)) +
                         " lobes at order " + std::to_string(command.order) + ", not " + std::to_string(command.lobes));
    if (command.factor_choice.mode == FactorMode::kPaper && command.factor_choice.suns > 1)
        throw UsageError("--suns: --factor-mode paper finds one sun");
    try {
        if (command.pictures.empty()) command.analytic = parseLights(joined(command.words, "+"));
    } catch (const std::invalid_argument& error) {
        throw UsageError(std::string("--analytic: ") + error.what());
    }
}

// Moves what was found into the file.
FactorReport takeSuns(LightSuns found, LightFile& light) {
    light.suns = std::move(found.suns);
    light.factor = std::move(found.factor);
    light.picture = std::move(found.picture);
    return std::move(found.report);
}

// The options of reading that were given belong to the light's origin.
void addReading(const PictureOptions& reading, nlohmann::ordered_json& options) {
    if (!reading.layer.empty()) options["layer"] = reading.layer;
    if (!reading.colorspace.empty()) options["colorspace"] = reading.colorspace;
    if (reading.fill) options["fill"] = {reading.fill->x, reading.fill->y, reading.fill->z};
    if (reading.repair) options["repair"] = true;
}

void describeReading(const std::filesystem::path& picture, const PictureNotes& notes, const CommonOptions& common) {
    const std::string name = oneLine(picture.filename().string());
    for (const std::string& warning : notes.warnings) reportWarning("penumbra-fit", name + ": " + warning);
    if (common.quiet || common.dry_run) return;
    for (const std::string& line : notes.lines) std::printf("%s: %s\n", name.c_str(), line.c_str());
}

LightFile fitPicture(const LightCommand& command, const CommonOptions& common, Report& report,
                     nlohmann::ordered_json& options, HotPixel& hot, FactorReport& suns) {
    report.phase("read");
    const std::string name = command.pictures.front().string();
    const PictureLight picture = readPictureLight(
        command.pictures, command.reading, {command.order, command.factor ? command.factor_choice.suns : 1, {}, {}});
    const EnvironmentMap& map = picture.map;
    options["layout"] = nameOf(map.layout);
    addReading(command.reading, options);
    report.figures["layout"] = nameOf(map.layout);
    report.figures["negative_pixels"] = map.negative_pixels;
    report.figures["negative_share"] = map.negative_share;
    report.figures["repaired_pixels"] = map.notes.repaired_pixels;
    report.figures["repaired_share"] = map.notes.repaired_share;
    describeReading(command.pictures.front(), map.notes, common);
    report.phase("fit");
    hot = findHotPixel(map);
    hot.x *= picture.shape.width / map.image.width;
    hot.y *= picture.shape.height / map.image.height;
    LightFile light = fitLight(picture.project(command.order, common.threads), name, command.order);
    if (command.factor) {
        const bool several = command.factor_choice.suns > 1;  // they are found in the picture and not in its SH
        const std::vector<double> sh =
            several ? std::vector<double>() : picture.project(kFactorOrder, common.threads).sh;
        suns = takeSuns(factorLight(map, sh, command.factor_choice), light);
    }
    if (map.negative_share > 1e-5 && !common.quiet && !common.dry_run)
        std::printf("%s: %zu pixels below 0 made 0, %.2g%% of the light, taken from the bright ones beside them\n",
                    light.name.c_str(), map.negative_pixels, 100 * map.negative_share);
    return light;
}

// Above this residual the report explains it in words. When half of the light's energy is left out, it is 0.71.
constexpr double kMuchResidual = 0.7;

void describe(const LightFile& light, Report& report, bool quiet) {
    report.figures["order"] = light.order;
    report.figures["residual"] = light.residual;
    // The mean radiance is SH_0 / sqrt(4pi) = SH_0 y_0.
    const double y0 = 0.28209479177387814;
    report.figures["mean_radiance"] = {light.sh[0] * y0, light.sh[1] * y0, light.sh[2] * y0};
    if (std::all_of(light.sh.begin(), light.sh.end(), [](double value) { return value == 0; }))
        reportWarning("penumbra-fit", light.name + " is black: nothing that it lights will be seen");
    if (quiet) return;
    std::printf("%s: order %d, residual %.4f of the light, mean radiance %.4g %.4g %.4g\n", light.name.c_str(),
                light.order, light.residual, light.sh[0] * y0, light.sh[1] * y0, light.sh[2] * y0);
    if (light.residual > kMuchResidual)
        std::printf(
            "%s: the residual is detail finer than SH of order %d hold, normal for lights with a sun or lamps\n",
            light.name.c_str(), light.order);
}

void describeSuns(const LightFile& light, const FactorReport& found, Report& report, bool quiet) {
    nlohmann::ordered_json& suns = report.figures["suns"] = nlohmann::ordered_json::array();
    if (light.suns.empty() && !quiet)
        std::printf("%s: no sun: no small part of the sky dominates this light\n", light.name.c_str());
    for (std::size_t i = 0; i < light.suns.size(); ++i) {
        const SunD& sun = light.suns[i];
        const FactorReport::SunReport& how = found.suns[i];
        suns.push_back({{"direction", {sun.direction.x, sun.direction.y, sun.direction.z}},
                        {"irradiance", {sun.irradiance.x, sun.irradiance.y, sun.irradiance.z}},
                        {"radius_degrees", degrees(sun.radius)},
                        {"dominance", how.dominance},
                        {"share", how.share},
                        {"flat_pixels", how.flat_pixels}});
        if (quiet) continue;
        std::printf("%s: sun %zu from %.4f %.4f %.4f, irradiance %.4g %.4g %.4g, radius %.2f degrees, %s, share %.2f\n",
                    light.name.c_str(), i + 1, sun.direction.x, sun.direction.y, sun.direction.z, sun.irradiance.x,
                    sun.irradiance.y, sun.irradiance.z, degrees(sun.radius), light.factor.c_str(), how.share);
        if (how.flat_pixels >= kClippedPixels)
            std::printf(
                "%s: %zu pixels of sun %zu share the largest value, as in clipped pictures: the sun may be "
                "brighter and smaller than this\n",
                light.name.c_str(), how.flat_pixels, i + 1);
    }
    report.figures["picture"] = {
        {"width", light.picture.width}, {"height", light.picture.height}, {"clamped", found.clamped}};
    if (light.picture.width > 0 && !quiet)
        std::printf("%s: a picture of %d x %d without the suns\n", light.name.c_str(), light.picture.width,
                    light.picture.height);
    if (found.clamped > 0)
        reportWarning("penumbra-fit", light.name + ": some of the picture is too bright for half floats and is cut");
}

// Ringing below -1 times the mean is visible.
constexpr double kWorstRinging = 1;

// Suns are shaded apart from the SH, so their ringing is seen only where they are switched off.
bool ringsVisibly(const LightFile& light, double least) { return least < -kWorstRinging && light.suns.empty(); }

void warnOfRinging(const LightFile& light, double least) {
    if (!ringsVisibly(light, least)) return;
    char far[32];
    std::snprintf(far, sizeof far, "%.1f%%", 100 * least);
    reportWarning("penumbra-fit", light.name + " rings down to " + far +
                                      " of the mean: shading can be black or negative away from its brightest source; "
                                      "--window always takes that away, at the price of contrast");
}

void describeWindow(const WindowReport& window, const HotPixel& hot, const LightFile& light) {
    const char* name = light.name.c_str();
    if (hot.share > 0)
        std::printf("%s: pixel (%d, %d) %s %.1f%% of the light\n", name, hot.x, hot.y,
                    hot.alone ? "alone has" : "and the spot around it have", 100 * hot.share);
    if (window.any())
        std::printf(
            "%s: a window (%.3f of band 1) raises the least radiance from %.2f%% to %.2f%% of the mean and changes "
            "irradiance by %.1f%%; --window none keeps the projection\n",
            name, window.weights[1], 100 * window.least_before, 100 * window.least_after,
            100 * window.irradiance_change);
    else if (ringsVisibly(light, window.least_after))
        return;  // warnOfRinging() has said so
    else if (window.least_after < -kMaxRinging && !light.suns.empty())
        std::printf("%s: no window; with its suns as SH (--suns off) it rings down to %.1f%% of the mean\n", name,
                    100 * window.least_after);
    else if (window.least_after < -kMaxRinging)
        std::printf("%s: no window; rings down to %.1f%% of the mean, --window always would take that away\n", name,
                    100 * window.least_after);
    else
        std::printf("%s: no window needed, least radiance %.1f%% of the mean\n", name, 100 * window.least_after);
}

void addWindow(const WindowChoice& choice, const HotPixel& hot, LightFile& light, Report& report, bool quiet) {
    const WindowReport window = windowFit(choice, hot, light);
    report.figures["window"] = {{"weights", window.weights},
                                {"least_radiance_before", window.least_before},
                                {"least_radiance_after", window.least_after},
                                {"irradiance_change", window.irradiance_change},
                                {"hot_pixel_share", hot.share}};
    warnOfRinging(light, window.least_after);
    if (!quiet) describeWindow(window, hot, light);
}

void addLobes(const LightCommand& command, LightFile& light, Report& report, bool quiet) {
    if (command.lobes == 0 && command.lobe_fit != LobeFit::kFixed) return;
    report.phase("lobes");
    const auto start = std::chrono::steady_clock::now();
    light.lobes = fitLobes(light.order, light.sh, command.lobes, command.lobe_fit);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
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

void run(LightCommand& command, const CommonOptions& common, Report& report) {
    checkOptions(command);
    nlohmann::ordered_json options;
    LightFile light;
    HotPixel hot;
    FactorReport suns;
    if (command.pictures.empty()) {
        report.phase("fit");
        options["analytic"] = toString(command.analytic);
        light = fitLight(command.analytic, joined(command.words, "+"), command.order);
        if (command.factor) suns = takeSuns(factorLight(command.analytic, command.factor_choice), light);
    } else {
        light = fitPicture(command, common, report, options, hot, suns);
    }
    light.name = command.name.empty() ? oneLine(light.name) : command.name;
    if (common.dry_run) {
        std::printf("would fit order %d to %s and write %s\n", command.order, light.name.c_str(),
                    command.output.c_str());
        return;
    }
    if (command.order == 1 && command.window_option->count() > 0)
        reportWarning("penumbra-fit",
                      "--window does nothing at order 1: a light that is the same from everywhere does not ring");
    if (!command.name.empty()) options["name"] = command.name;
    options["order"] = command.order;
    options["window"] = command.window_text;
    options["lobes"] = command.lobe_fit == LobeFit::kFixed ? fixedLobeCount(command.order) : command.lobes;
    options["lobe_fit"] = wordOf(kLobeFitWords, command.lobe_fit);
    if (command.factor) {
        options["factor"] = wordOf(kFactorWords, command.factor_choice.mode);
        options["suns"] = command.factor_choice.suns;
        options["picture_width"] = command.factor_choice.picture_width;
    }
    describe(light, report, common.quiet);
    if (command.factor) describeSuns(light, suns, report, common.quiet);
    addWindow(command.window, hot, light, report, common.quiet);
    addLobes(command, light, report, common.quiet);
    report.phase("write");
    light.provenance = makeProvenance("penumbra-fit light", options.dump(), command.inputs());
    writeLight(command.output, light);
}

}  // namespace

Verb lightVerb() {
    return verbOf<LightCommand>("light", "A light, pictured or analytic, as SH and as zonal lobes.", define, run);
}

}  // namespace penumbra
