#include "formats/stage/blocker_file.h"

#include <cassert>
#include <cmath>
#include <span>

#include "formats/common/errors.h"
#include "formats/common/sha256.h"
#include "formats/common/write_file.h"
#include "formats/stage/field_file.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

namespace {

std::string skinSha256(const Mesh& mesh, const Skin& skin) {
    const std::size_t rows = mesh.frontVertexCount() * std::size_t(skin.influences);
    Sha256 hash;
    hash.update(std::as_bytes(std::span(skin.joints).first(rows)));
    hash.update(std::as_bytes(std::span(skin.weights).first(rows)));
    return hash.hex();
}

}  // namespace

void setCharacter(const Mesh& mesh, const Skin& skin, BlockerFile& file) {
    file.joint_names = skin.joint_names;
    file.mesh_sha256 = meshSha256(mesh);
    file.skin_sha256 = skinSha256(mesh, skin);
}

void checkCharacter(const BlockerFile& file, const Mesh& mesh, const Skin& skin) {
    if (file.joint_names != skin.joint_names || file.mesh_sha256 != meshSha256(mesh) ||
        file.skin_sha256 != skinSha256(mesh, skin))
        throw InvalidInput("the blockers are of another character than the model");
}

// --- Writing --------------------------------------------------------------------------------------------------------

void writeBlockers(const std::filesystem::path& path, const BlockerFile& blockers) {
    const std::vector<CasterSphere>& spheres = blockers.blockers.spheres;
    const std::vector<std::uint16_t>& joints = blockers.blockers.joints;
    const hsize_t count = spheres.size();
    assert(joints.size() == count);
    std::vector<Vec3> centers;
    std::vector<float> radii;
    for (const CasterSphere& sphere : spheres) {
        centers.push_back(sphere.center);
        radii.push_back(sphere.radius);
    }
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeKind(file, kBlockersFormat, blockers.provenance);
    writeTextAttribute(file, "/", "mesh_sha256", blockers.mesh_sha256);
    writeTextAttribute(file, "/", "skin_sha256", blockers.skin_sha256);
    writeTextAttribute(file, "/", "method", blockers.method);
    writeNumberAttribute(file, "/", "scale", blockers.scale);
    writeNumberAttribute(file, "/", "mesh_area", blockers.mesh_area);
    writeNumberAttribute(file, "/", "area", blockers.area);
    writeStrings(file, "/skin/joint_names", blockers.joint_names);
    writeIntegers(file, "/blockers/joint", std::vector<std::int64_t>(joints.begin(), joints.end()), {count},
                  H5T_STD_U16LE);
    writeVectors(file, "/blockers/center", centers);
    writeFloats(file, "/blockers/radius", radii, {count});
    closeHdf5(file);
    partial.commit();
}

// --- Reading --------------------------------------------------------------------------------------------------------

namespace {

std::string readHash(const Hdf5Reader& in, const std::string& attribute) {
    std::string hash = readTextAttribute(in, "/", attribute);
    if (hash.size() != 64 || hash.find_first_not_of("0123456789abcdef") != std::string::npos)
        throw InvalidInput(in.name + ": attribute " + attribute + ": not 64 lower-case hexadecimal digits");
    return hash;
}

double readPositive(const Hdf5Reader& in, const std::string& attribute) {
    const double value = readNumberAttribute(in, "/", attribute);
    if (!(value > 0 && std::isfinite(value)))
        throw InvalidInput(in.name + ": attribute " + attribute + ": not a number above 0");
    return value;
}

SphereBlockers readSpheres(const Hdf5Reader& in, std::size_t joints) {
    SphereBlockers blockers;
    std::vector<hsize_t> shape{0};
    const std::vector<std::int64_t> joint = readIntegers(in, "/blockers/joint", shape, 0, std::int64_t(joints) - 1);
    const std::size_t count = joint.size();
    if (count == 0 || count > kMaxBlockers)
        throw InvalidInput(in.name + ": /blockers/joint: " + std::to_string(count) + " spheres; 1.." +
                           std::to_string(kMaxBlockers) + " are possible");
    blockers.joints.assign(joint.begin(), joint.end());
    const std::vector<Vec3> centers = readVectors(in, "/blockers/center", count);
    const std::vector<float> radii = readExactly(in, "/blockers/radius", {count});
    for (std::size_t s = 0; s < count; ++s) {
        for (int axis = 0; axis < 3; ++axis)
            if (!(std::abs(centers[s][axis]) <= kLargestBlockerLength))
                throw InvalidInput(in.name + ": /blockers/center: that of sphere " + std::to_string(s) +
                                   " is not finite, or above 1e15");
        if (!(radii[s] >= 1 / kLargestBlockerLength && radii[s] <= kLargestBlockerLength))
            throw InvalidInput(in.name + ": /blockers/radius: that of sphere " + std::to_string(s) +
                               " is not in [1e-15, 1e15]");
        blockers.spheres.push_back({centers[s], radii[s]});
    }
    return blockers;
}

}  // namespace

BlockerFile readBlockers(const std::filesystem::path& path) {
    const Hdf5Reader in = openHdf5(path);
    BlockerFile file;
    readKind(in, kBlockersFormat, file.provenance);
    file.mesh_sha256 = readHash(in, "mesh_sha256");
    file.skin_sha256 = readHash(in, "skin_sha256");
    file.method = readTextAttribute(in, "/", "method");
    file.scale = readPositive(in, "scale");
    file.mesh_area = readPositive(in, "mesh_area");
    file.area = readPositive(in, "area");
    file.joint_names = readStrings(in, "/skin/joint_names");
    if (file.joint_names.empty() || file.joint_names.size() > 65535)
        throw InvalidInput(in.name + ": /skin/joint_names: " + std::to_string(file.joint_names.size()) + " joints");
    checkUnique(in, "/skin/joint_names", file.joint_names);
    file.blockers = readSpheres(in, file.joint_names.size());
    return file;
}

}  // namespace penumbra
