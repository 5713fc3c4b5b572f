#pragma once
// Height fields that move, in closed form: "waves:height=0.2,length=4", several joined by "+".
//
// - waves: `count` trains of waves of deep water, z = height / sqrt(count) sum sin(k . p - sqrt(g k) t + phase), whose
//   directions lie within `spread` degrees of `angle` and whose lengths lie around `length`
// - dunes: ridges with a gentle slope towards the wind and a steep one behind it, bent sideways; they travel at `speed`
// - ripples: rings around the middle, z = height cos(2 pi (r / length - t speed / length)) / (1 + r / length)
//
// On a grid with a periodic border each form closes: waves and dunes take the nearest wave vectors that have whole
// numbers of waves along both sides, and ripples the distance on a torus, hypot of side / pi sin(pi x / side).
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sh/height/height_field.h"

namespace penumbra {

struct AnalyticHeights {
    enum class Kind { kWaves, kDunes, kRipples } kind = Kind::kWaves;
    double height = 0.2, length = 4;  // metres
    double speed = 1;                 // metres a second; of waves a factor on the time
    double angle = 30, spread = 40;   // degrees
    int count = 5;                    // trains
    int seed = 1;
};

// Throws std::invalid_argument with one sentence.
std::vector<AnalyticHeights> parseAnalyticHeights(std::string_view text);

// Writes the heights of all points of a grid whose middle is the origin, at a time in seconds; [rows, columns]. Rows
// [first_row, end_row) alone, so that rows may be written at once by several threads.
void analyticHeights(std::span<const AnalyticHeights> fields, const HeightGrid& grid, double seconds, int first_row,
                     int end_row, std::span<float> heights);

}  // namespace penumbra
