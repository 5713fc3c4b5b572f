#include "player/view/folder_list.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

#include "formats/common/errors.h"

namespace penumbra {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 5> kCharacterFiles = {".glb", ".gltf", ".vrm", ".fbx", ".dae"};
constexpr std::array<std::string_view, 3> kShownFiles = {".pnb", ".exr", ".hdr"};
constexpr std::size_t kMaxRecent = 8;

bool hasOne(const fs::path& path, auto&& extensions) {
    return std::ranges::find(extensions, path.extension().string()) != extensions.end();
}

fs::path assetBeside(const fs::path& character) { return fs::path(character).replace_extension(".pnb"); }

// Reports are .json files, too. A scene names its characters or its props near its beginning.
bool isScene(const fs::path& path) {
    constexpr std::size_t kHead = 1 << 16;  // bytes
    std::error_code failed;
    if (path.extension() != ".json" || !fs::is_regular_file(path, failed)) return false;
    std::string head(kHead, '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(head.data(), std::streamsize(head.size()));
    head.resize(std::size_t(file.gcount()));
    return head.find("\"characters\"") != head.npos || head.find("\"props\"") != head.npos;
}

bool opens(const fs::path& path) {
    std::error_code failed;
    return hasOne(path, kShownFiles) || isScene(path) ||
           (hasOne(path, kCharacterFiles) && fs::exists(assetBeside(path), failed));
}

}  // namespace

FolderList listFolder(const fs::path& folder) {
    FolderList list;
    std::error_code failed;
    list.folder = fs::canonical(folder, failed);
    if (failed) list.folder = folder;
    fs::directory_iterator entries(list.folder, fs::directory_options::skip_permission_denied, failed);
    for (; !failed && entries != fs::directory_iterator(); entries.increment(failed)) {
        const fs::path& path = entries->path();
        if (path.filename().string().starts_with('.')) continue;
        std::error_code unknown;  // then it is neither
        if (entries->is_directory(unknown))
            list.folders.push_back(path);
        else if (opens(path))
            list.files.push_back(path);
        else if (path.extension() == ".h5")
            list.unpacked.push_back(path);
    }
    if (failed) list.problem = list.folder.string() + ": " + failed.message();
    std::ranges::sort(list.folders);
    std::ranges::sort(list.files);
    std::ranges::sort(list.unpacked);
    return list;
}

fs::path shownFile(const fs::path& path) {
    if (!hasOne(path, kCharacterFiles)) return path;
    const fs::path asset = assetBeside(path);
    if (!fs::exists(asset))
        throw InvalidInput(path.filename().string() + ": there is no " + asset.filename().string() +
                           " beside it, which penumbra-bake, penumbra-fit and penumbra-pack make");
    return asset;
}

void noteRecent(std::vector<fs::path>& recent, const fs::path& file) {
    std::error_code failed;
    fs::path whole = fs::canonical(file, failed);
    if (failed) return;
    std::erase(recent, whole);
    recent.insert(recent.begin(), std::move(whole));
    if (recent.size() > kMaxRecent) recent.resize(kMaxRecent);
}

}  // namespace penumbra
