#pragma once
// Makes the visibility of one vertex a surface that can be drawn. It uses no GL.
#include <span>

#include "player/frame/shape.h"
#include "sh/visibility_convention.h"

namespace penumbra {

constexpr double kLobeRadius = 0.14;       // of visibility 1, in radii of what the picture frames
constexpr float kResidualEnlargement = 4;  // residuals are small: their lobes are drawn as many times as large

// Makes the function that a vertex' numbers stand for visible, over the directions above its horizon: a sphere about
// `center` is deformed to radius V(s) `scale`. Its values have x = V; where V < 0 the radius is 0.
Shape visibilityLobe(const Convention& convention, std::span<const float> coefficients, const Mat3& local_frame,
                     Vec3 center, float scale);
// The same of a function that may be negative: the radius is |V(s)| `scale`.
Shape signedLobe(const Convention& convention, std::span<const float> coefficients, const Mat3& local_frame,
                 Vec3 center, float scale);

// Turns the values into colours, under a lamp at the eye so that the shape is seen: blue for V = 0 to yellow for 1.
void shadeLobe(Shape& lobe, Vec3 eye);
// The same of a signed lobe: red where V < 0, green where V > 0.
void shadeSignedLobe(Shape& lobe, Vec3 eye);

}  // namespace penumbra
