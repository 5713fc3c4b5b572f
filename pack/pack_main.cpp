// penumbra-pack: models, materials and lights to the run-time asset, and the asset against baked truth.
#include <cmath>
#include <cstdio>

#include "formats/command_line.h"
#include "formats/errors.h"
#include "formats/name_list_option.h"
#include "formats/program_version.h"
#include "formats/write_file.h"
#include "pack/check_asset.h"
#include "pack/error_budget.h"
#include "pack/material_section.h"
#include "pack/pack_asset.h"
#include "pack/pack_truth.h"

namespace penumbra {

namespace fs = std::filesystem;

static AssetPrecision parsePrecision(const std::string& word) {
    return word == "f32" ? AssetPrecision::kF32 : word == "f16" ? AssetPrecision::kF16 : AssetPrecision::kI8;
}

// Runs `work`, whose complaints about its input do not say which file that is.
template <class Error = InvalidInput, class Work>
static auto naming(const fs::path& path, Work work) {
    try {
        return work();
    } catch (const Error& error) {
        throw Error(path.string() + ": " + error.what());
    }
}

// --- asset ----------------------------------------------------------------------------------------------------------

struct AssetCommand {
    fs::path model, output;
    std::vector<fs::path> brdfs, lights;
    std::string precision;
    std::optional<double> max_error, max_bytes_per_vertex;
    std::vector<std::string> slots;
    bool no_playback = false;

    std::vector<fs::path> inputs() const {
        std::vector<fs::path> all;
        if (!model.empty()) all.push_back(model);
        all.insert(all.end(), brdfs.begin(), brdfs.end());
        all.insert(all.end(), lights.begin(), lights.end());
        return all;
    }
};

static std::string provenanceOf(const AssetCommand& command) {
    nlohmann::ordered_json options;
    options["precision"] = command.precision.empty() ? "auto" : command.precision;
    if (command.max_error) options["max_error"] = *command.max_error;
    if (command.max_bytes_per_vertex) options["max_bytes_per_vertex"] = *command.max_bytes_per_vertex;
    if (!command.slots.empty()) options["slots"] = command.slots;
    if (command.no_playback) options["playback"] = false;
    return toJson(makeProvenance("penumbra-pack asset", options.dump(), command.inputs()));
}

// Bytes of every section, and what counts at run time: bytes a vertex of the visibility model alone and of everything.
static void reportSizes(const Packed& packed, bool quiet, Report& report) {
    const AssetView asset = openAsset(packed.bytes);
    const double vertices = double(asset.mesh.positions.size());
    const double model = double(modelBytes(asset, packed.bytes.size()));
    for (const SizeOf& size : sectionSizes(asset, packed.bytes.size())) {
        report.figures["bytes"][size.section] = size.bytes;
        if (!quiet)
            std::printf("  %-17s %10zu bytes  %8.1f a vertex\n", size.section.c_str(), size.bytes,
                        double(size.bytes) / vertices);
    }
    if (const PlaybackView& playback = asset.animation.playback; !playback.positions.empty()) {
        report.figures["playback_error"] = playback.error;
        if (!quiet)
            std::printf("  playback: %zu frames, every position within %.2e m of where it was\n",
                        asset.animation.frameCount(), double(playback.error));
    }
    const double all = double(packed.bytes.size());
    report.figures["bytes"]["file"] = packed.bytes.size();
    report.figures["model_bytes_per_vertex"] = model / vertices;
    report.figures["file_bytes_per_vertex"] = all / vertices;
    if (!quiet)
        std::printf("  %-17s %10.0f bytes  %8.1f a vertex\n  %-17s %10.0f bytes  %8.1f a vertex\n", "model alone",
                    model, model / vertices, "file", all, all / vertices);
}

static BrdfFile readMaterial(const fs::path& path) {
    BrdfFile brdf = readBrdf(path);
    naming<Unsupported>(path, [&] { checkMaterial(brdf); });
    return brdf;
}

// Two files of one name cannot be in an asset. `verb` of penumbra-fit makes such files.
template <class File>
static void checkNames(const std::vector<File>& files, const std::vector<fs::path>& paths, const std::string& verb) {
    for (std::size_t i = 0; i < files.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (files[i].name == files[j].name)
                throw InvalidInput(paths[j].string() + " and " + paths[i].string() + " are both \"" + files[i].name +
                                   "\": penumbra-fit " + verb + " --name gives one another name");
}

static void runAsset(const AssetCommand& command, const CommonOptions& common, Report& report) {
    PackOptions options;
    if (!command.precision.empty()) options.precision = parsePrecision(command.precision);
    options.max_error = command.max_error;
    options.max_bytes_per_vertex = command.max_bytes_per_vertex;
    if (options.max_error && !(*options.max_error > 0))
        throw UsageError("--max-error must be above 0, not " + std::to_string(*options.max_error));
    if (options.max_bytes_per_vertex && !(*options.max_bytes_per_vertex > 0))
        throw UsageError("--max-bytes-per-vertex must be above 0, not " +
                         std::to_string(*options.max_bytes_per_vertex));
    for (const std::string& text : command.slots) options.slots.push_back(parseSlotChoice(text));
    options.playback = !command.no_playback;
    report.phase("read");
    std::optional<Model> model;
    if (!command.model.empty()) model = readModel(command.model);
    if (command.no_playback && !(model && model->deforming))
        throw UsageError("--no-playback needs a model of a deforming mesh");
    std::vector<BrdfFile> brdfs;
    std::vector<LightFile> lights;
    for (const fs::path& path : command.brdfs) brdfs.push_back(readMaterial(path));
    for (const fs::path& path : command.lights) lights.push_back(readLight(path));
    checkNames(brdfs, command.brdfs, "brdf");
    checkNames(lights, command.lights, "light");
    if (!model) {
        if (!command.slots.empty() || !command.precision.empty() || options.max_error || options.max_bytes_per_vertex)
            throw UsageError("--slot, --precision, --max-error and --max-bytes-per-vertex need a model");
        const std::vector<std::byte> library = packLibrary(brdfs, lights, provenanceOf(command));
        if (!common.quiet)
            std::printf("%s: %zu materials, %zu lights\n", command.output.c_str(), brdfs.size(), lights.size());
        if (!common.dry_run) writeWholeFile(command.output, library);
        return;
    }
    report.phase("quantise");
    const Packed packed = naming(command.model, [&] {
        return packAsset(*model, brdfs, lights, options, provenanceOf(command), common.threads);
    });
    report.figures["precision"] = nameOf(packed.precision);
    report.figures["quantization_error"] = packed.quantization_error;
    report.figures["dropped_error"] = packed.dropped_error;
    report.figures["components"] = packed.components;
    report.figures["model_components"] = packed.all_components;
    if (!common.quiet)
        std::printf(
            "%s: precision %s, %zu of %zu components; error of packing %.2e of the signal, %.2e of it by "
            "dropping (training frames)\n",
            command.output.c_str(), nameOf(packed.precision), packed.components, packed.all_components,
            packed.quantization_error, packed.dropped_error);
    reportSizes(packed, common.quiet, report);
    report.phase("write");
    if (!common.dry_run) writeWholeFile(command.output, packed.bytes);
}

static Verb assetVerb() {
    const auto command = std::make_shared<AssetCommand>();
    return {"asset",
            "Pack a model with materials and lights into a run-time asset.",
            [command](CLI::App& app) {
                app.add_option(
                    "model", command->model,
                    "X.model.h5; without it the file holds materials and lights for penumbra-player view to add");
                app.add_option("--brdf", command->brdfs, "M.brdf.h5; any number of them")->allow_extra_args(false);
                app.add_option("--light", command->lights, "E.light.h5; any number of them")->allow_extra_args(false);
                app.add_option("--slot", command->slots,
                               "SLOT=MATERIAL: the material of a part of the mesh (penumbra-bake info lists the "
                               "slots); any number of them, the other parts have the first --brdf")
                    ->allow_extra_args(false);
                app.add_option("-o,--output", command->output, "X.pnb")->required();
                app.add_option("--precision", command->precision,
                               "of the visibility basis (i8 unless --max-error); alone it keeps every component")
                    ->check(CLI::IsMember({"f32", "f16", "i8"}));
                app.add_option("--max-error", command->max_error,
                               "bound on the error of packing (rounded and dropped components), relative to the "
                               "signal: takes the fewest components and the coarsest precision within it");
                app.add_option("--max-bytes-per-vertex", command->max_bytes_per_vertex,
                               "bound on the visibility model: drops the components that add least to predictions");
                app.add_flag("--no-playback", command->no_playback,
                             "leave out the frames of a deforming mesh: for engines that move it themselves");
            },
            [command] { return command->inputs(); },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { runAsset(*command, common, report); }};
}

// --- truth ----------------------------------------------------------------------------------------------------------

struct TruthCommand {
    fs::path input, output;
    std::string precision = "f16";
    TruthOptions options;
};

static void runTruth(TruthCommand& command, const CommonOptions& common, Report& report) {
    command.options.precision = parsePrecision(command.precision);
    report.phase("read");
    const VisibilityReader reader(command.input);
    const TruthPlan plan = naming(command.input, [&] { return planTruth(reader, command.options); });
    report.figures["frames"] = plan.frames.size();
    report.figures["moment_bytes"] = plan.bytes;
    if (!common.quiet)
        std::printf("%s: %zu frames, %zu vertices, %.1f MB\n", command.output.c_str(), plan.frames.size(),
                    reader.header().mesh.vertexCount(), double(plan.bytes) * 1e-6);
    if (common.dry_run) return;
    report.phase("pack and write");
    nlohmann::ordered_json options;
    options["precision"] = command.precision;
    options["clips"] = command.options.clips;
    const std::string provenance = toJson(makeProvenance("penumbra-pack truth", options.dump(), {command.input}));
    Progress progress(parseProgressStyle(common.quiet ? "none" : common.progress), "packing truth", "frames",
                      double(std::max<std::size_t>(1, plan.frames.size())));
    naming(command.input, [&] {
        packTruth(reader, plan, command.options, provenance, command.output,
                  [&](std::size_t done) { progress.update(double(done)); });
    });
}

static Verb truthVerb() {
    const auto command = std::make_shared<TruthCommand>();
    return {
        "truth",
        "Pack baked frames as they are, for the player to show beside a model.",
        [command](CLI::App& app) {
            app.add_option("visibility", command->input, "X.vis.h5")->required();
            app.add_option("-o,--output", command->output, "X.truth.pnb")->required();
            app.add_option("--precision", command->precision, "of the moments")->check(CLI::IsMember({"f32", "f16"}));
            addNameListOption(app, "--clips", command->options.clips, "names of the clips to pack (default: all)");
        },
        [command] { return std::vector<fs::path>{command->input}; },
        [command] { return command->output; },
        [command](const CommonOptions& common, Report& report) { runTruth(*command, common, report); }};
}

// --- check ----------------------------------------------------------------------------------------------------------

struct CheckCommand {
    fs::path asset, truth, predictions, second_bake, model;
};

static void printRow(const ErrorFigures& f, bool predictions) {
    std::printf("%-24s %-8s %6zu %9.4f %10.4f %10.4f %8.4f %8.4f", f.name.substr(0, 24).c_str(),
                f.held_out ? "held out" : "training", f.frames, f.relative_error, f.truncation, f.regression, f.rms_v,
                f.ambient_error);
    if (predictions) std::printf(" %11.2e", f.prediction_difference);
    std::printf("\n");
}

static nlohmann::ordered_json toJson(const ErrorFigures& f, bool predictions) {
    nlohmann::ordered_json json;
    json["name"] = f.name;
    json["held_out"] = f.held_out;
    json["frames"] = f.frames;
    json["relative_error"] = f.relative_error;
    json["truncation_error"] = f.truncation;
    json["regression_error"] = f.regression;
    json["rms_v"] = f.rms_v;
    json["ambient_error"] = f.ambient_error;
    if (predictions) json["prediction_difference"] = f.prediction_difference;
    return json;
}

// One table: a row a source of error, held-out and training frames side by side, relative and as rms V.
static void reportBudget(const CheckResult& result, Report& report) {
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
    std::printf("\n%-22s %20s %20s\n%-22s %11s %8s %11s %8s\n", "error budget", "held out", "training", "", "relative",
                "rms V", "relative", "rms V");
    for (std::size_t i = 0; i < held_out.size(); ++i) {
        const bool ask = std::isnan(result.held_out.frames ? held_out[i].relative : training[i].relative) &&
                         !held_out[i].option.empty();
        std::printf("%-22s %s %s%s%s\n", held_out[i].name.c_str(), cell(result.held_out, held_out[i]).c_str(),
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
    std::printf(
        "squares add up: output PCA + regression = unpacked model; total + SH truncation = against all bands;\n"
        "unpacked model + rank and quantisation = total up to their correlation. Bake noise is in the truth.\n");
}

static void reportFrames(const CheckResult& result, Report& report) {
    for (const FrameCheck& f : result.frames)
        report.figures["per_frame"].push_back({{"clip", f.clip},
                                               {"time", f.time},
                                               {"held_out", f.held_out},
                                               {"rms_v", f.rms_v},
                                               {"out_of_range", f.out_of_range}});
    const double correlation = rangeCorrelation(result);
    nlohmann::ordered_json& json = report.figures["out_of_range_rank_correlation"];
    if (std::isnan(correlation)) return;  // null: no held-out frames, or all alike
    json = correlation;
    std::printf("out of range against error: rank correlation %.2f over %zu held-out frames\n", correlation,
                result.held_out.frames);
}

static void reportCheck(const CheckResult& result, const AssetView& asset, bool predictions, Report& report) {
    std::printf("%-24s %-8s %6s %9s %10s %10s %8s %8s%s\n", "clip", "", "frames", "relative", "truncation",
                "regression", "rms V", "ambient", predictions ? " predictions" : "");
    for (const ErrorFigures& clip : result.clips) {
        printRow(clip, predictions);
        report.figures["clips"].push_back(toJson(clip, predictions));
    }
    for (const ErrorFigures* all : {&result.training, &result.held_out}) {
        if (all->frames == 0) continue;
        printRow(*all, predictions);
        report.figures[all->held_out ? "held_out" : "training"] = toJson(*all, predictions);
    }
    std::printf("packing, as stored: %.2e of the signal (relative squared = truncation squared + regression squared)\n",
                double(asset.model.quantization_error));
    report.figures["quantization_error"] = asset.model.quantization_error;
    report.figures["mean_from_truth"] = result.mean_from_truth;
    if (!result.mean_from_truth)
        std::printf("no training clip in the truth: relative numbers are against the model's stored mean\n");
    reportFrames(result, report);
    reportBudget(result, report);
}

// The F32 asset of the model that the checked asset was made of, and its view.
struct UnpackedModel {
    std::vector<std::byte> bytes;
    AssetView asset;
};

static UnpackedModel unpackedModel(const fs::path& path, int threads) {
    UnpackedModel result;
    const Model model = readModel(path);
    naming(path, [&] {
        result.bytes = packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", threads).bytes;
        result.asset = openAsset(result.bytes);
    });
    return result;
}

static void runCheck(const CheckCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    const MappedFile file(command.asset);
    const AssetView asset = openAsset(file.bytes(), command.asset.string());
    const VisibilityReader truth(command.truth);
    std::optional<VisibilityReader> predictions, second_bake;
    std::optional<UnpackedModel> model;
    if (!command.predictions.empty()) predictions.emplace(command.predictions);
    if (!command.second_bake.empty()) second_bake.emplace(command.second_bake);
    if (!asset.has_model) throw InvalidInput(command.asset.string() + ": has no model to check");
    if (truth.header().quantity != "hemisphere_visibility")
        throw InvalidInput(command.truth.string() + ": quantity is " + truth.header().quantity +
                           "; truth is hemisphere_visibility");
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
    const CheckReferences references{predictions ? &*predictions : nullptr, second_bake ? &*second_bake : nullptr,
                                     model ? &model->asset : nullptr};
    const std::size_t frames = truth.header().frames.frameCount();
    if (common.dry_run) {
        std::printf("%zu frames of %zu vertices\n", frames, asset.mesh.positions.size());
        return;
    }
    report.phase("check");
    CheckResult result;
    {
        Progress progress(parseProgressStyle(common.quiet ? "none" : common.progress), "checking", "frames",
                          double(std::max<std::size_t>(1, frames)));
        result = checkAsset(asset, truth, references, common.threads,
                            [&](std::size_t done) { progress.update(double(done)); });
    }
    reportCheck(result, asset, predictions.has_value(), report);
}

static Verb checkVerb() {
    const auto command = std::make_shared<CheckCommand>();
    return {"check",
            "Hold the run-time evaluator against baked truth.",
            [command](CLI::App& app) {
                app.add_option("asset", command->asset, "X.pnb with a model")->required();
                app.add_option("truth", command->truth, "TRUTH.vis.h5 of the same mesh")->required();
                app.add_option("--predictions", command->predictions, "PRED.vis.h5 of penumbra-fit predict");
                app.add_option("--second-bake", command->second_bake,
                               "OTHER.vis.h5: the same frames, or some, baked with another --seed: the bake's noise");
                app.add_option("--model", command->model,
                               "X.model.h5 that the asset was made of, for what packing costs");
            },
            [command] {
                std::vector<fs::path> inputs{command->asset, command->truth};
                for (const fs::path& path : {command->predictions, command->second_bake, command->model})
                    if (!path.empty()) inputs.push_back(path);
                return inputs;
            },
            nullptr,
            [command](const CommonOptions& common, Report& report) { runCheck(*command, common, report); }};
}

}  // namespace penumbra

int main(int argc, char** argv) {
    using namespace penumbra;
    setSourceHash(kSourceHash);
    return runProgram(
        "penumbra-pack", "The run-time asset: packed, and held against truth.",
        "penumbra.asset 2..4, penumbra.visibility 1, penumbra.model 2..3, penumbra.brdf 1, penumbra.light 1",
        {assetVerb(), truthVerb(), checkVerb()}, argc, argv);
}
