#include "formats/common/find_program.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace penumbra {

bool isProgram(const std::filesystem::path& path) {
    std::error_code error;
    return std::filesystem::is_regular_file(path, error) && ::access(path.c_str(), X_OK) == 0;
}

std::vector<std::filesystem::path> foldersOfPath() {
    std::vector<std::filesystem::path> folders;
    const char* value = std::getenv("PATH");
    const std::string path = value ? value : "";
    for (std::size_t first = 0; first < path.size();) {
        const std::size_t end = std::min(path.find(':', first), path.size());
        if (end > first) folders.emplace_back(path.substr(first, end - first));
        first = end + 1;
    }
    return folders;
}

std::optional<std::filesystem::path> findProgram(const std::string& name,
                                                 const std::vector<std::filesystem::path>& folders) {
    for (const std::filesystem::path& folder : folders)
        if (isProgram(folder / name)) return std::filesystem::absolute(folder / name);
    return std::nullopt;
}

std::optional<std::filesystem::path> findOwnProgram(const std::string& name) {
    std::vector<std::filesystem::path> folders = foldersOfPath();
    std::error_code error;
    const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", error);
    if (!error) folders.insert(folders.begin(), own.parent_path());
    return findProgram(name, folders);
}

}  // namespace penumbra
