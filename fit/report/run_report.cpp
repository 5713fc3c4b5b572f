#include "fit/report/run_report.h"

#include <algorithm>
#include <cstdio>

namespace penumbra {

Progress progressOf(const CommonOptions& common, const char* what, const char* unit, double total) {
    return {common.progress, what, unit, total};
}

FitObserver observerOf(Report& report, Progress& progress) {
    return {[&report](const char* name) { report.phase(name); },
            [&progress](double share) { progress.update(100 * share); }};
}

void printFitPlan(const VisibilityHeader& header, const std::string& output) {
    std::printf("would fit %zu frames of %zu vertices and write %s\n", header.frames.frameCount(),
                header.mesh.vertexCount(), output.c_str());
}

namespace {

void printRow(const char* name, const char* role, std::size_t frames, const ErrorFigures& errors) {
    std::printf("%-24s %-9s %6zu %14.4f %8.4f %13.4f\n", name, role, frames, errors.relative_error, errors.rms_v,
                errors.ambient_error);
}

ErrorFigures figuresOf(const ClipError& clip) { return {clip.relative_error, clip.rms_v, clip.ambient_error}; }

}  // namespace

nlohmann::ordered_json toJson(const ErrorFigures& errors) {
    return {
        {"relative_error", errors.relative_error}, {"rms_v", errors.rms_v}, {"ambient_error", errors.ambient_error}};
}

void addToReport(const ClipTable& table, nlohmann::ordered_json& figures) {
    figures["train_frames"] = table.train_frames;
    figures["held_out_frames"] = table.held_out_frames;
    figures["train"] = toJson(table.train);
    if (table.held_out_frames) figures["held_out"] = toJson(table.held_out);
    for (const ClipError& clip : table.clips) {
        figures["clips"][clip.clip] = toJson(figuresOf(clip));
        figures["clips"][clip.clip]["held_out"] = clip.held_out;
    }
}

void print(const ClipTable& table) {
    std::printf("%-24s %-9s %6s %14s %8s %13s\n", "clip", "", "frames", "relative error", "rms V", "ambient error");
    for (const ClipError& clip : table.clips) {
        const auto index = std::ranges::find(table.frames.clip_names, clip.clip) - table.frames.clip_names.begin();
        const auto frames = std::ranges::count(table.frames.clip, std::uint16_t(index));
        printRow(clip.clip.c_str(), clip.held_out ? "held out" : "train", std::size_t(frames), figuresOf(clip));
    }
    printRow("all", "train", table.train_frames, table.train);
    if (table.held_out_frames) printRow("all", "held out", table.held_out_frames, table.held_out);
}

std::size_t runPredict(const PredictCommand& command, const PosePredictor& model, const CommonOptions& common,
                       Report& report) {
    const VisibilityReader poses(command.poses);
    const std::size_t frames = poses.header().frames.frameCount();
    model.check(poses.header());
    if (common.dry_run) {
        std::printf("would predict %zu frames of %zu vertices and write %s\n", frames,
                    poses.header().mesh.vertexCount(), command.output.c_str());
        return 0;
    }
    report.phase("predict");
    Progress progress = progressOf(common, "predict", "frames", double(frames));
    model.predict(poses, {command.output, makeProvenance("penumbra-fit predict", "{}", command.inputs()),
                          common.threads, [&](double frame) { progress.update(frame); }});
    report.figures["frames"] = frames;
    return frames;
}

}  // namespace penumbra
