// penumbra-pack check X.pnb TRUTH.vis.h5: the run-time evaluator against baked truth.
#include <cmath>
#include <cstdio>

#include "formats/asset/mapped_file.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "formats/common/write_file.h"
#include "pack/check/check_asset.h"
#include "pack/check/check_indirect.h"
#include "pack/check/check_transfer.h"
#include "pack/check/error_budget.h"
#include "pack/check/worst_places.h"
#include "pack/named_input.h"
#include "pack/pack_asset.h"
#include "pack/pack_verbs.h"

namespace penumbra {

namespace {

namespace fs = std::filesystem;

constexpr Word<FarQuality> kQualityWords[] = {{"full", FarQuality::kFull}, {"fast", FarQuality::kFast}};

struct CheckCommand {
    fs::path asset, truth, predictions, second_bake, model, bounces, output;
    PlaceSpread spread;
    FarQuality quality = FarQuality::kFull;

    std::vector<fs::path> inputs() const {
        return namedFiles({asset, truth, predictions, second_bake, model, bounces});
    }
};

// A composed model has no truncation and no regression, because its numbers are products and no components span them.
std::string orDash(double figure) {
    char text[32] = "-";
    if (!std::isnan(figure)) std::snprintf(text, sizeof text, "%.4f", figure);
    return text;
}

void printRow(const ErrorFigures& f, bool predictions) {
    std::printf("%-24s %-8s %6zu %9s %10s %10s %8.4f %8.4f %8.4f %8.4f", f.name.substr(0, 24).c_str(),
                f.held_out ? "held out" : "training", f.frames, orDash(f.relative_error).c_str(),
                orDash(f.truncation).c_str(), orDash(f.regression).c_str(), f.rms_v, f.ambient_error, f.ambient_p999,
                f.ambient_max);
    if (predictions) std::printf(" %11.2e", f.prediction_difference);
    std::printf("\n");
}

nlohmann::ordered_json toJson(const ErrorFigures& f, bool predictions) {
    nlohmann::ordered_json json;
    json["name"] = f.name;
    json["held_out"] = f.held_out;
    json["frames"] = f.frames;
    json["relative_error"] = f.relative_error;
    json["truncation_error"] = f.truncation;
    json["regression_error"] = f.regression;
    json["rms_v"] = f.rms_v;
    json["ambient_error"] = f.ambient_error;
    json["ambient_error_p999"] = f.ambient_p999;
    json["ambient_error_max"] = f.ambient_max;
    if (predictions) json["prediction_difference"] = f.prediction_difference;
    return json;
}

// Prints one table with a row for each source of error. Held-out and training frames stand side by side, relative and
// as rms V.
void reportBudget(const CheckResult& result, Report& report) {
    const std::vector<BudgetRow> held_out = errorBudget(result.held_out), training = errorBudget(result.training);
    const auto cell = [](const ErrorFigures& set, const BudgetRow& row) {
        char text[64];
        if (set.frames == 0)
            std::snprintf(text, sizeof text, "%20s", "no frames");
        else if (std::isnan(row.relative))
            std::snprintf(text, sizeof text, "%20s", "not measured");
        else
            std::snprintf(text, sizeof text, "%11.4f %8.4f", row.relative, row.rms_v);
        return std::string(text);
    };
    std::printf("\n%-26s %20s %20s\n%-26s %11s %8s %11s %8s\n", "error budget", "held out", "training", "", "relative",
                "rms V", "relative", "rms V");
    for (std::size_t i = 0; i < held_out.size(); ++i) {
        const bool ask = std::isnan(result.held_out.frames ? held_out[i].relative : training[i].relative) &&
                         !held_out[i].option.empty();
        std::printf("%-26s %s %s%s%s\n", held_out[i].name.c_str(), cell(result.held_out, held_out[i]).c_str(),
                    cell(result.training, training[i]).c_str(), ask ? "   " : "",
                    ask ? held_out[i].option.c_str() : "");
        for (const auto& [set, row] : {std::pair(&result.held_out, &held_out[i]), {&result.training, &training[i]}}) {
            nlohmann::ordered_json& json =
                report.figures["budget"][set == &result.held_out ? "held_out" : "training"][row->name];
            if (set->frames > 0 && !std::isnan(row->relative))
                json = {{"relative", row->relative}, {"rms_v", row->rms_v}};
            else
                json = nullptr;
        }
    }
    if (result.far_vertices > 0) {
        std::printf(
            "by fields and by rays: of %zu vertices in %zu held-out and %zu training frames; rays meet rigid parts\n",
            result.far_vertices, result.held_out.far_frames, result.training.far_frames);
        report.figures["far_sample"] = {{"vertices", result.far_vertices},
                                        {"held_out_frames", result.held_out.far_frames},
                                        {"train_frames", result.training.far_frames}};
    }
    if (result.training.composed) {
        std::printf(
            "squares add up: total + SH truncation = against all bands. These do up to their correlation: local PCA +\n"
            "local regression = local model; unpacked model + rank and quantisation = total. The rows from true local "
            "x\n"
            "far to without residual do not add up to the total. Bake noise is in the truth.\n");
        return;
    }
    std::printf(
        "squares add up: output PCA + regression = unpacked model; total + SH truncation = against all bands;\n"
        "unpacked model + rank and quantisation = total up to their correlation. Bake noise is in the truth.\n");
}

void reportFrames(const CheckResult& result, Report& report) {
    for (const FrameCheck& f : result.frames)
        report.figures["per_frame"].push_back({{"clip", f.clip},
                                               {"time", f.time},
                                               {"held_out", f.held_out},
                                               {"rms_v", f.rms_v},
                                               {"out_of_range", f.out_of_range}});
    const double correlation = rangeCorrelation(result);
    nlohmann::ordered_json& json = report.figures["out_of_range_rank_correlation"];
    if (std::isnan(correlation)) return;  // null: there are no held-out frames, or all are alike
    json = correlation;
    std::printf("out of range against error: rank correlation %.2f over %zu held-out frames\n", correlation,
                result.held_out.frames);
}

void reportCheck(const CheckResult& result, const AssetView& asset, bool predictions, Report& report) {
    std::printf("%-24s %-8s %6s %9s %10s %10s %8s %8s %8s %8s%s\n", "clip", "", "frames", "relative", "truncation",
                "regression", "rms V", "ambient", "99.9%", "largest", predictions ? " predictions" : "");
    for (const ErrorFigures& clip : result.clips) {
        printRow(clip, predictions);
        report.figures["clips"].push_back(toJson(clip, predictions));
    }
    for (const ErrorFigures* all : {&result.training, &result.held_out}) {
        if (all->frames == 0) continue;
        printRow(*all, predictions);
        report.figures[all->held_out ? "held_out" : "training"] = toJson(*all, predictions);
    }
    std::printf("packing, as stored: %.2e of the signal%s\n", double(asset.model.quantization_error),
                asset.model.composition ? "" : " (relative squared = truncation squared + regression squared)");
    report.figures["quantization_error"] = asset.model.quantization_error;
    if (const std::size_t spheres = asset.blockers.spheres.size(); spheres > 0) {
        report.figures["blockers"] = spheres;
        std::printf("%zu sphere blockers for casting; this check does not judge them\n", spheres);
    }
    report.figures["mean_from_truth"] = result.mean_from_truth;
    if (!result.mean_from_truth)
        std::printf("no training clip in the truth: relative numbers are against the model's stored mean\n");
    reportFrames(result, report);
    reportBudget(result, report);
}

// Prints in how many of the places each cause makes the model too dark or too light, and their share of the sum of
// |error|.
void reportCauses(std::span<const WorstPlace> places, Report& report) {
    double all = 0;
    struct Sums {
        std::size_t dark = 0, light = 0;
        double error = 0;
    };
    std::map<PlaceCause, Sums> of_cause;
    for (const WorstPlace& place : places) {
        const double error = std::abs(place.e_model - place.e_truth);
        Sums& sums = of_cause[causeOf(place)];
        ++(place.e_model < place.e_truth ? sums.dark : sums.light);
        sums.error += error;
        all += error;
    }
    std::printf("\n%-20s %8s %9s %8s\n", "worst places", "too dark", "too light", "|error|");
    for (const auto& [cause, sums] : of_cause) {
        const std::string name(wordOf(kPlaceCauseWords, cause));
        std::printf("%-20s %8zu %9zu %7.1f%%\n", name.c_str(), sums.dark, sums.light, 100 * sums.error / all);
        report.figures["worst_places"][name] = {
            {"too_dark", sums.dark}, {"too_light", sums.light}, {"error_sum", sums.error}};
    }
}

void reportIndirect(const IndirectChecks& checks, const AssetView& asset, Report& report) {
    std::printf("\nlight that bounces, as a share of direct light: %13s %10s\n", "no bounces", "error");
    for (const auto& [name, check] : {std::pair("training", &checks.training), {"held out", &checks.held_out}}) {
        if (check->frames == 0) continue;
        std::printf("%-9s %6zu frames %38.4f %10.4f\n", name, check->frames, check->without, check->error);
        report.figures["bounced"][name] = {
            {"frames", check->frames}, {"share_without", check->without}, {"share_of_direct", check->error}};
    }
    std::printf("packing of light that bounces, as stored: %.2e of the signal\n",
                double(asset.model.indirect->packing_error));
    report.figures["bounced"]["packing_error"] = asset.model.indirect->packing_error;
}

// The F32 asset of the model that the checked asset was made of, and its view.
struct UnpackedModel {
    std::vector<std::byte> bytes;
    AssetView asset;
};

UnpackedModel unpackedModel(const fs::path& path, int threads) {
    UnpackedModel result;
    const Model model = readModel(path);
    naming(path, [&] {
        result.bytes = packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", threads).bytes;
        result.asset = openAsset(result.bytes);
    });
    return result;
}

// Holds an asset of transfer against a bake of it, or of visibility.
void runTransferCheck(const CheckCommand& command, const AssetView& asset, const VisibilityReader& truth,
                      const CommonOptions& common, Report& report) {
    if (!command.predictions.empty() || !command.second_bake.empty() || !command.model.empty() ||
        !command.bounces.empty() || !command.output.empty())
        throw UsageError("--predictions, --second-bake, --model, --bounces and --worst cannot be used: " +
                         command.asset.string() + " has linear transfer");
    const std::size_t frames = truth.header().frames.frameCount();
    naming(command.truth, [&] { checkTransferFits(asset, truth.header()); });
    if (common.dry_run) {
        std::printf("%zu frames of %zu vertices\n", frames, asset.mesh.positions.size());
        return;
    }
    report.phase("check");
    Progress progress(common.progress, "checking", "frames", double(std::max<std::size_t>(1, frames)));
    const TransferCheck check =
        checkTransfer(asset, truth, common.threads, [&](std::size_t done) { progress.update(double(done)); });
    std::printf("%-24s %-8s %6s %9s %11s %11s %8s %8s %8s\n", "clip", "", "frames", "relative", "E_transfer",
                "relative E", "ambient", "99.9%", "largest");
    const auto print = [&](const TransferCheckRow& row) {
        std::printf("%-24s %-8s %6zu %9s %11.6f %11.4f %8.4f %8.4f %8.4f\n", row.name.substr(0, 24).c_str(),
                    row.held_out ? "held out" : "training", row.frames, orDash(row.errors.relative_error).c_str(),
                    row.errors.transfer_error, row.errors.relative_transfer_error, row.ambient_error, row.ambient_p999,
                    row.ambient_max);
        nlohmann::ordered_json json{{"name", row.name},
                                    {"held_out", row.held_out},
                                    {"frames", row.frames},
                                    {"relative_error", nullptr},
                                    {"transfer_error", row.errors.transfer_error},
                                    {"relative_transfer_error", row.errors.relative_transfer_error},
                                    {"ambient_error", row.ambient_error},
                                    {"ambient_error_p999", row.ambient_p999},
                                    {"ambient_error_max", row.ambient_max}};
        if (!std::isnan(row.errors.relative_error)) json["relative_error"] = row.errors.relative_error;
        return json;
    };
    for (const TransferCheckRow& row : check.clips) report.figures["clips"].push_back(print(row));
    for (const TransferCheckRow* all : {&check.training, &check.held_out})
        if (all->frames > 0) report.figures[all->held_out ? "held_out" : "training"] = print(*all);
}

void runCheck(const CheckCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    const MappedFile file(command.asset);
    const AssetView asset = openAsset(file.bytes(), command.asset.string());
    const VisibilityReader truth(command.truth);
    std::optional<VisibilityReader> predictions, second_bake;
    std::optional<UnpackedModel> model;
    if (!command.predictions.empty()) predictions.emplace(command.predictions);
    if (!command.second_bake.empty()) second_bake.emplace(command.second_bake);
    if (asset.transfer) return runTransferCheck(command, asset, truth, common, report);
    if (!asset.has_model) throw InvalidInput(command.asset.string() + ": has no model to check");
    if (truth.header().quantity != "hemisphere_visibility")
        throw InvalidInput(command.truth.string() + ": quantity is " + truth.header().quantity +
                           "; truth is hemisphere_visibility");
    if (!asset.model.deforming && asset.animation.clips.empty())
        reportWarning("penumbra-pack",
                      command.asset.string() +
                          ": was packed with --no-playback and has no list of training clips, so that every "
                          "frame counts as held out");
    const auto check = [&](const fs::path& path, const CheckReferences& references) {
        naming(path, [&] { checkFits(asset, truth.header(), references); });
    };
    check(command.truth, {});
    if (predictions) check(command.predictions, {.predictions = &*predictions});
    if (second_bake) check(command.second_bake, {.second_bake = &*second_bake});
    if (!command.model.empty()) {
        model = unpackedModel(command.model, common.threads);
        check(command.model, {.unpacked = &model->asset});
    }
    std::optional<VisibilityReader> bounces;
    if (!command.bounces.empty()) {
        bounces.emplace(command.bounces);
        checkIndirectFits(asset, bounces->header(), command.bounces.string());
    }
    CheckReferences references{predictions ? &*predictions : nullptr, second_bake ? &*second_bake : nullptr,
                               model ? &model->asset : nullptr, command.quality};
    std::optional<WorstPairs> worst;
    if (!command.output.empty()) references.worst = &worst.emplace(asset, truth.header().frames, command.spread);
    const std::size_t frames = truth.header().frames.frameCount();
    if (common.dry_run) {
        std::printf("%zu frames of %zu vertices\n", frames, asset.mesh.positions.size());
        return;
    }
    report.phase("check");
    CheckResult result;
    {
        Progress progress(common.progress, "checking", "frames", double(std::max<std::size_t>(1, frames)));
        result = checkAsset(asset, truth, references, common.threads,
                            [&](std::size_t done) { progress.update(double(done)); });
    }
    reportCheck(result, asset, predictions.has_value(), report);
    if (worst) {
        report.phase("worst places");
        const std::vector<WorstPlace> places =
            describePlaces(asset, truth, references, worst->chosen(), common.threads);
        writeWholeFile(command.output, placesCsv(places));
        reportCauses(places, report);
    }
    if (bounces)
        reportIndirect(checkIndirect(asset, *bounces, command.bounces.string(), common.threads), asset, report);
}

void defineCheck(CLI::App& app, CheckCommand& command) {
    app.add_option("asset", command.asset, "X.pnb with a model")->required();
    app.add_option("truth", command.truth,
                   "TRUTH.vis.h5 of the same mesh; for an asset of transfer it may hold transfer")
        ->required();
    app.add_option("--predictions", command.predictions, "PRED.vis.h5 of penumbra-fit predict");
    app.add_option("--second-bake", command.second_bake,
                   "OTHER.vis.h5: the same frames, or some, baked with another --seed: the bake's noise");
    app.add_option("--model", command.model, "X.model.h5 that the asset was made of, for what packing costs");
    app.add_option("--bounces", command.bounces,
                   "TRANSFER.vis.h5 of penumbra-bake --quantity transfer --bounces N, some of the asset's "
                   "frames: checks the light that bounces");
    CLI::Option* worst =
        app.add_option("--worst", command.output, "write where E is most wrong, and why, a row for each place")
            ->type_name("OUT.csv")
            ->check(endsIn({".csv"}));
    app.add_option("--worst-count", command.spread.count, "places that --worst lists")
        ->check(within<std::size_t>(1, 100000))
        ->needs(worst);
    addChoice(app, "--quality", command.quality, kQualityWords,
              "quality of the far parts of a composed asset: full, or fast as for distant characters");
}

}  // namespace

Verb checkVerb() {
    return verbOf<CheckCommand, const CheckCommand>("check", "Compare the run-time evaluator with baked truth.",
                                                    defineCheck, runCheck);
}

}  // namespace penumbra
