// Tells which vertices have no weights, and which have more influences than a rig holds.
#include <algorithm>
#include <cstdio>

#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

struct InfluenceCount {
    std::size_t unweighted = 0, cut = 0;  // vertices
    double largest_cut = 0;               // share of a vertex's weight
};

// Counts a vertex whose weights rig_weld.cpp sorts, cuts and normalises.
void countVertex(std::vector<double> weights, InfluenceCount& count) {
    std::erase_if(weights, [](double w) { return !(w > 0); });
    std::sort(weights.begin(), weights.end(), std::greater<>());
    double sum = 0, kept = 0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
        sum += weights[k];
        if (k < kMaxInfluences) kept += weights[k];
    }
    if (!(sum > kNoWeight))
        ++count.unweighted;
    else if (weights.size() > kMaxInfluences) {
        ++count.cut;
        count.largest_cut = std::max(count.largest_cut, 1 - kept / sum);
    }
}

InfluenceCount countInfluences(const SourcePart& part) {
    std::vector<bool> used(part.positions.size());
    for (const Triangle& t : part.triangles)
        for (const std::uint32_t v : t) used[v] = true;
    InfluenceCount count;
    const auto width = std::ptrdiff_t(part.influences);
    for (std::size_t v = 0; v < used.size(); ++v) {
        const auto first = part.weights.begin() + std::ptrdiff_t(v) * width;
        if (used[v]) countVertex({first, first + width}, count);
    }
    return count;
}

}  // namespace

void sayInfluences(RigSource& source) {
    for (const SourcePart& part : source.parts) {
        if (part.skin < 0) continue;
        const InfluenceCount count = countInfluences(part);
        const std::string file = source.file.string(), &node = source.nodes[std::size_t(part.node)].name;
        const auto vertices = [](std::size_t n) { return std::to_string(n) + (n == 1 ? " vertex" : " vertices"); };
        if (count.unweighted > 0) {
            const std::vector<int>& joints = source.skins[std::size_t(part.skin)].nodes;
            const int root = *std::min_element(joints.begin(), joints.end());
            source.notes.push_back({file, node, vertices(count.unweighted) + " without weights",
                                    "move with '" + source.nodes[std::size_t(root)].name + "'"});
        }
        if (count.cut > 0) {
            char share[32];
            std::snprintf(share, sizeof share, "%.2g", 100 * count.largest_cut);
            source.notes.push_back(
                {file, node, vertices(count.cut) + " with more than " + std::to_string(kMaxInfluences) + " influences",
                 "the smallest are cut, up to " + std::string(share) + "% of a vertex's weight"});
        }
    }
}

}  // namespace penumbra
