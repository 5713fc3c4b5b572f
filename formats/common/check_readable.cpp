#include "formats/common/check_readable.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "formats/common/errors.h"

namespace penumbra {
namespace fs = std::filesystem;

void checkReadable(const fs::path& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (fs::is_directory(status)) throw IoError(path.string() + ": is a folder");
    if (fs::exists(status) && !fs::is_regular_file(status)) throw IoError(path.string() + ": not a regular file");
    if (!std::ifstream(path, std::ios::binary)) throw IoError(path.string() + ": cannot read: " + std::strerror(errno));
}

}  // namespace penumbra
