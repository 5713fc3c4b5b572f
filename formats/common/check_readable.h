#pragma once
#include <filesystem>

namespace penumbra {

// Throws IoError at once for what cannot be read as a file. Call it before opening: opening a pipe would wait for its
// writer, and a device has no end.
void checkReadable(const std::filesystem::path& path);

}  // namespace penumbra
