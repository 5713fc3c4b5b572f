#pragma once
// The camera of sh/camera.h under the hands of a user.
#include "sh/bounding_box.h"
#include "sh/camera.h"

namespace penumbra {

// Target and distance such that the sphere around the box is within a picture of this aspect (width / height). Keeps
// the angles.
void frameAll(Camera& camera, const BoundingBox& box, double aspect);
// A drag by pixels of a picture that is `height` pixels high: its whole height turns by half a turn; pitch stays within
// 89 degrees.
void orbit(Camera& camera, double right, double down, double height);
// Moves the target so that what is at its depth follows the pointer.
void pan(Camera& camera, double right, double down, double height);
// Steps of a wheel, each 10% nearer; `radius` of the scene bounds the distance.
void dolly(Camera& camera, double steps, double radius);
// A whole turn in 12 seconds.
void turntable(Camera& camera, double seconds);

}  // namespace penumbra
