#pragma once
// Divides a skinned mesh into nearly rigid parts, one for each bone that owns enough of it. Composed models learn what
// nearby parts block, and treat all other parts as rigid (docs/formulas.md, section 7).
#include <cstdint>
#include <span>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

// More parts than these are merged, the smallest first, so that the fields of a character stay small.
constexpr std::size_t kMaxParts = 32;
// A part whose box at rest has a half diagonal below this share of the whole mesh's diagonal merges into its parent.
constexpr double kMinPartRadius = 0.02;
// A part of which one morph target moves a vertex by more than this share of the part's diagonal at rest, at weight 1,
// is one step from all other parts. Smaller moves change what the part blocks from afar less than its field errs.
constexpr double kMaxMorph = 0.02;

// A vertex belongs to the joint that moves it most, a triangle to the joint that owns two of its corners (or to that of
// its first corner). A joint that owns no triangle, or too little, has the part of its nearest ancestor with a part.
struct PartTable {
    std::vector<std::uint16_t> joint_of_part;     // [P], ascending
    std::vector<std::uint16_t> part_of_joint;     // [J]
    std::vector<std::uint16_t> part_of_vertex;    // [V]
    std::vector<std::uint16_t> part_of_triangle;  // [T]
    // [P, P] how many bones with a part of their own lie on the way from one to the other in the skeleton. 255: there
    // is no way, they hang from different roots. 1: they share an edge of the mesh, or one of them morphs (kMaxMorph).
    std::vector<std::uint8_t> steps;

    std::size_t partCount() const { return joint_of_part.size(); }
    std::uint8_t stepsBetween(std::size_t a, std::size_t b) const { return steps[a * partCount() + b]; }
};
PartTable makePartTable(const Mesh& mesh, const Skin& skin);

}  // namespace penumbra
