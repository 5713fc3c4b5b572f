#pragma once
// How a source file describes the look of a material, as far as ours can say it (sh/brdf/principled.h).
#include <array>
#include <charconv>
#include <string>
#include <vector>

#include "sh/brdf/principled.h"

namespace penumbra {

struct SourceLook {
    std::string material = {};  // the material's name in the file; "" if it has none
    Principled principled = {};
    // The roles for which the material has pictures, in words: "base color", "normal", .. Factors are in `principled`,
    // pictures are not. So are colours of vertices ("vertex colors").
    std::vector<std::string> textures = {};
    // Further properties of the material, and what was done about them: "KHR_materials_clearcoat is not read".
    std::vector<std::string> notes = {};
    std::string problem = {};  // a whole sentence that says why the material cannot be known; "" when it can

    bool operator==(const SourceLook&) const = default;
};

// Returns the number with the fewest digits that is the same float: exporters print 0.8f as 0.800000011920929, which is
// part of a material's name here.
inline double shortestOf(float value) {
    std::array<char, 32> text;
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    double number = 0;
    std::from_chars(text.data(), end, number);
    return number;
}

}  // namespace penumbra
