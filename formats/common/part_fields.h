#pragma once
// The fields of all parts of a character, as fields files, models and assets hold them (sh/far/part_field.h).
#include <cstdint>
#include <string>
#include <vector>

#include "sh/far/part_field.h"

namespace penumbra {

constexpr std::size_t kMaxOccluders = 32;  // beside the parts of a character

struct PartFields {
    std::vector<PartField> parts;                     // [P]
    std::vector<std::vector<std::int8_t>> values;     // [P] bytes of each part, [points, 36]
    std::vector<std::vector<std::int8_t>> distances;  // [P] [points of the fine box]
    float fade = 0;  // depth below a part's surface over which a point goes dark, rest positions, > 0

    FieldBytes bytesOf(std::size_t part) const { return {values[part], distances[part]}; }
    std::size_t byteCount() const {
        std::size_t bytes = 0;
        for (std::size_t p = 0; p < parts.size(); ++p) bytes += values[p].size() + distances[p].size();
        return bytes;
    }
};

}  // namespace penumbra
