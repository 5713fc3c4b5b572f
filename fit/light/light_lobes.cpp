// Fits zonal lobes to the SH of a light.
//
// Problem: find directions s_d and coefficients z_dl, for every band l and channel, so that l_lm = sum_d
// sqrt(4pi/(2l+1)) z_dl y_lm(s_d) is as near as possible to the light.
//
// Naive: minimise over directions and coefficients together. There are 3 n coefficients for each lobe and only two
// numbers for its direction, and the objective has many minima.
//
// Here: for given directions, every band and channel is a least squares problem of its own, which solveMinNorm() solves
// exactly (band 0 has rank 1, because all lobes share it), or a regularised one. So only directions are searched. At
// the best coefficients their derivative is zero, so the gradient by the directions needs no derivative of the solution
// (variable projection, Golub and Pereyra 1973). Many starts take care of the minima.
//
// Derivation: docs/formulas.md, section 6.

#include "fit/light/light_lobes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/matrix.h"
#include "fit/numerics/minimise_directions.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "sh/zonal.h"

namespace penumbra {

namespace {

constexpr int kCandidates = 1500;  // Nowrouzezahrai 2009 section 5.4
// Weight of |z|^2 against the square of the light. Without it two lobes could move into one direction with opposite
// coefficients that grow without bound, and act like a lobe and its derivative. With it, coefficients stay below some
// 100 times the light's norm, which floats can hold. It is used while directions are searched; the coefficients of the
// final directions are solved without it.
constexpr double kRidge = 1e-8;

using Basis = std::array<double, coefficientCount(kMaxOrder)>;
using Eigen::Index;

// The bands of a light, scaled to a norm of 1 (or 0 for a black light).
struct Bands {
    int order = 0;
    double scale = 0;                       // norm before scaling
    std::array<SmallMatrix, kMaxOrder> of;  // [2l+1, 3]
};

Bands bandsOf(int order, std::span<const double> sh) {
    Bands bands;
    bands.order = order;
    bands.scale = std::sqrt(std::inner_product(sh.begin(), sh.end(), sh.begin(), 0.0));
    for (int l = 0; l < order; ++l) {
        SmallMatrix& band = bands.of[std::size_t(l)];
        band.resize(2 * l + 1, 3);
        for (Index i = 0; i < band.rows(); ++i)
            for (Index c = 0; c < 3; ++c)
                band(i, c) = bands.scale > 0 ? sh[std::size_t(3 * (l * l + i) + c)] / bands.scale : 0;
    }
    return bands;
}

// Returns y_lm(s) sqrt(4pi/(2l+1)), which is a unit vector in every band.
Basis unitBasis(int order, Vec3d s) {
    Basis y{};
    evalBasis(order, s, std::span(y).first(std::size_t(coefficientCount(order))));
    for (int l = 0; l < order; ++l)
        for (int m = -l; m <= l; ++m) y[std::size_t(shIndex(l, m))] *= std::sqrt(4 * std::numbers::pi / (2 * l + 1));
    return y;
}

// Returns the derivative of unitBasis() along the great circle from s towards the unit tangent t. Along that circle the
// basis is a trigonometric polynomial of degree < 8, and the fourth-order central difference with this step is right to
// 1e-11.
Basis slopeOfBasis(int order, Vec3d s, Vec3d t) {
    constexpr double h = 3e-4;
    const auto at = [&](double a) { return unitBasis(order, s * std::cos(a) + t * std::sin(a)); };
    const Basis p1 = at(h), m1 = at(-h), p2 = at(2 * h), m2 = at(-2 * h);
    Basis slope{};
    for (std::size_t i = 0; i < slope.size(); ++i) slope[i] = (8 * (p1[i] - m1[i]) - (p2[i] - m2[i])) / (12 * h);
    return slope;
}

// Returns band l of every lobe's basis as the columns of a matrix.
SmallMatrix columnsOf(int l, std::span<const Basis> bases) {
    SmallMatrix columns(2 * l + 1, Index(bases.size()));
    for (Index d = 0; d < columns.cols(); ++d)
        std::copy_n(bases[std::size_t(d)].begin() + l * l, columns.rows(), columns.col(d).begin());
    return columns;
}

std::vector<Basis> basesOf(int order, std::span<const Vec3d> directions) {
    std::vector<Basis> bases;
    for (Vec3d s : directions) bases.push_back(unitBasis(order, s));
    return bases;
}

// Ridge term of the lobe search: weight times squared distance from `towards`, per band. Bands are scaled. Empty
// matrices stand for zeros.
struct RidgeTo {
    double weight = 0;
    std::array<SmallMatrix, kMaxOrder> towards{};  // [D, 3]
};

// Solves for the coefficients of a band: the smallest |columns x - band|^2 + weight |x - towards|^2.
SmallMatrix solveBand(const SmallMatrix& columns, const SmallMatrix& band, int l, const RidgeTo& ridge) {
    if (ridge.weight == 0) return solveMinNorm(columns, band);
    const SmallMatrix& towards = ridge.towards[std::size_t(l)];
    SmallMatrix normal = columns.transpose() * columns, right = columns.transpose() * band;
    normal.diagonal().array() += ridge.weight;
    if (towards.size() > 0) right += ridge.weight * towards;
    return normal.llt().solve(right);
}

// Returns what is left, squared, when every band has its best coefficients, plus the ridge. Because these are best,
// only the moving columns count in the gradient: d|R|^2 = -2 <R, dA X>. `gradient` may be empty.
double residualOf(const Bands& bands, std::span<const Vec3d> directions, std::span<Vec3d> gradient,
                  const RidgeTo& ridge) {
    const std::vector<Basis> bases = basesOf(bands.order, directions);
    std::vector<Basis> pull(directions.size(), Basis{});  // -2 R X^T
    double sum = 0;
    for (int l = 1; l < bands.order; ++l) {  // band 0 is left out: any lobe has all of it
        // 1. Solve for the coefficients of the band.
        const SmallMatrix columns = columnsOf(l, bases);
        const SmallMatrix x = solveBand(columns, bands.of[std::size_t(l)], l, ridge);
        const SmallMatrix left = bands.of[std::size_t(l)] - columns * x, &towards = ridge.towards[std::size_t(l)];
        // 2. Sum what is left, and take the pull -2 R X^T on every lobe's column.
        sum += left.squaredNorm() + ridge.weight * (towards.size() == 0 ? x : x - towards).squaredNorm();
        const SmallMatrix of_band = -2 * left * x.transpose();
        for (Index d = 0; d < of_band.cols(); ++d)
            std::copy_n(of_band.col(d).begin(), of_band.rows(), pull[std::size_t(d)].begin() + l * l);
    }
    // 3. Take the pull along two tangents of every direction.
    for (std::size_t d = 0; d < gradient.size(); ++d) {
        const Vec3d s = directions[d], a = normalized(cross(s, std::abs(s.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})),
                    b = cross(s, a);
        const Basis along_a = slopeOfBasis(bands.order, s, a), along_b = slopeOfBasis(bands.order, s, b);
        gradient[d] = std::inner_product(pull[d].begin(), pull[d].end(), along_a.begin(), 0.0) * a +
                      std::inner_product(pull[d].begin(), pull[d].end(), along_b.begin(), 0.0) * b;
    }
    return sum;
}

// Returns the candidate that takes most away: it maximises the sum over bands and channels of (y_l(s) . band)^2.
Vec3d bestCandidate(const Bands& bands, std::span<const Vec3d> candidates) {
    double best = -1;
    Vec3d direction;
    for (Vec3d s : candidates) {
        const Basis y = unitBasis(bands.order, s);
        double gain = 0;
        for (int l = 1; l < bands.order; ++l)
            for (std::size_t c = 0; c < 3; ++c) {
                const double* band = bands.of[std::size_t(l)].col(Index(c)).data();
                const double projected = std::inner_product(band, band + 2 * l + 1, y.begin() + l * l, 0.0);
                gain += projected * projected;
            }
        if (gain > best * (1 + 1e-12)) best = gain, direction = s;
    }
    return direction;
}

struct Lobes {
    std::vector<Vec3d> directions;
    std::array<SmallMatrix, kMaxOrder> z;  // [D, 3] for each band
};

// Solves for the coefficients of given directions.
Lobes withBestCoefficients(const Bands& bands, std::vector<Vec3d> directions, const RidgeTo& ridge = {}) {
    Lobes lobes{std::move(directions), {}};
    const std::vector<Basis> bases = basesOf(bands.order, lobes.directions);
    for (int l = 0; l < bands.order; ++l)
        lobes.z[std::size_t(l)] = solveBand(columnsOf(l, bases), bands.of[std::size_t(l)], l, ridge);
    return lobes;
}

// Searches for better directions from `start`.
DirectionMinimum refine(const Bands& bands, std::span<const Vec3d> start, const RidgeTo& ridge = {kRidge, {}}) {
    return minimiseOverDirections(
        [&](std::span<const Vec3d> s, std::span<Vec3d> gradient) { return residualOf(bands, s, gradient, ridge); },
        start);
}

// Fits one lobe at a time to what the lobes before have left.
Lobes fitGreedily(Bands bands, int count, std::span<const Vec3d> candidates) {
    Lobes lobes;
    for (int l = 0; l < bands.order; ++l) lobes.z[std::size_t(l)] = SmallMatrix::Zero(count, 3);
    for (int d = 0; d < count; ++d) {
        // 1. Find the best direction for one lobe, and its coefficients.
        const Vec3d start = bestCandidate(bands, candidates);
        const Lobes one = withBestCoefficients(bands, refine(bands, std::span(&start, 1)).directions);
        lobes.directions.push_back(one.directions[0]);
        // 2. Subtract the lobe.
        const Basis y = unitBasis(bands.order, one.directions[0]);
        for (int l = 0; l < bands.order; ++l) {
            const SmallMatrix& z = one.z[std::size_t(l)];
            lobes.z[std::size_t(l)].row(d) = z.row(0);
            bands.of[std::size_t(l)] -= columnsOf(l, std::span(&y, 1)) * z;
        }
    }
    return lobes;
}

// Returns another start: `count` candidates that lie far apart in the list, which winds from pole to pole. 617 and 401
// share no factor with the length of the list.
std::vector<Vec3d> otherStart(int start, int count, std::span<const Vec3d> candidates) {
    std::vector<Vec3d> directions;
    for (int d = 0; d < count; ++d)
        directions.push_back(candidates[std::size_t(d * 617 + start * 401 + 1) % candidates.size()]);
    return directions;
}

Lobes fitJointly(const Bands& bands, int count, std::span<const Vec3d> candidates) {
    constexpr int kOtherStarts = 12;
    constexpr double kExact = 2 * kRidge;
    // 1. Start from the greedy directions.
    DirectionMinimum best = refine(bands, fitGreedily(bands, count, candidates).directions);
    // 2. Try other starts until the fit is exact, and keep the best.
    for (int i = 0; i < kOtherStarts && best.value > kExact; ++i) {
        DirectionMinimum other = refine(bands, otherStart(i, count, candidates));
        if (other.value < best.value * (1 - 1e-6)) best = std::move(other);
    }
    return withBestCoefficients(bands, std::move(best.directions));
}

// Returns |a - b| / |b|, where the squares of band l count weight_l times.
double relativeDifference(int order, std::span<const double> a, std::span<const double> b,
                          std::span<const double> weight) {
    RelativeRms difference;
    for (int l = 0; l < order; ++l)
        for (std::size_t i = std::size_t(3 * l * l); i < std::size_t(3 * (l + 1) * (l + 1)); ++i)
            difference.add(a[i], b[i], weight[std::size_t(l)]);
    return difference.value();
}

// Turns the axes of lobes that point away from the light to the opposite direction. The lobes stay the same, because
// z_l and (-1)^l z_l at the opposite axis agree.
void turnTowardsLight(int order, Lobes& lobes) {
    const Eigen::RowVector3d luminance(0.2126, 0.7152, 0.0722);
    for (std::size_t d = 0; order > 1 && d < lobes.directions.size(); ++d) {
        if (lobes.z[1].row(Index(d)).dot(luminance) >= 0) continue;
        lobes.directions[d] = -lobes.directions[d];
        for (std::size_t l = 1; l < std::size_t(order); l += 2) lobes.z[l].row(Index(d)) *= -1;
    }
}

// Returns the lobes in descending order of energy.
std::vector<std::size_t> byEnergy(int order, const Lobes& lobes) {
    std::vector<double> energy(lobes.directions.size(), 0.0);
    for (int l = 0; l < order; ++l)
        for (std::size_t d = 0; d < energy.size(); ++d)
            energy[d] += lobes.z[std::size_t(l)].row(Index(d)).squaredNorm();
    std::vector<std::size_t> sorted = indices(energy.size());
    std::stable_sort(sorted.begin(), sorted.end(), [&](std::size_t a, std::size_t b) { return energy[a] > energy[b]; });
    return sorted;
}

// Returns the lobes in the given order, with their errors.
LightLobesFit measured(int order, std::span<const double> sh, double scale, const Lobes& lobes,
                       std::span<const std::size_t> sorted, const char* mode) {
    LightLobesFit fit;
    fit.mode = mode;
    for (std::size_t d : sorted) {
        fit.directions.push_back(lobes.directions[d]);
        for (int l = 0; l < order; ++l)
            for (Index c = 0; c < 3; ++c) fit.coefficients.push_back(scale * lobes.z[std::size_t(l)](Index(d), c));
    }
    const std::vector<double> lobes_sh = lobesToSh(order, fit);
    fit.residual = relativeDifference(order, lobes_sh, sh, std::vector<double>(std::size_t(order), 1.0));
    fit.irradiance_error = irradianceDifference(order, lobes_sh, sh);
    return fit;
}

}  // namespace

LightLobesFit fitLobes(int order, std::span<const double> sh, int count, LobeFit how) {
    assert(order >= 1 && order <= kMaxOrder && int(sh.size()) == 3 * coefficientCount(order));
    assert(how == LobeFit::kFixed || (count >= 1 && count <= kMaxFittedLobes));
    // 1. Fit the lobes in the way that was asked for.
    const Bands bands = bandsOf(order, sh);
    const std::vector<Vec3d> candidates = fibonacciSphere(kCandidates);
    const std::span<const Vec3d> fixed = fixedLobeDirections(order);
    Lobes lobes = how == LobeFit::kGreedy  ? fitGreedily(bands, count, candidates)
                  : how == LobeFit::kJoint ? fitJointly(bands, count, candidates)
                                           : withBestCoefficients(bands, {fixed.begin(), fixed.end()});
    // 2. Bring them into a definite form. Fixed lobes keep the order of their table.
    if (how != LobeFit::kFixed) turnTowardsLight(order, lobes);
    const std::vector<std::size_t> sorted =
        how == LobeFit::kFixed ? indices(lobes.directions.size()) : byEnergy(order, lobes);
    // 3. Measure the error.
    return measured(order, sh, bands.scale, lobes, sorted,
                    how == LobeFit::kGreedy  ? "greedy"
                    : how == LobeFit::kJoint ? "joint"
                                             : "fixed");
}

LightLobesFit fitLobesFrom(int order, std::span<const double> sh, std::span<const Vec3d> directions, double ridge,
                           std::span<const double> towards) {
    assert(order >= 1 && order <= kMaxOrder && int(sh.size()) == 3 * coefficientCount(order));
    assert(towards.empty() || towards.size() == 3 * directions.size() * std::size_t(order));
    Bands bands = bandsOf(order, sh);
    if (bands.scale == 0) bands.scale = 1;  // black stays black, and coefficients that are pulled have a scale
    RidgeTo pull{ridge, {}};
    for (std::size_t l = 0; l < std::size_t(order) && !towards.empty(); ++l) {
        pull.towards[l].resize(Index(directions.size()), 3);
        for (std::size_t d = 0; d < directions.size(); ++d)
            for (std::size_t c = 0; c < 3; ++c)
                pull.towards[l](Index(d), Index(c)) = towards[(d * std::size_t(order) + l) * 3 + c] / bands.scale;
    }
    const Lobes lobes = withBestCoefficients(bands, refine(bands, directions, pull).directions, pull);
    return measured(order, sh, bands.scale, lobes, indices(directions.size()), "joint");
}

double irradianceDifference(int order, std::span<const double> sh, std::span<const double> truth) {
    std::vector<double> weight(std::size_t(order), 0.0);  // (sqrt(4pi/(2l+1)) z_l)^2 of the clamped cosine
    clampedCosineZonal(weight);
    for (int l = 0; l < order; ++l)
        weight[std::size_t(l)] *= weight[std::size_t(l)] * 4 * std::numbers::pi / (2 * l + 1);
    return relativeDifference(order, sh, truth, weight);
}

std::vector<double> lobesToSh(int order, const LightLobesFit& lobes) {
    std::vector<double> sh(3 * std::size_t(coefficientCount(order)), 0.0), zonal(std::size_t(order), 0.0),
        one(sh.size() / 3);
    for (std::size_t d = 0; d < lobes.directions.size(); ++d)
        for (std::size_t c = 0; c < 3; ++c) {
            for (std::size_t l = 0; l < zonal.size(); ++l)
                zonal[l] = lobes.coefficients[(d * zonal.size() + l) * 3 + c];
            rotateZonal(zonal, lobes.directions[d], one);
            for (std::size_t i = 0; i < one.size(); ++i) sh[3 * i + c] += one[i];
        }
    return sh;
}

}  // namespace penumbra
