#include "sh/quadrature.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace penumbra {

namespace {
struct Node {
    double z, weight;
};

// Returns nodes and weights of Gauss-Legendre quadrature on (-1, 1), ascending. Newton's method on P_n starts from
// Tricomi's guess.
std::vector<Node> gaussLegendre(int n) {
    assert(n > 0);
    std::vector<Node> nodes(n);
    for (int i = 0; i < n; ++i) {
        double z = -std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), derivative = 1;
        for (int step = 0; step < 8; ++step) {
            double before = 0, p = 1;
            // Evaluate P_n and P_(n-1) by recurrence.
            for (int l = 1; l <= n; ++l) {
                const double next = ((2 * l - 1) * z * p - (l - 1) * before) / l;
                before = p;
                p = next;
            }
            derivative = n * (before - z * p) / (1 - z * z);
            z -= p / derivative;
        }
        nodes[i] = {z, 2 / ((1 - z * z) * derivative * derivative)};
    }
    return nodes;
}

std::vector<WeightedDirection> productGrid(const std::vector<Node>& nodes, int n_phi) {
    assert(n_phi > 0);
    std::vector<WeightedDirection> grid;
    grid.reserve(nodes.size() * n_phi);
    for (const Node& node : nodes) {
        const double sine = std::sqrt(1 - node.z * node.z);
        for (int j = 0; j < n_phi; ++j) {
            const double phi = 2 * std::numbers::pi * j / n_phi;
            grid.push_back(
                {{sine * std::cos(phi), sine * std::sin(phi), node.z}, node.weight * 2 * std::numbers::pi / n_phi});
        }
    }
    return grid;
}

}  // namespace

std::vector<WeightedNumber> gaussInterval(int n) {
    std::vector<WeightedNumber> nodes;
    for (const Node& node : gaussLegendre(n)) nodes.push_back({(node.z + 1) / 2, node.weight / 2});
    return nodes;
}

std::vector<WeightedDirection> gaussSphere(int n_z, int n_phi) { return productGrid(gaussLegendre(n_z), n_phi); }

std::vector<WeightedDirection> gaussHemisphere(int n_z, int n_phi) {
    std::vector<Node> nodes = gaussLegendre(n_z);
    for (Node& node : nodes) node = {(node.z + 1) / 2, node.weight / 2};
    return productGrid(nodes, n_phi);
}

std::vector<Vec3d> fibonacciSphere(int n) {
    assert(n > 0);
    const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
    std::vector<Vec3d> directions(n);
    for (int i = 0; i < n; ++i) {
        const double z = 1 - (2.0 * i + 1) / n, sine = std::sqrt(1 - z * z), phi = i * golden_angle;
        directions[i] = {sine * std::cos(phi), sine * std::sin(phi), z};
    }
    return directions;
}

namespace {

// Moves bit i of x to bit 2 i.
std::uint32_t spreadBits(std::uint32_t x) {
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

// Maps the sphere onto the square [0, 65535]^2 by the octahedral map, and interleaves the bits of the two coordinates.
std::uint32_t mortonCode(Vec3d d) {
    const double sum = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
    double u = d.x / sum, v = d.y / sum;
    if (d.z < 0) {
        const double folded = (1 - std::abs(v)) * (u < 0 ? -1 : 1);
        v = (1 - std::abs(u)) * (v < 0 ? -1 : 1);
        u = folded;
    }
    const auto quantised = [](double t) { return std::uint32_t(std::clamp((t + 1) * 32768, 0.0, 65535.0)); };
    return spreadBits(quantised(u)) | spreadBits(quantised(v)) << 1;
}

}  // namespace

std::vector<Vec3d> mortonSorted(std::vector<Vec3d> directions) {
    std::stable_sort(directions.begin(), directions.end(),
                     [](Vec3d a, Vec3d b) { return mortonCode(a) < mortonCode(b); });
    return directions;
}

}  // namespace penumbra
