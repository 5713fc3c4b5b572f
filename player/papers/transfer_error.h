#pragma once
// E_transfer of Nowrouzezahrai 2007 (section 6): the squared difference of the transfer of model and truth, integrated
// over the visible hemisphere. It knows no light, and it is the same measure for models of visibility and of transfer.
#include <vector>

#include "player/frame/posed_frame.h"
#include "sh/cosine_product.h"
#include "sh/hemisphere_norm.h"

namespace penumbra {

class TransferError {
public:
    // Compares transferErrorOrder() bands, at least 1.
    TransferError(const AssetView& asset, const AssetView& truth);
    // Returns E_transfer of every vertex of the model. The frame must have truth.
    std::vector<float> of(PosedFrame& frame) const;

private:
    int order_;
    HemisphereNorm norm_;
    CosineProduct cosine_;
    std::vector<double> transfer_of_;  // [order^2, n^2] integral over z >= 0 of z y_i y_j, of visibility alone

    float ofTransfer(const Shot& shot, std::span<const float> truth, std::size_t vertex,
                     const FrameVertices& vertices) const;
    float ofVisibility(const Shot& shot, std::size_t vertex, const FrameVertices& vertices) const;
};

}  // namespace penumbra
