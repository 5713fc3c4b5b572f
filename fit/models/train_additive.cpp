// Chooses the units of an additive model and computes their weights.
//
// Problem: a cluster's scores Y [frames, components] are to be predicted from groups of inputs, for instance 13 numbers
// for each bone that the cluster sees. The prediction must hold in poses that combine what training frames showed only
// one bone at a time.
//
// Naive: a Gaussian process with a kernel over all inputs together needs training frames near every combination of
// poses, and it keeps all training frames to be evaluated. A ridge regression on every candidate unit, of which the
// smallest weights are then dropped, chooses badly: units that overlap share their weight, so all of them look small.
//
// Here: the kernel is a sum over groups, sum_g w_g exp(-|x_g - x'_g|^2 / 2), where w_g is the weight of group g. Its
// subset-of-regressors form needs no training frames. It has units phi_h = sqrt(w_g) exp(-|x_g - center_h|^2 / 2) and
// the prior c^T P c on their coefficients, where P_hh' is the kernel between centers of one group and 0 between groups.
// All components have the same noise, and component k has a signal of its own energy E_k. Its prior therefore weighs
// lambda_k = lambda E_1 / E_k.
//
// 1. The candidate centers of a group are training inputs that lie far apart (makeCandidates).
// 2. Regularised orthogonal least squares picks the units, one at a time (chooseUnits; Chen, Cowan, Grant 1991). This
//    is a Cholesky factorisation of Phi^T Phi + lambda_0 P whose next pivot is the unit that lowers the objective most.
//    With M candidates, the step that adds unit t costs O(M t) instead of a new fit for each of them.
// 3. A generalised eigenproblem gives the coefficients for every lambda at once (RidgePath).
// 4. Blocked cross-validation chooses lambda and the number of units (crossValidate).
//
// Derivation: docs/formulas.md, section 4.

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/models/trainers.h"
#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

// Number of candidate centers in each group of a character.
constexpr std::size_t kCentersPerGroup = 48;
// The groups of a deforming mesh share this many centers, because such a mesh has more parts than a character has
// bones. Training takes time in proportion to the square of the number of centers.
constexpr std::size_t kDeformingCenters = 1024, kMinCentersPerGroup = 12;
constexpr std::size_t kUnitCounts[] = {16, 32, 48, 64, 96, 128};
constexpr double kLambdas[] = {3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 1.0};
constexpr double kSelectionLambda = 1e-3;
// Components with less energy than this share of the first one's hardly take part in the choice of units.
constexpr double kSelectionShare = 1.0 / 30;
// A smaller number of units is taken when its squared error is at most this part above the best.
constexpr double kWorthMoreUnits = 0.01;
// A stronger prior is taken when its squared error is at most this part above the least.
constexpr double kWorthLessPrior = 0.005;
// Without prior: the prior as a part of the units' largest energy. Less lets rounding grow where there are more units
// than frames.
constexpr double kNoAdditivePrior = 1e-10;
constexpr float kMinIdleWeight = 0.05f;  // relative to the largest group weight

struct Candidates {
    std::vector<std::size_t> group;  // index into the model's groups
    Matrix centers;                  // [M, D] the inputs at which each unit is largest
    Eigen::MatrixXd phi;             // [n, M] values of the units on the training rows
};

// Returns rows that lie far apart. The first is the row nearest the mean, and each next one is the row farthest from
// all before it. There are fewer than `count` when the remaining rows repeat the chosen ones.
std::vector<std::size_t> farthestRows(const Matrix& x, std::size_t count) {
    // 1. Start at the row nearest the mean.
    const std::vector<double> mean = meanOfRows(x, indices(x.rows));
    std::vector<double> distance(x.rows);
    for (std::size_t r = 0; r < x.rows; ++r) distance[r] = squaredDistance(x.row(r), mean);
    std::vector<std::size_t> chosen{std::size_t(std::min_element(distance.begin(), distance.end()) - distance.begin())};
    // 2. Keep each row's squared distance to the nearest chosen row, and add the row where it is largest.
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

// Returns entry (i, j) of the prior P. It is zero between units of different groups.
double priorOf(const Candidates& all, Eigen::Index i, Eigen::Index j) {
    const std::size_t a = std::size_t(i), b = std::size_t(j);
    if (all.group[a] != all.group[b]) return 0;
    return std::exp(-0.5 * squaredDistance(all.centers.row(a), all.centers.row(b)));
}

// Returns the inputs of one group on every training row, [n, D].
Matrix groupRows(const RegressionProblem& problem, std::size_t group) {
    Matrix x(problem.train.size(), groupInputs(problem.recipe.kind));
    for (std::size_t r = 0; r < x.rows; ++r)
        readGroup(problem.recipe, problem.place, group, problem.raw.row(problem.train[r]), x.row(r));
    return x;
}

// Makes the candidate units of all groups and evaluates them on the training rows.
Candidates makeCandidates(const RegressionProblem& problem, const ClusterModel& model) {
    Candidates all;
    // 1. Decide how many centers a group may have.
    const std::size_t centers_per_group =
        problem.recipe.deforming ? std::clamp(kDeformingCenters / std::max<std::size_t>(model.groups.size(), 1),
                                              kMinCentersPerGroup, kCentersPerGroup)
                                 : kCentersPerGroup;
    std::vector<Eigen::VectorXd> columns;
    std::vector<double> centers;
    // 2. Choose the centers of each group among its training inputs, and evaluate their units.
    for (std::size_t g = 0; g < model.groups.size(); ++g) {
        const Matrix x = groupRows(problem, model.groups[g]);
        const std::vector<std::size_t> rows = farthestRows(x, centers_per_group);
        if (rows.size() == 1) continue;  // the group does not move, so nothing can be learned from it
        for (std::size_t c : rows) {
            all.group.push_back(g);
            centers.insert(centers.end(), x.row(c).begin(), x.row(c).end());
            Eigen::VectorXd& phi = columns.emplace_back(x.rows);
            for (std::size_t r = 0; r < x.rows; ++r)
                phi[Eigen::Index(r)] = std::exp(-0.5 * squaredDistance(x.row(r), x.row(c)));
            phi *= std::sqrt(double(model.group_weight[g]));
        }
    }
    // 3. Gather centers and columns into matrices.
    all.centers = Matrix(columns.size(), groupInputs(problem.recipe.kind));
    all.centers.values = centers;
    const auto count = Eigen::Index(columns.size());
    all.phi.resize(Eigen::Index(problem.train.size()), count);
    for (Eigen::Index i = 0; i < count; ++i) all.phi.col(i) = columns[std::size_t(i)];
    return all;
}

// The second moments of a set of rows, Phi^T Phi and Phi^T Y, and the sums that center() needs to take the means off
// them.
struct Moments {
    Eigen::MatrixXd gram, cross;
    Eigen::RowVectorXd phi_sum, y_sum;
    double rows = 0;
};

Moments momentsOf(const Eigen::MatrixXd& phi, const Eigen::MatrixXd& y) {
    return {phi.transpose() * phi, phi.transpose() * y, phi.colwise().sum(), y.colwise().sum(), double(phi.rows())};
}

// Takes rows out of `m`. It works in place, because the Gram matrices are what training needs memory for.
void removeRows(const Eigen::MatrixXd& phi, const Eigen::MatrixXd& y, Moments& m) {
    m.gram.noalias() -= phi.transpose() * phi;
    m.cross.noalias() -= phi.transpose() * y;
    m.phi_sum -= phi.colwise().sum();
    m.y_sum -= y.colwise().sum();
    m.rows -= double(phi.rows());
}

// Turns moments about zero into moments about the means.
void center(Moments& m) {
    m.gram.noalias() -= m.phi_sum.transpose() * (m.phi_sum / m.rows);
    m.cross.noalias() -= m.phi_sum.transpose() * (m.y_sum / m.rows);
}

// Returns a factor for each component: weak components count less in the choice of units, as the prior will shrink
// them.
Eigen::RowVectorXd selectionWeights(const Eigen::RowVectorXd& ratios) {
    return (1 + kSelectionShare * ratios.array()).inverse();
}

// Returns up to `count` candidates, the most useful first. `m` holds centered moments. After t steps the factorisation
// has done two things: row i of `residual` is the inner product of candidate i with what the chosen units leave of the
// outputs, and pivots[i] is the candidate's penalised energy that the chosen units do not share.
std::vector<Eigen::Index> chooseUnits(const Candidates& all, const Moments& m, const Eigen::RowVectorXd& ratios,
                                      std::size_t count) {
    const Eigen::Index size = m.gram.rows();
    // 1. Nothing is chosen yet, so every candidate sees all of the outputs. The diagonal of P is 1.
    Eigen::MatrixXd residual = m.cross * selectionWeights(ratios).asDiagonal();
    Eigen::MatrixXd factor(size, Eigen::Index(count));
    Eigen::VectorXd pivots = m.gram.diagonal().array() + kSelectionLambda;
    // A candidate of which less than this is left nearly repeats the chosen ones.
    const Eigen::VectorXd least = 1e-4 * pivots;
    std::vector<Eigen::Index> chosen;
    while (chosen.size() < count) {
        // 2. Adding candidate i lowers the penalised error by |residual_i|^2 / pivot_i. Pick the largest gain.
        Eigen::VectorXd gain = residual.rowwise().squaredNorm();
        for (Eigen::Index i = 0; i < size; ++i) gain[i] = pivots[i] > least[i] ? gain[i] / pivots[i] : -1;
        Eigen::Index best;
        if (!(gain.maxCoeff(&best) > 0)) break;
        // 3. Compute the chosen unit's column of the Cholesky factor of Phi^T Phi + lambda_0 P.
        const auto t = Eigen::Index(chosen.size());
        const double root = std::sqrt(pivots[best]);
        Eigen::VectorXd column = m.gram.col(best) - factor.leftCols(t) * factor.row(best).head(t).transpose();
        for (Eigen::Index i = 0; i < size; ++i) column[i] += kSelectionLambda * priorOf(all, i, best);
        factor.col(t) = column / root;
        // 4. Remove the chosen unit's direction from the outputs and from the energies of all other candidates.
        residual -= (factor.col(t) * (residual.row(best) / root)).eval();
        pivots -= factor.col(t).cwiseAbs2();
        pivots[best] = 0;
        chosen.push_back(best);
    }
    return chosen;
}

// Coefficients of a set of units for any lambda. The generalised eigenvectors of G v = s P v turn both the Gram matrix
// G and the prior P into diagonal matrices, so one decomposition serves every lambda and every component.
class RidgePath {
public:
    RidgePath(const Candidates& all, const Moments& m, const std::vector<Eigen::Index>& rows) {
        projected_.resize(0, m.cross.cols());
        if (rows.empty()) return;  // there is nothing to learn, so the mean alone remains
        // 1. Cut the moments and the prior down to the chosen units.
        const Eigen::MatrixXd gram = m.gram(rows, rows);
        Eigen::MatrixXd prior(gram.rows(), gram.cols());
        for (Eigen::Index i = 0; i < prior.rows(); ++i)
            for (Eigen::Index j = 0; j < prior.cols(); ++j)
                prior(i, j) = priorOf(all, rows[std::size_t(i)], rows[std::size_t(j)]);
        prior.diagonal().array() += 1e-9;  // keeps P positive definite when centers nearly repeat one another
        // 2. Solve G V = P V diag(s) with V^T P V = I, and project Phi^T Y on V.
        EigenPairs pairs = generalizedEigenPairs(gram, prior);
        vectors_ = std::move(pairs.vectors);
        values_ = pairs.values.cwiseMax(0);
        projected_ = vectors_.transpose() * m.cross(rows, Eigen::all);
    }
    double largest() const { return values_.size() > 0 ? values_.maxCoeff() : 0; }
    // Returns the coefficients [H, K] where component k has the prior lambda * ratios[k]: V (s + lambda_k)^-1 V^T Phi^T
    // Y.
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

// Adds the squared errors on one fold, for every number of units and every lambda. `kept` holds the centered moments of
// the rows outside the fold.
void addFoldErrors(const Candidates& all, const Eigen::MatrixXd& y, const Eigen::RowVectorXd& ratios,
                   const Moments& kept, const std::vector<Eigen::Index>& left_out, ErrorTable& errors) {
    // 1. Choose units without the fold. The first n of them are the choice for n units.
    const std::vector<Eigen::Index> units = chooseUnits(all, kept, ratios, std::end(kUnitCounts)[-1]);
    // 2. Center the rows of the fold by the means of the other rows.
    const Eigen::RowVectorXd phi_mean = kept.phi_sum / kept.rows, y_mean = kept.y_sum / kept.rows;
    const Eigen::MatrixXd truth = y(left_out, Eigen::all).rowwise() - y_mean;
    // 3. For each number of units, one decomposition gives the errors for all lambdas.
    for (std::size_t n = 0; n < std::size(kUnitCounts); ++n) {
        const auto count = std::ptrdiff_t(std::min(kUnitCounts[n], units.size()));
        const std::vector<Eigen::Index> columns(units.begin(), units.begin() + count);
        const RidgePath path(all, kept, columns);
        const Eigen::MatrixXd phi = all.phi(left_out, columns).rowwise() - phi_mean(columns);
        for (std::size_t l = 0; l < std::size(kLambdas); ++l)
            errors[n][l] += (truth - phi * path.solve(kLambdas[l], ratios)).squaredNorm();
    }
}

struct Choice {
    std::size_t units = kUnitCounts[0];
    double lambda = std::end(kLambdas)[-1], error = 0;
};

// Takes the smallest number of units that is nearly as good as the best and, with it, the strongest prior that is
// nearly as good. Coefficients then stay small, so rounding them does little harm. Without any fold all errors are
// zero, and the choice is the fewest units with the strongest prior, which is nearly the mean alone.
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

// Cross-validates over blocks of frames. No output of a fold takes part in what is predicted for the fold. The
// candidates are shared by all folds; they are inputs of all training frames. `whole` holds the moments of all rows,
// not centered.
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
        center(kept);
        addFoldErrors(all, y, ratios, kept, left_out, errors);
    }
    return choose(errors);
}

// Writes units and coefficients into the model. The stored units leave out sqrt(w_g), so the stored weights include it.
void store(const Candidates& all, const std::vector<Eigen::Index>& units, const Eigen::MatrixXd& weights,
           ClusterModel& model) {
    for (Eigen::Index unit : units) {
        const std::size_t u = std::size_t(unit);
        model.unit_group.push_back(std::uint32_t(all.group[u]));
        model.hidden.insert(model.hidden.end(), all.centers.row(u).begin(), all.centers.row(u).end());
    }
    for (Eigen::Index k = 0; k < weights.cols(); ++k)
        for (Eigen::Index h = 0; h < weights.rows(); ++h) {
            const std::size_t group = all.group[std::size_t(units[std::size_t(h)])];
            model.weights.push_back(float(weights(h, k) * std::sqrt(double(model.group_weight[group]))));
        }
}

// Removes the groups that no unit sees and that weigh little, because they only cost bytes. The other unused groups
// stay: they still count in the distance from the training poses ("out of range").
void dropIdleGroups(ClusterModel& model) {
    const std::size_t size = model.groups.empty() ? 0 : model.group_min.size() / model.groups.size();
    const float least = kMinIdleWeight * *std::max_element(model.group_weight.begin(), model.group_weight.end());
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
    // 1. Make the candidates. The components that are not kept always count as error.
    const Matrix kept = keptScores(problem);
    const Eigen::MatrixXd y = asEigen(kept);
    const Candidates all = makeCandidates(problem, model);
    const double dropped = problem.outputs.total - y.squaredNorm();
    const double none = std::numeric_limits<double>::quiet_NaN();
    model.bias.assign(problem.components, 0.0f);  // scores are centered
    // Nothing can be learned when no group moves, or when the outputs never change (vertices that are always blocked).
    if (all.group.empty() || y.squaredNorm() == 0) return {problem.outputs.total, none};

    // 2. The prior of component k is E_1 / E_k times that of the first; tiny energies are limited. Without prior all
    //    components count alike.
    const Eigen::RowVectorXd energies = y.colwise().squaredNorm();
    Eigen::RowVectorXd ratios = Eigen::RowVectorXd::Ones(energies.size());
    // 3. Choose lambda and the number of units by cross-validation.
    Moments centered = momentsOf(all.phi, y);
    Choice choice{std::end(kUnitCounts)[-1], 0, none};
    if (problem.prior) {
        ratios = energies[0] / energies.array().max(1e-12 * energies[0]);
        choice = crossValidate(all, y, ratios, problem.folds, centered);
    }
    // 4. Choose the units again on all training rows and compute their coefficients.
    center(centered);
    const std::vector<Eigen::Index> units = chooseUnits(all, centered, ratios, choice.units);
    const RidgePath path(all, centered, units);
    if (choice.lambda == 0) choice.lambda = kNoAdditivePrior * path.largest();
    const Eigen::MatrixXd weights = path.solve(choice.lambda, ratios);
    // 5. The bias moves the centered prediction back: mean of y less the mean of the units times their coefficients.
    const Eigen::RowVectorXd offset =
        centered.y_sum / centered.rows - centered.phi_sum(units) / centered.rows * weights;
    for (std::size_t k = 0; k < problem.components; ++k) model.bias[k] = float(offset[Eigen::Index(k)]);
    store(all, units, weights, model);
    dropIdleGroups(model);
    model.ridge = choice.lambda;
    return {choice.error + dropped, none};
}

}  // namespace penumbra
