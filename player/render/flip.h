#pragma once
// Computes LDR-FLIP, the difference that one perceives when flipping between two pictures: 0 = none, 1 = the largest.
// Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild: FLIP: A Difference Evaluator for Alternating
// Images, HPG 2020. scripts/figures/flip.py computes the same numbers, and has the constants' sources.
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

constexpr double kFlipPixelsPerDegree = 67;  // a 0.7 m wide 4K display seen from 0.7 m

// Returns FLIP of every pixel. Pictures are linear Rec.709 in [0, 1], row by row, width * height pixels each.
// `threads` as in parallelFor(); the result does not depend on it.
std::vector<float> flipMap(int width, int height, std::span<const Vec3> reference, std::span<const Vec3> test,
                           int threads);

}  // namespace penumbra
