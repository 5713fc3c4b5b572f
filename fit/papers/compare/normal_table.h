#pragma once
// Measures what operators for a list of normals cost in the model frame (Nowrouzezahrai 2009, section 5.4). There the
// light needs no rotation, but an operator depends on the normal, and a table has one for each of a set of normals.
#include <vector>

#include "fit/papers/compare/compare_character.h"

namespace penumbra {

struct NormalTable {
    int normals = 0;       // in the table, evenly spread; a vertex takes the nearest
    double angle = 0;      // mean angle from a vertex' normal to the nearest of the table, radians
    double diffuse = 0;    // |t - t'| / |t| of transfer under a Lambertian material, over vertices and frames
    double glossy = 0;     // the same of a Phong lobe, over directions of view too
    double kilobytes = 0;  // size of the paper's operators, 8 terms each
};

// Measures tables of 16 to 4096 normals on baked visibility in convention A of this order, at up to 96 vertices in up
// to 8 frames. No light enters: |t - t'| is the error under lights that are white in SH.
std::vector<NormalTable> measureNormalTables(const CompareInput& input, const CompareCharacter& character,
                                             const Convention& convention, int threads);

}  // namespace penumbra
