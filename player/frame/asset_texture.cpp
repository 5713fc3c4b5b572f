#include "player/frame/asset_texture.h"

#include "formats/common/errors.h"

namespace penumbra {

TexturePicture openTexture(const AssetView& asset, const TextureView& texture) {
    const std::string name = asset.name + ": " + std::string(texture.name);
    if (texture.file.empty()) return decodeTexture(texture.bytes, name);
    try {
        return readTexture(std::filesystem::path(asset.name).parent_path() / std::string(texture.file), name);
    } catch (const IoError& error) {
        throw IoError(name + ": " + error.what());
    }
}

}  // namespace penumbra
