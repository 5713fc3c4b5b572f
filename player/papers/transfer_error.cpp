#include "player/papers/transfer_error.h"

#include <algorithm>
#include <array>

#include "formats/common/parallel_for.h"
#include "player/papers/transfer/transfer_model.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

constexpr std::size_t kErrorPiece = 256;  // vertices of a task
constexpr std::size_t kMaxNumbers = coefficientCount(kMaxOrder);

}  // namespace

TransferError::TransferError(const AssetView& asset, const AssetView& truth)
    : order_(transferErrorOrder(asset, truth)),
      norm_(order_),
      cosine_(std::min(order_, kMaxOrder - 1)),
      transfer_of_(cosineMatrix(order_, asset.model.convention.order)) {}

float TransferError::ofTransfer(const Shot& shot, std::span<const float> truth, std::size_t vertex,
                                const FrameVertices& vertices) const {
    const auto n = std::size_t(coefficientCount(order_)), first = vertex * std::size_t(shot.asset->model.stride);
    std::array<double, kMaxNumbers> difference;
    for (std::size_t c = 0; c < n; ++c) difference[c] = double(vertices.coefficients[first + c]) - truth[first + c];
    const std::span<const double> d = std::span(difference).first(n);
    return float(norm_.squared(d, d, vertices.normals[vertex])[0]);
}

float TransferError::ofVisibility(const Shot& shot, std::size_t vertex, const FrameVertices& vertices) const {
    const ModelView& model = shot.asset->model;
    const auto n = std::size_t(coefficientCount(order_)), m = std::size_t(coefficientCount(model.convention.order));
    const auto size = std::size_t(model.convention.size()), stored = std::size_t(coefficientCount(order_ + 1));
    std::array<float, kMaxNumbers> moments, local, truth, full;
    // 1. The truth, in the local frame. Its transfer follows from its moments exactly.
    readTruth(*shot.truth, shot.truth_frame, shot.asset->mesh.shading_point[vertex],
              std::span(moments).first(std::size_t(coefficientCount(shot.truth->truth.order))));
    const Mat3 frame = toLocalFrame(vertices.normals[vertex], vertices.tangents[vertex]);
    apply(makeShRotation(order_ + 1, frame), std::span<const float>(moments).first(stored),
          std::span(local).first(stored));
    cosine_.apply(std::span<const float>(local).first(stored), {0, 0, 1}, std::span(truth).first(n));
    // 2. The model's visibility, times the cosine.
    fullCoefficients(model.convention,
                     std::span(vertices.coefficients).subspan(vertex * std::size_t(model.stride), size),
                     std::span(full).first(m));
    std::array<double, kMaxNumbers> difference;
    for (std::size_t i = 0; i < n; ++i) {
        double sum = 0;
        for (std::size_t j = 0; j < m; ++j) sum += transfer_of_[i * m + j] * full[j];
        difference[i] = sum - truth[i];
    }
    return float(norm_.ofLocal(std::span<const double>(difference).first(n)));
}

std::vector<float> TransferError::of(PosedFrame& frame) const {
    const Shot& shot = frame.shot();
    const FrameVertices& vertices = frame.vertices(VisibilitySource::kModel);
    std::vector<float> errors(vertices.positions.size());
    const auto overVertices = [&](const auto& error) {
        parallelFor((errors.size() + kErrorPiece - 1) / kErrorPiece, frame.threads(), [&](std::size_t piece) {
            for (std::size_t v = piece * kErrorPiece; v < std::min(errors.size(), (piece + 1) * kErrorPiece); ++v)
                errors[v] = std::max(error(v), 0.0f);  // NaN stays NaN in this order
        });
        return errors;
    };
    if (hasVisibility(*shot.asset)) return overVertices([&](std::size_t v) { return ofVisibility(shot, v, vertices); });
    const std::vector<float> truth = truthCoefficients(shot, vertices, frame.threads());
    return overVertices([&](std::size_t v) { return ofTransfer(shot, truth, v, vertices); });
}

}  // namespace penumbra
