#pragma once
#include <filesystem>

#include "formats/asset_file.h"

namespace penumbra {

// A mapped asset file and the checked view into it. InvalidInput messages start with the file's name.
class OpenAsset {
public:
    explicit OpenAsset(const std::filesystem::path& path);
    const AssetView& view() const { return view_; }

private:
    MappedFile file_;
    AssetView view_;
};

}  // namespace penumbra
