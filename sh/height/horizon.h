#pragma once
// Computes the visibility that a height field leaves at a point: horizons at some azimuths, and the SH of the sky above
// them (Nowrouzezahrai 2009 eq. 4-5, corrected: omega is an elevation). These are the directions in which a point
// looks; height_visibility.h computes what it sees, and tests/sh/horizon_reference.h has the plain form.
//
// V is 1 above the horizon and 0 below it, over the whole sphere, in the frame of the field. Between azimuths the
// trapezoid rule integrates: v_l,+-m = 2 pi / A sum_i Theta_l|m|(omega_i) {cos, sin}(m phi_i). It is exact for A > 2 n
// but for what the horizon does between azimuths, and errs less than wedges with a linear horizon.
#include <vector>

#include "sh/height/height_field.h"

namespace penumbra {

// True horizons at 16 azimuths leave rms V 0.0137 of order 5 on rough ground, at 20 they leave 0.0094.
constexpr int kHorizonAzimuths = 20;
constexpr int kMinHeightOrder = 4, kMaxHeightOrder = 5;

// A sample of the pyramid: how far it is along an azimuth, in texels and in metres, and of which level.
struct HorizonTap {
    float row = 0, column = 0;  // texels from the receiver
    float per_metre = 0;        // 1 / distance
    int level = 0;
};
// Distances are 1/4 and 1/2 of a texel, then there are 3 to an octave up to 16 texels and 2.5 to an octave up to the
// longer side of the field. Within a cell, which is bilinear, more of them find nothing else; beyond it they are what
// errs. The level is that of the distance less 3.25: pure maxima at the level of the distance are far too dark.
// taps[a * count + k], k ascending.
struct HorizonTaps {
    std::size_t count = 0;  // taps per azimuth
    std::vector<HorizonTap> taps;
};
HorizonTaps horizonTaps(const HeightField& field, int azimuths = kHorizonAzimuths);
// The azimuth of ray `a`, from +x to +y.
double horizonAzimuth(int a, int azimuths);

// The tangent of the horizon where nothing at all is in the way. Borders that go on for ever reach the horizontal.
constexpr float kNoHorizon = -1e9f;
inline float leastHorizon(HeightBorder border) { return border == HeightBorder::kOpen ? kNoHorizon : 0; }

}  // namespace penumbra
