#pragma once
// Compact forms of reflectance slices C [J^2, E] (sh/reflectance.h): only the entries that a symmetry of the BRDF
// leaves.
//
// C_(l m)(L M) pairs y_lm of the incident direction with y_LM of the view, where L + M is even. At one height y_lm goes
// with cos(m phi) for m >= 0 and with sin(|m| phi) for m < 0.
//
// - Isotropic: f is a function of phi_i - phi_o and even in it, so its series is the sum over m of a_m cos m(phi_i -
//   phi_o) = a_m (cos m phi_i cos m phi_o + sin m phi_i sin m phi_o). Only m = M is left, and the entry of -m equals
//   that of m.
// - Orthotropic: f is unchanged by the mirror y = 0, which takes phi of both directions to -phi and changes the sign of
//   sines only. So cosines pair with cosines (m >= 0) and sines with sines (m < 0). f is unchanged by x = 0 too, hence
//   by both mirrors one after the other. That is a turn by pi, which multiplies y_lm by (-1)^m, so even m pair with
//   even and odd with odd.
//
// The fit of C keeps all this: its weights w_o z_o have the symmetries, and the symmetries map the span of y_even to
// itself.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sh/reflectance.h"

namespace penumbra {

enum class SliceForm : std::uint8_t { kGeneral = 0, kOrthotropic = 1, kIsotropic = 2 };
const char* nameOf(SliceForm form);  // "general", "orthotropic", "isotropic"

// Returns, for every entry of C in row-major order, the position of its value among those that the form keeps, or -1
// where the form has zero. Kept entries are in the order of C; of two equal entries the one with m > 0 is kept.
std::vector<int> entryPositions(SliceForm form, int slice_order, int view_order);

// Returns the numbers of a channel: 375 general, 102 orthotropic, 32 isotropic at slice and view order 5.
std::size_t entryCount(SliceForm form, int slice_order, int view_order);

// Turns [channels, J^2, E] into [channels, entryCount] and back. Entries that the form has equal give their mean.
std::vector<float> compactSlices(SliceForm form, int slice_order, int view_order, std::span<const float> slices);
std::vector<float> expandSlices(SliceForm form, int slice_order, int view_order, std::span<const float> entries);

// Returns the form with the fewest numbers that changes no entry of any channel by more than kFormTolerance of the
// largest entry of all.
constexpr float kFormTolerance = 1e-6f;
SliceForm mostCompactForm(int slice_order, int view_order, std::span<const float> slices);

}  // namespace penumbra
