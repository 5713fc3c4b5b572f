#include "fit/papers/transfer/transfer_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "sh/sh_product.h"

namespace penumbra {

namespace {

// Vertices whose frames are compressed together in a file, and the bytes of a block that is read at a time.
constexpr std::size_t kChunkVertices = 64, kReadBytes = std::size_t(32) << 20;

std::size_t blockWidth(const VisibilityHeader& header) {
    const std::size_t chunk = kChunkVertices * header.coefficientCount() * header.frames.frameCount() * sizeof(float);
    return kChunkVertices * std::max<std::size_t>(kReadBytes / chunk, 1);
}

}  // namespace

TransferSource::TransferSource(const VisibilityReader& reader, int order, std::vector<std::size_t> frames,
                               std::optional<std::size_t> indirect_channel)
    : reader_(reader),
      order_(order),
      channel_(indirect_channel),
      frames_(std::move(frames)),
      width_(blockWidth(reader.header())),
      cosine_(order) {
    if (!isVisibility()) return;
    for (const std::size_t frame : frames_) {
        const std::vector<Vec3> normals = reader.readPose(frame).normals;
        normals_.insert(normals_.end(), normals.begin(), normals.end());
    }
}

std::size_t TransferSource::blockCount() const { return (reader_.header().mesh.vertexCount() + width_ - 1) / width_; }

void TransferSource::convert(std::span<const float> stored, Vec3 normal, std::span<float> transfer) const {
    if (isVisibility())
        cosine_.apply(stored, normal, transfer);
    else
        std::copy_n(stored.begin(), transfer.size(), transfer.begin());
}

MatrixF TransferSource::readBlock(std::size_t block) const {
    const VisibilityHeader& header = reader_.header();
    const std::size_t vertices = header.mesh.vertexCount(), begin = firstVertex(block),
                      width = std::min(width_, vertices - begin), stored = header.coefficientCount();
    MatrixF rows(coefficients() * frames(), width);
    if (channel_) {
        readIndirectRows(begin, width, rows);
        return rows;
    }
    std::vector<float> baked(header.frames.frameCount() * width * stored), transfer(coefficients());
    reader_.readVertices(begin, begin + width, baked);
    for (std::size_t i = 0; i < frames(); ++i)
        for (std::size_t v = 0; v < width; ++v) {
            const Vec3 normal = isVisibility() ? normals_[i * vertices + begin + v] : Vec3{};
            convert(std::span(baked).subspan((frames_[i] * width + v) * stored, stored), normal, transfer);
            for (std::size_t c = 0; c < transfer.size(); ++c) rows(c * frames() + i, v) = transfer[c];
        }
    return rows;
}

void TransferSource::readIndirectRows(std::size_t begin, std::size_t width, MatrixF& rows) const {
    const VisibilityHeader& header = reader_.header();
    const std::size_t stored = header.coefficientCount();
    std::vector<float> baked(header.frames.frameCount() * width * 3 * stored);
    reader_.readIndirectVertices(begin, begin + width, baked);
    for (std::size_t i = 0; i < frames(); ++i)
        for (std::size_t v = 0; v < width; ++v)
            for (std::size_t c = 0; c < coefficients(); ++c)
                rows(c * frames() + i, v) = baked[((frames_[i] * width + v) * 3 + *channel_) * stored + c];
}

ColumnBlocks TransferSource::blocks() const {
    return {coefficients() * frames(), reader_.header().mesh.vertexCount(), blockCount(),
            [this](std::size_t block) { return readBlock(block); }};
}

std::vector<float> TransferSource::ofFrame(const VisibilityFrame& frame) const {
    const std::size_t stored = reader_.header().coefficientCount(), n = coefficients();
    std::vector<float> transfer(frame.normals.size() * n);
    for (std::size_t v = 0; v < frame.normals.size() && channel_; ++v)
        std::copy_n(frame.indirect.begin() + std::ptrdiff_t((3 * v + *channel_) * stored), n,
                    transfer.begin() + std::ptrdiff_t(v * n));
    for (std::size_t v = 0; v < frame.normals.size() && !channel_; ++v)
        convert(std::span(frame.coefficients).subspan(v * stored, stored), frame.normals[v],
                std::span(transfer).subspan(v * n, n));
    return transfer;
}

}  // namespace penumbra
