#pragma once
// Turns the visibility of one vertex in all frames into zonal lobes, and lobes back into visibility (Nowrouzezahrai
// 2008, section 3.1 and equation 1).
#include <array>
#include <span>
#include <vector>

#include "fit/numerics/matrix.h"
#include "sh/vec3.h"

namespace penumbra {

// The direction of a lobe as two numbers that are continuous near the axis a of the vertex' mean: the point of the
// tangent plane at a that is as far from it as the direction is, in radians.
struct LobeChart {
    Vec3d axis, x, y;

    explicit LobeChart(Vec3 a);
    std::array<double, 2> of(Vec3d direction) const;
    Vec3d at(double u, double v) const;
};

// The lobes of one vertex in all frames. A lobe is 2 + order numbers: its place in the chart, then z_l.
struct VertexLobes {
    std::vector<Vec3> axes;         // [C] of the charts
    Matrix values;                  // [F, C (2 + order)]
    double error = 0, squares = 0;  // sums of squares of what the lobes leave, and of the visibility
};

struct LobeProblem {
    int order = 4, lobes = 2;
    double ridge = 0;                    // weight of the squared distance of coefficients from those of the mean
    std::span<const std::size_t> train;  // frames that the mean is of
    std::size_t coefficients() const { return std::size_t(order) * std::size_t(order); }
    std::size_t valuesOfVertex() const { return std::size_t(lobes) * (2 + std::size_t(order)); }
};

// Fits the lobes of a vertex jointly. In every frame they start from those of its mean over training frames, and their
// coefficients are held near those of the mean, so that they follow the pose without jumps where they can. `visibility`
// has the numbers of convention B of several vertices, [F, V order^2].
VertexLobes fitVertexLobes(const LobeProblem& problem, const MatrixF& visibility, std::size_t vertex);

// Writes the SH that the numbers of a vertex' lobes, [C (2 + order)], stand for. out.size() == order^2.
void lobesToVisibility(int order, std::span<const Vec3> axes, std::span<const double> values, std::span<double> out);

}  // namespace penumbra
