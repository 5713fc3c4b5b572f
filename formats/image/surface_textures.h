#pragma once
// Opens the pictures on a mesh, as those who draw or store them need them.
#include <filesystem>
#include <string>
#include <vector>

#include "formats/common/surface.h"

namespace penumbra {

// The files of pictures that were read, and what is wrong with those that are left out.
struct OpenedTextures {
    std::vector<std::filesystem::path> files;
    std::vector<std::string> notes;
};
// Reads the bytes of the pictures that are files, and decodes each once, so that none is missing or damaged later. A
// picture that cannot be read is left out: its slots have the numbers of their materials alone. `name` of the rig
// starts the notes.
OpenedTextures openTextures(const std::string& name, MeshSurface& surface);

}  // namespace penumbra
