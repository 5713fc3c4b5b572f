#pragma once
// The far parts of a composed asset for shaders: the arrays that they read, and the SH functions that are written out
// for them. player/shaders/far.glsl has the rest. Both compute what sh/far/far_lanes.h computes.
#include <cstdint>
#include <string>
#include <vector>

#include "player/runtime/far_anchors.h"

namespace penumbra {

// Tables of 32-bit words. Floats are there by their bits.
struct FarWords {
    // kFarPartWords for each part: its boxes, fine and coarse, each low, high, cells a unit, cells (3 floats each), 1 /
    // fading width, steps along y and z, first point; then centre, radius, 1 / fading depth, the first point of its
    // spheres, the words of its points and of its signed distances among the bytes (set by setFieldWords()), the scale
    // of the distances, and the scales [3 levels][6 bands].
    std::vector<std::uint32_t> parts;
    std::vector<std::uint32_t> lists;      // [P + 1] where the far parts of each part begin below, then these
    std::vector<std::uint32_t> anchors;    // [anchors, 2]: vertex, where its values begin, in vec4
    std::vector<std::uint32_t> receivers;  // [V, 8]: where the values of 4 anchors begin (kNoAnchor: none), weights
    std::size_t anchor_values = 0;         // vec4 that the values of all anchors take
};
constexpr std::uint32_t kFarPartWords = 60, kNoAnchor = 0xffffffff;
// The values of an anchor, in vec4: the sums [36], then how near each of the far parts of its part is.
constexpr std::uint32_t kFarAnchorSums = 9;

// Vertices that are anchors of several clusters are anchors once.
FarWords makeFarWords(const FarTables& tables, const FarLayout& layout);
// Tells where the bytes of a part's points and distances lie, in words from the start of the shader's buffer.
void setFieldWords(FarWords& words, std::size_t part, std::uint32_t points, std::uint32_t distances);

// A part in a pose: 7 rows of 4 floats. Rows 0..2 take a point of the model frame to the part's rest frame, rows 3..5
// are the rotation from the rest frame to the model frame, and row 6 is the bounding sphere in the model frame.
constexpr std::size_t kPosedPartRows = 7;
void writePosedPart(const PosedPart& part, float* rows);

// Writes the constants and functions that far.glsl needs: penumbra_far_turn(), penumbra_far_mirror(),
// penumbra_far_values() and penumbra_far_from_values(). The functions work on the arrays penumbra_f [36] and
// penumbra_even [21]. All loops are written out, with FarGrid as literals: software GL compiles arithmetic fast and
// reads of buffers slowly, and on a GPU the arrays stay in registers.
std::string farGlsl(const FarConstants& constants);

}  // namespace penumbra
