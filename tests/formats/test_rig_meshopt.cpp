// Samples that meshoptimizer's own encoders compress here (EXT_meshopt_compression) read as the plain ones do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/rig/gltf/rig_meshopt.h"
#include "formats/source/source_readers.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::test_rig_meshopt {
namespace {

using nlohmann::json;
using samples::EditableGlb;

std::filesystem::path scratch(const std::string& name) {
    return std::filesystem::path(testing::TempDir()) / ("penumbra_meshopt_" + name);
}

std::string encodeAttributes(const std::string& data, std::size_t count, std::size_t stride) {
    std::string out(meshopt_encodeVertexBufferBound(count, stride), '\0');
    out.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(out.data()), out.size(), data.data(), count,
                                          stride));
    return out;
}

std::string encodeIndices(const std::string& data, std::size_t count, bool triangles) {
    std::vector<unsigned> indices;
    for (std::size_t i = 0; i < count; ++i) {
        std::uint16_t index = 0;
        std::memcpy(&index, data.data() + 2 * i, 2);
        indices.push_back(index);
    }
    std::string out(
        std::max(meshopt_encodeIndexBufferBound(count, 65536), meshopt_encodeIndexSequenceBound(count, 65536)), '\0');
    auto* bytes = reinterpret_cast<unsigned char*>(out.data());
    out.resize(triangles ? meshopt_encodeIndexBuffer(bytes, out.size(), indices.data(), count)
                         : meshopt_encodeIndexSequence(bytes, out.size(), indices.data(), count));
    return out;
}

struct Encoded {
    std::string bytes;
    std::size_t count, stride;
    const char *mode, *filter;
};

// Adds the encoded bytes at the end of the buffer, and points buffer view `view` at them.
void compress(EditableGlb& glb, std::size_t view, const Encoded& encoded) {
    glb.binary.resize((glb.binary.size() + 3) / 4 * 4);
    json& target = glb.json["bufferViews"][view];
    target["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                       {"byteOffset", glb.binary.size()},
                                                       {"byteLength", encoded.bytes.size()},
                                                       {"count", encoded.count},
                                                       {"byteStride", encoded.stride},
                                                       {"mode", encoded.mode},
                                                       {"filter", encoded.filter}};
    target["buffer"] = 1;  // a fallback that has no bytes
    glb.binary += encoded.bytes;
    glb.json["buffers"][0]["byteLength"] = glb.binary.size();
    glb.json["buffers"][1] = {{"byteLength", 1 << 20},
                              {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}};
    glb.json["extensionsRequired"] = {"EXT_meshopt_compression"};
}

std::string viewBytes(const EditableGlb& glb, std::size_t view) {
    const json& v = glb.json["bufferViews"][view];
    return glb.binary.substr(v.value("byteOffset", 0u), v["byteLength"].get<std::size_t>());
}

std::size_t viewOf(const EditableGlb& glb, const json& accessor) {
    return glb.json["accessors"][accessor.get<std::size_t>()]["bufferView"].get<std::size_t>();
}

void compressAttribute(EditableGlb& glb, const json& accessor, std::size_t stride) {
    const std::size_t view = viewOf(glb, accessor), count = glb.json["accessors"][accessor.get<std::size_t>()]["count"];
    compress(glb, view, {encodeAttributes(viewBytes(glb, view), count, stride), count, stride, "ATTRIBUTES", "NONE"});
}

Rig readEdited(const EditableGlb& glb, const std::string& name) {
    samples::writeText(scratch(name), glb.bytes());
    return readRig({scratch(name)});
}

TEST(RigMeshopt, AttributesAndBothKindsOfIndicesReadAsWithoutCompression) {
    const Rig plain = samples::readSample("weights_u16");
    for (const bool triangles : {true, false}) {
        EditableGlb glb = EditableGlb::of("weights_u16");
        compressAttribute(glb, glb.attributes()["POSITION"], 12);
        compressAttribute(glb, glb.attributes()["WEIGHTS_0"], 8);
        compressAttribute(glb, glb.attributes()["JOINTS_0"], 4);
        const std::size_t view = viewOf(glb, glb.json["meshes"][0]["primitives"][0]["indices"]);
        compress(
            glb, view,
            {encodeIndices(viewBytes(glb, view), 432, triangles), 432, 2, triangles ? "TRIANGLES" : "INDICES", "NONE"});
        const Rig rig = readEdited(glb, "mesh.glb");
        EXPECT_EQ(rig.mesh.rest_positions, plain.mesh.rest_positions);
        EXPECT_EQ(rig.skin.weights, plain.skin.weights);
        EXPECT_EQ(rig.skin.joints, plain.skin.joints);
        ASSERT_EQ(rig.mesh.triangles.size(), plain.mesh.triangles.size());
        for (std::size_t t = 0; t < rig.mesh.triangles.size(); ++t) {  // the codec may turn a triangle
            Triangle turned = rig.mesh.triangles[t];
            while (turned[0] != plain.mesh.triangles[t][0]) std::rotate(&turned[0], &turned[1], &turned[0] + 3);
            EXPECT_EQ(turned, plain.mesh.triangles[t]);
        }
    }
}

// The exponential filter of EXT_meshopt_compression: value = mantissa 2^exponent, with the exponent in the upper 8 bits
// and the mantissa in the lower 24, both signed. Versions of meshoptimizer encode it by different calls.
std::uint32_t encodeExponential(float value) {
    int exponent = 0;
    std::frexp(value, &exponent);
    exponent -= 22;
    const auto mantissa = std::int32_t(std::lround(std::ldexp(value, -exponent)));
    return std::uint32_t(exponent) << 24 | (std::uint32_t(mantissa) & 0xffffff);
}

// Rotation keys are 16-bit quaternions, and positions are 23-bit mantissas with an exponent.
TEST(RigMeshopt, QuaternionAndExponentialFiltersAreUndone) {
    const Rig plain = samples::readSample("weights_u16");
    EditableGlb glb = EditableGlb::of("weights_u16");
    const json& output = glb.json["animations"][0]["samplers"][0]["output"];
    const std::size_t keys = viewOf(glb, output), count = glb.json["accessors"][output.get<std::size_t>()]["count"];
    std::vector<float> values(4 * count);
    std::memcpy(values.data(), viewBytes(glb, keys).data(), 16 * count);
    std::string filtered(8 * count, '\0');
    meshopt_encodeFilterQuat(filtered.data(), count, 8, 16, values.data());
    json& accessor = glb.json["accessors"][output.get<std::size_t>()];
    accessor["componentType"] = 5122;
    accessor["normalized"] = true;
    compress(glb, keys, {encodeAttributes(filtered, count, 8), count, 8, "ATTRIBUTES", "QUATERNION"});

    const std::size_t view = viewOf(glb, glb.attributes()["POSITION"]);
    std::vector<float> positions(3 * 74);
    std::memcpy(positions.data(), viewBytes(glb, view).data(), 12 * 74);
    std::vector<std::uint32_t> exponential(positions.size());
    std::transform(positions.begin(), positions.end(), exponential.begin(), encodeExponential);
    filtered.assign(reinterpret_cast<const char*>(exponential.data()), 12 * 74);
    compress(glb, view, {encodeAttributes(filtered, 74, 12), 74, 12, "ATTRIBUTES", "EXPONENTIAL"});

    const Rig rig = readEdited(glb, "filters.glb");
    for (std::size_t v = 0; v < 74; ++v)  // 2^-23 of each number
        EXPECT_LT(length(rig.mesh.rest_positions[rig.mesh.source_vertex[v]] -
                         plain.mesh.rest_positions[plain.mesh.source_vertex[v]]),
                  1e-6);
    for (const double time : {0.0, 0.3, 0.6, 1.0}) {
        const RigPose a = evaluatePose(rig, 0, time), b = evaluatePose(plain, 0, time);
        for (std::size_t i = 0; i < a.pose.size(); ++i) EXPECT_NEAR(a.pose[i], b.pose[i], 2e-4);  // 16-bit quaternions
    }
}

TEST(RigMeshopt, DamagedAndImpossibleViewsAreRefused) {
    std::vector<unsigned char> out;
    const std::vector<unsigned char> few(40, 0xA0);
    const MeshoptView good{74, 12, "ATTRIBUTES", "NONE"};
    for (const MeshoptView& view :
         {MeshoptView{0, 12, "ATTRIBUTES", "NONE"}, MeshoptView{74, 0, "ATTRIBUTES", "NONE"},
          MeshoptView{74, 10, "ATTRIBUTES", "NONE"}, MeshoptView{74, 260, "ATTRIBUTES", "NONE"},
          MeshoptView{74, 12, "ATTRIBUTES", "QUATERNION"}, MeshoptView{74, 12, "ATTRIBUTES", "OCTAHEDRAL"},
          MeshoptView{74, 12, "ATTRIBUTES", "WAVELET"}, MeshoptView{74, 12, "VERTICES", "NONE"},
          MeshoptView{std::size_t(1) << 60, 256, "ATTRIBUTES", "NONE"}, MeshoptView{7, 2, "TRIANGLES", "NONE"},
          MeshoptView{6, 3, "TRIANGLES", "NONE"}, MeshoptView{6, 2, "INDICES", "EXPONENTIAL"},
          MeshoptView{std::size_t(3) << 60, 4, "TRIANGLES", "NONE"},
          MeshoptView{std::size_t(1) << 60, 4, "INDICES", "NONE"}, good})
        EXPECT_NE(decodeMeshopt(view, few, out), "") << view.mode << ' ' << view.filter << ' ' << view.stride;

    const std::string data(74 * 12, 'x');
    const std::string encoded = encodeAttributes(data, 74, 12);
    const auto* bytes = reinterpret_cast<const unsigned char*>(encoded.data());
    ASSERT_EQ(decodeMeshopt(good, {bytes, encoded.size()}, out), "");
    EXPECT_EQ(std::string(out.begin(), out.end()), data);
    for (std::size_t n = 0; n < encoded.size(); ++n) {
        const std::vector<unsigned char> cut(bytes, bytes + n);  // a copy: ASan sees any overread
        EXPECT_NE(decodeMeshopt(good, cut, out), "") << "first " << n << " bytes";
    }
}

}  // namespace
}  // namespace penumbra::test_rig_meshopt
