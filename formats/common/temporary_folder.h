#pragma once
#include <filesystem>

namespace penumbra {

// A folder with a name of its own in the place for temporary files, deleted with all in it. Throws IoError where none
// can be made.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

}  // namespace penumbra
