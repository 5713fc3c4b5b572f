#pragma once
#include <filesystem>

namespace penumbra {

// IoError, at once, for what cannot be read as a file. Called before a file is opened: to open a pipe would wait for
// its writer, and a device has no end.
void checkReadable(const std::filesystem::path& path);

}  // namespace penumbra
