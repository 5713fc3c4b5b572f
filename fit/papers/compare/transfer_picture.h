#pragma once
#include "fit/papers/compare/compare_transfer.h"
#include "formats/common/mesh.h"
#include "formats/image/image_file.h"

namespace penumbra {

// Draws the pictured frame as Nowrouzezahrai 2007's figure 5 does: the bake, then each regularised model, diffuse with
// albedo 1 under one light, and below each model four times the square root of E_transfer as a grey, darker for larger
// errors.
Image transferPicture(const TransferComparison& comparison, const Mesh& mesh);

// Draws figure 7 of Nowrouzezahrai 2007: all light of the bake and of each model under the same light, with albedo 1,
// and below three times the light that bounced. The comparison must have bounces.
Image bouncesPicture(const TransferComparison& comparison, const Mesh& mesh);

}  // namespace penumbra
