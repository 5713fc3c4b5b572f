#include "sh/far/near_parts.h"

#include <algorithm>
#include <cassert>

namespace penumbra {

std::string findNearProblem(std::span<const std::uint16_t> near_parts, const PartSteps& parts) {
    assert(parts.steps.size() == parts.count * parts.count && parts.count > 0);
    assert(near_parts.size() % parts.count == 0);
    const std::size_t columns = near_parts.size() / parts.count;
    for (std::size_t i = 0; i < near_parts.size(); ++i) {
        const std::uint16_t part = near_parts[i];
        if (part == kNoPart) continue;
        const std::size_t of = i / columns;
        const auto row = near_parts.begin() + std::ptrdiff_t(of * columns);
        const std::string entry = "entry " + std::to_string(i) + ", part " + std::to_string(part) + ", ";
        if (part >= parts.count) return entry + "is not below " + std::to_string(parts.count);
        if (part == of) return entry + "is near itself";
        if (int(parts.steps[of * parts.count + part]) > parts.local_steps)
            return entry + "is a far part of part " + std::to_string(of);
        if (std::find(row, near_parts.begin() + std::ptrdiff_t(i), part) != near_parts.begin() + std::ptrdiff_t(i))
            return entry + "occurs twice for part " + std::to_string(of);
    }
    return "";
}

}  // namespace penumbra
