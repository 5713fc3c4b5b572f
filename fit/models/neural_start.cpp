// Draws the hidden weights from which the searches for a tanh net start, and runs many of them.
//
// Problem: the objective has many minima, and where a search ends depends on where it starts.
//
// Naive: draw all weights from one normal distribution. Most such neurons are flat or saturated over the poses that
// occur, or bend where the outputs hardly change.
//
// Here: every neuron is put between two training frames, and pairs of frames between which the outputs change fast are
// drawn more often (Bolager et al. 2023). See docs/formulas.md, section 4.

#include "fit/models/neural_start.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <random>

namespace penumbra {

namespace {

// The least distance between two frames, as a part of the inputs' length. Nearer frames show one pose (the two ends of
// a loop). A neuron between them would be so steep that the search could never move it again.
constexpr double kMinDistance = 1e-3;
constexpr std::size_t kCandidatesPerNeuron = 16;   // random pairs of which one is drawn
constexpr double kSteepness = 1.0986122886681098;  // 2 atanh(1/2)

// Returns a number in [0, 1). It is the same in every standard library, unlike that of std::uniform_real_distribution.
double uniform(std::mt19937_64& random) { return double(random() >> 11) * 0x1p-53; }

struct PairOfFrames {
    std::size_t a = 0, b = 0;
    double steepness = 0;  // |y_b - y_a| / |x_b - x_a|
};

// Returns the root mean square length of the inputs.
double lengthOf(const Matrix& inputs) {
    double sum = 0;
    for (const double x : inputs.values) sum += x * x;
    return std::sqrt(sum / double(inputs.rows));
}

// Runs searches, remembers the best result and counts the work of all.
struct Search {
    const NetData& data;
    double alpha, target;
    NetFit best;
    int iterations = 0, evaluations = 0;

    NetFit run(const TanhNet& start, const SearchOptions& options) {
        NetFit fit = fitByProjection(data, start, alpha, options);
        iterations += fit.iterations;
        evaluations += fit.evaluations;
        if (fit.objective < best.objective) best = fit;
        return fit;
    }
    bool done() const { return best.objective <= target; }
};

}  // namespace

TanhNet startNet(const Matrix& inputs, const Matrix& outputs, std::size_t neurons, std::uint64_t seed) {
    assert(inputs.rows == outputs.rows && inputs.rows > 0);
    TanhNet net = emptyNet(inputs.columns, outputs.columns, neurons);
    std::mt19937_64 random(seed);
    const auto frame = [&] { return std::size_t(uniform(random) * double(inputs.rows)); };
    const double least = kMinDistance * lengthOf(inputs);
    for (std::size_t n = 0; n < neurons; ++n) {
        // 1. Draw pairs of frames and note how steeply the outputs change between the two.
        PairOfFrames candidates[kCandidatesPerNeuron];
        double total = 0;
        for (PairOfFrames& pair : candidates) {
            pair.a = frame(), pair.b = frame();
            const double distance = std::sqrt(squaredDistance(inputs.row(pair.a), inputs.row(pair.b)));
            if (distance > least)
                pair.steepness = std::sqrt(squaredDistance(outputs.row(pair.a), outputs.row(pair.b))) / distance;
            total += pair.steepness;
        }
        // 2. Choose one of the pairs with a probability proportional to its steepness.
        double draw = uniform(random) * total;
        const PairOfFrames* chosen = candidates;
        for (const PairOfFrames& pair : candidates) {
            if (pair.steepness > 0) chosen = &pair;
            if ((draw -= pair.steepness) < 0) break;
        }
        if (chosen->steepness == 0) continue;  // all frames look alike to this neuron: it starts, and stays, at zero
        // 3. Put the neuron between the two frames of the pair.
        const std::span<const double> a = inputs.row(chosen->a), b = inputs.row(chosen->b);
        const double square = squaredDistance(a, b);
        for (std::size_t i = 0; i < a.size(); ++i) {
            const double d = kSteepness * (b[i] - a[i]) / square;
            net.hidden(n, i) = d;
            net.hidden_bias[n] -= d * (a[i] + b[i]) / 2;
        }
    }
    return net;
}

NetFit fitFromManyStarts(const Matrix& inputs, const Matrix& outputs, double alpha, const StartPlan& plan,
                         const SearchOptions& options) {
    assert(plan.rounds > 0 && plan.starts > 0 && plan.kept > 0);
    const NetData data = netData(inputs, outputs);
    Search search{data, alpha, options.target, {}};
    search.best.objective = std::numeric_limits<double>::infinity();
    SearchOptions first = options;
    first.iterations = std::min(plan.first_iterations, options.iterations);
    for (int round = 0; round < plan.rounds && !search.done(); ++round) {
        // 1. Search briefly from every start of the round.
        std::vector<NetFit> fits;
        for (int s = 0; s < plan.starts && !search.done(); ++s) {
            const auto seed = plan.seed + std::uint64_t(round * plan.starts + s);
            fits.push_back(search.run(startNet(inputs, outputs, plan.neurons, seed), first));
        }
        // 2. Continue the best of these searches to the end.
        std::stable_sort(fits.begin(), fits.end(),
                         [](const NetFit& a, const NetFit& b) { return a.objective < b.objective; });
        for (int k = 0; k < std::min(plan.kept, int(fits.size())) && !search.done(); ++k)
            search.run(fits[std::size_t(k)].net, options);
    }
    search.best.iterations = search.iterations;
    search.best.evaluations = search.evaluations;
    return search.best;
}

}  // namespace penumbra
