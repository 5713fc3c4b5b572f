#pragma once
// The families of tags as libapriltag takes them. Only tag_family.cpp and tag_detector.cpp include its headers.
#include <apriltag/apriltag.h>

#include <array>
#include <cstdint>
#include <memory>

#include "formats/camera/tag_detector.h"

namespace penumbra {

using FamilyPointer = std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)>;
FamilyPointer makeFamily(TagFamily family);

// Bits of ArUco's DICT_4X4_50, row by row from the upper left, white is 1. [0] has 16 bits.
extern const std::array<std::uint16_t, 50> kAruco4x4;

}  // namespace penumbra
