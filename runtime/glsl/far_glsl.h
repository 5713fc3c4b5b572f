#pragma once
// The parts of a composed asset for shaders: the arrays that they read, and the SH functions that are written out for
// them. player/shaders/ has the rest: far.glsl for a character's own far parts, cast_fields.glsl for those of others.
// Both compute what sh/far/far_lanes.cpp computes.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "runtime/evaluate/far_anchors.h"

namespace penumbra {

// Tables of 32-bit words. Floats are there by their bits.
struct FarWords {
    // kFarPartWords for each part: its boxes, fine and coarse, each low, high, cells a unit, cells (3 floats each), 1 /
    // fading width, steps along y and z, first point; then center, radius, 1 / fading depth, the first point of its
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

// The fields of an asset as one block of words for shaders that cast: kFarPartWords for each part, then the bytes as
// they lie in the file, each array from a multiple of 16 bytes on. The places in the block count from the start of the
// buffer in which it stands at `first_word`, a multiple of 4. out.size() is fieldBlockWords().
std::size_t fieldBlockWords(const CompositionView& composition);
void writeFieldBlock(const FarTables& tables, const CompositionView& composition, std::uint32_t first_word,
                     std::span<std::uint32_t> out);
// A float that tells where a part's words begin is exact up to here.
constexpr std::uint32_t kMaxFieldWords = 1u << 26;

// A part in a pose: 7 rows of 4 floats. Rows 0..2 take a point of the frame that `placement`, a rotation and a
// translation, leads to from the model frame, to the part's rest frame. Rows 3..5 are the rotation from the rest frame
// to that frame; the fourth number of row 3 tells where the words of the part begin, in units of 4. Row 6 is the
// bounding sphere.
constexpr std::size_t kPosedPartRows = 7;
void writePosedPart(const PosedPart& part, const Affine& placement, std::uint32_t first_word, float* rows);

// Writes the functions and constants that field.glsl needs: penumbra_far_turn(), penumbra_far_mirror(),
// penumbra_far_values() and penumbra_far_from_values(). They work on the arrays penumbra_f [36] and penumbra_even [21].
// All loops are written out, with FarGrid as literals: software GL compiles arithmetic fast and reads of buffers
// slowly, and on a GPU the arrays stay in registers. field.glsl follows.
std::string fieldGlsl(const FarConstants& constants);
// The same, and what far.glsl needs besides.
std::string farGlsl(const FarConstants& constants);
// Writes penumbra_cast_fields() and penumbra_cast_combine() with all that they need.
std::string castFieldsGlsl();
// The kinds of casters in a scene.
struct CasterKinds {
    bool parts = false, spheres = false;
};
// Writes what cast_anchors.glsl needs: the constants of anchors where some casters have parts, whose functions
// castFieldsGlsl() writes; else penumbra_f and penumbra_far_turn().
std::string castAnchorsGlsl(CasterKinds kinds);

}  // namespace penumbra
