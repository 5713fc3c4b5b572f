#include "player/open_asset.h"

#include "formats/errors.h"

namespace penumbra {

OpenAsset::OpenAsset(const std::filesystem::path& path) : file_(path) {
    try {
        view_ = openAsset(file_.bytes());
    } catch (const InvalidInput& problem) {
        throw InvalidInput(path.string() + ": " + problem.what());
    }
}

}  // namespace penumbra
