// penumbra-fit visibility X.vis.h5 -o X.model.h5: reads a bake, fits a model and writes it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "fit/fit_verbs.h"
#include "fit/papers/papers.h"
#include "fit/report/run_report.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "formats/common/pass_rig_options.h"
#include "formats/common/warning.h"
#include "formats/stage/pose_file.h"
#include "sh/angles.h"

namespace penumbra {

namespace {

// Default of --model: composed if --fields are given, otherwise additive.
constexpr const char* kAuto = "auto";
// The word for a model whose local part has one of kModelKinds, and whose far part are fields.
constexpr const char* kComposed = "composed";

constexpr Word<NearUse> kNearUses[] = {{kAuto, NearUse::kAuto}, {"off", NearUse::kOff}, {"on", NearUse::kOn}};

struct VisibilityCommand {
    std::string input, output, train_frames;
    std::vector<std::string> fields;
    std::string model = kAuto;
    ModelKind local_model = FitOptions{}.model;
    FitOptions options;
    const CLI::App* app = nullptr;
    int lobes = 0;

    std::vector<std::filesystem::path> inputs() const {
        std::vector<std::filesystem::path> files{input, train_frames};
        files.insert(files.end(), fields.begin(), fields.end());
        return namedFiles(files);
    }
};

// The model that is meant.
std::string modelOf(const VisibilityCommand& command) {
    if (command.model != kAuto) return command.model;
    return command.fields.empty() ? nameOf(FitOptions{}.model) : kComposed;
}

// Adds an option that takes a number, or auto, which is 0.
template <class T>
void addOrAuto(CLI::App& app, const std::string& option, T& value, const CLI::Validator& number,
               const std::string& help) {
    const auto problem = [number](const std::string& text) { return text == kAuto ? "" : number(text); };
    const auto parse = [](const std::string& text) {
        return text == kAuto ? T(0) : T(std::strtod(text.c_str(), nullptr));
    };
    addParsed(app, option, value, parse, help)->check(CLI::Validator(problem, ""))->default_str(kAuto);
}

void define(CLI::App& app, VisibilityCommand& command) {
    FitOptions& options = command.options;
    command.app = &app;
    app.add_option("visibility_file", command.input, "baked visibility, X.vis.h5")->required();
    app.add_option("-o,--output", command.output, "model to write, X.model.h5, or X.lobes.h5 of zh-lobes")->required();
    app.add_option("--model", command.model,
                   "how the numbers are predicted; auto: composed with --fields, else additive; zh-lobes: the "
                   "reference model of zonal lobes, for `predict` alone")
        ->check(CLI::IsMember([] {
            std::vector<std::string> names;
            for (const ModelKind kind : kModelKinds) names.emplace_back(nameOf(kind));
            names.emplace_back(kComposed);
            names.emplace_back(kZhLobes);
            names.emplace_back(kAuto);
            return names;
        }()));
    addLobesOption(app, command.lobes);
    app.add_option("--fields", command.fields,
                   "X.fields.h5 of `penumbra-bake fields`, for --model composed: of the character and of occluders");
    addKind(app, "--local-model", command.local_model, kModelKinds,
            "how a composed model predicts what nearby parts hide, and what the composition leaves");
    addChoice(app, "--near", options.near, kNearUses,
              "whether a composed model takes near parts as geometry, too, with gains; auto: where cross-validation "
              "over training clips prefers that");
    app.add_option(
           "--compared-vertices", options.compared_vertices,
           "vertices at which the report holds the fields of a composed model against rays; 0: none, in less time")
        ->check(within(0, 1000000));
    addKind(app, "--features", options.features, kFeatureKinds,
            "what the numbers are predicted from; zh-lobes read only joint-angles");
    addOrAuto(app, "--clusters", options.clusters, within(1, 1000000), "number of clusters, or auto");
    addOrAuto(app, "--parts", options.parts, within(1, 65000),
              "near-rigid parts of a mesh without skeleton, its bones for relative-bones; a number or auto");
    addOrAuto(app, "--input-variance", options.input_variance, aShare(),
              "share of the features' variance to keep, (0, 1], not used by additive models; auto: 0.9 for angles, "
              "0.99 for relative-bones, 0.95 for neural models of them");
    app.add_option("--output-variance", options.output_variance, "share of the visibility's variance to keep, (0, 1]")
        ->check(aShare());
    addNameListOption(app, "--holdout", options.holdout, "clips that no step of the fit sees, for the errors");
    app.add_option("--train-frames", command.train_frames,
                   "X.poses.h5 of `penumbra-bake poses`: train on these frames alone");
    addParsed(app, "--convention", options.convention, parseConvention,
              "A, B or D and the order: A4, D5, ...; zh-lobes have B4")
        ->default_str(options.convention.name());
}

// Returns the options that all models of visibility share. CLI11 has checked the names.
FitOptions sharedOptions(const VisibilityCommand& command, const CommonOptions& common) {
    FitOptions options = command.options;
    if (!command.train_frames.empty()) options.train_frames = readPoseFile(command.train_frames).frames;
    options.threads = common.threads;
    return options;
}

FitOptions resolveOptions(const VisibilityCommand& command, FitOptions options) {
    const std::string model = modelOf(command);
    const bool composed = model == kComposed;
    if (composed == command.fields.empty())
        throw UsageError(composed ? "--model composed needs --fields X.fields.h5 (penumbra-bake fields)"
                                  : "--fields: only --model composed reads them");
    if (command.app->count("--lobes") > 0) throw UsageError("--lobes: only --model zh-lobes has them");
    if (!composed && command.app->count("--local-model") > 0)
        throw UsageError("--local-model: only --model composed has one");
    if (!composed && command.app->count("--near") > 0) throw UsageError("--near: only --model composed has near parts");
    if (!composed && command.app->count("--compared-vertices") > 0)
        throw UsageError("--compared-vertices: only --model composed has fields");
    options.model = composed ? command.local_model : kindNamed(kModelKinds, model).value();
    for (const std::string& file : command.fields) options.fields.push_back(readFields(file));
    return options;
}

std::string optionsJson(const VisibilityCommand& command, const FitOptions& options, const Provenance& bake) {
    nlohmann::ordered_json json;
    json["model"] = modelOf(command);
    if (!options.fields.empty()) {
        json["local_model"] = nameOf(command.local_model);
        json["near"] = wordOf(kNearUses, options.near);
    }
    json["features"] = nameOf(options.features);
    json["clusters"] = options.clusters > 0 ? std::to_string(options.clusters) : kAuto;
    if (options.parts > 0) json["parts"] = options.parts;
    json["input_variance"] = inputVariance(options);
    json["output_variance"] = options.output_variance;
    json["holdout"] = options.holdout;
    json["convention"] = options.convention.name();
    passRigOptions(bake.options_json, json);
    return json.dump();
}

// The name of an own part of a composed model: that of its joint.
std::string partName(const Model& model, std::size_t part) {
    return model.skin.joint_names[model.composition->fields.parts[part].joint];
}

// Warns of each part whose field is far from what rays say.
void warnOfFields(const FitResult& result) {
    if (!result.report.composed || !result.report.composed->far) return;
    const std::vector<double>& rms = result.report.composed->far->part_rms;
    for (std::size_t p = 0; p < rms.size(); ++p)
        if (rms[p] > kMaxFieldRms) reportWarning("penumbra-fit", fieldWarning(partName(result.model, p), rms[p]));
}

nlohmann::ordered_json clusterFigures(const Model& model) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const ClusterModel& cluster : model.clusters)
        list.push_back({{"joint", model.skin.joint_names[std::size_t(cluster.joint)]},
                        {"vertices", cluster.vertices.size()},
                        {"inputs", cluster.inputs()},
                        {"components", cluster.components()},
                        {"ridge", cluster.ridge},
                        {"train_relative_error", std::sqrt(cluster.train_error)},
                        {"held_out_relative_error", std::sqrt(cluster.holdout_error)}});
    return list;
}

// The true local visibility times the far parts by their fields and by rays, and how far each field is from rays.
nlohmann::ordered_json farFigures(const FitResult& result) {
    const FarError& far = *result.report.composed->far;
    nlohmann::ordered_json json{
        {"vertices", far.vertices}, {"train_frames", far.train_frames}, {"held_out_frames", far.held_out_frames}};
    const auto add = [&](const char* way, const char* frames, const ErrorFigures& figures) {
        json[way][frames] = {{"relative_error", figures.relative_error}, {"rms_v", figures.rms_v}};
    };
    add("by_fields", "train", far.fields_train);
    add("by_rays", "train", far.rays_train);
    if (far.held_out_frames) {
        add("by_fields", "held_out", far.fields_held_out);
        add("by_rays", "held_out", far.rays_held_out);
    }
    for (std::size_t p = 0; p < far.part_rms.size(); ++p)
        json["parts"].push_back({{"part", partName(result.model, p)}, {"rms_v", far.part_rms[p]}});
    return json;
}

// The rows of a composed model: its local part, the product, and the limit of the split.
nlohmann::ordered_json composedFigures(const FitResult& result) {
    const FitReport& fit = result.report;
    const ComposedReport& composed = *fit.composed;
    nlohmann::ordered_json json;
    const auto add = [&](const char* name, const ErrorFigures& train, const ErrorFigures& held_out) {
        json[name]["train"] = toJson(train);
        if (fit.held_out_frames) json[name]["held_out"] = toJson(held_out);
    };
    add("local", composed.local_train, composed.local_held_out);
    add("without_residual", composed.without_train, composed.without_held_out);
    add("true_local", composed.split_train, composed.split_held_out);
    if (composed.far) json["far_sample"] = farFigures(result);
    json["near_parts"] = composed.near_kept;
    if (composed.near) {
        json["near_cross_validated_relative_error"] = {{"local_alone", composed.near->local_alone},
                                                       {"with_near_parts", composed.near->with_near},
                                                       {"hidden_learned", composed.near->hidden_learned},
                                                       {"hidden_opened", composed.near->hidden_opened}};
    }
    json["residual_cross_validated_relative_error"] = composed.residual_cross_validated;
    json["residual"] = composed.residual_kept;
    json["residual_mean"] = composed.mean_kept;
    return json;
}

ClipTable tableOf(const FitResult& result) {
    const FitReport& fit = result.report;
    return {result.model.frames, result.model.clip_errors, fit.train_frames, fit.held_out_frames, fit.train,
            fit.held_out};
}

void fillReport(const FitResult& result, Report& report) {
    const FitReport& fit = result.report;
    auto& figures = report.figures;
    figures["vertices"] = result.model.mesh.vertexCount();
    figures["clusters"] = result.model.clusters.size();
    addToReport(tableOf(result), figures);
    figures["cross_validated_relative_error"] = fit.cross_validated_error;
    figures["leave_one_out_relative_error"] = fit.leave_one_out_error;
    figures["output_pca_relative_error"] = fit.output_floor;
    figures["largest_tangent_angle_degrees"] = degrees(fit.largest_tangent_angle);
    if (fit.composed) figures["composed"] = composedFigures(result);
    figures["cluster_list"] = clusterFigures(result.model);
}

void printComposed(const FitReport& fit) {
    const ComposedReport& composed = *fit.composed;
    const auto row = [&](const char* name, const ErrorFigures& train, const ErrorFigures& held_out) {
        std::printf("%-44s %8.4f", name, train.relative_error);
        if (fit.held_out_frames) std::printf(" %10.4f", held_out.relative_error);
        std::printf("\n");
    };
    std::printf("%-44s %8s%s\n", "relative error of the composed model's parts", "train",
                fit.held_out_frames ? "   held out" : "");
    row("local model, of the local visibility", composed.local_train, composed.local_held_out);
    row("local x far parts", composed.without_train, composed.without_held_out);
    row("true local x far parts", composed.split_train, composed.split_held_out);
    if (const auto& far = composed.far) {
        std::printf("of a sample of %zu vertices in %zu + %zu frames:\n", far->vertices, far->train_frames,
                    far->held_out_frames);
        row("  true local x far parts by fields", far->fields_train, far->fields_held_out);
        row("  true local x far parts by rays", far->rays_train, far->rays_held_out);
    }
    std::printf("near parts: %s", composed.near_kept ? "kept" : "none");
    if (composed.near)
        std::printf(
            "; blocked cross-validation leaves %.4f with them, %.4f without; hidden vertices learned %.4f, opened %.4f",
            composed.near->with_near, composed.near->local_alone, composed.near->hidden_learned,
            composed.near->hidden_opened);
    std::printf("\n");
    std::printf("residual model: %s; it leaves %.4f of the residual in blocked cross-validation\n",
                composed.residual_kept ? "kept"
                : composed.mean_kept   ? "dropped but for its mean"
                                       : "dropped",
                composed.residual_cross_validated);
}

void printTable(const FitResult& result) {
    const Model& model = result.model;
    const FitReport& fit = result.report;
    std::size_t components = 0, inputs = 0;
    for (const ClusterModel& cluster : model.clusters) {
        components += std::size_t(cluster.components());
        inputs += std::size_t(cluster.inputs());
    }
    std::printf("%zu clusters, %.1f inputs and %.1f components each\n", model.clusters.size(),
                double(inputs) / double(model.clusters.size()), double(components) / double(model.clusters.size()));
    print(tableOf(result));
    std::printf("relative error, training frames: %.4f blocked cross-validation, %.4f output PCA\n",
                fit.cross_validated_error, fit.output_floor);
    if (fit.composed) printComposed(fit);
    if (std::isfinite(fit.leave_one_out_error))
        std::printf("leave-one-out, optimistic on neighbouring frames: %.4f\n", fit.leave_one_out_error);
}

void run(const VisibilityCommand& command, const CommonOptions& common, Report& report) {
    const FitOptions shared = sharedOptions(command, common);
    if (command.model == kZhLobes)
        return runLobes({command.app, command.input, command.output, command.inputs(), command.lobes}, shared, common,
                        report);
    FitOptions options = resolveOptions(command, shared);
    const VisibilityReader reader(command.input);
    if (command.app->count("--features") == 0) options.features = defaultFeatures(reader.header());
    checkFit(reader.header(), command.input, options);
    if (common.dry_run) return printFitPlan(reader.header(), command.output);
    Progress progress = progressOf(common, "fit");
    FitResult result = fitVisibility(reader, command.input, options, observerOf(report, progress));
    report.phase("write");
    result.model.provenance = makeProvenance(
        "penumbra-fit visibility", optionsJson(command, options, reader.header().provenance), command.inputs());
    writeModel(command.output, result.model);
    fillReport(result, report);
    warnOfFields(result);
    if (!common.quiet) printTable(result);
}

}  // namespace

Verb visibilityVerb() {
    return verbOf<VisibilityCommand, const VisibilityCommand>(
        "visibility", "Fit a model of baked visibility as a function of the pose.", define, run);
}

}  // namespace penumbra
