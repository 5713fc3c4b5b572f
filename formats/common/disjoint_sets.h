#pragma once
// Union-find (Tarjan 1975): numbers that are joined to groups, step by step.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace penumbra {

// The least number of a group is its name.
class DisjointSets {
public:
    explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
    // Returns the name of the group of i, and shortens the way to it.
    std::uint32_t of(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = of(a), b = of(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }
    // Returns the name of every number's group.
    std::vector<std::uint32_t> names() {
        for (std::uint32_t i = 0; i < parent_.size(); ++i) parent_[i] = of(i);
        return parent_;
    }

private:
    std::vector<std::uint32_t> parent_;
};

// Returns for each vertex the least vertex that edges of triangles (three vertices each) lead to.
template <class Triangles>
std::vector<std::uint32_t> connectedParts(const Triangles& triangles, std::size_t vertices) {
    DisjointSets parts(vertices);
    for (const auto& t : triangles)
        for (std::size_t k = 1; k < 3; ++k) parts.join(t[0], t[k]);
    return parts.names();
}

}  // namespace penumbra
