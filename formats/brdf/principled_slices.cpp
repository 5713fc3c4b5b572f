#include "formats/brdf/principled_slices.h"

#include <utility>

namespace penumbra {

const std::vector<double>& PrincipledSlices::slicesOf(const BrdfSpec& part) {
    BrdfSpec white = part;
    white.color = {1, 1, 1};
    std::vector<double>& slices = of_part_[toString(white)];
    if (slices.empty()) slices = fitSlices(settledSlices(rgbBrdf(white), orders_.slice_order, threads_), orders_);
    return slices;
}

std::vector<double> PrincipledSlices::slicesOf(const Principled& material) {
    std::vector<double> sum;
    for (const BrdfSpec& term : principledTerms(material)) {
        const std::vector<double>& part = slicesOf(term);
        sum.resize(part.size());
        for (std::size_t i = 0; i < part.size(); ++i) sum[i] += term.color[int(i % kSliceChannels)] * part[i];
    }
    return sum;
}

}  // namespace penumbra
