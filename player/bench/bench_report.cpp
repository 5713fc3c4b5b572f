#include "player/bench/bench_report.h"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace penumbra {

namespace {

using Json = nlohmann::ordered_json;

double hertz(double milliseconds) { return 1000 / milliseconds; }

void printRoofline(const Roofline& r) {
    std::printf("machine, %d thread%s, %s path: %.1f GFLOP/s on registers;", r.threads, r.threads == 1 ? "" : "s",
                r.path, r.peak);
    for (const Bandwidth& b : r.memory)
        std::printf(" %.*f MB %.0f", b.bytes < 10e6 ? 1 : 0, double(b.bytes) * 1e-6, b.best());
    std::printf(" GB/s\n");
}

void printStages(const CpuBench& cpu) {
    std::printf("%-19s %7s %8s %8s %8s %8s %8s %10s %7s %8s %6s %7s\n", "CPU stage", "threads", "ms", "best", "KB read",
                "KB writ.", "Mflop", "flop/byte", "GB/s", "GFLOP/s", "roof", "of it");
    for (const CpuStage& s : cpu.stages) {
        if (!s.counted()) {
            std::printf("%-19s %7d %8.3f %8.3f\n", s.name, s.threads, s.time.median, s.time.best);
            continue;
        }
        std::printf("%-19s %7d %8.3f %8.3f %8.0f %8.0f %8.2f %10.2f %7.1f %8.1f %6.1f %6.1f%% %s\n", s.name, s.threads,
                    s.time.median, s.time.best, double(s.work.read) * 1e-3, double(s.work.written) * 1e-3,
                    s.work.flop * 1e-6, s.intensity(), s.gigabytes(), s.gflops(), s.roof, 100 * s.ofRoof(),
                    s.memory_bound ? "memory" : "multiply-adds");
    }
}

void printRate(const char* what, const StageTime& time) {
    if (time.median > 0) std::printf("%-32s %8.3f ms %8.1f Hz\n", what, time.median, hertz(time.median));
}

void printSwitching(const char* what, const Switching& s) {
    if (s.steady == 0) return;
    std::printf("%-32s %8.3f ms, worst %.3f; without %.3f ms, worst %.3f: ratio %.3f, worst %.3f\n", what, s.switched,
                s.switched_worst, s.steady, s.steady_worst, s.switched / s.steady, s.switched_worst / s.steady_worst);
}

// Returns "0.034", or "-" where the time is not known.
std::string orDash(const std::optional<double>& milliseconds) {
    if (!milliseconds) return "-";
    char text[32];
    std::snprintf(text, sizeof text, "%.3f", *milliseconds);
    return text;
}

void printGpuCost(const GpuCost& c) {
    std::printf("%-10zu %9.3f %9.3f %13s %9s %11.1f %15.1f %20.1f\n", c.characters, c.evaluate, c.draw,
                orDash(c.gpu_evaluate).c_str(), orDash(c.gpu_draw).c_str(), double(c.bytes_shared) * 1e-3,
                double(c.bytes_each) * 1e-3, double(c.bytes_uploaded) * 1e-3);
}

void printGpuTable(const BenchResult& r) {
    std::printf("%-10s %9s %9s %13s %9s %11s %15s %20s\n", "GLSL path", "evaluate", "draw, ms", "GPU: evaluate",
                "draw, ms", "shared, KB", "KB a character", "KB uploaded for each");
    if (r.characters.empty()) printGpuCost(r.gl.model);
    for (const CharactersCost& c : r.characters) printGpuCost(c.glsl);
}

void printGl(const GlBench& gl) {
    for (const GlBench::WholeFrame& f : gl.whole_frames) {
        const std::string what = "whole frame, CPU path, --aa " + std::to_string(f.samples);
        printRate(what.c_str(), f.time);
    }
    printRate("GL draw CPU's values", {gl.draw_values, 0});
    if (gl.draw_model == 0) return;  // an asset that the CPU alone evaluates
    printRate("GL evaluate and draw", {gl.draw_model, 0});
    std::printf("%-32s %8.0f ms with upload and shader compilation\n", "GL the first time", gl.first_frame);
    printSwitching("GL draw, switched", gl.switching);
    std::printf("%-32s %8.3f of an 8-bit step, root mean square\n", "GLSL path against CPU path", gl.path_difference);
}

// Compares what one of many costs with one alone, which benchCharacters() puts first.
double linearity(double first, const CharactersCost& one, double all, const CharactersCost& many) {
    return all / many.count / (first / one.count);
}

void printCharacters(const std::vector<CharactersCost>& characters) {
    if (characters.empty()) return;
    const CharactersCost& one = characters.front();
    std::printf("%-10s %10s %9s %9s %9s %9s %8s %12s %12s %15s\n", "characters", "pose, skin", "evaluate", "shade",
                "draw", "all, ms", "Hz", "linear: CPU", "linear: draw", "KB a character");
    for (const CharactersCost& c : characters)
        std::printf("%-10d %10.3f %9.3f %9.3f %9.3f %9.3f %8.1f %12.3f %12.3f %15.1f\n", c.count, c.pose_skin,
                    c.evaluate, c.shade, c.draw, c.total(), hertz(c.total()), linearity(one.cpu(), one, c.cpu(), c),
                    linearity(one.draw, one, c.draw, c), double(c.bytes_each) * 1e-3);
    std::printf("linear: cost of one of many / cost of one alone; shared: the mapped asset and %.1f KB decoded of it\n",
                double(one.bytes_decoded) * 1e-3);
}

}  // namespace

void printBench(const BenchResult& r) {
    std::printf("%zu vertices, %zu triangles, %d threads; %s\n", r.vertices, r.triangles, r.threads,
                r.gl.context.c_str());
    printRoofline(r.cpu.one_thread);
    if (r.threads > 1) printRoofline(r.cpu.all_threads);
    printStages(r.cpu);
    printRate("CPU pose and evaluate", r.cpu.pose_evaluate);
    printRate("CPU pose, skin and evaluate", r.cpu.pose_skin_evaluate);
    printRate("CPU shade", r.cpu.shade);
    if (r.cpu.shade_clay.best > 0)
        std::printf("%-32s %8.2f times clay, the best of each\n", "CPU shade, with pictures",
                    r.cpu.shade.best / r.cpu.shade_clay.best);
    if (r.cpu.shade.median == 0) std::printf("CPU shade                               - (no material or no light)\n");
    printRate("CPU all of a frame", r.cpu.frame);
    printSwitching("CPU shade, switched", r.cpu.switching);
    if (r.suns > 0)
        std::printf("%-32s %8zu, timed as SH like all of the light; bench --scene times suns\n", "suns of the light",
                    r.suns);
    printGl(r.gl);
    printCharacters(r.characters);
    if (r.gl.draw_model > 0) printGpuTable(r);
    std::printf("the asset's frames are out of the training range by %.4f on average, at most %.4f\n",
                r.cpu.out_of_range_mean, r.cpu.out_of_range_max);
}

namespace {

Json figuresOf(const StageTime& t) { return {{"median_ms", t.median}, {"best_ms", t.best}}; }

Json figuresOf(const Roofline& r) {
    Json memory = Json::array();
    for (const Bandwidth& b : r.memory)
        memory.push_back({{"bytes", b.bytes}, {"read_gb_per_s", b.read}, {"triad_gb_per_s", b.triad}});
    return {{"path", r.path}, {"threads", r.threads}, {"peak_gflop_per_s", r.peak}, {"memory", memory}};
}

Json figuresOf(const CpuStage& s) {
    return {{"stage", s.name},
            {"threads", s.threads},
            {"median_ms", s.time.median},
            {"best_ms", s.time.best},
            {"bytes_read", s.work.read},
            {"bytes_written", s.work.written},
            {"flop", s.work.flop},
            {"working_set_bytes", s.working_set},
            {"flop_per_byte", s.intensity()},
            {"gb_per_s", s.gigabytes()},
            {"gflop_per_s", s.gflops()},
            {"roof_gflop_per_s", s.roof},
            {"of_roof", s.ofRoof()},
            {"bound_by", s.memory_bound ? "memory" : "multiply-adds"}};
}

Json figuresOf(const Switching& s) {
    return {{"switched_ms", s.switched},
            {"switched_worst_ms", s.switched_worst},
            {"steady_ms", s.steady},
            {"steady_worst_ms", s.steady_worst}};
}

Json figuresOf(const GpuCost& c) {
    const auto orNull = [](const std::optional<double>& milliseconds) {
        return milliseconds ? Json(*milliseconds) : Json();
    };
    return {{"evaluate_ms", c.evaluate},
            {"draw_ms", c.draw},
            {"gpu_evaluate_ms", orNull(c.gpu_evaluate)},
            {"gpu_draw_ms", orNull(c.gpu_draw)},
            {"gl_bytes_shared", c.bytes_shared},
            {"gl_bytes_each", c.bytes_each},
            {"bytes_uploaded_each", c.bytes_uploaded}};
}

Json figuresOf(const GlBench& gl) {
    Json frames = Json::array();
    for (const GlBench::WholeFrame& f : gl.whole_frames) {
        Json frame = figuresOf(f.time);
        frame["samples"] = f.samples;
        frame["hz"] = hertz(f.time.median);
        frames.push_back(frame);
    }
    return {{"context", gl.context},
            {"whole_frames", frames},
            {"draw_values_ms", gl.draw_values},
            {"draw_model_ms", gl.draw_model},
            {"glsl", figuresOf(gl.model)},
            {"first_frame_ms", gl.first_frame},
            {"path_difference_8bit", gl.path_difference},
            {"switching", figuresOf(gl.switching)}};
}

Json figuresOf(const std::vector<CharactersCost>& characters) {
    Json all = Json::array();
    for (const CharactersCost& c : characters)
        all.push_back({{"characters", c.count},
                       {"pose_skin_ms", c.pose_skin},
                       {"evaluate_ms", c.evaluate},
                       {"shade_ms", c.shade},
                       {"draw_ms", c.draw},
                       {"total_ms", c.total()},
                       {"cpu_linearity", linearity(characters[0].cpu(), characters[0], c.cpu(), c)},
                       {"draw_linearity", linearity(characters[0].draw, characters[0], c.draw, c)},
                       {"bytes_decoded_shared", c.bytes_decoded},
                       {"bytes_each", c.bytes_each},
                       {"glsl", figuresOf(c.glsl)}});
    return all;
}

}  // namespace

Json figuresOf(const BenchResult& r) {
    Json stages = Json::array();
    for (const CpuStage& s : r.cpu.stages) stages.push_back(figuresOf(s));
    return {{"vertices", r.vertices},
            {"triangles", r.triangles},
            {"threads", r.threads},
            {"roofline", {{"one_thread", figuresOf(r.cpu.one_thread)}, {"all_threads", figuresOf(r.cpu.all_threads)}}},
            {"stages", stages},
            {"pose_evaluate", figuresOf(r.cpu.pose_evaluate)},
            {"pose_skin_evaluate", figuresOf(r.cpu.pose_skin_evaluate)},
            {"shade", figuresOf(r.cpu.shade)},
            {"shade_clay", figuresOf(r.cpu.shade_clay)},
            {"frame", figuresOf(r.cpu.frame)},
            {"switching", figuresOf(r.cpu.switching)},
            {"out_of_range_mean", r.cpu.out_of_range_mean},
            {"out_of_range_max", r.cpu.out_of_range_max},
            {"suns_as_sh", r.suns},
            {"gl", figuresOf(r.gl)},
            {"characters", figuresOf(r.characters)}};
}

}  // namespace penumbra
