#pragma once
// Judges how well the corners of tags fit the poses that were found.
#include <string>

#include "sh/pinhole_camera.h"

namespace penumbra {

// Above this many pixels the camera is hardly that of cam.json, and a picture is of no use with it: 2, and more in a
// picture of over 1000 pixels of diagonal, where blur is as many pixels more.
double grossResidual(const PinholeCamera& camera);

// Warns of a residual above half a pixel, and throws InvalidInput for one above grossResidual(). Both sentences begin
// with `of`, which says whose residual it is, as "ball.json: the tag's corners are".
void judgeResidual(const std::string& of, double residual, const PinholeCamera& camera);

}  // namespace penumbra
