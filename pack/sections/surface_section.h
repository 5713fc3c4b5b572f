#pragma once
// Writes the pictures on a mesh into an asset.
#include <span>
#include <string>
#include <vector>

#include "formats/common/surface.h"
#include "formats/stage/brdf_file.h"
#include "pack/sections/asset_writer.h"

namespace penumbra {

// Where pictures go: into the asset, or nowhere but by name.
enum class TextureStorage { kEmbed, kLink };

// A surface to pack. The materials of its slots index `materials`, which follow the asset's others.
struct SurfaceLook {
    MeshSurface surface;  // of the model's mesh
    std::vector<BrdfFile> materials;
};

// The files of pictures that were read, and what is wrong with those that are left out.
struct StoredTextures {
    std::vector<std::filesystem::path> files;
    std::vector<std::string> notes;
};
// Reads the files of the pictures into the surface (kEmbed), or makes their paths relative to `folder`, where the asset
// will lie (kLink); pictures inside the rig are embedded in any case. All have their bytes afterwards. Opens each once,
// so that none is missing or damaged later. A picture that cannot be read is left out: its slots have the numbers of
// their materials alone. `name` of the rig starts the notes.
StoredTextures storeTextures(TextureStorage storage, const std::filesystem::path& folder, const std::string& name,
                             MeshSurface& surface);

// Numbers what is drawn of the surface and writes it. `triangles` are those of the asset's mesh of `vertices` vertices.
// `first_material` is the number of the look's first material in the asset.
Offset<fbs::Surface> writeSurface(FlatBufferBuilder& builder, const SurfaceLook& look,
                                  std::span<const Triangle> triangles, std::size_t vertices,
                                  std::size_t first_material);

}  // namespace penumbra
