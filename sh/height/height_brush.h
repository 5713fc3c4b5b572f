#pragma once
// Raises or lowers a round hill of a height field by hand.
#include <vector>

#include "sh/height/height_field.h"

namespace penumbra {

struct HeightStroke {
    float row = 0, column = 0;  // middle of the stroke, which may lie beyond the border
    float radius = 0;           // metres
    float rise = 0;             // metres at the middle; below 0 it digs
};
// Returns the box of the points that a stroke changes, and their new heights: h + rise (1 - d^2 / radius^2)^2, whose
// slope is 0 in the middle and at the rim. Heights stay within kMaxElevation. The box ends at the edges of the field,
// also of a periodic one. It is empty where no point lies within the radius.
TexelBox strokeHeights(const HeightField& field, const HeightStroke& stroke, std::vector<float>& heights);

}  // namespace penumbra
