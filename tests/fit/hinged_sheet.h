#pragma once
// A deforming mesh made of rigid strips with hinges between them. Segmentation has to find the strips.
#include <cmath>
#include <random>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra::synthetic {

struct HingedSheet {
    Mesh mesh;  // in the plane z = 0, x from 0 to 1, y from 0 to rows / 36
    std::vector<std::uint16_t> strip_of_triangle;
    std::vector<Vec3> positions;  // [F, V]
    std::size_t frames = 0;
};

// Makes a sheet with hinges at the columns 6, 16 and 26 of 36. Strips 0 and 2 always turn alike, and strips 1 and 3
// each turn in their own way. `noise` is the standard deviation of every coordinate in edge lengths.
inline HingedSheet hingedSheet(std::size_t frames, double noise, std::size_t rows = 22) {
    constexpr std::size_t kColumns = 36;
    constexpr std::size_t kHinges[] = {6, 16, 26};
    constexpr float kEdge = 1.0f / kColumns;
    const auto stripOf = [&](std::size_t column) {
        return std::uint16_t((column >= kHinges[0]) + (column >= kHinges[1]) + (column >= kHinges[2]));
    };
    HingedSheet sheet;
    sheet.frames = frames;
    for (std::size_t y = 0; y <= rows; ++y)
        for (std::size_t x = 0; x <= kColumns; ++x) {
            sheet.mesh.rest_positions.push_back({kEdge * float(x), kEdge * float(y), 0});
            sheet.mesh.source_vertex.push_back(std::uint32_t(sheet.mesh.source_vertex.size()));
        }
    const auto at = [&](std::size_t x, std::size_t y) { return std::uint32_t(y * (kColumns + 1) + x); };
    for (std::size_t y = 0; y < rows; ++y)
        for (std::size_t x = 0; x < kColumns; ++x) {
            sheet.mesh.triangles.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
            sheet.mesh.triangles.push_back({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
            sheet.strip_of_triangle.insert(sheet.strip_of_triangle.end(), 2, stripOf(x));
        }
    std::mt19937 random{7};
    std::normal_distribution<double> normal;
    for (std::size_t f = 0; f < frames; ++f) {
        const double t = double(f);
        const double own = 0.4 * std::sin(0.11 * t);
        const double angle[] = {own, own + 0.9 * std::sin(0.31 * t), own, own - 0.7 * std::sin(0.23 * t + 0.5)};
        std::vector<Vec3> profile(kColumns + 1);  // positions of the row y = 0
        for (std::size_t x = 1; x <= kColumns; ++x) {
            const double a = angle[stripOf(x - 1)];
            profile[x] = profile[x - 1] + Vec3{kEdge * float(std::cos(a)), 0, kEdge * float(std::sin(a))};
        }
        for (std::size_t y = 0; y <= rows; ++y)
            for (std::size_t x = 0; x <= kColumns; ++x) {
                Vec3 p = profile[x] + Vec3{0, kEdge * float(y), 0};
                for (int i = 0; i < 3; ++i) p[i] += float(noise * kEdge * normal(random));
                sheet.positions.push_back(p);
            }
    }
    return sheet;
}

}  // namespace penumbra::synthetic
