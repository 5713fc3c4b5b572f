#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "formats/cache/still_mesh.h"
#include "formats/common/errors.h"

namespace penumbra::test_still_mesh {
namespace {

using Json = nlohmann::json;

// One triangle of floats, then its three indices of 16 bits.
Json triangleJson() {
    return Json::parse(R"({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
        "buffers": [{"byteLength": 44}]})");
}

std::string glbOf(const Json& json) {
    std::string text = json.dump(), binary(44, '\0');
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const float corners[] = {0, 0, 0, 1, 0, 0, 0, 0, 2};
    const std::uint16_t order[] = {2, 0, 1};
    std::memcpy(binary.data(), corners, sizeof corners);
    std::memcpy(binary.data() + 36, order, sizeof order);
    std::string out = "glTF";
    const auto word = [&](std::size_t w) { out.append(reinterpret_cast<const char*>(&w), 4); };
    word(2);
    word(28 + text.size() + binary.size());
    word(text.size());
    out += "JSON" + text;
    word(binary.size());
    out += std::string("BIN\0", 4) + binary;
    return out;
}

StillMesh parsed(const std::string& bytes) { return parseStillGlb(std::as_bytes(std::span(bytes)), "m.glb"); }

TEST(StillMesh, NodesPlaceTheTriangles) {
    Json json = triangleJson();
    json["nodes"] = Json::parse(R"([{"children": [1], "translation": [10, 0, 0], "scale": [2, 2, 2]},
                                    {"mesh": 0, "rotation": [0, 0.70710678, 0, 0.70710678]}])");
    const StillMesh mesh = parsed(glbOf(json));
    ASSERT_EQ(mesh.positions.size(), 3u);
    EXPECT_EQ(mesh.triangles, (std::vector<std::uint32_t>{2, 0, 1}));
    // A quarter turn about y takes +x to -z and +z to +x, then twice as large, then 10 along x.
    EXPECT_LT(length(mesh.positions[0] - Vec3{10, 0, 0}), 1e-5f);
    EXPECT_LT(length(mesh.positions[1] - Vec3{10, 0, -2}), 1e-5f);
    EXPECT_LT(length(mesh.positions[2] - Vec3{14, 0, 0}), 1e-5f);
}

TEST(StillMesh, RefusesEveryTruncation) {
    const std::string whole = glbOf(triangleJson());
    ASSERT_NO_THROW(parsed(whole));
    for (std::size_t n = 0; n < whole.size(); ++n) EXPECT_THROW(parsed(whole.substr(0, n)), InvalidInput) << n;
}

TEST(StillMesh, RefusesWhatReachesOutsideOfTheFile) {
    const auto with = [](const char* pointer, const Json& value) {
        Json json = triangleJson();
        json[Json::json_pointer(pointer)] = value;
        return glbOf(json);
    };
    for (const auto& [pointer, value] : std::vector<std::pair<const char*, Json>>{{"/accessors/0/count", 4},
                                                                                  {"/accessors/0/byteOffset", 8},
                                                                                  {"/accessors/1/bufferView", 7},
                                                                                  {"/bufferViews/0/byteLength", 500},
                                                                                  {"/bufferViews/0/byteStride", 4},
                                                                                  {"/nodes/0/mesh", -1},
                                                                                  {"/nodes/0/children", {0}},
                                                                                  {"/accessors/0/type", "VEC2"}})
        EXPECT_THROW(parsed(with(pointer, value)), InvalidInput) << pointer;
    EXPECT_THROW(parsed(with("/extensionsRequired", {"EXT_meshopt_compression"})), Unsupported);
}

}  // namespace
}  // namespace penumbra::test_still_mesh
