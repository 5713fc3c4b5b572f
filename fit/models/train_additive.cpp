#include "fit/models/train_additive.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

// A Gaussian process with the kernel sum_g w_g exp(-|x_g - x'_g|^2 / 2), w_g the groups' weights, in its
// subset-of-regressors form: units phi_h = sqrt(w_g) exp(-|x_g - centre_h|^2 / 2) and the prior c^T P c, P_hh' the
// kernel between centres of one group. Component k has a signal of its own energy E_k and all have one noise, so its
// prior weighs lambda_k = lambda E_1 / E_k. Candidate centres are training inputs; the units among them are chosen by
// regularised orthogonal least squares (Chen, Cowan, Grant 1991), which is a Cholesky factorisation of
// Phi^T Phi + lambda P whose pivot is the unit that lowers the objective most.
constexpr std::size_t kCentresPerGroup = 48;
// Of all groups of a deforming mesh together, which has more parts than a character has bones: training takes time in
// proportion to their square.
constexpr std::size_t kDeformingCentres = 1024, kLeastCentresPerGroup = 12;
constexpr std::size_t kUnitCounts[] = {16, 32, 48, 64, 96, 128};
constexpr double kLambdas[] = {3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 1.0};
constexpr double kSelectionLambda = 1e-3;
// Components with less than this share of the first one's energy hardly take part in the choice of units.
constexpr double kSelectionShare = 1.0 / 30;
// Fewer units are taken when cross-validation finds them within this of the best (squared error, relative).
constexpr double kWorthMoreUnits = 0.01;
constexpr double kWorthLessPrior = 0.005;  // a stronger prior is taken when it costs no more (likewise)
constexpr float kLeastIdleWeight = 0.05f;  // of the largest group weight

struct Candidates {
    std::vector<std::size_t> group;  // index into the model's groups
    Matrix centres;                  // [M, D]
    Eigen::MatrixXd phi;             // [n, M]
};

// Rows that lie far apart: the first is nearest the mean, each next one farthest from those before; fewer than `count`
// when the rest repeat them.
std::vector<std::size_t> farthestRows(const Matrix& x, std::size_t count) {
    std::vector<std::size_t> all(x.rows);
    for (std::size_t r = 0; r < x.rows; ++r) all[r] = r;
    const std::vector<double> mean = meanOfRows(x, all);
    std::vector<double> distance(x.rows);
    for (std::size_t r = 0; r < x.rows; ++r) distance[r] = squaredDistance(x.row(r), mean);
    std::vector<std::size_t> chosen{std::size_t(std::min_element(distance.begin(), distance.end()) - distance.begin())};
    std::fill(distance.begin(), distance.end(), std::numeric_limits<double>::infinity());
    while (chosen.size() < count) {
        for (std::size_t r = 0; r < x.rows; ++r)
            distance[r] = std::min(distance[r], squaredDistance(x.row(r), x.row(chosen.back())));
        const auto next = std::max_element(distance.begin(), distance.end());
        if (*next < 1e-8) break;
        chosen.push_back(std::size_t(next - distance.begin()));
    }
    return chosen;
}

// Entry of the prior: units of different groups do not know of one another.
double priorOf(const Candidates& all, Eigen::Index i, Eigen::Index j) {
    const std::size_t a = std::size_t(i), b = std::size_t(j);
    if (all.group[a] != all.group[b]) return 0;
    return std::exp(-0.5 * squaredDistance(all.centres.row(a), all.centres.row(b)));
}

Matrix groupRows(const RegressionProblem& problem, std::size_t group) {
    Matrix x(problem.train.size(), groupInputs(problem.recipe.kind));
    for (std::size_t r = 0; r < x.rows; ++r)
        readGroup(problem.recipe, problem.place, group, problem.raw.row(problem.train[r]), x.row(r));
    return x;
}

Candidates makeCandidates(const RegressionProblem& problem, const ClusterModel& model) {
    Candidates all;
    const std::size_t centres_per_group =
        problem.recipe.deforming ? std::clamp(kDeformingCentres / std::max<std::size_t>(model.groups.size(), 1),
                                              kLeastCentresPerGroup, kCentresPerGroup)
                                 : kCentresPerGroup;
    std::vector<Eigen::VectorXd> columns;
    std::vector<double> centres;
    for (std::size_t g = 0; g < model.groups.size(); ++g) {
        const Matrix x = groupRows(problem, model.groups[g]);
        const std::vector<std::size_t> rows = farthestRows(x, centres_per_group);
        if (rows.size() == 1) continue;  // it does not move: nothing can be learned from it
        for (std::size_t c : rows) {
            all.group.push_back(g);
            centres.insert(centres.end(), x.row(c).begin(), x.row(c).end());
            Eigen::VectorXd& phi = columns.emplace_back(x.rows);
            for (std::size_t r = 0; r < x.rows; ++r)
                phi[Eigen::Index(r)] = std::exp(-0.5 * squaredDistance(x.row(r), x.row(c)));
            phi *= std::sqrt(double(model.group_weight[g]));
        }
    }
    all.centres = Matrix(columns.size(), groupInputs(problem.recipe.kind));
    all.centres.values = centres;
    const auto count = Eigen::Index(columns.size());
    all.phi.resize(Eigen::Index(problem.train.size()), count);
    for (Eigen::Index i = 0; i < count; ++i) all.phi.col(i) = columns[std::size_t(i)];
    return all;
}

// Second moments of a set of rows, Phi^T Phi and Phi^T Y, and the sums that centre() takes off them.
struct Moments {
    Eigen::MatrixXd gram, cross;
    Eigen::RowVectorXd phi_sum, y_sum;
    double rows = 0;
};

Moments momentsOf(const Eigen::MatrixXd& phi, const Eigen::MatrixXd& y) {
    return {phi.transpose() * phi, phi.transpose() * y, phi.colwise().sum(), y.colwise().sum(), double(phi.rows())};
}

// In place, because the Gram matrices are what training needs memory for.
void removeRows(const Eigen::MatrixXd& phi, const Eigen::MatrixXd& y, Moments& m) {
    m.gram.noalias() -= phi.transpose() * phi;
    m.cross.noalias() -= phi.transpose() * y;
    m.phi_sum -= phi.colwise().sum();
    m.y_sum -= y.colwise().sum();
    m.rows -= double(phi.rows());
}

void centre(Moments& m) {
    m.gram.noalias() -= m.phi_sum.transpose() * (m.phi_sum / m.rows);
    m.cross.noalias() -= m.phi_sum.transpose() * (m.y_sum / m.rows);
}

// Shrinks the components as the prior will.
Eigen::RowVectorXd selectionWeights(const Eigen::RowVectorXd& ratios) {
    return (1 + kSelectionShare * ratios.array()).inverse();
}

// Up to `count` candidates, best first.
std::vector<Eigen::Index> chooseUnits(const Candidates& all, const Moments& m, const Eigen::RowVectorXd& ratios,
                                      std::size_t count) {
    const Eigen::Index size = m.gram.rows();
    Eigen::MatrixXd residual = m.cross * selectionWeights(ratios).asDiagonal();
    Eigen::MatrixXd factor(size, Eigen::Index(count));
    Eigen::VectorXd pivots = m.gram.diagonal().array() + kSelectionLambda;
    const Eigen::VectorXd least = 1e-4 * pivots;
    std::vector<Eigen::Index> chosen;
    while (chosen.size() < count) {
        Eigen::VectorXd gain = residual.rowwise().squaredNorm();
        for (Eigen::Index i = 0; i < size; ++i) gain[i] = pivots[i] > least[i] ? gain[i] / pivots[i] : -1;
        Eigen::Index best;
        if (!(gain.maxCoeff(&best) > 0)) break;
        const auto t = Eigen::Index(chosen.size());
        const double root = std::sqrt(pivots[best]);
        Eigen::VectorXd column = m.gram.col(best) - factor.leftCols(t) * factor.row(best).head(t).transpose();
        for (Eigen::Index i = 0; i < size; ++i) column[i] += kSelectionLambda * priorOf(all, i, best);
        factor.col(t) = column / root;
        residual -= (factor.col(t) * (residual.row(best) / root)).eval();
        pivots -= factor.col(t).cwiseAbs2();
        pivots[best] = 0;
        chosen.push_back(best);
    }
    return chosen;
}

// Coefficients of units for any lambda, through the generalised eigenproblem G v = s P v, which makes both diagonal.
class RidgePath {
public:
    RidgePath(const Candidates& all, const Moments& m, std::span<const Eigen::Index> units) {
        const std::vector<Eigen::Index> rows(units.begin(), units.end());
        projected_.resize(0, m.cross.cols());
        if (rows.empty()) return;  // nothing to learn: the mean alone
        const Eigen::MatrixXd gram = m.gram(rows, rows);
        Eigen::MatrixXd prior(gram.rows(), gram.cols());
        for (Eigen::Index i = 0; i < prior.rows(); ++i)
            for (Eigen::Index j = 0; j < prior.cols(); ++j)
                prior(i, j) = priorOf(all, rows[std::size_t(i)], rows[std::size_t(j)]);
        prior.diagonal().array() += 1e-9;  // centres that nearly repeat one another
        const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram, prior);
        vectors_ = solver.eigenvectors();
        values_ = solver.eigenvalues().cwiseMax(0);
        projected_ = vectors_.transpose() * m.cross(rows, Eigen::all);
    }
    // [H, K] with component k's prior lambda * ratios[k].
    Eigen::MatrixXd solve(double lambda, const Eigen::RowVectorXd& ratios) const {
        Eigen::MatrixXd scaled = projected_;
        for (Eigen::Index k = 0; k < scaled.cols(); ++k) scaled.col(k).array() /= values_.array() + lambda * ratios[k];
        return vectors_ * scaled;
    }

private:
    Eigen::MatrixXd vectors_, projected_;
    Eigen::VectorXd values_;
};

using ErrorTable = std::vector<std::vector<double>>;  // [unit count][lambda] squared error

void addFoldErrors(const Candidates& all, const Eigen::MatrixXd& y, const Eigen::RowVectorXd& ratios,
                   const Moments& kept, const std::vector<Eigen::Index>& left_out, ErrorTable& errors) {
    const std::vector<Eigen::Index> units = chooseUnits(all, kept, ratios, std::end(kUnitCounts)[-1]);
    const Eigen::RowVectorXd phi_mean = kept.phi_sum / kept.rows, y_mean = kept.y_sum / kept.rows;
    const Eigen::MatrixXd truth = y(left_out, Eigen::all).rowwise() - y_mean;
    for (std::size_t n = 0; n < std::size(kUnitCounts); ++n) {
        const std::span<const Eigen::Index> some = std::span(units).first(std::min(kUnitCounts[n], units.size()));
        const RidgePath path(all, kept, some);
        const std::vector<Eigen::Index> columns(some.begin(), some.end());
        const Eigen::MatrixXd phi = all.phi(left_out, columns).rowwise() - phi_mean(columns);
        for (std::size_t l = 0; l < std::size(kLambdas); ++l)
            errors[n][l] += (truth - phi * path.solve(kLambdas[l], ratios)).squaredNorm();
    }
}

struct Choice {
    std::size_t units = kUnitCounts[0];
    double lambda = std::end(kLambdas)[-1], error = 0;
};

// The smallest number of units that is nearly as good as the best, with the strongest prior that is as good: weights
// then stay small, and what rounds them does little harm. With nothing to validate on, that is nearly the mean alone.
Choice choose(const ErrorTable& errors) {
    double best = std::numeric_limits<double>::infinity();
    for (const std::vector<double>& row : errors) best = std::min(best, *std::min_element(row.begin(), row.end()));
    for (std::size_t n = 0; n < errors.size(); ++n) {
        const double least = *std::min_element(errors[n].begin(), errors[n].end());
        if (least > (1 + kWorthMoreUnits) * best) continue;
        for (std::size_t l = errors[n].size(); l-- > 0;)
            if (errors[n][l] <= (1 + kWorthLessPrior) * least) return {kUnitCounts[n], kLambdas[l], errors[n][l]};
    }
    return {};
}

// Blocked: what a fold would predict depends on no output of it. (The candidates are inputs of all training frames.)
Choice crossValidate(const Candidates& all, const Eigen::MatrixXd& y, const Eigen::RowVectorXd& ratios,
                     const std::vector<int>& folds, const Moments& whole) {
    const int fold_count = folds.empty() ? 0 : 1 + *std::max_element(folds.begin(), folds.end());
    ErrorTable errors(std::size(kUnitCounts), std::vector<double>(std::size(kLambdas)));
    for (int f = 0; f < fold_count && fold_count > 1; ++f) {
        std::vector<Eigen::Index> left_out;
        for (std::size_t i = 0; i < folds.size(); ++i)
            if (folds[i] == f) left_out.push_back(Eigen::Index(i));
        Moments kept = whole;
        removeRows(all.phi(left_out, Eigen::all), y(left_out, Eigen::all), kept);
        centre(kept);
        addFoldErrors(all, y, ratios, kept, left_out, errors);
    }
    return choose(errors);
}

void store(const Candidates& all, const std::vector<Eigen::Index>& units, const Eigen::MatrixXd& weights,
           ClusterModel& model) {
    for (Eigen::Index unit : units) {
        const std::size_t u = std::size_t(unit);
        model.unit_group.push_back(std::uint32_t(all.group[u]));
        model.hidden.insert(model.hidden.end(), all.centres.row(u).begin(), all.centres.row(u).end());
    }
    for (Eigen::Index k = 0; k < weights.cols(); ++k)
        for (Eigen::Index h = 0; h < weights.rows(); ++h) {
            const std::size_t group = all.group[std::size_t(units[std::size_t(h)])];
            model.weights.push_back(float(weights(h, k) * std::sqrt(double(model.group_weight[group]))));
        }
}

// Groups that no unit sees and that weigh little only cost bytes.
void dropIdleGroups(ClusterModel& model) {
    const std::size_t size = model.groups.empty() ? 0 : model.group_min.size() / model.groups.size();
    const float least = kLeastIdleWeight * *std::max_element(model.group_weight.begin(), model.group_weight.end());
    std::vector<bool> used(model.groups.size());
    for (std::uint32_t g : model.unit_group) used[g] = true;
    std::vector<std::uint32_t> place(model.groups.size());
    std::size_t kept = 0;
    for (std::size_t g = 0; g < model.groups.size(); ++g) {
        if (!used[g] && model.group_weight[g] < least) continue;
        place[g] = std::uint32_t(kept);
        model.groups[kept] = model.groups[g];
        model.group_weight[kept] = model.group_weight[g];
        std::copy_n(model.group_min.begin() + long(g * size), size, model.group_min.begin() + long(kept * size));
        std::copy_n(model.group_max.begin() + long(g * size), size, model.group_max.begin() + long(kept * size));
        ++kept;
    }
    model.groups.resize(kept);
    model.group_weight.resize(kept);
    model.group_min.resize(kept * size);
    model.group_max.resize(kept * size);
    for (std::uint32_t& g : model.unit_group) g = place[g];
}

}  // namespace

RegressionErrors trainAdditive(const RegressionProblem& problem, ClusterModel& model) {
    const Matrix kept = keptScores(problem);
    const Eigen::MatrixXd y = asEigen(kept);
    const Candidates all = makeCandidates(problem, model);
    const double dropped = problem.outputs.total - y.squaredNorm();
    const double none = std::numeric_limits<double>::quiet_NaN();
    model.bias.assign(problem.components, 0.0f);  // scores are centred
    // Nothing moves, or nothing changes (vertices that are always blocked).
    if (all.group.empty() || y.squaredNorm() == 0) return {problem.outputs.total, none};

    const Eigen::RowVectorXd energies = y.colwise().squaredNorm();
    const Eigen::RowVectorXd ratios = energies[0] / energies.array().max(1e-12 * energies[0]);
    Moments centred = momentsOf(all.phi, y);
    const Choice choice = crossValidate(all, y, ratios, problem.folds, centred);
    centre(centred);
    const std::vector<Eigen::Index> units = chooseUnits(all, centred, ratios, choice.units);
    const Eigen::MatrixXd weights = RidgePath(all, centred, units).solve(choice.lambda, ratios);
    const Eigen::RowVectorXd offset = centred.y_sum / centred.rows - centred.phi_sum(units) / centred.rows * weights;
    for (std::size_t k = 0; k < problem.components; ++k) model.bias[k] = float(offset[Eigen::Index(k)]);
    store(all, units, weights, model);
    dropIdleGroups(model);
    model.ridge = choice.lambda;
    return {choice.error + dropped, none};
}

}  // namespace penumbra
