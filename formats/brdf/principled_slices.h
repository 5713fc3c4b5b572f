#pragma once
// Slices of glTF's material from those of its three parts (sh/brdf/principled.h), each of which is fitted once: the
// materials of a file share most of them.
#include <map>
#include <string>
#include <vector>

#include "formats/brdf/fit_slices.h"
#include "sh/brdf/principled.h"

namespace penumbra {

class PrincipledSlices {
public:
    PrincipledSlices(const SliceOrders& orders, int threads) : orders_(orders), threads_(threads) {}

    const SliceOrders& orders() const { return orders_; }
    // Returns the slices of a part: of principledDiffuse(), principledF0(), principledF90(). [J^2, E, 3], three equal
    // channels. Throws as settledSlices() does.
    const std::vector<double>& slicesOf(const BrdfSpec& part);
    // Returns the slices of the material, [J^2, E, 3]: the parts times their coefficients.
    std::vector<double> slicesOf(const Principled& material);

private:
    SliceOrders orders_;
    int threads_;
    std::map<std::string, std::vector<double>> of_part_;
};

}  // namespace penumbra
