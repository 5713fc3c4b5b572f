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
    MeshSurface surface;  // surface of the model's mesh
    std::vector<BrdfFile> materials;
};

// Says where the pictures of a surface will be, which openTextures() has opened: inside of the asset (kEmbed), or at
// paths relative to `folder`, where the asset will lie (kLink); pictures inside the rig are embedded in any case.
void storeTextures(TextureStorage storage, const std::filesystem::path& folder, MeshSurface& surface);

// Numbers what is drawn of the surface and writes it. `triangles` are those of the asset's mesh of `vertices` vertices.
// `first_material` is the number of the look's first material in the asset.
Offset<fbs::Surface> writeSurface(FlatBufferBuilder& builder, const SurfaceLook& look,
                                  std::span<const Triangle> triangles, std::size_t vertices,
                                  std::size_t first_material);

}  // namespace penumbra
