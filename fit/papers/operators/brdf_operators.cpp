// Fits reflection product operators to a material.
//
// Problem: write the cosine-weighted BRDF as a sum of k products of a function of the light's direction and a function
// of the view, f cos_i ~= sum_b U^b(wi) W^b(wo), with both sides in SH.
//
// Naive: tabulate f on equal steps of both directions, take the SVD of the table and project its vectors. That is the
// paper as printed (termsAsPrinted). The poles of the table count too much, grazing spikes rule the result, and the
// projection of W takes it for zero below the horizon; a Lambertian alone then has an error of 13.6%.
//
// Here: weigh the table by solid angle and cosine, and project W by least squares on even functions (termsOfTable); or,
// by default, decompose the slices C that are fitted already. Whitening C by the Gram matrix of the view functions
// turns the SVD of a 25 x 15 matrix into that of the function itself (termsOfSlices).
//
// Derivation and errors: docs/formulas.md, section 3.

#include "fit/papers/operators/brdf_operators.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/eigen_map.h"
#include "fit/numerics/truncated_svd.h"
#include "fit/papers/operators/brdf_terms.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"

namespace penumbra {

namespace {

// The terms of one channel as SH coefficients.
struct ProjectedTerms {
    std::vector<double> sigma;
    Matrix u, w;  // [k, order^2] with sigma, and [k, view functions]
};

// Returns the number of terms nearest to `count` that does not cut a run of equal singular values; which of the run's
// vectors were kept would otherwise depend on the SVD routine. When k + 1 and k - 1 are both possible, it returns the
// larger. It is at most the rank and kMaxOperators.
std::size_t cutAtGap(const std::vector<double>& sigma, std::size_t count) {
    constexpr double kRank = 1e-9, kEqual = 1e-6;
    std::size_t rank = 0;
    while (rank < sigma.size() && sigma[rank] > kRank * sigma[0]) ++rank;
    if (count >= rank) return std::min<std::size_t>(rank, kMaxOperators);
    for (std::size_t step = 0; step < sigma.size(); ++step)
        for (std::size_t k : {count + step, count - std::min(step, count)})
            if (k > 0 && k <= std::min<std::size_t>(rank, kMaxOperators) &&
                (k == sigma.size() || sigma[k] < sigma[k - 1] * (1 - kEqual)))
                return k;
    return count;
}

// Returns the integrals of values y_i over the hemisphere, for each row of `values` and each i in `index`.
Matrix projected(const Matrix& values, const DirectionGrid& grid, const std::vector<int>& index) {
    Matrix out(values.rows, index.size());
    std::array<double, coefficientCount(kMaxOrder)> y;
    for (std::size_t q = 0; q < grid.size(); ++q) {
        evalBasis(kMaxOrder, grid.direction(q), y);
        for (std::size_t b = 0; b < values.rows; ++b)
            for (std::size_t i = 0; i < index.size(); ++i)
                out(b, i) += grid.weight(q) * values(b, q) * y[std::size_t(index[i])];
    }
    return out;
}

std::vector<int> allIndices(int order) {
    std::vector<int> index(std::size_t(coefficientCount(order)));
    for (std::size_t i = 0; i < index.size(); ++i) index[i] = int(i);
    return index;
}

// Returns G = integral over the hemisphere of z y y^T for the view functions. The quadrature is exact.
Eigen::MatrixXd cosineGram(const std::vector<int>& even_index) {
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(Eigen::Index(even_index.size()), Eigen::Index(even_index.size()));
    std::array<double, coefficientCount(kMaxOrder)> y;
    Eigen::VectorXd even(gram.rows());
    for (const auto& [direction, weight] : gaussHemisphere(kMaxOrder + 1, 2 * kMaxOrder + 2)) {
        evalBasis(kMaxOrder, direction, y);
        for (Eigen::Index e = 0; e < even.size(); ++e) even[e] = y[std::size_t(even_index[std::size_t(e)])];
        gram += weight * direction.z * even * even.transpose();
    }
    return gram;
}

// Returns terms by the SVD of a table. w y_even is the best fit to W in the measure of the SVD: it solves sum over e of
// G_de w_e = integral over H of z W y_d. It is even across the horizon.
std::vector<ProjectedTerms> termsOfTable(const RgbBrdf& source, const std::vector<int>& even_index, int threads) {
    const DirectionGrid grid = gaussGrid(32, 64);
    const Eigen::MatrixXd gram = cosineGram(even_index);
    std::vector<ProjectedTerms> out;
    for (BrdfTerms& terms : brdfTerms(source, grid, ViewMeasure::kCosine, kMaxOperators + 1, threads)) {
        // The cosine belongs to the measure of the least squares problem.
        for (std::size_t i = 0; i < terms.w.values.size(); ++i) terms.w.values[i] *= grid.direction(i % grid.size()).z;
        Matrix w = projected(terms.w, grid, even_index);
        Eigen::MatrixXd columns = asEigen(w).transpose();
        solvePositive(gram, columns, columns);
        asEigen(w) = columns.transpose();
        out.push_back({terms.sigma, projected(terms.u, grid, allIndices(kMaxOrder)), std::move(w)});
    }
    return out;
}

constexpr int kLiteralOrder = 4;

// Returns terms as the paper prints them.
std::vector<ProjectedTerms> termsAsPrinted(const RgbBrdf& source, int threads) {
    const DirectionGrid grid = latitudeGrid(16, 32);
    const std::vector<int> index = allIndices(kLiteralOrder);
    std::vector<ProjectedTerms> out;
    for (const BrdfTerms& terms : brdfTerms(source, grid, ViewMeasure::kNone, kMaxOperators + 1, threads))
        out.push_back({terms.sigma, projected(terms.u, grid, index), projected(terms.w, grid, index)});
    return out;
}

// Returns terms from the slices: C = (C L) L^-1 with G = L L^T. The functions L^-1 y_even are orthonormal in the cosine
// measure, so the SVD of C L is that of the function F(o) itself: u' sigma (v'^T L^-1) y_even.
std::vector<ProjectedTerms> termsOfSlices(const BrdfFile& brdf) {
    const Eigen::MatrixXd gram = cosineGram(brdf.even_index);
    const Eigen::MatrixXd l = choleskyFactor(gram);
    const std::size_t rows = std::size_t(coefficientCount(brdf.slice_order)), columns = brdf.even_index.size();
    // 1. Channels that are multiples of one another share one decomposition.
    const ChannelFactors same = channelFactors(brdf.slices);
    std::vector<ProjectedTerms> out;
    for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t channel = same.factors.empty() ? c : std::size_t(same.strongest);
        const double factor = same.factors.empty() ? 1 : same.factors[c];
        // 2. Whiten: C L.
        Matrix whitened(rows, columns);
        for (std::size_t i = 0; i < rows; ++i)
            for (std::size_t e = 0; e < columns; ++e)
                for (std::size_t d = 0; d < columns; ++d)
                    whitened(i, e) +=
                        brdf.slices[(i * columns + d) * 3 + channel] * l(Eigen::Index(d), Eigen::Index(e));
        // 3. Decompose. u takes the singular values, and w = L^-T v' undoes the whitening.
        TruncatedSvd svd = truncatedSvd(whitened, kMaxOperators + 1);
        ProjectedTerms terms{svd.sigma, svd.u, Matrix(svd.v.rows, columns)};
        for (std::size_t b = 0; b < svd.sigma.size(); ++b)
            for (double& u : terms.u.row(b)) u *= svd.sigma[b] * factor;
        asEigen(terms.w) = solveTransposedLower(l, asEigen(svd.v).transpose()).transpose();
        for (double& sigma : terms.sigma) sigma *= factor;
        out.push_back(std::move(terms));
    }
    return out;
}

// Cuts every channel at a gap and stores the terms. A channel with fewer terms than the others is filled up with zeros.
BrdfOperators assembled(const std::vector<ProjectedTerms>& channels, std::size_t asked,
                        const std::vector<int>& view_index, OperatorSource from) {
    std::array<std::size_t, 3> kept{};
    for (std::size_t c = 0; c < 3; ++c)
        if (channels[c].sigma[0] > 0) kept[c] = cutAtGap(channels[c].sigma, asked);
    BrdfOperators out;
    const std::size_t k = std::max<std::size_t>(1, *std::max_element(kept.begin(), kept.end()));
    const std::size_t rows = channels[0].u.columns, columns = view_index.size();
    out.count = int(k);
    out.order = bandOfIndex(int(rows) - 1) + 1;
    out.source = nameOf(from);
    out.view_index = view_index;
    out.u.resize(k * rows * 3);
    out.w.resize(k * columns * 3);
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t b = 0; b < k; ++b) {
            for (std::size_t i = 0; i < rows && b < kept[c]; ++i) out.u[(b * rows + i) * 3 + c] = channels[c].u(b, i);
            for (std::size_t e = 0; e < columns && b < channels[c].w.rows; ++e)
                out.w[(b * columns + e) * 3 + c] = channels[c].w(b, e);
        }
    return out;
}

}  // namespace

BrdfOperators fitOperators(const RgbBrdf& source, const BrdfFile& brdf, OperatorSource from, int count, int threads) {
    assert(count >= 1 && count <= kMaxOperators);
    std::vector<ProjectedTerms> terms;
    if (from == OperatorSource::kSlices) terms = termsOfSlices(brdf);
    if (from == OperatorSource::kTable) terms = termsOfTable(source, brdf.even_index, threads);
    if (from == OperatorSource::kLiteral) terms = termsAsPrinted(source, threads);
    const std::vector<int> index = from == OperatorSource::kLiteral ? allIndices(kLiteralOrder) : brdf.even_index;
    return assembled(terms, std::size_t(count), index, from);
}

std::size_t expandedBytes(const BrdfOperators& operators, int light_order, const Convention& convention) {
    const std::size_t matrix = std::size_t(coefficientCount(light_order) * convention.size());
    return 3 * std::size_t(operators.count) * (matrix + operators.view_index.size()) * sizeof(float);
}

namespace {

// Returns operators in the form of slices, c[i, e, channel] = sum_b u^b_i w^b_e, for any view functions.
std::vector<double> slicesOf(const BrdfOperators& operators) {
    const std::size_t rows = std::size_t(coefficientCount(operators.order)), columns = operators.view_index.size();
    std::vector<double> c(rows * columns * 3);
    for (std::size_t b = 0; b < std::size_t(operators.count); ++b)
        for (std::size_t i = 0; i < rows; ++i)
            for (std::size_t e = 0; e < columns; ++e)
                for (std::size_t channel = 0; channel < 3; ++channel)
                    c[(i * columns + e) * 3 + channel] +=
                        operators.u[(b * rows + i) * 3 + channel] * operators.w[(b * columns + e) * 3 + channel];
    return c;
}

}  // namespace

void measureOperators(const ShadingTruth& truth, BrdfFile& brdf) {
    const BrdfOperators& operators = brdf.operators;
    const std::vector<double> sums = slicesOfViews(truth.test.scenes.views, slicesOf(operators), operators.view_index);
    brdf.errors["shading_operators"] = shadingError(truth, {BelowHorizon::kOpen, 4}, sums, operators.order);
    brdf.errors["shading_operators_d5"] = shadingError(truth, {BelowHorizon::kMirrored, 5}, sums, operators.order);
}

}  // namespace penumbra
