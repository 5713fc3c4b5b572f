// Clusters points by mean-shift.
//
// Problem: find the groups of vertices that follow the same bones. Nobody knows how many groups there are.
//
// Naive: k-means needs the number of groups, and its result depends on the start. Clustering every vertex by mean-shift
// costs the square of the number of vertices.
//
// Here: mean-shift (Comaniciu and Meer 2002) finds the number of groups by itself: each point climbs to a mode of the
// density of all points. Vertices with nearly equal weights are first put into one bin, so that only the bins climb.
// See docs/formulas.md, section 4.

#include "fit/clusters/mean_shift.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "fit/numerics/matrix.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

constexpr float kBinsPerUnit = 8;
constexpr int kMaxSteps = 300;
constexpr double kStopStep = 1e-3;  // relative to the bandwidth

struct WeightBins {
    MatrixF points;                        // [B, J] mean weights of each bin's members
    std::vector<double> counts;            // [B] number of members
    std::vector<std::uint32_t> of_vertex;  // [V] bin of each vertex
};

// Returns the bin of a vertex: the joint and the level of every weight that rounds to at least one level.
std::vector<std::pair<int, int>> binKey(const Skin& skin, std::size_t vertex) {
    std::vector<std::pair<int, int>> key;
    for (int k = 0; k < skin.influences; ++k) {
        const std::size_t i = vertex * std::size_t(skin.influences) + std::size_t(k);
        const int level = int(std::lround(skin.weights[i] * kBinsPerUnit));
        if (level > 0) key.emplace_back(skin.joints[i], level);
    }
    std::sort(key.begin(), key.end());
    return key;
}

// Puts the vertices into bins.
WeightBins makeBins(const Skin& skin) {
    const std::size_t vertices = skin.weights.size() / std::size_t(skin.influences);
    // 1. Vertices with the same key share a bin.
    WeightBins bins;
    std::map<std::vector<std::pair<int, int>>, std::uint32_t> known;
    for (std::size_t v = 0; v < vertices; ++v)
        bins.of_vertex.push_back(known.try_emplace(binKey(skin, v), std::uint32_t(known.size())).first->second);
    // 2. Each bin gets the mean weights of its members.
    bins.points = MatrixF(known.size(), skin.jointCount());
    bins.counts.resize(known.size());
    for (std::size_t v = 0; v < vertices; ++v) {
        ++bins.counts[bins.of_vertex[v]];
        for (int k = 0; k < skin.influences; ++k) {
            const std::size_t i = v * std::size_t(skin.influences) + std::size_t(k);
            bins.points(bins.of_vertex[v], skin.joints[i]) += skin.weights[i];
        }
    }
    for (std::size_t b = 0; b < bins.points.rows; ++b)
        for (float& x : bins.points.row(b)) x /= float(bins.counts[b]);
    return bins;
}

double squaredDistance(std::span<const float> a, std::span<const float> b) {
    float sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
}

// Moves x to the mode that it climbs to: x becomes the weighted mean of the points around it, again and again.
void climb(const MatrixF& points, std::span<const double> counts, double bandwidth, std::span<float> x) {
    std::vector<double> mean(x.size());
    for (int step = 0; step < kMaxSteps; ++step) {
        // 1. Average the points by the kernel around x. Points where the kernel is below exp(-20) = 2e-9 are left out.
        std::fill(mean.begin(), mean.end(), 0.0);
        double total = 0;
        for (std::size_t b = 0; b < points.rows; ++b) {
            const double d2 = squaredDistance(points.row(b), x) / (2 * bandwidth * bandwidth);
            if (d2 > 20) continue;
            const double w = counts[b] * std::exp(-d2);
            total += w;
            for (std::size_t i = 0; i < x.size(); ++i) mean[i] += w * points(b, i);
        }
        if (total <= 0) return;
        // 2. Move x there, and stop when it hardly moves.
        double moved = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            const auto next = float(mean[i] / total);
            moved += double(next - x[i]) * (next - x[i]);
            x[i] = next;
        }
        if (moved < kStopStep * kStopStep * bandwidth * bandwidth) return;
    }
}

// Gives every point the number of its mode. Points come in descending order of count; each joins the first mode within
// one bandwidth, or else founds a new mode.
std::vector<std::uint32_t> labelModes(std::span<const double> counts, const MatrixF& ends, double bandwidth) {
    std::vector<std::size_t> order = indices(ends.rows), modes;
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return counts[a] > counts[b]; });
    std::vector<std::uint32_t> label(ends.rows);
    for (std::size_t b : order) {
        std::size_t mode = 0;
        while (mode < modes.size() && squaredDistance(ends.row(modes[mode]), ends.row(b)) > bandwidth * bandwidth)
            ++mode;
        if (mode == modes.size()) modes.push_back(b);
        label[b] = std::uint32_t(mode);
    }
    return label;
}

}  // namespace

std::vector<std::uint32_t> meanShift(const MatrixF& points, std::span<const double> counts, double bandwidth,
                                     int threads) {
    MatrixF ends = points;
    parallelFor(ends.rows, threads, [&](std::size_t p) {
        throwIfInterrupted();
        climb(points, counts, bandwidth, ends.row(p));
    });
    return labelModes(counts, ends, bandwidth);
}

std::vector<std::uint32_t> meanShiftSkinWeights(const Skin& skin, double bandwidth, int threads) {
    // 1. Cluster the bins.
    const WeightBins bins = makeBins(skin);
    const std::vector<std::uint32_t> mode_of_bin = meanShift(bins.points, bins.counts, bandwidth, threads);
    // 2. Number the clusters in the order in which vertices use them.
    std::vector<std::uint32_t> dense(bins.points.rows, std::uint32_t(-1)), label;
    std::uint32_t used = 0;
    for (std::uint32_t bin : bins.of_vertex) {
        std::uint32_t& name = dense[mode_of_bin[bin]];
        if (name == std::uint32_t(-1)) name = used++;
        label.push_back(name);
    }
    return label;
}

}  // namespace penumbra
