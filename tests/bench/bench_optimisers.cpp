// bench_optimisers X.vis.h5 [--clusters N] [--every S] [--neurons N] [--prior P] [--iterations N] [--holdout clip,clip]
//   [--features joint-angles|relative-bones] [--input-variance V] [--methods bfgs,lbfgs]
// Eq 13 of Nowrouzezahrai 2009 on the clusters of a bake: the papers' BFGS and L-BFGS (Ceres) against variable
// projection, one thread. All start at the same net, its output weights already at their best. The time of ours is
// until its objective is not above the other's last one, over the rounds of starts of fit/models/neural_start.h, of
// which the first start is that net. Times are processor seconds, so that other work on the machine changes them
// little. One table a method.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <functional>
#include <map>
#include <sstream>

#include "fit/models/features.h"
#include "fit/models/neural_start.h"
#include "fit/models/variable_projection.h"
#include "fit/visibility/fit_visibility.h"
#include "fit/visibility/local_coefficients.h"
#include "tests/fit/neural_bfgs.h"

namespace {

using namespace penumbra;

constexpr int kMaxRounds = 6;       // of 8 starts
constexpr double kSame = 1 + 1e-5;  // objectives within this factor count as the same

double seconds(const std::function<void()>& run) {
    const std::clock_t start = std::clock();
    run();
    return double(std::clock() - start) / CLOCKS_PER_SEC;
}

struct Cluster {
    std::size_t index;
    Matrix x, y;  // training frames; root mean square lengths 1
};

void scaleToUnit(Matrix& m) {
    double square = 0;
    for (double v : m.values) square += v * v / double(m.rows);
    for (double& v : m.values) v /= std::sqrt(square);
}

// Reads inputs and scores of cluster c of a linear fit, which shares everything with the neural one except the
// regression.
Cluster readCluster(const VisibilityReader& reader, const PoseTable& poses, const Model& model, std::size_t c) {
    const ClusterModel& cluster = model.clusters[c];
    const FeatureRecipe recipe = recipeOf(model);
    const std::vector<int> joints(model.clusters.size(), cluster.joint);
    ClusterCoefficientsRequest request;
    request.convention = model.convention;
    request.frames = {&model.rest_tangents, &model.cluster_of_vertex, joints};
    const std::vector<std::vector<std::uint32_t>> vertices{cluster.vertices};
    request.vertices_of_cluster = vertices;
    const MatrixF coefficients = readClusterCoefficients(reader, poses, request)[0];
    std::vector<std::size_t> train;
    for (std::size_t f = 0; f < poses.frameCount(); ++f) {
        const std::string& clip = model.frames.clip_names[model.frames.clip[f]];
        if (std::find(model.holdout_clips.begin(), model.holdout_clips.end(), clip) == model.holdout_clips.end())
            train.push_back(f);
    }
    const std::size_t inputs = cluster.input_min.size(), outputs = cluster.bias.size();
    Cluster out{c, Matrix(train.size(), inputs), Matrix(train.size(), outputs)};
    std::vector<double> raw(recipe.count());
    for (std::size_t r = 0; r < train.size(); ++r) {
        const std::size_t f = train[r];
        rawFeatures(recipe, cluster.joint, poses.bonesOf(f), poses.rotationsOf(f), poses.poseOf(f), raw);
        for (std::size_t i = 0; i < inputs; ++i)
            for (std::size_t n = 0; n < raw.size(); ++n)
                out.x(r, i) +=
                    double(cluster.input_basis[i * raw.size() + n]) * (raw[n] - double(cluster.feature_mean[n]));
        for (std::size_t k = 0; k < outputs; ++k)
            for (std::size_t n = 0; n < coefficients.columns; ++n)
                out.y(r, k) +=
                    double(cluster.basis[k * coefficients.columns + n]) * double(coefficients(f, n) - cluster.mean[n]);
    }
    scaleToUnit(out.x);
    scaleToUnit(out.y);
    return out;
}

struct Timed {
    double objective = 0, time = 0;
    int iterations = 0;
};

Timed reachTarget(const Cluster& cluster, std::size_t neurons, double alpha, double target) {
    NetFit fit;
    const double time = seconds([&] {
        fit = fitFromManyStarts(cluster.x, cluster.y, alpha, {.neurons = neurons, .rounds = kMaxRounds},
                                {.iterations = 5000, .least_decrease = 1e-8, .target = kSame * target});
    });
    return {fit.objective, time, fit.iterations};
}

struct Settings {
    std::size_t neurons = 16, every = 1;
    double prior = 1e-3;
    int iterations = 5000;
};

void compare(const char* name, QuasiNewton method, const std::vector<Cluster>& clusters, const Settings& settings) {
    std::printf("%-8s %6s %5s %3s %3s | %6s %12s %9s | %6s %12s %9s | %8s %s\n", name, "frames", "vars", "I", "K",
                "iter", "objective", "s", "iter", "ours", "s", "ratio", "ours/theirs");
    Timed theirs_sum, ours_sum;
    std::size_t reached = 0;
    for (const Cluster& c : clusters) {
        const double alpha = settings.prior * double(c.x.rows);
        const TanhNet start = startNet(c.x, c.y, settings.neurons, 1);
        const TanhNet from = fitByProjection(netData(c.x, c.y), start, alpha, {.iterations = 0}).net;
        NetFit fit;
        SearchOptions search = kPapersSearch;
        search.method = method;
        search.iterations = settings.iterations;
        const double time = seconds([&] { fit = fitByBfgs(c.x, c.y, from, alpha, search); });
        const Timed ours = reachTarget(c, settings.neurons, alpha, fit.objective);
        const bool there = ours.objective <= kSame * fit.objective;
        const std::size_t variables = settings.neurons * (c.x.columns + 1) + (settings.neurons + 1) * c.y.columns;
        std::printf("%-8zu %6zu %5zu %3zu %3zu | %6d %12.6f %9.3f | %6d %12.6f %9.4f | %8.0f %.6f%s\n", c.index,
                    c.x.rows, variables, c.x.columns, c.y.columns, fit.iterations, fit.objective, time, ours.iterations,
                    ours.objective, ours.time, time / ours.time, ours.objective / fit.objective,
                    there ? "" : "  not reached");
        std::fflush(stdout);
        reached += there;
        theirs_sum.time += time, theirs_sum.objective += fit.objective, theirs_sum.iterations += fit.iterations;
        ours_sum.time += ours.time, ours_sum.objective += ours.objective, ours_sum.iterations += ours.iterations;
    }
    std::printf("%-8s %20s | %6d %12.6f %9.3f | %6d %12.6f %9.4f | %8.0f %.6f  reached in %zu of %zu\n\n", "all", "",
                theirs_sum.iterations, theirs_sum.objective, theirs_sum.time, ours_sum.iterations, ours_sum.objective,
                ours_sum.time, theirs_sum.time / ours_sum.time, ours_sum.objective / theirs_sum.objective, reached,
                clusters.size());
}

std::vector<std::string> splitAtCommas(const std::string& text) {
    std::vector<std::string> words;
    std::istringstream stream(text);
    for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
    return words;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: bench_optimisers X.vis.h5 [options as in the source]\n");
        return 1;
    }
    std::map<std::string, std::string> given;
    for (int i = 2; i + 1 < argc; i += 2) given[argv[i]] = argv[i + 1];
    const auto option = [&](const char* name, const char* fallback) {
        return given.count(name) ? given[name] : std::string(fallback);
    };
    FitOptions options;
    options.clusters = std::stoi(option("--clusters", "64"));
    options.holdout = splitAtCommas(option("--holdout", ""));
    options.input_variance = std::stod(option("--input-variance", "0.95"));
    options.model = ModelKind::kLinear;
    options.threads = 1;
    for (FeatureKind kind : kFeatureKinds)
        if (option("--features", "relative-bones") == nameOf(kind)) options.features = kind;
    const Settings settings{std::stoul(option("--neurons", "16")), std::stoul(option("--every", "8")),
                            std::stod(option("--prior", "1e-3")), std::stoi(option("--iterations", "5000"))};

    const VisibilityReader reader(argv[1]);
    const PoseTable poses = readPoses(reader, {.threads = 1});
    const Model model = fitVisibility(reader, argv[1], options, {}).model;
    std::vector<Cluster> clusters;
    for (std::size_t c = 0; c < model.clusters.size(); c += settings.every)
        clusters.push_back(readCluster(reader, poses, model, c));
    for (const std::string& method : splitAtCommas(option("--methods", "bfgs,lbfgs")))
        compare(method.c_str(), method == "bfgs" ? QuasiNewton::kBfgs : QuasiNewton::kLbfgs, clusters, settings);
    return 0;
}
