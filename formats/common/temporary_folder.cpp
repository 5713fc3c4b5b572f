#include "formats/common/temporary_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "formats/common/errors.h"

namespace penumbra {

TemporaryFolder::TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "penumbra.XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
        throw IoError(name + ": cannot be made (TMPDIR names another folder): " + std::strerror(errno));
    path_ = std::filesystem::absolute(name);
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
}

}  // namespace penumbra
