// Singular value decomposition of a tabulated BRDF.
//
// Problem: a grid of 32 heights and 64 azimuths has 2048 directions, so the table of f cos_i over both directions has
// 2048 x 2048 entries for each channel.
//
// Naive: decompose the whole table. This takes long, and rounding mixes the vectors of equal singular values, so that
// the terms lose the symmetry of the BRDF.
//
// Here: the symmetry splits the table into independent blocks. For an isotropic BRDF every frequency m of the azimuth
// is a block of 32 x 32, and cos m phi and sin m phi have the same one. For an orthotropic BRDF the parities under the
// two mirrors give four blocks. The terms of all blocks are then merged in the order of their singular values.
//
// See docs/formulas.md, section 3 (reflection product operators).

#include "fit/papers/operators/brdf_terms.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "fit/numerics/truncated_svd.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "sh/quadrature.h"

namespace penumbra {

Vec3d DirectionGrid::direction(std::size_t i) const {
    const double z = heights[i / std::size_t(azimuths)], sine = std::sqrt(1 - z * z);
    const double azimuth = 2 * std::numbers::pi * double(i % std::size_t(azimuths)) / azimuths;
    return {sine * std::cos(azimuth), sine * std::sin(azimuth), z};
}

DirectionGrid gaussGrid(int heights, int azimuths) {
    DirectionGrid grid{{}, {}, azimuths};
    for (const auto& [z, weight] : gaussInterval(heights)) {
        grid.heights.push_back(z);
        grid.weights.push_back(weight * 2 * std::numbers::pi / azimuths);
    }
    return grid;
}

DirectionGrid latitudeGrid(int heights, int azimuths) {
    DirectionGrid grid{{}, {}, azimuths};
    const double step = std::numbers::pi / 2 / heights;
    for (int i = 0; i < heights; ++i) {
        grid.heights.push_back(std::cos((i + 0.5) * step));
        grid.weights.push_back(std::sin((i + 0.5) * step) * step * 2 * std::numbers::pi / azimuths);
    }
    return grid;
}

ChannelFactors channelFactors(const std::vector<double>& values) {
    // 1. Find the largest entry.
    std::size_t largest = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (std::abs(values[i]) > std::abs(values[largest])) largest = i;
    const double top = values[largest];
    ChannelFactors out{int(largest % 3), {1, 0, 0}};
    if (top == 0) return out;
    // 2. Take the ratios of the channels there, and see whether they hold everywhere.
    for (std::size_t c = 0; c < 3; ++c) out.factors[c] = values[largest / 3 * 3 + c] / top;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (std::abs(values[i] - out.factors[i % 3] * values[i / 3 * 3 + largest % 3]) > 1e-12 * std::abs(top))
            return {out.strongest, {}};
    return out;
}

namespace {

// A set of functions t_a of the azimuth that the BRDF maps to themselves. They are orthonormal over the grid's
// azimuths. For a pair of heights only sum over phi_i, phi_o of t_a(phi_i) F t_b(phi_o) remains, and functions of other
// sets give 0. Because of the symmetry the sum over phi_o needs a single azimuth sources[b]: sum over phi_i of
// t_a(phi_i) F(phi_i, sources[b]) / t_b(sources[b]).
struct AzimuthBlock {
    Matrix functions;                  // [p, azimuths]
    std::vector<std::size_t> sources;  // [p] azimuths at which the views are evaluated
    Matrix twin;                       // functions of another set that has the same matrix; may be empty
};

// One set for each frequency m: cos m phi, with sin m phi as its twin.
std::vector<AzimuthBlock> isotropicBlocks(std::size_t azimuths) {
    std::vector<AzimuthBlock> blocks;
    for (std::size_t m = 0; m <= azimuths / 2; ++m) {
        const bool single = m == 0 || m == azimuths / 2;
        AzimuthBlock block{{1, azimuths}, {0}, {single ? 0u : 1u, azimuths}};
        const double scale = std::sqrt((single ? 1.0 : 2.0) / double(azimuths));
        for (std::size_t j = 0; j < azimuths; ++j) {
            const double angle = 2 * std::numbers::pi * double(m * j % azimuths) / double(azimuths);
            block.functions(0, j) = scale * std::cos(angle);
            if (!single) block.twin(0, j) = scale * std::sin(angle);
        }
        blocks.push_back(std::move(block));
    }
    return blocks;
}

// One set for each pair of parities. The azimuths j, -j, n/2 - j and n/2 + j are mirror images, and a function takes
// the signs of its parities there.
std::vector<AzimuthBlock> orthotropicBlocks(std::size_t n) {
    std::vector<AzimuthBlock> blocks;
    for (int sign_x : {1, -1})
        for (int sign_y : {1, -1}) {
            AzimuthBlock block;
            std::vector<double> rows;
            for (std::size_t j = 0; j <= n / 4; ++j) {
                if ((j == 0 && sign_y < 0) || (j == n / 4 && sign_x < 0)) continue;
                const double value = j == 0 || j == n / 4 ? std::sqrt(0.5) : 0.5;
                std::vector<double> row(n);
                row[j] = value;
                row[(n - j) % n] = sign_y * value;
                row[n / 2 - j] = sign_x * value;
                row[(n / 2 + j) % n] = sign_x * sign_y * value;
                rows.insert(rows.end(), row.begin(), row.end());
                block.sources.push_back(j);
            }
            block.functions = Matrix(block.sources.size(), n);
            block.functions.values = std::move(rows);
            blocks.push_back(std::move(block));
        }
    return blocks;
}

// Without a symmetry, one set has all azimuths.
std::vector<AzimuthBlock> blocksOf(BrdfSymmetry symmetry, std::size_t azimuths) {
    if (symmetry == BrdfSymmetry::kIsotropic) return isotropicBlocks(azimuths);
    if (symmetry == BrdfSymmetry::kOrthotropic) return orthotropicBlocks(azimuths);
    AzimuthBlock all{{azimuths, azimuths}, {}, {}};
    for (std::size_t j = 0; j < azimuths; ++j) {
        all.functions(j, j) = 1;
        all.sources.push_back(j);
    }
    return {all};
}

// Tabulates f cos_i for all incident directions and the views of the first `sources` azimuths: [sources, heights,
// directions, 3].
std::vector<double> tabulate(const RgbBrdf& brdf, const DirectionGrid& grid, std::size_t sources, int threads) {
    const std::size_t heights = grid.heights.size(), count = grid.size();
    std::vector<Vec3d> directions(count);
    for (std::size_t i = 0; i < count; ++i) directions[i] = grid.direction(i);
    std::vector<double> table(sources * heights * count * 3);
    parallelFor(sources * heights, threads, [&](std::size_t view) {
        throwIfInterrupted();
        const Vec3d wo = directions[view % heights * std::size_t(grid.azimuths) + view / heights];
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3d f = brdf.eval(directions[i], wo);
            for (int c = 0; c < 3; ++c) table[(view * count + i) * 3 + std::size_t(c)] = f[c] * directions[i].z;
        }
    });
    return table;
}

// The square roots of the measures of one direction at each height.
struct Roots {
    std::vector<double> incident, view;
};

Roots rootsOf(const DirectionGrid& grid, ViewMeasure measure) {
    Roots roots;
    for (std::size_t h = 0; h < grid.heights.size(); ++h) {
        const double weight = measure == ViewMeasure::kNone ? 1 : grid.weights[h];
        roots.incident.push_back(std::sqrt(weight));
        roots.view.push_back(std::sqrt(measure == ViewMeasure::kCosine ? weight * grid.heights[h] : weight));
    }
    return roots;
}

// Returns the matrix of one set of functions: rows are (height of wi, a), columns are (height of wo, b).
Matrix blockMatrix(const AzimuthBlock& block, const std::vector<double>& table, std::size_t channel,
                   const DirectionGrid& grid, const Roots& roots) {
    const std::size_t p = block.sources.size(), heights = grid.heights.size(), n = std::size_t(grid.azimuths);
    std::vector<std::vector<std::pair<std::size_t, double>>> terms(p);
    for (std::size_t a = 0; a < p; ++a)
        for (std::size_t j = 0; j < n; ++j)
            if (block.functions(a, j) != 0) terms[a].emplace_back(j, block.functions(a, j));
    Matrix matrix(heights * p, heights * p);
    for (std::size_t ho = 0; ho < heights; ++ho)
        for (std::size_t b = 0; b < p; ++b) {
            const double* f = table.data() + (block.sources[b] * heights + ho) * heights * n * 3 + channel;
            const double scale = roots.view[ho] / block.functions(b, block.sources[b]);
            for (std::size_t hi = 0; hi < heights; ++hi)
                for (std::size_t a = 0; a < p; ++a) {
                    double sum = 0;
                    for (const auto& [j, value] : terms[a]) sum += value * f[(hi * n + j) * 3];
                    matrix(hi * p + a, ho * p + b) = roots.incident[hi] * scale * sum;
                }
        }
    return matrix;
}

// Adds a vector over (height, a) to `out` as values on the grid. Each height is divided by its root.
void expand(std::span<const double> vector, const Matrix& functions, const std::vector<double>& roots, double factor,
            std::span<double> out) {
    const std::size_t p = functions.rows, n = functions.columns;
    for (std::size_t h = 0; h < roots.size(); ++h)
        for (std::size_t a = 0; a < p; ++a)
            for (std::size_t j = 0; j < n; ++j)
                out[h * n + j] += vector[h * p + a] * functions(a, j) * factor / roots[h];
}

// A term before merging: its singular value and the block that it comes from.
struct TermRef {
    double sigma;
    std::size_t block, index;
    bool twin;
};

// Merges the terms of all sets in descending order of sigma and keeps the first `count`.
BrdfTerms mergedTerms(const std::vector<AzimuthBlock>& blocks, std::span<const TruncatedSvd> parts,
                      const DirectionGrid& grid, const Roots& roots, std::size_t count) {
    std::vector<TermRef> refs;
    for (std::size_t block = 0; block < parts.size(); ++block)
        for (std::size_t i = 0; i < parts[block].sigma.size(); ++i)
            for (bool twin : {false, true})
                if (!twin || blocks[block].twin.rows > 0) refs.push_back({parts[block].sigma[i], block, i, twin});
    std::stable_sort(refs.begin(), refs.end(), [](const TermRef& a, const TermRef& b) { return a.sigma > b.sigma; });
    refs.resize(std::min(refs.size(), count));
    BrdfTerms terms{{}, {refs.size(), grid.size()}, {refs.size(), grid.size()}};
    for (std::size_t b = 0; b < refs.size(); ++b) {
        const auto& [sigma, block, index, twin] = refs[b];
        const Matrix& functions = twin ? blocks[block].twin : blocks[block].functions;
        terms.sigma.push_back(sigma);
        expand(parts[block].u.row(index), functions, roots.incident, sigma, terms.u.row(b));
        expand(parts[block].v.row(index), functions, roots.view, 1, terms.w.row(b));
    }
    return terms;
}

}  // namespace

std::vector<BrdfTerms> brdfTerms(const RgbBrdf& brdf, const DirectionGrid& grid, ViewMeasure measure, int count,
                                 int threads) {
    // 1. Split the azimuths by the symmetry, and tabulate the views that this needs.
    assert(grid.azimuths % 4 == 0);
    const std::vector<AzimuthBlock> blocks = blocksOf(brdf.symmetry, std::size_t(grid.azimuths));
    std::size_t sources = 0;
    for (const AzimuthBlock& block : blocks)
        for (std::size_t source : block.sources) sources = std::max(sources, source + 1);
    const std::vector<double> table = tabulate(brdf, grid, sources, threads);
    // 2. Channels that differ by a factor need one decomposition.
    const ChannelFactors same = channelFactors(table);
    const std::vector<std::size_t> channels = same.factors.empty()
                                                  ? std::vector<std::size_t>{0, 1, 2}
                                                  : std::vector<std::size_t>{std::size_t(same.strongest)};
    const Roots roots = rootsOf(grid, measure);
    // 3. Decompose every set of functions in every channel.
    std::vector<TruncatedSvd> parts(channels.size() * blocks.size());
    parallelFor(parts.size(), threads, [&](std::size_t i) {
        const AzimuthBlock& block = blocks[i % blocks.size()];
        parts[i] =
            truncatedSvd(blockMatrix(block, table, channels[i / blocks.size()], grid, roots), std::size_t(count));
    });
    // 4. Merge the sets, and apply the factors of the channels.
    std::vector<BrdfTerms> terms;
    for (std::size_t c = 0; c < channels.size(); ++c)
        terms.push_back(mergedTerms(blocks, std::span(parts).subspan(c * blocks.size(), blocks.size()), grid, roots,
                                    std::size_t(count)));
    if (same.factors.empty()) return terms;
    terms.resize(3, terms[0]);
    for (std::size_t c = 0; c < 3; ++c) {
        for (double& sigma : terms[c].sigma) sigma *= same.factors[c];
        for (double& u : terms[c].u.values) u *= same.factors[c];
    }
    return terms;
}

}  // namespace penumbra
