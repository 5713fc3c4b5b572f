#include "fit/models/many_starts.h"

#include <algorithm>
#include <cassert>

#include "fit/models/neural_start.h"

namespace penumbra {

namespace {

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
            fits.push_back(search.run(startNet(inputs, outputs, plan.neurons, plan.ranges, seed), first));
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
