#pragma once
// Compact forms of reflectance slices C [J^2, E] (sh/reflectance.h): the entries that a symmetry of the BRDF leaves.
//
// C_(l m)(L M) pairs y_lm of the incident direction with y_LM of the view, L + M even. At one height y_lm goes with
// cos(m phi) where m >= 0 and with sin(|m| phi) where m < 0.
// Isotropic: f is a function of phi_i - phi_o and even in it, so its series is sum over m of
//   a_m cos m(phi_i - phi_o) = a_m (cos m phi_i cos m phi_o + sin m phi_i sin m phi_o):
//   only m = M is left, and the entry of -m equals that of m.
// Orthotropic: f stays under the mirror y = 0, phi -> -phi of both directions, which changes the sign of sines only:
//   cosines pair with cosines (m >= 0), sines with sines (m < 0). It stays under x = 0 too, hence under both one after
//   the other, a turn by pi, which multiplies y_lm by (-1)^m: even m pair with even, odd with odd.
// The fit of C keeps all this: its weights w_o z_o have the symmetries, and they map the span of y_even to itself.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sh/reflectance.h"

namespace penumbra {

enum class SliceForm : std::uint8_t { kGeneral = 0, kOrthotropic = 1, kIsotropic = 2 };
const char* nameOf(SliceForm form);  // "general", "orthotropic", "isotropic"

// For every entry of C, row-major, the position of its value among those that the form keeps, or -1 where it has zero.
// Kept entries are in the order of C; of two that are equal the one with m > 0 is kept.
std::vector<int> entryPositions(SliceForm form, int slice_order, int view_order);

// Numbers a channel: 375 general, 102 orthotropic, 32 isotropic at slice and view order 5.
std::size_t entryCount(SliceForm form, int slice_order, int view_order);

// [channels, J^2, E] to [channels, entryCount]: entries that the form has equal give their mean. And back.
std::vector<float> compactSlices(SliceForm form, int slice_order, int view_order, std::span<const float> slices);
std::vector<float> expandSlices(SliceForm form, int slice_order, int view_order, std::span<const float> entries);

// The form of fewest numbers that changes no entry of any channel by more than kFormTolerance of the largest of all.
constexpr float kFormTolerance = 1e-6f;
SliceForm mostCompactForm(int slice_order, int view_order, std::span<const float> slices);

}  // namespace penumbra
