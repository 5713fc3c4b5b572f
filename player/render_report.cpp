#include "player/render_report.h"

#include <cmath>
#include <cstdio>
#include <string>

namespace penumbra {

void reportExposure(const RenderOptions& options, float exposure, const CommonOptions& common, Report& report) {
    report.figures["exposure"] = exposure;
    if (!options.exposure && !common.quiet) std::printf("automatic exposure: --exposure %.4g\n", double(exposure));
}

namespace {

void reportPictures(const BatchPlan& plan, const BatchResult& result, const CommonOptions& common, Report& report) {
    if (result.gl.empty()) return;
    const RenderOptions& options = plan.options;
    const char* path = result.path == EvaluationPath::kCpu ? "cpu" : "glsl";
    report.figures["width"] = options.width;
    report.figures["height"] = options.height;
    report.figures["gl"] = result.gl;
    report.figures["path"] = path;
    if (options.channel == Channel::kShaded) {
        report.figures["reflectance"] = nameOf(options.shading.reflectance);
        report.figures["light_form"] = nameOf(options.shading.light_form);
    }
    if (plan.exposes()) reportExposure(options, result.exposure, common, report);
    if (common.verbosity > 0) std::printf("%s; path %s\n", result.gl.c_str(), path);
}

// Says what the colours of a picture of `channel` stand for. "" where another channel is drawn.
std::string colorsOf(const RenderOptions& options, Channel channel) {
    char text[48] = "";
    if (options.channel == channel) std::snprintf(text, sizeof text, "; colours: 0 to %g", double(options.error_max));
    return text;
}

}  // namespace

void reportFrame(const BatchPlan& plan, const BatchResult& result, const CommonOptions& common, Report& report) {
    reportPictures(plan, result, common, report);
    const FrameRecord& record = result.frames.front();
    report.figures["out_of_range"] = record.out_of_range;
    if (!common.quiet)
        std::printf(
            "out of range by %.4f: how far the pose has what hides the sky from where training frames had it, "
            "about radians\n",
            record.out_of_range);
    if (!record.errors) return;
    report.figures["ambient_error_mean"] = record.errors->ambientMean();
    report.figures["ambient_error_max"] = record.errors->ambient_max;
    if (!common.quiet)
        std::printf("ambient error |E(model) - E(truth)| over all vertices: mean %.5f, max %.5f%s\n",
                    record.errors->ambientMean(), record.errors->ambient_max,
                    colorsOf(plan.options, Channel::kError).c_str());
    const double transfer = record.errors->transferMean();
    if (!std::isfinite(transfer)) return;
    report.figures["transfer_error"] = transfer;
    if (!common.quiet && plan.options.channel == Channel::kTransferError)
        std::printf("E_transfer over all vertices: mean %.6f%s\n", transfer,
                    colorsOf(plan.options, Channel::kTransferError).c_str());
}

// --- Many frames ----------------------------------------------------------------------------------------------------

namespace {

template <class Measured>
void putFigures(const Measured& measured, nlohmann::ordered_json& json) {
    for (const auto& [word, figure] : kFigureWords) {
        const double value = figureOf(measured, figure);
        if (std::isfinite(value)) json[std::string(keyOf(figure))] = value;
    }
}

nlohmann::ordered_json frameJson(const FrameRecord& record, const AnimationView& animation) {
    const ClipView& clip = animation.clips[record.at.clip];
    nlohmann::ordered_json json = {{"clip", clip.name},
                                   {"frame", record.at.number},
                                   {"time", animation.times[record.at.frame]},
                                   {"held_out", clip.held_out},
                                   {"truth", record.errors.has_value()}};
    putFigures(record, json);
    if (!record.file.empty()) json["file"] = record.file.string();
    return json;
}

// A row of the table, for the frames of one clip or of several.
struct Row {
    std::string name;
    bool held_out = false;
    RunFigures run;
};

nlohmann::ordered_json rowJson(const Row& row) {
    nlohmann::ordered_json json = {{"name", row.name},
                                   {"held_out", row.held_out},
                                   {"frames", row.run.frames},
                                   {"frames_with_truth", row.run.with_truth}};
    putFigures(row.run, json);
    return json;
}

void printRow(const Row& row) {
    std::printf("%-24s %-8s %6zu %6zu", row.name.substr(0, 24).c_str(), row.held_out ? "held out" : "training",
                row.run.frames, row.run.with_truth);
    constexpr std::array<int, std::size(kFigureWords)> kDigits = {4, 4, 4, 4, 4, 2, 4, 4, 4};  // by Figure
    for (const auto& [word, figure] : kFigureWords) {
        const double value = figureOf(row.run, figure);
        if (std::isfinite(value))
            std::printf(" %9.*f", kDigits[std::size_t(figure)], value);
        else
            std::printf(" %9s", "-");
    }
    std::printf("\n");
}

std::vector<Row> rowsOf(const BatchPlan& plan, const BatchResult& result) {
    const AnimationView& animation = plan.look.asset->animation;
    std::vector<Row> rows;
    for (const std::size_t c : plan.chosen.clips)
        rows.push_back({std::string(animation.clips[c].name), animation.clips[c].held_out, {}});
    Row sets[2] = {{"all training", false, {}}, {"all held out", true, {}}};
    for (const FrameRecord& record : result.frames) {
        for (std::size_t i = 0; i < plan.chosen.clips.size(); ++i)
            if (plan.chosen.clips[i] == record.at.clip) rows[i].run.add(record);
        sets[animation.clips[record.at.clip].held_out].run.add(record);
    }
    std::erase_if(rows, [](const Row& row) { return row.run.frames == 0; });
    for (const Row& set : sets)
        if (set.run.frames > 0) rows.push_back(set);
    return rows;
}

void reportRows(const std::vector<Row>& rows, const CommonOptions& common, Report& report) {
    if (!common.quiet)
        std::printf("%-24s %-8s %6s %6s %9s %9s %9s %9s %9s %9s %9s %9s %9s\n", "clip", "", "frames", "truth", "E mean",
                    "E 99.9%", "E max", "rms V", "relative", "rmse/255", "FLIP", "out of r.", "E_transf.");
    for (const Row& row : rows) {
        if (!common.quiet) printRow(row);
        const bool set = row.name == "all training" || row.name == "all held out";
        nlohmann::ordered_json& json = report.figures[set ? "sets" : "clips"];
        json.push_back(rowJson(row));
    }
}

}  // namespace

void reportBatch(const BatchPlan& plan, const BatchResult& result, const CommonOptions& common, Report& report) {
    reportPictures(plan, result, common, report);
    RunFigures all;
    report.figures["frames"] = nlohmann::ordered_json::array();
    for (const FrameRecord& record : result.frames) {
        all.add(record);
        report.figures["frames"].push_back(frameJson(record, plan.look.asset->animation));
    }
    reportRows(rowsOf(plan, result), common, report);
    report.figures["all"] = rowJson({"all", false, all});
    report.figures["all"].erase("held_out");
    if (plan.look.truth) {
        report.figures["mean_from_truth"] = result.mean_from_truth;
        report.figures["frames_without_truth"] = all.frames - all.with_truth;
        if (all.with_truth < all.frames && !common.quiet)
            std::printf("%zu of %zu frames have no truth\n", all.frames - all.with_truth, all.frames);
    }
}

}  // namespace penumbra
