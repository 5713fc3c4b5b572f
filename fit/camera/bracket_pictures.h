#pragma once
// The pictures of a bracket in memory.
#include <string>
#include <vector>

#include "formats/camera/bracket_file.h"
#include "formats/image/texture_file.h"

namespace penumbra {

// One place, seen by one camera that did not move, at K exposures.
struct BracketPictures {
    std::string name;                      // name of the file that lists them, for messages
    std::vector<TexturePicture> pictures;  // [K], all of one size, at least 2
    std::vector<double> exposures;         // [K], all different, > 0
};

// Reads the pictures of a bracket. Throws what readTexture() throws, and InvalidInput where sizes differ from one
// another or from the camera's.
BracketPictures readPictures(const BracketFile& bracket);

}  // namespace penumbra
