#pragma once
// Measures how large numbers become on disk, without a disk.
#include <span>
#include <vector>

#include "formats/stage/visibility_file.h"

namespace penumbra {

// Returns the bytes of one chunk of this shape in x.vis.h5, after shuffle and deflate as the writer applies them.
double storedSize(std::span<const float> values, const std::vector<std::size_t>& shape, Precision precision);

}  // namespace penumbra
