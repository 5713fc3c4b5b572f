#pragma once
#include <filesystem>
#include <string>

namespace penumbra {

// Returns the root attribute `format` of an HDF5 file ("penumbra.visibility", ...). Throws InvalidInput when it has
// none.
std::string stageFileKind(const std::filesystem::path& path);

}  // namespace penumbra
