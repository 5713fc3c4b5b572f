#pragma once
// How large numbers become on disk, measured without a disk.
#include <span>
#include <vector>

#include "formats/stage/visibility_file.h"

namespace penumbra {

// Bytes of one chunk of this shape in x.vis.h5: shuffle and deflate as the writer has them.
double storedSize(std::span<const float> values, const std::vector<std::size_t>& shape, Precision precision);

}  // namespace penumbra
