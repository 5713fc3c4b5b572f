#pragma once
// Near parts of a composed model (docs/formulas.md, section 7). A vertex of part q also multiplies in up to kMaxNear
// near parts of q, each with a gain of its own. All vertices of q have the same near parts, and only their gains
// differ.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sh/far/far_kernel.h"

namespace penumbra {

struct NearParts {
    std::size_t count = 0;             // <= kMaxNear; 0: the model has none
    std::vector<std::uint16_t> parts;  // [P, count], kNoPart where a part has fewer

    std::span<const std::uint16_t> of(std::size_t part) const { return std::span(parts).subspan(part * count, count); }
};

// How far parts are from one another, and which are far ones: b is far from a where steps[a * count + b] > local_steps.
struct PartSteps {
    std::span<const std::uint8_t> steps;  // [count, count]
    std::size_t count = 0;
    int local_steps = 0;
};
// Empty when `near_parts` [parts.count, N] can be those of a model with these parts, else what is wrong with an entry:
// each must be a part, neither the part itself nor a far part of it, and stand once in its row.
std::string findNearProblem(std::span<const std::uint16_t> near_parts, const PartSteps& parts);

}  // namespace penumbra
