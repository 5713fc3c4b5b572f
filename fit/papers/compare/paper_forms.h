#pragma once
// The fits of figures 8 and 9 of Nowrouzezahrai 2009 learn other numbers of a vertex than models that become files do.
// This file has these numbers. As in the paper, predictions are not clamped.
#include "fit/visibility/local_coefficients.h"

namespace penumbra {

extern const NumberForm kUnclampedForm;  // visibility in the local frame
// The moments of V(s) max(s.N, 0), in convention A or B. They are 0 below the horizon whatever the convention says, and
// exact, which takes moments of one order more.
extern const NumberForm kCosineForm;
// Visibility in the model frame, in convention A or B. With A it has the 1 below the vertex' own horizon. The weights
// of E turn with the normal, so there are none.
extern const NumberForm kModelFrameForm;

// Computes the moments of z f(s), order^2 of them, from those of f, (order + 1)^2: z y_lm = a(l+1,m) y_(l+1)m + a(l,m)
// y_(l-1)m with a(l,m)^2 = (l^2 - m^2) / (4 l^2 - 1).
void timesZ(int order, std::span<const float> moments, std::span<float> out);

}  // namespace penumbra
