#include "fit/papers/transfer/predict_transfer.h"

#include <algorithm>
#include <cassert>

#include "fit/numerics/eigen_map.h"
#include "formats/common/parallel_for.h"
#include "formats/stage/same_character.h"

namespace penumbra {

namespace {

using Rows = EigenRows<float>;
using ConstRows = Eigen::Map<const Rows>;
using Row = Eigen::RowVectorXf;

constexpr Eigen::Index kVertexTile =
    512;  // vertices that are summed together: three channels of them stay in the first cache

// Returns what the maps multiply: the angles that the model sees or their principal components, and a 1 for the bias.
Row inputsOf(const TransferModel& model, std::span<const float> pose) {
    const auto a = Eigen::Index(model.angles.size()), k = Eigen::Index(model.inputs());
    Row angles(a), inputs(k + 1);
    for (Eigen::Index i = 0; i < a; ++i) angles[i] = pose[model.angles[std::size_t(i)]];
    if (model.kind == TransferModelKind::kLinear)
        inputs.head(k) = angles;
    else
        inputs.head(k) = angles * ConstRows(model.pose_basis.data(), a, k);
    inputs[k] = 1;
    return inputs;
}

ConstRows mapOf(const TransferModel& model, std::size_t coefficient) {
    const auto rows = Eigen::Index(model.inputs()) + 1, columns = Eigen::Index(model.outputs());
    return {model.weights.data() + Eigen::Index(coefficient) * rows * columns, rows, columns};
}

// Sets `out` to the sum over i of factors[i] times row i of `rows`, for the columns [first, first + out.size()).
void combineRows(std::span<const float> factors, ConstRows rows, Eigen::Index first, std::span<float> out) {
    for (std::size_t i = 0; i < factors.size(); ++i) {
        const float factor = factors[i];
        const float* row = rows.data() + Eigen::Index(i) * rows.cols() + first;
        for (std::size_t v = 0; v < out.size(); ++v) out[v] += factor * row[v];
    }
}

}  // namespace

std::vector<float> predictTransfer(const TransferModel& model, std::span<const float> pose, int threads) {
    assert(pose.size() == std::size_t(model.pose_size));
    const Row inputs = inputsOf(model, pose);
    const auto n = Eigen::Index(model.coefficients()), m = Eigen::Index(model.outputs()),
               vertices = Eigen::Index(model.mesh.vertexCount());
    Rows scores(n, m);
    for (Eigen::Index c = 0; c < n; ++c) scores.row(c) = inputs * mapOf(model, std::size_t(c));
    std::vector<float> out(std::size_t(vertices * n));
    Eigen::Map<Rows> transfer(out.data(), vertices, n);
    if (model.kind == TransferModelKind::kLinear) {
        transfer = scores.transpose();
        return out;
    }
    const ConstRows basis(model.basis.data(), m, vertices);
    const Eigen::Map<const Eigen::VectorXf> mean(model.mean.data(), vertices);
    parallelFor(std::size_t((vertices + kVertexTile - 1) / kVertexTile), threads, [&](std::size_t tile) {
        const Eigen::Index first = Eigen::Index(tile) * kVertexTile, count = std::min(kVertexTile, vertices - first);
        const Rows sum = basis.middleCols(first, count).transpose() * scores.transpose();
        transfer.middleRows(first, count) = sum.colwise() + mean.segment(first, count);
    });
    return out;
}

LitTransfer contractLight(const TransferModel& model, std::span<const float> light) {
    assert(light.size() == 3 * model.coefficients());
    LitTransfer lit;
    const std::size_t size = (model.inputs() + 1) * model.outputs();
    for (std::size_t channel = 0; channel < 3; ++channel) {
        std::vector<float>& sum = lit.weights[channel];
        sum.assign(size, 0.0f);
        for (std::size_t c = 0; c < model.coefficients(); ++c) {
            const float factor = light[3 * c + channel];
            const float* weights = model.weights.data() + c * size;
            for (std::size_t i = 0; i < size; ++i) sum[i] += factor * weights[i];
            lit.of_mean[channel] += factor;
        }
    }
    return lit;
}

void shadeTransfer(const TransferModel& model, const LitTransfer& lit, std::span<const float> pose,
                   std::span<float> out) {
    const Row inputs = inputsOf(model, pose);
    const auto k = Eigen::Index(model.inputs()) + 1, m = Eigen::Index(model.outputs()),
               vertices = Eigen::Index(model.mesh.vertexCount());
    assert(out.size() == std::size_t(3 * vertices));
    std::array<Row, 3> scores;
    for (std::size_t c = 0; c < 3 && model.kind == TransferModelKind::kPca; ++c)
        scores[c] = inputs * ConstRows(lit.weights[c].data(), k, m);
    for (Eigen::Index first = 0; first < vertices; first += kVertexTile) {
        const Eigen::Index count = std::min(kVertexTile, vertices - first);
        for (std::size_t c = 0; c < 3; ++c) {
            const std::span<float> sum =
                out.subspan(c * std::size_t(vertices) + std::size_t(first), std::size_t(count));
            if (model.kind == TransferModelKind::kLinear) {
                std::fill(sum.begin(), sum.end(), 0.0f);
                combineRows({inputs.data(), std::size_t(k)}, {lit.weights[c].data(), k, m}, first, sum);
                continue;
            }
            for (Eigen::Index v = 0; v < count; ++v)
                sum[std::size_t(v)] = lit.of_mean[c] * model.mean[std::size_t(first + v)];
            combineRows({scores[c].data(), std::size_t(m)}, {model.basis.data(), m, vertices}, first, sum);
        }
    }
}

void checkCharacter(const TransferModel& model, const VisibilityHeader& header, const std::string& file) {
    checkSameCharacter({model.mesh, model.skin, model.input_names, std::size_t(model.pose_size)}, header, file);
}

void predictFile(const TransferModel& model, const VisibilityReader& poses, const PredictionOutput& to) {
    writePredictions(poses, model.order, kDiffuseTransfer, to,
                     [&](const VisibilityFrame& frame) { return predictTransfer(model, frame.pose, to.threads); });
}

}  // namespace penumbra
