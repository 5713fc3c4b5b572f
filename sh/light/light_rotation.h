#pragma once
// Reads the rotation of a light from the command line. The player and the ray-traced reference share it.
#include <string_view>

#include "sh/vec3.h"

namespace penumbra {

// Reads "yaw=30,pitch=10,roll=0" (any subset) or "axis=0/1/0,angle=30", in degrees; "" is no rotation. The result turns
// the light in the model frame, where y is up: L'(s) = L(R^T s). Roll turns about z (x towards y). Then pitch turns
// about x, so that what is at +z rises towards +y. Then yaw turns about y, so that what is at +z moves towards +x. The
// camera's angles move the camera in the same way. An axis turns anticlockwise as seen from its tip. Throws
// std::invalid_argument with a sentence.
Mat3d parseLightRotation(std::string_view text);

}  // namespace penumbra
