// penumbra-fit compare X.vis.h5 --holdout CLIPS -o REPORT.html: reads a bake, runs the fits of a comparison and writes
// the report.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "fit/papers/compare/compare_output.h"
#include "fit/papers/compare/transfer_picture.h"
#include "fit/papers/papers.h"
#include "fit/report/run_report.h"
#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "formats/common/options.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

struct CompareCommand {
    std::string input, output, bounces;
    std::vector<std::string> models, features, clusters, output_variances, conventions, holdout, fields, lights;
    std::vector<std::string> lobes, components;
    int parts = 0, order = TransferCompareOptions{}.order;
    bool transfer = false;
    std::vector<const CLI::Option*> of_visibility, of_transfer;  // options that only one kind of comparison has

    std::vector<std::filesystem::path> inputs() const {
        std::vector<std::filesystem::path> files{input};
        files.insert(files.end(), fields.begin(), fields.end());
        files.insert(files.end(), lights.begin(), lights.end());
        files.emplace_back(bounces);
        return namedFiles(files);
    }
};

void define(CLI::App& app, CompareCommand& command) {
    app.add_option("visibility_file", command.input, "baked visibility, X.vis.h5")->required();
    app.add_option("-o,--output", command.output, "page to write, NAME.html; NAME.json and NAME.csv go beside it")
        ->required();
    addNameListOption(app, "--holdout", command.holdout, "clips that no fit sees: what the errors are of")->required();
    addNameListOption(app, "--models", command.models,
                      "models to compare [all but zh-lobes, which are Nowrouzezahrai 2008's]");
    addNameListOption(app, "--lobes", command.lobes, "numbers of lobes of zh-lobes, 1..3 [1,2]");
    addNameListOption(app, "--features", command.features,
                      "features to compare [joint-angles, or dihedral-angles without a skeleton, and relative-bones]");
    app.add_option("--parts", command.parts, "near-rigid parts of a mesh without skeleton [as fit visibility chooses]")
        ->check(within(1, 65000));
    addNameListOption(app, "--clusters", command.clusters, "numbers of clusters [8,16,32,64]");
    addNameListOption(app, "--output-variances", command.output_variances,
                      "shares of the visibility's variance to keep [0.8,0.9,0.95,0.99]");
    addNameListOption(app, "--conventions", command.conventions,
                      "conventions, the reference first [A4,D5, at most of the file's order]");
    for (const char* name : {"--models", "--lobes", "--features", "--parts"})
        command.of_visibility.push_back(app.get_option(name));
    app.add_flag("--transfer", command.transfer,
                 "compare the linear models of transfer; a bake of transfer is compared so without it");
    command.of_transfer = {
        app.add_option("--components", command.components,
                       "components of the angles and of the vertices of a reduced model of --transfer; any number of "
                       "them [15,500 and 8,22]")
            ->allow_extra_args(false),
        app.add_option("--order", command.order, "SH bands of --transfer")->check(within(1, 8)),
        app.add_option("--bounces", command.bounces,
                       "bake of transfer with bounces of the same character: compare light that bounces, too [the file "
                       "itself, where it has bounces]")};
    app.add_option(
        "--fields", command.fields,
        "X.fields.h5 of `penumbra-bake fields`, of the character and of occluders: compare a composed model, "
        "too");
    app.add_option("--light", command.lights,
                   "E.light.h5 of `penumbra-fit light`: show it beside its 3 zonal lobes; any number of them")
        ->allow_extra_args(false);
}

template <class Kinds>
auto parseKinds(const char* option, const std::vector<std::string>& words, const Kinds& known) {
    std::vector<typename Kinds::value_type> kinds;
    for (const std::string& word : words) {
        const auto kind = kindNamed(known, word);
        if (!kind)
            throw UsageError(std::string(option) + ": '" + word + "' is not one of " +
                             joined(known, ", ", [](auto one) { return nameOf(one); }));
        if (std::find(kinds.begin(), kinds.end(), *kind) == kinds.end()) kinds.push_back(*kind);
    }
    return words.empty() ? std::vector<typename Kinds::value_type>(known.begin(), known.end()) : kinds;
}

// Returns the numbers in ascending order, each once.
std::vector<double> parseNumbers(const char* option, const std::vector<std::string>& words, double least, double most) {
    std::vector<double> numbers;
    for (const std::string& word : words) {
        char* end = nullptr;
        const double number = std::strtod(word.c_str(), &end);
        if (*end != '\0' || !(number >= least && number <= most))
            throw UsageError(std::string(option) + ": '" + word + "' is not a number from " + shortNumber(least) +
                             " to " + shortNumber(most));
        numbers.push_back(number);
    }
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    return numbers;
}

std::vector<int> parseCounts(const char* option, const std::vector<std::string>& words, double most) {
    std::vector<int> counts;
    for (const double n : parseNumbers(option, words, 1, most)) {
        if (n != int(n)) throw UsageError(std::string(option) + ": " + shortNumber(n) + " is not a whole number");
        counts.push_back(int(n));
    }
    return counts;
}

std::vector<Convention> parseConventions(const std::vector<std::string>& words, int file_order) {
    std::vector<Convention> conventions;
    try {
        for (const std::string& word : words)
            if (std::find(conventions.begin(), conventions.end(), parseConvention(word)) == conventions.end())
                conventions.push_back(parseConvention(word));
    } catch (const std::invalid_argument& error) {
        throw UsageError(std::string("--conventions: ") + error.what());
    }
    if (words.empty())
        conventions = {{BelowHorizon::kOpen, std::min(4, file_order)},
                       {BelowHorizon::kMirrored, std::min(5, file_order)}};
    return conventions;
}

std::vector<int> lobeCounts(const CompareCommand& command, const VisibilityHeader& header) {
    if (!header.skin) throw UsageError("--models zh-lobes: " + command.input + " has no joint angles");
    if (header.order < 2) throw UsageError("--models zh-lobes: " + command.input + " has one band, it takes two");
    const std::vector<int> counts = parseCounts("--lobes", command.lobes, 3);
    return counts.empty() ? std::vector{1, 2} : counts;
}

CompareOptions resolveOptions(const CompareCommand& command, const CommonOptions& common,
                              const VisibilityHeader& header) {
    CompareOptions options;
    if (!header.skin) options.features = {FeatureKind::kDihedrals, FeatureKind::kRelativeBones};
    options.parts = command.parts;
    std::vector<std::string> models = command.models;
    const bool zh_lobes = std::erase(models, kZhLobes) > 0;
    if (zh_lobes && models.empty()) models = {nameOf(ModelKind::kLinear)};
    options.models = parseKinds("--models", models, kModelKinds);
    if (!zh_lobes && !command.lobes.empty()) throw UsageError("--lobes: needs zh-lobes among --models");
    if (zh_lobes) options.lobes = lobeCounts(command, header);
    if (!command.features.empty()) options.features = parseKinds("--features", command.features, kFeatureKinds);
    if (!command.clusters.empty()) options.clusters = parseCounts("--clusters", command.clusters, 1e6);
    if (!command.output_variances.empty())
        options.output_variances = parseNumbers("--output-variances", command.output_variances, 1e-3, 1);
    options.conventions = parseConventions(command.conventions, header.order);
    options.holdout = command.holdout;
    for (const std::string& file : command.fields) options.fields.push_back(readFields(file));
    options.threads = common.threads;
    return options;
}

std::string optionsJson(const CompareOptions& options) {
    nlohmann::ordered_json json;
    for (ModelKind model : options.models) json["models"].push_back(nameOf(model));
    for (FeatureKind features : options.features) json["features"].push_back(nameOf(features));
    json["clusters"] = options.clusters;
    if (options.parts > 0) json["parts"] = options.parts;
    json["output_variances"] = options.output_variances;
    for (const Convention& convention : options.conventions) json["conventions"].push_back(convention.name());
    json["holdout"] = options.holdout;
    if (!options.fields.empty()) json["composed"] = true;
    if (!options.lobes.empty()) json["lobes"] = options.lobes;
    return json.dump();
}

// The report NAME.html and the files NAME.json and NAME.csv beside it.
struct OutputFiles {
    std::filesystem::path html, json, csv;
};

OutputFiles outputFiles(const std::string& output) {
    OutputFiles files{output, output, output};
    if (files.html.extension() != ".html")
        throw UsageError("-o " + output + ": the name of the page must end in .html");
    files.json.replace_extension(".json");
    files.csv.replace_extension(".csv");
    return files;
}

// The common checks know only the page. This holds the files beside it to the same rules.
void checkOutputs(const OutputFiles& files, const CompareCommand& command, const CommonOptions& common) {
    const auto whole = [](const std::filesystem::path& path) {
        return std::filesystem::absolute(path).lexically_normal();
    };
    for (const std::filesystem::path& path : {files.json, files.csv}) {
        for (const std::string& other : {common.report, common.depfile, command.input, command.bounces})
            if (!other.empty() && whole(other) == whole(path))
                throw UsageError(path.string() + ": is written beside the page; " + other + " is the same file");
        if (common.no_clobber && std::filesystem::exists(path))
            throw IoError(path.string() + ": exists, and --no-clobber was given");
        if (!common.dry_run) const PartialFile probe(path);
    }
}

CompareSource sourceOf(const VisibilityHeader& header, std::size_t joints, const CompareCommand& command,
                       const std::string& options) {
    CompareSource source;
    source.file = std::filesystem::path(command.input).filename().string();
    source.vertices = header.mesh.vertexCount();
    source.joints = joints;
    for (const std::string& clip : header.frames.clip_names)
        (isHeldOut(command.holdout, clip) ? source.held_out_clips : source.train_clips).push_back(clip);
    const Split split = splitFrames(header.frames, command.holdout);
    source.train_frames = split.train.size();
    source.held_out_frames = split.held_out.size();
    source.provenance = makeProvenance("penumbra-fit compare", options, command.inputs());
    return source;
}

// Measures everything. The reports of the fits go into `comparison`.
void measure(const CompareInput& input, const std::vector<FitOptions>& grid, const CommonOptions& common,
             Comparison& comparison, Report& report) {
    const double steps = double(grid.size()) + 3;
    Progress progress = progressOf(common, "compare", "steps", steps);
    report.phase("eigenvalues");
    const CompareOptions& options = comparison.options;
    const CompareCharacter character = prepareCharacter(input, options);
    comparison.inputs = inputDecays(input, character);
    comparison.outputs = outputDecays(input, character, options, [&](double share) { progress.update(share); });
    if (!options.lobes.empty()) {
        report.phase("lobes");
        comparison.lobes = compareLobes(input, character, options, [&](double share) { progress.update(1 + share); });
    }
    report.phase("joint");
    comparison.sweep = findJointSweep(input, character, options);
    report.phase("feature vectors");
    comparison.vectors = fitFeatureVectors(input, character, options, comparison.sweep ? &*comparison.sweep : nullptr,
                                           [&](double share) { progress.update(2 + share); });
    report.phase("tables of normals");
    comparison.normals =
        measureNormalTables(input, character, paperConvention(options, comparison.file_order), options.threads);
    for (const FitOptions& fit : grid) {
        report.phase("fit: " + describe(fit));
        const JointSweep* sweep = comparison.sweep && sameFit(fit, referenceFit(options, fit.model, fit.features))
                                      ? &*comparison.sweep
                                      : nullptr;
        const double done = double(comparison.fits.size()) + 3;
        progress.update(done);
        comparison.fits.push_back(runFit(input, fit, sweep, [&](double share) { progress.update(done + share); }));
    }
}

void printTable(const Table& table) {
    constexpr int kNarrowest = 12;  // characters: errors without prior may be in the thousands
    const auto print = [&](const std::vector<std::string>& row) {
        for (std::size_t c = 0; c < row.size(); ++c)
            std::printf("%*s", c ? std::max(int(table.columns[c].size()), kNarrowest) + 2 : -28, row[c].c_str());
        std::printf("\n");
    };
    print(table.columns);
    for (const auto& row : table.rows) print(row);
}

// Puts what the summary and each figure show into the report, and prints it.
void tellFindings(const Table& summary, const std::string& finding, const std::vector<Figure>& figures,
                  const CommonOptions& common, Report& report) {
    report.figures["findings"]["summary"] = finding;
    for (const Figure& figure : figures) report.figures["findings"][figure.id] = figure.finding;
    if (common.quiet) return;
    printTable(summary);
    std::printf("%s\n", finding.c_str());
    for (const Figure& figure : figures) std::printf("%s: %s\n", figure.title.c_str(), figure.finding.c_str());
}

TransferCompareOptions transferOptions(const CompareCommand& command, const CommonOptions& common,
                                       const VisibilityHeader& header) {
    TransferCompareOptions options;
    options.order = command.order;
    options.holdout = command.holdout;
    options.threads = common.threads;
    if (!command.components.empty()) options.components.clear();
    for (const std::string& text : command.components) options.components.push_back(parseComponents(text));
    const bool transfer = header.quantity == kDiffuseTransfer;
    if (transfer && !command.fields.empty())
        throw UsageError("--fields: " + command.input + " has transfer; a composed model learns visibility");
    if (!transfer) options.visibility = resolveOptions(command, common, header);
    return options;
}

std::string optionsJson(const TransferCompareOptions& options) {
    nlohmann::ordered_json json;
    json["transfer"] = true;
    json["order"] = options.order;
    for (const auto& [k, m] : options.components) json["components"].push_back({k, m});
    json["holdout"] = options.holdout;
    if (!options.visibility.fields.empty()) json["composed"] = true;
    return json.dump();
}

void printPlan(const TransferCompareOptions& options, const OutputFiles& files, const std::string& picture,
               const BouncesBake* bounces, const std::string& bounces_picture) {
    std::printf("would fit L and %zu reduced models, with and without prior; would write %s, %s, %s and %s\n",
                options.components.size(), files.html.c_str(), files.json.c_str(), files.csv.c_str(), picture.c_str());
    if (bounces)
        std::printf("would fit light that bounces of %s; would write %s\n", bounces->file.c_str(),
                    bounces_picture.c_str());
}

void runTransfer(const CompareCommand& command, const OutputFiles& files, const VisibilityReader& reader,
                 const CommonOptions& common, Report& report) {
    for (const CLI::Option* option : command.of_visibility)
        if (option->count() > 0) throw UsageError(option->get_name() + " cannot be used in a comparison of transfer");
    const VisibilityHeader& header = reader.header();
    const TransferCompareOptions options = transferOptions(command, common, header);
    std::optional<VisibilityReader> other;
    if (!command.bounces.empty()) other.emplace(command.bounces);
    std::optional<BouncesBake> bounces;
    if (other) bounces = {&*other, command.bounces};
    if (!other && header.hasBounces()) bounces = {&reader, command.input};
    checkTransferComparison(header, command.input, options, bounces ? &*bounces : nullptr);
    const std::filesystem::path picture = std::filesystem::path(files.html).replace_extension(".png"),
                                bounces_picture = std::filesystem::path(files.html).replace_extension(".bounces.png");
    if (common.dry_run)
        return printPlan(options, files, picture.string(), bounces ? &*bounces : nullptr, bounces_picture.string());
    for (const std::filesystem::path& path : {picture, bounces_picture})
        if (common.no_clobber && std::filesystem::exists(path))
            throw IoError(path.string() + ": exists, and --no-clobber was given");
    const TransferComparison comparison =
        compareTransferModels(reader, command.input, options, bounces ? &*bounces : nullptr,
                              [&](const std::string& phase) { report.phase(phase); });
    report.phase("write");
    const CompareSource source = sourceOf(header, header.skin->jointCount(), command, optionsJson(options));
    const std::vector<Figure> figures = transferFigures(comparison);
    writePng(picture, transferPicture(comparison, header.mesh), 1);
    if (bounces) writePng(bounces_picture, bouncesPicture(comparison, header.mesh), 1);
    writeWholeFile(files.json, transferJson(comparison, figures, source));
    writeWholeFile(files.csv, transferCsv(comparison));
    writeWholeFile(files.html, transferPage(comparison, figures, source, picture.filename().string(),
                                            bounces_picture.filename().string()));
    for (const TransferRun& run : comparison.runs)
        report.figures["held_out_transfer_error"][run.name + (run.regularised ? "" : " without prior")] =
            run.held_out.transfer_error;
    if (comparison.bounces)
        for (const BouncedRun& run : comparison.bounces->runs)
            report.figures["held_out_bounces_error"][run.name] = run.held_out;
    tellFindings(transferSummary(comparison), transferFinding(comparison), figures, common, report);
}

void run(const CompareCommand& command, const CommonOptions& common, Report& report) {
    const OutputFiles files = outputFiles(command.output);
    checkOutputs(files, command, common);
    const VisibilityReader reader(command.input);
    if (command.transfer || reader.header().quantity == kDiffuseTransfer)
        return runTransfer(command, files, reader, common, report);
    for (const CLI::Option* option : command.of_transfer)
        if (option->count() > 0) throw UsageError(option->get_name() + " needs --transfer");
    const int file_order = reader.header().order;
    Comparison comparison{resolveOptions(command, common, reader.header()), file_order, {}, {}, {}, {}, {}};
    const std::vector<FitOptions> grid = makeGrid(comparison.options, file_order);
    for (const FitOptions& fit : grid) checkFit(reader.header(), command.input, fit);
    for (const std::string& file : command.lights) comparison.lights.push_back(makeLightPair(readLight(file)));
    if (common.dry_run) {
        for (const FitOptions& fit : grid) std::printf("would fit %s\n", describe(fit).c_str());
        std::printf("would fit linear, quadratic and cubic feature vectors, with and without a prior\n");
        std::printf("%zu fits; would write %s, %s and %s\n", grid.size(), files.html.c_str(), files.json.c_str(),
                    files.csv.c_str());
        return;
    }
    report.phase("poses");
    // All fits share one table of poses. It has the angles when any fit reads them.
    PoseRequest request = poseRequest(reader.header(), grid.front());
    for (const FitOptions& fit : grid)
        if (fit.features == FeatureKind::kDihedrals) request.angle_variance = inputVariance(fit);
    const PoseTable poses = readPoses(reader, request);
    measure({reader, poses, command.input}, grid, common, comparison, report);
    report.phase("write");
    const CompareSource source = sourceOf(reader.header(), poses.joints, command, optionsJson(comparison.options));
    const std::vector<Figure> figures = compareFigures(comparison);
    // The page comes last: when it is new, all three files are.
    writeWholeFile(files.json, compareJson(comparison, figures, source));
    writeWholeFile(files.csv, compareCsv(comparison));
    writeWholeFile(files.html, comparePage(comparison, figures, source));
    const Table table = summaryTable(comparison);  // rows for every model at the reference
    report.figures["fits"] = comparison.fits.size();
    for (const auto& row : table.rows)
        for (std::size_t c = 1; c < row.size(); ++c) report.figures["reference"][row[0]][table.columns[c]] = row[c];
    tellFindings(table, modelsFinding(comparison), figures, common, report);
}

}  // namespace

Verb compareVerb() {
    return verbOf<CompareCommand, const CompareCommand>(
        "compare", "Train a grid of models and write a report: the papers' figures on your own data.", define, run);
}

}  // namespace penumbra
