// bench_brdf_fit COMMIT [FILE | FILE:ROW]...: what `penumbra-fit brdf` takes, by phase, for every analytic model at its
// defaults and for the files given (sh/brdf/brdf.h, formats/brdf/brdf_source.h): read, slices with their tabulation, 8
// operators from them and from the table, shading error. Minimum of 3 runs, ms; all phases on all threads. `total` is
// the command with --operators 8, which takes those of the slices. CSV rows (tests/bench/results).
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>

#include "fit/papers/operators/brdf_operators.h"
#include "fit/reflectance/fit_brdf.h"
#include "formats/brdf/brdf_source.h"
#include "formats/common/parallel_for.h"

namespace {

using namespace penumbra;

double milliseconds(const std::function<void()>& run) {
    double least = 1e30;
    for (int i = 0; i < 3; ++i) {
        const auto start = std::chrono::steady_clock::now();
        run();
        const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
        least = std::min(least, took.count());
    }
    return least;
}

void benchSource(const BrdfSource& source, const char* commit, int threads) {
    BrdfReading reading;
    BrdfFile brdf;
    const double read = milliseconds([&] { reading = readBrdfSource(source, threads); });
    const double slices = milliseconds([&] { brdf = fitBrdf(reading.brdf, {}, threads); });
    const auto operators = [&](OperatorSource from) {
        return milliseconds([&] { brdf.operators = fitOperators(reading.brdf, brdf, from, 8, threads); });
    };
    const double from_table = operators(OperatorSource::kTable), from_slices = operators(OperatorSource::kSlices);
    const double error = milliseconds([&] {
        const ShadingTruth truth = shadingTruth(reading.brdf, threads);
        measureShading(truth, brdf);
        measureOperators(truth, brdf);
    });
    std::string name = reading.brdf.name;
    std::replace(name.begin(), name.end(), ',', '+');
    std::printf("%s,%s,%.4f,%.4f,%d,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f\n", commit, name.c_str(),
                brdf.errors.at("shading_d5"), brdf.errors.at("shading_operators"), brdf.operators.count, read, slices,
                from_slices, from_table, error, read + slices + from_slices + error);
}

}  // namespace

int main(int argc, char** argv) {
    const int threads = hardwareThreads();
    const char* commit = argc > 1 ? argv[1] : "";
    std::printf(
        "commit,brdf,shading_d5,shading_operators,operators,read_ms,slices_ms,from_slices_ms,from_table_ms,"
        "shading_error_ms,total_ms\n");
    for (const std::string& name : brdfNames()) benchSource(brdfSource(name), commit, threads);
    for (int i = 2; i < argc; ++i) benchSource(brdfSource(argv[i]), commit, threads);
    return 0;
}
