#pragma once
// Band weights of the sharpest zonal filter that never turns a non-negative light negative.
#include <cassert>
#include <span>

#include "sh/sh_basis.h"

namespace penumbra {

// Returns the window of the sharpest zonal kernel of this order that is nowhere negative: it turns every light >= 0
// into one that is >= 0. It has the largest w_1 that this allows. The kernel is q^2 or (1 + x) q^2, where q has the
// Gauss nodes but the last as its zeros. tests/golden/light.json has the windows of orders 3 to 6.
inline std::span<const double> sharpestWindow(int order) {
    static constexpr double kWindows[kMaxOrder][kMaxOrder] = {
        {1},
        {1, 1.0 / 3},
        {1, 0.57735026918962573, 0.2},
        {1, 0.68989794855663562, 0.34494897427831781, 0.09357871796022743},
        {1, 0.77459666924148338, 0.48571428571428571, 0.22131333406898007, 0.06349206349204517},
        {1, 0.8228240809745874, 0.5761143020540718, 0.3261641250955518, 0.14039292951994284, 0.0356806143051892},
        {1, 0.8611363115940526, 0.6554076628610677, 0.4283890575415985, 0.23543778300975232, 0.09835164864825402,
         0.02635649431785249},
        {1, 0.8857916077709602, 0.7092461427365738, 0.5047838844600878, 0.3154254015168352, 0.16508996392375036,
         0.06698958850794337, 0.016604824016176162}};
    assert(order >= 1 && order <= kMaxOrder);
    return std::span(kWindows[order - 1]).first(std::size_t(order));
}

}  // namespace penumbra
