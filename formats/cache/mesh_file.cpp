#include "formats/cache/mesh_file.h"

#include "formats/common/errors.h"
#include "formats/common/random_bytes.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

constexpr std::uint64_t kMaxMeshFile = std::uint64_t(1) << 32;

bool isMeshFile(const std::filesystem::path& path) { return isExtension(path, ".obj") || isExtension(path, ".ply"); }

MeshFile readMeshFile(const std::filesystem::path& path) {
    if (!isMeshFile(path)) throw Unsupported(path.string() + ": not a mesh (.obj and .ply are read)");
    const RandomBytes file = openBytes(path);
    if (file.size > kMaxMeshFile) throw Unsupported(path.string() + ": is larger than 4 GiB");
    const std::vector<std::byte> bytes = readBytes(file, 0, std::size_t(file.size));
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return isExtension(path, ".obj") ? parseObj(text, path.string()) : parsePly(text, path.string());
}

}  // namespace penumbra
