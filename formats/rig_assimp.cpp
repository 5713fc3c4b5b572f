// FBX, Collada and DirectX .x through assimp.
#include "formats/errors.h"
#include "formats/rig_build.h"

namespace penumbra {

RigSource readWithAssimp(const std::filesystem::path& path) { throw Unsupported(path.string() + ": not read yet"); }

}  // namespace penumbra
