#pragma once
// E_transfer of Nowrouzezahrai 2007 (section 6): the squared difference of the transfer of model and truth, integrated
// over the visible hemisphere. It knows no light, and it is the same measure for models of visibility and of transfer.
#include <optional>
#include <vector>

#include "player/frame/frame_values.h"
#include "sh/cosine_product.h"
#include "sh/hemisphere_norm.h"

namespace penumbra {

class TransferError {
public:
    // Compares order() bands: those of an asset of transfer, else up to 6, one fewer than the truth has.
    TransferError(const AssetView& asset, const AssetView& truth);
    int order() const { return order_; }
    // Returns E_transfer of every vertex. `vertices` have the numbers of the model. The shot must have truth.
    std::vector<float> of(const Shot& shot, const FrameVertices& vertices, int threads) const;

private:
    int order_;
    HemisphereNorm norm_;
    CosineProduct cosine_;
    std::vector<double> transfer_of_;  // [order^2, n^2] integral over z >= 0 of z y_i y_j, of visibility alone

    float ofTransfer(const Shot& shot, std::span<const float> truth, std::size_t vertex,
                     const FrameVertices& vertices) const;
    float ofVisibility(const Shot& shot, std::size_t vertex, const FrameVertices& vertices) const;
};

// Tells whether the truth has enough bands for a TransferError.
bool hasTransferOf(const AssetView& asset, const AssetView& truth);

}  // namespace penumbra
