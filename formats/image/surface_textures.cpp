#include "formats/image/surface_textures.h"

#include <utility>

#include "formats/common/errors.h"
#include "formats/image/texture_file.h"

namespace penumbra {

namespace {

// Reads the bytes of a picture. Returns why it is none, or "".
std::string readPicture(SurfaceTexture& texture, const std::string& where) {
    try {
        if (!texture.file.empty()) texture.bytes = readTextureBytes(texture.file);
    } catch (const IoError& error) {
        return where + ": " + error.what();
    }
    try {
        (void)decodeTexture(texture.bytes, where);
    } catch (const InvalidInput& error) {
        return error.what();
    } catch (const Unsupported& error) {
        return error.what();
    }
    return "";
}

}  // namespace

OpenedTextures openTextures(const std::string& name, MeshSurface& surface) {
    OpenedTextures opened;
    std::vector<SurfaceTexture> kept;
    std::vector<std::uint16_t> new_of_old;
    for (SurfaceTexture& texture : surface.textures) {
        const std::string problem = readPicture(texture, name + ": " + texture.name);
        if (!texture.file.empty() && !texture.bytes.empty()) opened.files.push_back(texture.file);
        new_of_old.push_back(problem.empty() ? std::uint16_t(kept.size()) : kNoTexture);
        if (problem.empty())
            kept.push_back(std::move(texture));
        else
            opened.notes.push_back(problem + kNumbersAlone);
    }
    surface.textures = std::move(kept);
    for (SlotSurface& slot : surface.slots)
        for (TextureUse& use : slot.uses) {
            if (use.any()) use.texture = new_of_old[use.texture];
            if (!use.any()) use = {};
        }
    return opened;
}

}  // namespace penumbra
