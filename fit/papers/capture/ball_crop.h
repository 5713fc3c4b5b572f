#pragma once
// How Nowrouzezahrai 2011 (section 4) makes light of a mirror ball: the square crop of one photograph, in which (u, v)
// in [-1, 1]^2 are coordinates and the outline of the ball is r = 1, is projected to SH by a formula for directions and
// weights. These are references to compare with: formats/capture has the exact way.
#include <optional>
#include <vector>

#include "formats/capture/posed_picture.h"
#include "sh/light/mirror_ball.h"

namespace penumbra {

enum class CropFormula {
    kFarBall,      // a ball seen by a distant camera: polar angle 2 asin r from the axis ball -> camera, weight 4 du dv
    kEquationSix,  // polar angle pi r, weight (2 pi / w)^2 sinc(pi r): an angular map, which such a crop is not. The
                   // paper prints the two angles swapped; as printed the weights sum to 1.46 spheres.
};

struct CropDirection {
    double polar = 0, azimuth = 0;  // from the axis ball -> camera; from u towards v
    double steradians = 0;          // solid angle of the pixel
};
// Returns what a place in the crop shows by a formula. None outside of the outline. `width` is the crop's, in pixels.
std::optional<CropDirection> cropDirection(CropFormula formula, double u, double v, int width);

// Projects the crop of the ball, resampled to width x width pixels, to SH in the scene's frame [order^2, 3]. The
// reflectance is divided out.
std::vector<double> projectCrop(const PosedPicture& shot, const MirrorBall& ball, CropFormula formula, int order,
                                int width = 256);

}  // namespace penumbra
