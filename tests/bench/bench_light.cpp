// bench_light FOLDER [COMMIT] [ORDER]: zonal lobes of eight real lights of FOLDER (PENUMBRA_DATA/lights), greedy as
// Nowrouzezahrai 2009 and joint; relative residual of radiance, error of irradiance over all normals, and time, the
// best of five runs. The first fit of the process, with whatever Ceres does once, comes first. CSV on stdout, a table
// on stderr.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "fit/light/fit_light.h"
#include "fit/light/light_lobes.h"

namespace {

using namespace penumbra;

// Daylight with a low sun, soft and hard interiors, lamps at night, studio flashes, trees, an open sky.
const char* const kLights[] = {"blender_courtyard.exr", "blender_forest.exr",  "blender_interior.exr",
                               "blender_night.exr",     "blender_sunrise.exr", "pmndrs_apartment.exr",
                               "pmndrs_studio.exr",     "pmndrs_venice.exr"};
const int kLobes[] = {1, 2, 3, 5, 7};

double milliseconds(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return 1000 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: bench_light FOLDER [COMMIT] [ORDER]\n");
        return 1;
    }
    const std::filesystem::path folder = argv[1];
    const std::string commit = argc > 2 ? argv[2] : "";
    const int order = argc > 3 ? std::atoi(argv[3]) : 4;
    std::printf("commit,light,order,fit,lobes,residual,irradiance_error,ms\n");
    bool first = true;
    for (const char* name : kLights) {
        const LightFile light = fitLight(readEnvironmentMap(folder / name, {}), name, order, 1);
        const auto row = [&](const char* fit, int lobes, const LightLobesFit& result, double ms) {
            std::printf("%s,%s,%d,%s,%d,%.6f,%.6f,%.2f\n", commit.c_str(), light.name.c_str(), order, fit, lobes,
                        result.residual, result.irradiance_error, ms);
        };
        LightLobesFit result;
        if (first) {
            const double ms = milliseconds([&] { result = fitLobes(order, light.sh, 3, LobeFit::kJoint); });
            row("joint first call", 3, result, ms);
        }
        first = false;
        std::string line[2];
        double joint_ms = 0;
        for (const LobeFit how : {LobeFit::kGreedy, LobeFit::kJoint})
            for (const int lobes : kLobes) {
                double best = 1e9;
                for (int run = 0; run < 5; ++run)
                    best = std::min(best, milliseconds([&] { result = fitLobes(order, light.sh, lobes, how); }));
                row(result.mode.c_str(), lobes, result, best);
                char text[64];
                std::snprintf(text, sizeof text, " %.4f/%.4f", result.residual, result.irradiance_error);
                line[how == LobeFit::kJoint] += text;
                if (how == LobeFit::kJoint && lobes == 3) joint_ms = best;
            }
        std::fprintf(stderr, "%-22s greedy%s\n%-22s joint %s   3 lobes %.1f ms\n", light.name.c_str(), line[0].c_str(),
                     "", line[1].c_str(), joint_ms);
    }
    return 0;
}
