// Near parts with gains.
//
// Problem: what hides a vertex' sky is largely what lies next to it in the skeleton, which no regression knows in poses
// that nobody baked. The rest geometry of these parts would tell, but they bend with the skin at the vertex.
//
// Naive: multiply by the field of a near part as by that of a far one. Near the joint it hides what in truth is the
// vertex' own surface.
//
// Here: a part counts as much as training frames say, by a gain a for each vertex, and a vertex has numbers of its own
// that replace what the joint deforms: L = own x product of (1 - a_p (1 - f_p)), solved by Gauss-Newton. Then every
// frame gets the numbers X with X x product = L that a model of the pose learns.
#include "fit/visibility/near_gains.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "fit/numerics/eigen_map.h"
#include "formats/common/spread_evenly.h"
#include "sh/mirrored_product.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"

namespace penumbra {

namespace {

using Columns = Eigen::MatrixXf;  // one column a frame

// Ridges, in squares of numbers: towards gains of 1, and towards the mean of the training frames.
constexpr float kGainRidge = 1, kOwnRidge = 3;
// This ridge pulls the numbers of one frame towards the vertex' own.
constexpr float kFrameRidge = 0.1f;
constexpr float kMaxGain = 1.5f;
constexpr int kRounds = 3;  // steps of Gauss-Newton
// Gains are found from so many training frames at most, spread evenly.
constexpr std::size_t kMaxGainFrames = 192;
// A vertex is hidden whose E stays below the first number in all training frames, and to which its parts leave less
// than the second on average. With .04 some vertices of the demo shine that something else hides.
constexpr float kHiddenE = 0.02f, kLeftToHidden = 0.02f;
// Vertices whose factors are in memory at a time.
constexpr std::size_t kNearBlock = 64;

// These matrices make products of mirrored functions: to values at the directions of the kernel (sh/far/far_grid.h) and
// back, and a multiplication by a function.
struct Products {
    Columns at, back;  // [64, 21], [21, 64]
    Columns matrix;    // [n n, 21]

    explicit Products(int order);
    // The matrices [n n, F] that multiply by each of the functions whose values are given, [64, F].
    Columns matricesOf(const Columns& values) const { return matrix * (back * values); }
};

Products::Products(int order) {
    constexpr auto kFar = Eigen::Index(kFarCoefficients);
    std::vector<WeightedDirection> upper;
    for (const WeightedDirection& d : gaussSphere(8, 16))
        if (d.direction.z > 0) upper.push_back(d);
    const std::vector<int> even = evenIndices(kFieldOrder);
    std::vector<double> basis(std::size_t(coefficientCount(kFieldOrder)));
    at.resize(Eigen::Index(upper.size()), kFar);
    back.resize(kFar, Eigen::Index(upper.size()));
    for (Eigen::Index d = 0; d < at.rows(); ++d) {
        evalBasis(kFieldOrder, upper[std::size_t(d)].direction, basis);
        for (Eigen::Index i = 0; i < kFar; ++i) {
            const double y = basis[std::size_t(even[std::size_t(i)])];
            at(d, i) = float(y);
            back(i, d) = float(2 * upper[std::size_t(d)].weight * y);
        }
    }
    const Eigen::Index n = mirroredCount(order);
    matrix.resize(n * n, kFar);
    std::vector<float> a(static_cast<std::size_t>(n)), b(kFarCoefficients), product(a.size());
    for (Eigen::Index j = 0; j < n; ++j)
        for (Eigen::Index k = 0; k < kFar; ++k) {
            std::fill(a.begin(), a.end(), 0.0f);
            std::fill(b.begin(), b.end(), 0.0f);
            a[std::size_t(j)] = b[std::size_t(k)] = 1;
            multiplyMirrored(order, a, order, b, kFieldOrder, product);
            for (Eigen::Index i = 0; i < n; ++i) matrix(i + j * n, k) = product[std::size_t(i)];
        }
}

// One vertex: what each near part hides at the directions, [K][64, F], and its local numbers [n, F].
struct NearVertex {
    std::vector<Columns> hidden;
    Columns local;
    Eigen::VectorXf gains, own;
};

Columns visibleOf(const NearVertex& vertex) {
    Columns visible = Columns::Ones(vertex.hidden[0].rows(), vertex.hidden[0].cols());
    for (std::size_t p = 0; p < vertex.hidden.size(); ++p)
        visible.array() *= 1 - vertex.gains[Eigen::Index(p)] * vertex.hidden[p].array();
    return visible;
}

Eigen::Map<const Columns> matrixOf(const Columns& matrices, Eigen::Index frame, Eigen::Index n) {
    return {matrices.col(frame).data(), n, n};
}

// The numbers that times the near parts leave the least error over all frames.
void solveOwn(const Products& products, const Eigen::VectorXf& mean, NearVertex& vertex) {
    const Eigen::Index n = vertex.local.rows();
    const Columns matrices = products.matricesOf(visibleOf(vertex));
    Columns a = kOwnRidge * Columns::Identity(n, n);
    Eigen::VectorXf b = Eigen::VectorXf::Zero(n);
    for (Eigen::Index f = 0; f < vertex.local.cols(); ++f) {
        const auto m = matrixOf(matrices, f, n);
        a.noalias() += m.transpose() * m;
        b.noalias() += m.transpose() * (vertex.local.col(f) - m * mean);
    }
    vertex.own = mean + a.llt().solve(b);
}

// How the error of all frames falls with each gain, [n F, K].
Columns slopesOf(const NearVertex& vertex, const Columns& from_values) {
    const Eigen::Index n = vertex.local.rows(), parts = vertex.gains.size(), frames = vertex.local.cols();
    Columns slopes(n * frames, parts);
    for (Eigen::Index p = 0; p < parts; ++p) {
        Columns others = vertex.hidden[std::size_t(p)];
        for (Eigen::Index q = 0; q < parts; ++q)
            if (q != p) others.array() *= 1 - vertex.gains[q] * vertex.hidden[std::size_t(q)].array();
        Eigen::Map<Columns>(slopes.col(p).data(), n, frames).noalias() = -from_values * others;
    }
    return slopes;
}

// One Gauss-Newton step of the numbers and the gains together. Each can stand for much of what the other does, so that
// steps in turns come near only slowly.
void stepBoth(const Products& products, const Eigen::VectorXf& mean, NearVertex& vertex) {
    const Eigen::Index n = vertex.local.rows(), parts = vertex.gains.size(), frames = vertex.local.cols();
    // 1. The map from values of the product of the near parts to the local numbers.
    Columns by_number(n, products.matrix.cols());
    for (Eigen::Index k = 0; k < by_number.cols(); ++k)
        by_number.col(k).noalias() = matrixOf(products.matrix, k, n) * vertex.own;
    const Columns from_values = by_number * products.back, visible = visibleOf(vertex),
                  matrices = products.matricesOf(visible);
    Columns error = vertex.local;
    error.noalias() -= from_values * visible;
    // 2. Least squares, with ridges.
    const Columns slopes = slopesOf(vertex, from_values);
    Columns a = Columns::Zero(n + parts, n + parts);
    Eigen::VectorXf b(n + parts);
    a.diagonal() << Eigen::VectorXf::Constant(n, kOwnRidge), Eigen::VectorXf::Constant(parts, kGainRidge);
    b << -kOwnRidge * (vertex.own - mean), -kGainRidge * (vertex.gains.array() - 1).matrix();
    a.bottomRightCorner(parts, parts).noalias() += slopes.transpose() * slopes;
    b.tail(parts).noalias() += slopes.transpose() * error.reshaped();
    for (Eigen::Index f = 0; f < frames; ++f) {
        const auto m = matrixOf(matrices, f, n);
        a.topLeftCorner(n, n).noalias() += m.transpose() * m;
        a.topRightCorner(n, parts).noalias() += m.transpose() * slopes.middleRows(f * n, n);
        b.head(n).noalias() += m.transpose() * error.col(f);
    }
    a.bottomLeftCorner(parts, n) = a.topRightCorner(n, parts).transpose();
    const Eigen::VectorXf step = a.llt().solve(b);
    vertex.own += step.head(n);
    vertex.gains = (vertex.gains + step.tail(parts)).cwiseMax(0.0f).cwiseMin(kMaxGain);
}

// The columns of the given frames.
Columns columnsAt(const Columns& all, std::span<const std::size_t> frames) {
    Columns some(all.rows(), Eigen::Index(frames.size()));
    for (std::size_t i = 0; i < frames.size(); ++i) some.col(Eigen::Index(i)) = all.col(Eigen::Index(frames[i]));
    return some;
}

void solveGains(const Products& products, NearVertex& vertex) {
    const Eigen::VectorXf mean = vertex.local.rowwise().mean();
    vertex.gains.setOnes(Eigen::Index(vertex.hidden.size()));
    solveOwn(products, mean, vertex);
    for (int round = 0; round < kRounds; ++round) stepBoth(products, mean, vertex);
    vertex.gains = (vertex.gains / kPerGain).array().round().matrix() * kPerGain;
    solveOwn(products, mean, vertex);
}

// Replaces the numbers of every frame by those without the near parts.
void divideByNear(const Products& products, NearVertex& vertex) {
    const Eigen::Index n = vertex.local.rows();
    const Columns matrices = products.matricesOf(visibleOf(vertex));
    for (Eigen::Index f = 0; f < vertex.local.cols(); ++f) {
        const auto m = matrixOf(matrices, f, n);
        Columns a = kFrameRidge * Columns::Identity(n, n);
        a.noalias() += m.transpose() * m;
        const Eigen::VectorXf b = m.transpose() * (vertex.local.col(f) - m * vertex.own);
        vertex.local.col(f) = vertex.own + a.llt().solve(b);
    }
}

// The visibility past each near part alone at some vertices, with gains of 1.
struct NearFactors {
    std::size_t frames = 0, columns = 0, vertices = 0;
    std::vector<float> values;  // [F, Composition::near_count, vertices, kFarCoefficients]
};

NearFactors factorsOf(const NearProblem& problem, const VertexSet& vertices) {
    const std::size_t parts = problem.far->partCount(), stride = vertices.part.size() * kFarCoefficients;
    NearFactors near{problem.poses->frameCount(), problem.far->nearParts().count, vertices.part.size(), {}};
    near.values.resize(near.frames * near.columns * stride);
    std::vector<std::vector<std::uint16_t>> near_part(near.columns);  // indexed by part
    for (std::size_t k = 0; k < near.columns; ++k)
        for (std::size_t p = 0; p < parts; ++p) near_part[k].push_back(problem.far->nearParts().of(p)[k]);
    for (std::size_t f = 0; f < near.frames; ++f) {
        const SetPose pose = poseOfSet(vertices, *problem.poses, f, problem.posed.subspan(f * parts, parts));
        for (std::size_t k = 0; k < near.columns; ++k)
            nearFactor(*problem.far, vertices, pose, near_part[k],
                       std::span(near.values).subspan((f * near.columns + k) * stride, stride));
    }
    return near;
}

// Returns the visibility that the near parts hide from vertex v of the factors.
std::vector<Columns> hiddenFrom(const NearFactors& near, std::size_t v, const Products& products) {
    std::vector<Columns> hidden;
    Columns factor(Eigen::Index(kFarCoefficients), Eigen::Index(near.frames));
    for (std::size_t k = 0; k < near.columns; ++k) {
        for (std::size_t f = 0; f < near.frames; ++f)
            std::copy_n(&near.values[((f * near.columns + k) * near.vertices + v) * kFarCoefficients], kFarCoefficients,
                        factor.col(Eigen::Index(f)).data());
        hidden.push_back(Columns::Ones(products.at.rows(), factor.cols()) - products.at * factor);
    }
    return hidden;
}

// E of a vertex, from its coefficients.
float ambientOf(std::span<const float> weights, std::span<const float> coefficients) {
    return std::inner_product(weights.begin(), weights.end(), coefficients.begin(), 0.0f);
}

// Writes the numbers of a sky that nothing hides, for some vertices.
void fillWithSky(std::size_t of_vertex, std::span<float> coefficients) {
    for (std::size_t i = 0; i < coefficients.size(); ++i)
        coefficients[i] = i % of_vertex == 0 ? std::sqrt(4 * std::numbers::pi_v<float>) : 0.0f;
}

// The mean over some frames of the E that near parts with gains of 1 and far parts leave to some vertices.
std::vector<float> leftByParts(const NearProblem& problem, std::span<const std::uint32_t> vertices,
                               std::span<const float> ambient) {
    VertexSet set = vertexSet(*problem.model, vertices, problem.joint_of_cluster);
    set.gains.assign(set.gains.size(), std::uint8_t(1 / kPerGain));
    const std::size_t parts = problem.far->partCount(), n = ambient.size();
    const std::vector<std::size_t> frames = evenSample(problem.train, kMaxGainFrames);
    std::vector<float> factors(vertices.size() * kFarCoefficients), coefficients(vertices.size() * n),
        left(vertices.size());
    for (const std::size_t f : frames) {
        farFactors(*problem.far, set, poseOfSet(set, *problem.poses, f, problem.posed.subspan(f * parts, parts)),
                   factors);
        fillWithSky(n, coefficients);
        multiplyByFar(*problem.far, factors, coefficients);
        for (std::size_t v = 0; v < left.size(); ++v)
            left[v] +=
                std::max(ambientOf(ambient, std::span(coefficients).subspan(v * n, n)), 0.0f) / float(frames.size());
    }
    return left;
}

}  // namespace

std::vector<std::uint8_t> takeOutNearParts(const NearProblem& problem, std::span<const std::uint32_t> vertices,
                                           MatrixF& coefficients) {
    const Products products(problem.far->constants().order);
    const std::vector<std::size_t> used = evenSample(problem.train, kMaxGainFrames);
    const auto n = Eigen::Index(coefficients.columns / vertices.size());
    std::vector<std::uint8_t> gains;
    for (std::size_t first = 0; first < vertices.size(); first += kNearBlock) {
        const std::size_t count = std::min(kNearBlock, vertices.size() - first);
        const NearFactors near =
            factorsOf(problem, vertexSet(*problem.model, vertices.subspan(first, count), problem.joint_of_cluster));
        for (std::size_t v = 0; v < count; ++v) {
            auto of_vertex = asEigen(coefficients).middleCols(Eigen::Index(first + v) * n, n);
            NearVertex all{hiddenFrom(near, v, products), of_vertex.transpose(), {}, {}}, train;
            // 1. The gains, from training frames.
            for (const Columns& hidden : all.hidden) train.hidden.push_back(columnsAt(hidden, used));
            train.local = columnsAt(all.local, used);
            solveGains(products, train);
            for (const float gain : train.gains) gains.push_back(std::uint8_t(std::lround(gain / kPerGain)));
            // 2. The numbers without near parts, of all frames.
            all.gains = train.gains;
            all.own = train.own;
            divideByNear(products, all);
            of_vertex = all.local.transpose();
        }
    }
    return gains;
}

std::vector<bool> hiddenByParts(const NearProblem& problem, std::span<const std::uint32_t> vertices,
                                const MatrixF& whole, std::span<const float> ambient) {
    const std::size_t n = ambient.size();
    // 1. The vertices that no training frame shows.
    std::vector<std::uint32_t> never;
    std::vector<std::size_t> place;  // index of each in `vertices`
    for (std::size_t v = 0; v < vertices.size(); ++v) {
        const auto shows = [&](std::size_t f) {
            return ambientOf(ambient, whole.row(f).subspan(v * n, n)) >= kHiddenE;
        };
        if (std::any_of(problem.train.begin(), problem.train.end(), shows)) continue;
        never.push_back(vertices[v]);
        place.push_back(v);
    }
    // 2. Those of them that parts hide.
    std::vector<bool> hidden(vertices.size());
    if (never.empty()) return hidden;
    const std::vector<float> left = leftByParts(problem, never, ambient);
    for (std::size_t i = 0; i < never.size(); ++i) hidden[place[i]] = left[i] < kLeftToHidden;
    return hidden;
}

void openHidden(const std::vector<bool>& hidden, std::span<std::uint8_t> gains, MatrixF& coefficients) {
    const std::size_t n = coefficients.columns / hidden.size(), nears = gains.size() / hidden.size();
    for (std::size_t v = 0; v < hidden.size(); ++v) {
        if (!hidden[v]) continue;
        std::fill_n(gains.begin() + std::ptrdiff_t(v * nears), nears, std::uint8_t(1 / kPerGain));
        for (std::size_t f = 0; f < coefficients.rows; ++f) fillWithSky(n, coefficients.row(f).subspan(v * n, n));
    }
}

}  // namespace penumbra
