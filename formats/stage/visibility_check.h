#pragma once
#include "formats/stage/visibility_file.h"

namespace penumbra {

// Reads all frames for their checksums: InvalidInput names the file and the dataset that is damaged. What the frames
// share was read on opening. In bounded memory; throws Interrupted.
void checkFrames(const VisibilityReader& reader);

}  // namespace penumbra
