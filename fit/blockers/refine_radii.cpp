// Refines radii.
//
// Problem: one factor for all radii makes the mean silhouette right, but arms may be too thick and feet too thin.
//
// Naive: least squares of the areas of all silhouettes. An area does not tell where it is missing.
//
// Here: each silhouette is cut into bands across the view. The mesh's extent, and a tenth more on either side, is the
// range of the bands. Levenberg and Marquardt's method over log radii, with differences for derivatives, takes some
// ten steps of 64 unknowns at the most.
#include "fit/blockers/refine_radii.h"

#include <algorithm>
#include <cmath>

#include "fit/numerics/dense_solvers.h"
#include "formats/common/parallel_for.h"
#include "sh/cast/caster_sphere.h"

namespace penumbra {

namespace {

constexpr double kMargin = 0.1;       // in extents of a silhouette
constexpr double kDifference = 0.01;  // step of a log radius for derivatives
constexpr double kPull = 0.05;        // pull of a log radius towards 0, as a share of the mesh's rms band
constexpr int kMaxRadiusSteps = 12;
constexpr double kMinGain = 1e-4;  // relative decrease of the squares; a smaller one ends the search

class BandFit {
public:
    BandFit(std::span<const Triangle> triangles, const SilhouettePoses& poses, std::span<const Vec3d> views,
            int threads, const SphereBlockers& blockers)
        : poses_(poses), views_(views), threads_(threads), blockers_(blockers), bands_(pictures() * kSilhouetteBands) {
        ranges_.resize(pictures());
        parallelFor(pictures(), threads_, [&](std::size_t i) {
            const std::vector<Vec3>& positions = poses_.positions[i / views_.size()];
            const Vec3d view = views_[i % views_.size()];
            SilhouetteRange range = rangeOf(positions, view);
            const double margin = kMargin * (range.high - range.low);
            range.low -= margin;
            range.high += margin;
            ranges_[i] = range;
            silhouetteBands(triangles, positions, view, range, band(bands_, i));
        });
        double squares = 0;
        for (const double b : bands_) squares += b * b;
        rms_ = std::sqrt(squares / double(bands_.size()));
    }

    std::size_t unknowns() const { return blockers_.spheres.size(); }
    std::size_t residuals() const { return bands_.size() + unknowns(); }

    // (spheres - mesh) / rms of the mesh, over sqrt(bands), then the pull. Their squares add up to what is minimised.
    std::vector<double> evaluate(std::span<const double> logs) const {
        std::vector<double> out(bands_.size());
        parallelFor(pictures(), threads_, [&](std::size_t i) {
            std::vector<CasterSphere> spheres = blockers_.spheres;
            for (std::size_t s = 0; s < spheres.size(); ++s) {
                spheres[s].radius *= float(std::exp(logs[s]));
                spheres[s] = movedBy(poses_.bones[i / views_.size()][blockers_.joints[s]], spheres[s]);
            }
            silhouetteBands(spheres, views_[i % views_.size()], ranges_[i], band(out, i));
        });
        const double scale = 1 / (rms_ * std::sqrt(double(bands_.size())));
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = (out[i] - bands_[i]) * scale;
        for (const double log : logs) out.push_back(kPull * log);
        return out;
    }
    double error(std::span<const double> residuals) const {
        double squares = 0;
        for (std::size_t i = 0; i < bands_.size(); ++i) squares += residuals[i] * residuals[i];
        return std::sqrt(squares);
    }

private:
    const SilhouettePoses& poses_;
    std::span<const Vec3d> views_;
    int threads_;
    const SphereBlockers& blockers_;
    std::vector<double> bands_;  // bands of the mesh, [poses, views, kSilhouetteBands]
    std::vector<SilhouetteRange> ranges_;
    double rms_ = 0;

    std::size_t pictures() const { return poses_.bones.size() * views_.size(); }
    static std::span<double> band(std::vector<double>& all, std::size_t picture) {
        return std::span(all).subspan(picture * kSilhouetteBands, kSilhouetteBands);
    }
};

double squaresOf(std::span<const double> residuals) {
    double sum = 0;
    for (const double r : residuals) sum += r * r;
    return sum;
}

// J^T J and -J^T r, by forward differences.
void normalEquations(const BandFit& fit, const std::vector<double>& logs, const std::vector<double>& residuals,
                     Eigen::MatrixXd& matrix, Eigen::MatrixXd& right) {
    const auto asVector = [](const std::vector<double>& v) {
        return Eigen::Map<const Eigen::VectorXd>(v.data(), Eigen::Index(v.size()));
    };
    Eigen::MatrixXd columns(Eigen::Index(fit.residuals()), Eigen::Index(fit.unknowns()));
    for (std::size_t s = 0; s < fit.unknowns(); ++s) {
        std::vector<double> moved = logs;
        moved[s] += kDifference;
        columns.col(Eigen::Index(s)) = (asVector(fit.evaluate(moved)) - asVector(residuals)) / kDifference;
    }
    matrix = columns.transpose() * columns;
    right = -columns.transpose() * asVector(residuals);
}

}  // namespace

RadiusRefinement refineRadii(std::span<const Triangle> triangles, const SilhouettePoses& poses,
                             std::span<const Vec3d> views, int threads, SphereBlockers& blockers) {
    const BandFit fit(triangles, poses, views, threads, blockers);
    const std::size_t n = fit.unknowns();
    std::vector<double> logs(n, 0.0), residuals = fit.evaluate(logs), step(n);
    Eigen::MatrixXd matrix, right, found;
    RadiusRefinement out{fit.error(residuals), fit.error(residuals)};
    double squares = squaresOf(residuals), damping = 1e-3;
    for (bool better = true; better && out.steps < kMaxRadiusSteps;) {
        // 1. Linearise.
        normalEquations(fit, logs, residuals, matrix, right);
        // 2. Step, with more damping until the squares get fewer.
        better = false;
        for (int attempt = 0; attempt < 6 && !better; ++attempt, damping *= 10) {
            Eigen::MatrixXd damped = matrix;
            damped.diagonal() *= 1 + damping;
            if (!solvePositive(damped, right, found)) continue;
            for (std::size_t a = 0; a < n; ++a) step[a] = logs[a] + std::clamp(found(Eigen::Index(a)), -0.5, 0.5);
            const std::vector<double> moved = fit.evaluate(step);
            const double error = fit.error(moved);
            if (!(squaresOf(moved) < squares) || error > out.after) continue;
            better = squaresOf(moved) < squares * (1 - kMinGain);
            logs = step;
            residuals = moved;
            squares = squaresOf(moved);
            out.after = error;
            ++out.steps;
            damping *= 0.01;
            break;
        }
    }
    for (std::size_t s = 0; s < n; ++s) blockers.spheres[s].radius *= float(std::exp(logs[s]));
    return out;
}

}  // namespace penumbra
