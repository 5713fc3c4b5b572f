#pragma once
// Opens the pictures of an asset, which are inside it or beside it.
#include "formats/asset/asset_file.h"
#include "formats/image/texture_file.h"

namespace penumbra {

// Throws what decodeTexture() and readTexture() throw, with the name of the asset.
TexturePicture openTexture(const AssetView& asset, const TextureView& texture);

}  // namespace penumbra
