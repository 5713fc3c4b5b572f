#pragma once
// Reads the diffuse transfer of a bake as Nowrouzezahrai 2007 lays it out.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fit/numerics/leading_components.h"
#include "formats/stage/visibility_file.h"
#include "sh/cosine_product.h"

namespace penumbra {

// The transfer of some frames of a bake of diffuse transfer, or of visibility of one order more. With a colour channel
// it is the indirect transfer in that channel, of a bake with bounces.
class TransferSource {
public:
    // `reader` must outlive it.
    TransferSource(const VisibilityReader& reader, int order, std::vector<std::size_t> frames,
                   std::optional<std::size_t> indirect_channel = {});
    std::size_t coefficients() const { return std::size_t(order_) * std::size_t(order_); }
    std::size_t frames() const { return frames_.size(); }
    std::size_t blockCount() const;
    std::size_t firstVertex(std::size_t block) const { return block * width_; }
    // Returns the rows of Nowrouzezahrai 2007 for some vertices, [n^2 frames, vertices]: row c * frames + i has
    // coefficient c in frame i.
    MatrixF readBlock(std::size_t block) const;
    ColumnBlocks blocks() const;
    // Returns the transfer in one frame of the file, [V, n^2].
    std::vector<float> ofFrame(const VisibilityFrame& frame) const;

private:
    const VisibilityReader& reader_;
    int order_;
    std::optional<std::size_t> channel_;  // set for the indirect transfer
    std::vector<std::size_t> frames_;
    std::size_t width_;          // vertices of a block
    CosineProduct cosine_;       // only for visibility
    std::vector<Vec3> normals_;  // [frames, V], only for visibility

    void readIndirectRows(std::size_t begin, std::size_t width, MatrixF& rows) const;
    void convert(std::span<const float> stored, Vec3 normal, std::span<float> transfer) const;
    bool isVisibility() const { return reader_.header().quantity != kDiffuseTransfer; }
};

}  // namespace penumbra
