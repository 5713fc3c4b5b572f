#pragma once
#include <filesystem>

#include "formats/asset/asset_file.h"
#include "formats/asset/mapped_file.h"

namespace penumbra {

// A mapped asset file and the checked view into it.
struct OpenAsset {
    MappedFile file;
    AssetView view;
    explicit OpenAsset(const std::filesystem::path& path) : file(path), view(openAsset(file.bytes(), path.string())) {}
};

}  // namespace penumbra
