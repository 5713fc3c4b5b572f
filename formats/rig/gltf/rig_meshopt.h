#pragma once
// Decodes one buffer view of EXT_meshopt_compression.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace penumbra {

struct MeshoptView {
    std::size_t count = 0, stride = 0;  // number of elements, and bytes of one
    std::string mode, filter;  // ATTRIBUTES | TRIANGLES | INDICES; NONE | OCTAHEDRAL | QUATERNION | EXPONENTIAL
};
// Decodes to count x stride bytes. Returns what is wrong in a few words, and "" on success. Safe for any input.
std::string decodeMeshopt(const MeshoptView& view, std::span<const unsigned char> encoded,
                          std::vector<unsigned char>& out);

}  // namespace penumbra
