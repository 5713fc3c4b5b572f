#pragma once
// How a source file describes the look of a material, as far as ours can say it (sh/brdf/principled.h).
#include <string>
#include <vector>

#include "sh/brdf/principled.h"

namespace penumbra {

struct SourceLook {
    std::string material = {};  // its name in the file; "" where it has none
    Principled principled = {};
    // What it has pictures for, in words: "base color", "normal", .. Factors are in `principled`, pictures are not.
    std::vector<std::string> textures = {};
    // What it says beyond that, and what was done about it: "KHR_materials_clearcoat is not read".
    std::vector<std::string> notes = {};
    std::string problem = {};  // a whole sentence that says why the material cannot be known; "" when it can

    bool operator==(const SourceLook&) const = default;
};

}  // namespace penumbra
