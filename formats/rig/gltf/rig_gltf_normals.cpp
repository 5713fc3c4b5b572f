// Reads the normals of glTF (glTF 2.0, section 3.7.2.1), also as bytes and shorts (KHR_mesh_quantization).
#include "formats/rig/gltf/rig_gltf.h"
#include "formats/rig/rig_normals.h"

namespace penumbra {

void readNormals(const GltfFile& file, const tinygltf::Primitive& primitive, const std::string& where,
                 RigSource& source, SourcePart& part) {
    const auto normal = primitive.attributes.find("NORMAL");
    if (normal == primitive.attributes.end()) return;
    const AccessorValues values = readAnyNumbers(file, normal->second, where + " NORMAL");
    if (values.components != 3 || values.count() != part.positions.size())
        failAtFile(file.path, where + ": NORMAL does not have 3 numbers for every vertex");
    std::vector<Vec3> normals;
    for (std::size_t v = 0; v < values.count(); ++v)
        normals.push_back(toFloat({values.values[3 * v], values.values[3 * v + 1], values.values[3 * v + 2]}));
    takeNormals(std::move(normals), source, part);
}

}  // namespace penumbra
