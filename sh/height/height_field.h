#pragma once
// A height field: heights on a grid of points, between which they are bilinear, and the pyramid of their maxima.
//
// Its own frame has z up, x along the rows' numbers and y along the columns'. Places on the grid are in texels: (r, c)
// is the point of row r and column c.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// What lies beyond the last points.
enum class HeightBorder : std::uint8_t {
    kClamped,   // the heights of the edge, for ever
    kPeriodic,  // the field again: column `columns` is column 0
    kOpen,      // nothing, which hides nothing; from the edge one sees below the horizontal
};

constexpr int kMaxHeightSide = 65536;                                     // points
constexpr std::size_t kMaxHeightTexels = std::size_t(1) << 26;            // points
constexpr float kMaxElevation = 1e7f, kMinCell = 1e-4f, kMaxCell = 1e5f;  // |metres|, metres, metres

struct HeightGrid {
    int rows = 0, columns = 0;
    float cell_x = 1, cell_y = 1;  // metres from row to row, from column to column
    HeightBorder border = HeightBorder::kClamped;

    std::size_t size() const { return std::size_t(rows) * std::size_t(columns); }
    bool operator==(const HeightGrid&) const = default;
};
// Returns "" for a grid that can be used, else one sentence with the field, its range and its value.
std::string findProblem(const HeightGrid& grid);

// Points of rows [first_row, end_row) and columns [first_column, end_column).
struct TexelBox {
    int first_row = 0, first_column = 0, end_row = 0, end_column = 0;
    bool empty() const { return first_row >= end_row || first_column >= end_column; }
    bool operator==(const TexelBox&) const = default;
};
// Makes a box large enough for another one, too.
void include(TexelBox& box, const TexelBox& other);

// Level l has the largest of 2^l x 2^l heights at a point. Level 0 has the heights.
struct HeightLevel {
    int rows = 0, columns = 0;
    std::size_t first = 0;  // of its heights among those of all levels
};

class HeightField {
public:
    // The grid has no problem. Heights are finite and at most kMaxElevation; [rows, columns].
    HeightField(const HeightGrid& grid, std::span<const float> heights);

    const HeightGrid& grid() const { return grid_; }
    std::span<const float> heights() const { return std::span(all_heights_).first(grid_.size()); }
    std::span<const HeightLevel> levels() const { return levels_; }
    const float* allHeights() const { return all_heights_.data(); }  // of all levels

    // Replaces the heights of a box, which lies in the grid, [its rows, its columns], and the maxima above it. Returns
    // for each level the box of what became another number. Allocates nothing.
    std::span<const TexelBox> set(const TexelBox& box, std::span<const float> heights);
    std::span<const TexelBox> set(std::span<const float> heights) {
        return set({0, 0, grid_.rows, grid_.columns}, heights);
    }

    // Bilinear, at any place; beyond an open border as beyond a clamped one.
    float at(float row, float column) const;
    // The same on the two triangles of each square as a ground is drawn and ray-traced: one has the corner (r, c), the
    // other (r + 1, c + 1), and between them is the line from (r + 1, c) to (r, c + 1).
    double onTriangles(double row, double column) const;
    // (dz/dx, dz/dy, 1) made unit, by central differences.
    Vec3 normal(int row, int column) const;

private:
    HeightGrid grid_;
    std::vector<HeightLevel> levels_;
    std::vector<float> all_heights_;
    std::vector<TexelBox> changed_;  // [levels]

    float height(int row, int column) const {
        return all_heights_[std::size_t(row) * std::size_t(grid_.columns) + std::size_t(column)];
    }
    int neighbour(int at, int step, int count) const;
};

}  // namespace penumbra
