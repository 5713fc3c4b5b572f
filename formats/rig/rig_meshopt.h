#pragma once
// EXT_meshopt_compression, one buffer view.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace penumbra {

struct MeshoptView {
    std::size_t count = 0, stride = 0;  // elements, and bytes of one
    std::string mode, filter;  // ATTRIBUTES | TRIANGLES | INDICES; NONE | OCTAHEDRAL | QUATERNION | EXPONENTIAL
};
// Decodes to count x stride bytes. Returns what is wrong in a few words, empty on success. Safe for any input.
std::string decodeMeshopt(const MeshoptView& view, std::span<const unsigned char> encoded,
                          std::vector<unsigned char>& out);

}  // namespace penumbra
