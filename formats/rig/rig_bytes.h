#pragma once
// A RigSource as bytes, for the way from one process to another of the same program (child_process.h).
#include <cstddef>
#include <span>
#include <vector>

#include "formats/rig/rig_build.h"

namespace penumbra {

// Leaves out what importers through assimp do not have: morph targets, tints, and the names of files.
std::vector<std::byte> bytesOf(const RigSource& source);
// Throws std::out_of_range where the bytes end too early or too late. Counts are checked; what they count is not.
RigSource rigFromBytes(std::span<const std::byte> bytes);

// Checks every index, count and number. Throws InvalidInput, which names file and node.
void checkSource(const RigSource& source);

}  // namespace penumbra
