#include "runtime/shade/lambert_material.h"

#include <array>
#include <cmath>
#include <numbers>

#include "sh/sh_basis.h"
#include "sh/zonal.h"

namespace penumbra {

LambertMaterial::LambertMaterial(Vec3 albedo) {
    constexpr int kOrder = 5;  // order of the clamped cosine
    std::array<double, kOrder> zonal{};
    clampedCosineZonal(zonal);
    slices.assign(coefficientCount(kOrder), 0.0f);
    // f = C y_0(omega_o), and y_0 = 1 / (2 sqrt(pi)).
    for (int l = 0; l < kOrder; ++l)
        slices[std::size_t(shIndex(l, 0))] =
            float(zonal[std::size_t(l)] / std::numbers::pi * 2 * std::sqrt(std::numbers::pi));
    view.name = "lambert";
    view.slice_order = kOrder;
    view.view_order = 1;
    view.channels = 1;
    view.color = albedo;
    view.slices = view.stored_slices = slices;
}

}  // namespace penumbra
