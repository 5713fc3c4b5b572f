#pragma once
#include "formats/stage/visibility_file.h"

namespace penumbra {

// Reads all frames for their checksums, in bounded memory. What the frames share was read on opening. Throws
// InvalidInput, which names the file and the dataset that is damaged, and Interrupted.
void checkFrames(const VisibilityReader& reader);

}  // namespace penumbra
