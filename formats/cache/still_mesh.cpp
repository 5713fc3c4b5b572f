#include "formats/cache/still_mesh.h"

#include <cmath>
#include <fstream>

#include "formats/cache/mesh_file.h"
#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr std::uintmax_t kMaxStillMesh = std::uintmax_t(1) << 30;

std::string bytesOf(const std::filesystem::path& path) {
    std::error_code problem;
    const std::uintmax_t size = std::filesystem::file_size(path, problem);
    if (problem) throw IoError(path.string() + ": " + problem.message());
    if (size > kMaxStillMesh) throw Unsupported(path.string() + ": is larger than 1 GiB");
    std::ifstream file(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(file)), {});
    if (!file) throw IoError(path.string() + ": cannot be read");
    return bytes;
}

StillMesh fromObj(const MeshFile& mesh) {
    StillMesh out;
    for (const Vec3d& p : mesh.positions) out.positions.push_back(toFloat(p));
    for (const Triangle& t : mesh.triangles) out.triangles.insert(out.triangles.end(), t.begin(), t.end());
    return out;
}

}  // namespace

StillMesh readStillMesh(const std::filesystem::path& path) {
    const std::string extension = path.extension().string(), bytes = bytesOf(path);
    StillMesh mesh;
    if (extension == ".obj" || extension == ".OBJ")
        mesh = fromObj(parseObj(bytes, path.string()));
    else if (extension == ".glb" || extension == ".GLB")
        mesh = parseStillGlb(std::as_bytes(std::span(bytes)), path.string());
    else
        throw Unsupported(path.string() + ": is neither .obj nor .glb");
    if (mesh.triangles.empty()) throw InvalidInput(path.string() + ": has no triangles");
    for (const Vec3& p : mesh.positions)
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            throw InvalidInput(path.string() + ": has a position that is not finite");
    return mesh;
}

}  // namespace penumbra
