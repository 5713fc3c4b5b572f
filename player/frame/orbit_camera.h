#pragma once
// Moves the camera of sh/camera.h as a user wants it.
#include "sh/bounding_box.h"
#include "sh/camera.h"

namespace penumbra {

// Sets target and distance such that the sphere around the box is within a picture of this aspect (width / height).
// Keeps the angles.
void frameAll(Camera& camera, const BoundingBox& box, double aspect);
// Turns by a drag, in pixels of a picture that is `height` pixels high. The whole height turns by half a turn, and
// the pitch stays within 89 degrees.
void orbit(Camera& camera, double right, double down, double height);
// Moves the target so that what is at its depth follows the pointer.
void pan(Camera& camera, double right, double down, double height);
// Moves by steps of a wheel, each of which is 10% nearer. `radius` of the scene bounds the distance.
void dolly(Camera& camera, double steps, double radius);
constexpr int kTurnSeconds = 12;
// Turns around once in kTurnSeconds.
void turntable(Camera& camera, double seconds);

}  // namespace penumbra
