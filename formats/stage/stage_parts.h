#pragma once
// Reads and writes what visibility and model files have in common: root attributes, /mesh, /skin, /clips and the
// frame list.
#include <span>
#include <string>
#include <vector>

#include "formats/common/file_format.h"
#include "formats/common/mesh.h"
#include "formats/common/provenance.h"
#include "formats/stage/hdf5_handle.h"

namespace penumbra {

// Write and read format, format_version and provenance, which every file has. Only files without SH call these
// directly.
void writeKind(hid_t file, const FileFormat& format, const Provenance& provenance);
void readKind(const Hdf5Reader& in, const FileFormat& format, Provenance& provenance);
void writeRoot(hid_t file, const FileFormat& format, int sh_order, const Provenance& provenance);
// Checks format, version and SH convention, and returns the SH order. Throws Unsupported for another version.
int readRoot(const Hdf5Reader& in, const FileFormat& format, Provenance& provenance);

// Writes also the root attribute two_sided where it is true.
void writeMesh(hid_t file, const Mesh& mesh, const std::vector<Vec3>& rest_normals);
// Write and read which of `triangles` front triangles do not stop all rays, which only few meshes have. `mesh` is the
// group of the mesh.
void writeOpacity(hid_t file, const Opacity& opacity, const std::string& mesh);
Opacity readOpacity(const Hdf5Reader& in, std::size_t triangles, const std::string& mesh);
Mesh readMesh(const Hdf5Reader& in);
void writeSkin(hid_t file, const Skin& skin);
Skin readSkin(const Hdf5Reader& in, std::size_t vertices);
// Throws InvalidInput when a name of `dataset` is there twice.
void checkUnique(const Hdf5Reader& in, const std::string& dataset, const std::vector<std::string>& names);
void writeFrameList(hid_t file, const FrameList& frames);
FrameList readFrameList(const Hdf5Reader& in);

void writeVectors(hid_t file, const std::string& dataset, const std::vector<Vec3>& vectors);     // f32[N,3]
std::vector<Vec3> readVectors(const Hdf5Reader& in, const std::string& dataset, std::size_t n);  // n 0: any number
std::vector<std::uint32_t> readIndices(const Hdf5Reader& in, const std::string& dataset, std::size_t n,
                                       std::size_t limit);  // u32[n], each < limit; n 0: any number
void writeIndices(hid_t file, const std::string& dataset, std::span<const std::uint32_t> indices);

// Reads floats of exactly this shape, in which zeros count too, whereas readFloats() takes any size for a zero.
std::vector<float> readExactly(const Hdf5Reader& in, const std::string& dataset, const std::vector<hsize_t>& shape);

// Vec3 and Affine consist of floats alone, so their arrays are arrays of floats.
template <class T>
std::span<const float> floatsOf(const std::vector<T>& items) {
    return {reinterpret_cast<const float*>(items.data()), items.size() * sizeof(T) / sizeof(float)};
}
template <class T>
std::span<float> floatsOf(std::vector<T>& items) {
    return {reinterpret_cast<float*>(items.data()), items.size() * sizeof(T) / sizeof(float)};
}

}  // namespace penumbra
