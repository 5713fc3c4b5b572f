// penumbra-fit blockers X.model.h5 -o X.blockers.h5: spheres that cast in the place of a character.
#include <cstdio>
#include <memory>

#include "fit/blockers/fit_blockers.h"
#include "fit/fit_verbs.h"
#include "formats/common/options.h"

namespace penumbra {

namespace {

struct BlockersCommand {
    std::filesystem::path model, output;
    BlockerOptions options;

    std::vector<std::filesystem::path> inputs() const { return {model}; }
};

void define(CLI::App& app, BlockersCommand& command) {
    app.add_option("model", command.model, "fitted model, X.model.h5: its mesh, skin and frames matter")->required();
    app.add_option("-o,--output", command.output, "X.blockers.h5")->required();
    app.add_option("--spheres", command.options.spheres, "number of spheres; more than 20 gain little")
        ->check(within(1, int(kMaxBlockers)));
    addChoice(app, "--method", command.options.method, kBlockerMethodWords,
              "area: points spread over the surface, silhouettes as large as the mesh's; paper: spheres that hold the "
              "vertices, as in the papers (much too dark)");
    app.add_flag("--refine", command.options.refine,
                 "then change each radius until the silhouettes of the training poses differ least");
    addSeed(app, command.options.seed, "seed of the points and of the starts of the groups");
}

BlockerFile fileOf(const BlockersCommand& command, const Model& model, const BlockerFit& fit) {
    BlockerFile file;
    setCharacter(model.mesh, model.skin, file);
    file.blockers = fit.blockers;
    file.method = nameOf(command.options.method);
    file.scale = fit.scale;
    file.mesh_area = fit.mesh_area;
    file.area = fit.area;
    nlohmann::ordered_json options;
    options["spheres"] = command.options.spheres;
    options["method"] = file.method;
    options["seed"] = command.options.seed;
    if (command.options.refine) options["refine"] = true;
    file.provenance = makeProvenance("penumbra-fit blockers", options.dump(), command.inputs());
    return file;
}

void reportFit(const BlockersCommand& command, const BlockerFit& fit, bool quiet, Report& report) {
    report.figures["spheres"] = fit.blockers.spheres.size();
    report.figures["method"] = nameOf(command.options.method);
    report.figures["scale"] = fit.scale;
    report.figures["mesh_area"] = fit.mesh_area;
    report.figures["area"] = fit.area;
    report.figures["silhouette_error"] = fit.silhouette_error;
    report.figures["rigid_share"] = fit.rigid_share;
    report.figures["poses"] = fit.poses;
    report.figures["views"] = fit.views;
    if (fit.refinement)
        report.figures["refine"] = {
            {"before", fit.refinement->before}, {"after", fit.refinement->after}, {"steps", fit.refinement->steps}};
    report.figures["feet"] = nlohmann::ordered_json::array();
    for (const FootBlockers& foot : fit.feet)
        report.figures["feet"].push_back({{"joint", foot.joint}, {"spheres", foot.spheres}});
    if (quiet) return;
    std::printf("%s: %zu spheres, radii scaled by %.3f\n", command.output.c_str(), fit.blockers.spheres.size(),
                fit.scale);
    std::printf(
        "  silhouettes in %zu poses, %zu views: mesh %.4f m^2, spheres %.4f m^2; single ones differ by %.1f%%\n",
        fit.poses, fit.views, fit.mesh_area, fit.area, 100 * fit.silhouette_error);
    if (fit.refinement)
        std::printf("  refined in %d steps: bands of silhouettes differ by %.2f%%, and by %.2f%% before\n",
                    fit.refinement->steps, 100 * fit.refinement->after, 100 * fit.refinement->before);
    std::printf("  %.1f%% of the surface moves with the bone of its sphere\n", 100 * fit.rigid_share);
    for (const FootBlockers& foot : fit.feet) std::printf("  foot %s: %d spheres\n", foot.joint.c_str(), foot.spheres);
}

void run(BlockersCommand& command, const CommonOptions& common, Report& report) {
    if (command.options.refine && command.options.method == BlockerMethod::kPaper)
        throw UsageError("--refine does not go with --method paper, whose spheres hold their vertices");
    report.phase("read");
    const Model model = readModel(command.model);
    if (common.dry_run) {
        std::printf("would fit %d spheres to %zu vertices and write %s\n", command.options.spheres,
                    model.mesh.vertexCount(), command.output.c_str());
        return;
    }
    report.phase("fit");
    BlockerFit fit;
    try {
        fit = fitBlockers(model, command.options, common.threads);
    } catch (const InvalidInput& error) {
        throw InvalidInput(command.model.string() + ": " + error.what());
    }
    reportFit(command, fit, common.quiet, report);
    report.phase("write");
    writeBlockers(command.output, fileOf(command, model, fit));
}

}  // namespace

Verb blockersVerb() {
    return verbOf<BlockersCommand>("blockers", "Spheres that move with the bones of a character and cast in its place.",
                                   define, run);
}

}  // namespace penumbra
