#pragma once
// A light's rotation from the command line, the same in the player and the ray-traced reference.
#include <string_view>

#include "sh/vec3.h"

namespace penumbra {

// "yaw=30,pitch=10,roll=0" or "axis=0/1/0,angle=30", degrees, any subset of the former; "" is no rotation. Turns the
// light in the model frame: L'(s) = L(R^T s). y is up. Roll turns about z (x towards y), then pitch about x so that
// what is at +z rises towards +y, then yaw about y so that what is at +z moves towards +x: as the camera's angles move
// the camera. An axis turns anticlockwise as seen from its tip. Throws std::invalid_argument with a sentence.
Mat3d parseLightRotation(std::string_view text);

}  // namespace penumbra
