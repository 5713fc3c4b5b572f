#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "formats/rig/gltf_numbers.h"
#include "formats/rig/growing_glb.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::test_growing_glb {

namespace {

using nlohmann::ordered_json;
using testing::HasSubstr;

std::filesystem::path inTemporary(const std::string& name, const std::string& bytes) {
    const std::filesystem::path path = std::filesystem::temp_directory_path() / name;
    samples::writeText(path, bytes);
    return path;
}

std::string u32(std::size_t value) {
    std::string out;
    for (int i = 0; i < 4; ++i) out += char(value >> (8 * i) & 0xff);
    return out;
}

// A .glb of this JSON, whose binary chunk has `binary` (padded by the caller), with further chunks behind it.
std::string glbOf(std::string json, const std::string& binary, const std::string& chunks = "") {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    return u32(0x46546C67) + u32(2) + u32(28 + json.size() + binary.size() + chunks.size()) + u32(json.size()) +
           u32(0x4E4F534A) + json + u32(binary.size()) + u32(0x004E4942) + binary + chunks;
}

std::string textOf(const GrowingGlb& glb) {
    const std::vector<std::byte> bytes = bytesOf(glb);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

TEST(GrowingGlb, KeepsAFileThatNothingIsAddedTo) {
    // Keys out of order, numbers of all kinds, and things that no reader knows.
    const std::string json =
        R"({"zebra":{"b":1,"a":[1e-7,0.1,3,-2.5,true,null,"\u00e4 ☃"]},"asset":{"version":"2.0","extras":7},)"
        R"("bufferViews":[{"byteLength":4,"buffer":0}],"accessors":[],"buffers":[{"extras":{"x":1},"byteLength":8}],)"
        R"("extensionsUsed":["ACME_unheard"]})";
    const std::string bytes = glbOf(json, "binary!!", u32(4) + u32(0x454D4341) + "acme");
    const GrowingGlb glb = openGrowingGlb(inTemporary("penumbra_growing_same.glb", bytes));
    EXPECT_EQ(glb.document.dump(), ordered_json::parse(json).dump());
    const std::string written = textOf(glb);
    const std::string end = u32(8) + u32(0x004E4942) + "binary!!" + u32(4) + u32(0x454D4341) + "acme";
    EXPECT_EQ(written.substr(written.size() - end.size()), end);
    EXPECT_EQ(ordered_json::parse(written.substr(20, written.size() - end.size() - 20)), ordered_json::parse(json));
    EXPECT_TRUE(glb.notes.empty());
}

TEST(GrowingGlb, AddsBehindWhatIsThere) {
    GrowingGlb glb = openGrowingGlb(samples::samplePath("quantized"));
    const std::vector<unsigned char> binary = glb.binary;
    const ordered_json document = glb.document;
    const std::vector<float> colors{0, 0.5f, 1, 0.25f, 0.75f, 0.125f}, times{0.5f, 2};
    const std::size_t a = addAccessor(glb, colors, 3, AccessorUse::kVertices);
    const std::size_t t = addAccessor(glb, times, 1, AccessorUse::kTimes);
    const std::size_t z = addZeros(glb, 2, 3);
    ASSERT_GE(glb.binary.size(), binary.size() + 32);
    EXPECT_TRUE(std::equal(binary.begin(), binary.end(), glb.binary.begin()));
    for (const auto& [key, value] : document.items())
        for (std::size_t i = 0; i < value.size() && value.is_array(); ++i)
            EXPECT_EQ(glb.document[key][i], value[i]) << key;
    EXPECT_EQ(glb.document["accessors"][t]["max"], ordered_json::array({2.0}));
    const std::filesystem::path path = inTemporary("penumbra_growing_added.glb", textOf(glb));
    const GltfNumbers numbers(path);
    const GltfArray read = numbers.read(a, "colors");
    EXPECT_EQ(read.components, 3u);
    EXPECT_TRUE(std::equal(read.values.begin(), read.values.end(), colors.begin(), colors.end()));
    EXPECT_EQ(numbers.read(z, "zeros").values, std::vector<double>(6));
    EXPECT_THROW(numbers.read(z + 1, "none"), InvalidInput);
    EXPECT_NO_THROW(readRig({path}));
}

TEST(GrowingGlb, TakesBuffersAndPicturesOfOtherFilesIntoOne) {
    const std::filesystem::path folder = std::filesystem::temp_directory_path();
    samples::writeText(folder / "penumbra a.bin", "0123456789");
    samples::writeText(folder / "penumbra_p.png", "\x89PNG picture");
    ordered_json json = ordered_json::parse(
        R"({"asset":{"version":"2.0"},"buffers":[{"uri":"penumbra%20a.bin","byteLength":9},)"
        R"({"byteLength":64,"extensions":{"EXT_meshopt_compression":{"fallback":true}}},)"
        R"({"uri":"data:application/octet-stream;base64,QUJD","byteLength":3}],)"
        R"("bufferViews":[{"buffer":0,"byteOffset":1,"byteLength":4},{"buffer":1,"byteLength":64,)"
        R"("extensions":{"EXT_meshopt_compression":{"buffer":2,"byteLength":3,"count":1}}},{"buffer":2,"byteLength":3}],)"
        R"("images":[{"uri":"penumbra_p.png"},{"uri":"penumbra_gone.png"},{"uri":"data:image/png;base64,QUJD"}]})");
    const GrowingGlb glb = openGrowingGlb(inTemporary("penumbra_growing.gltf", json.dump()));
    const auto viewed = [&](std::size_t view) {
        const ordered_json& v = glb.document["bufferViews"][view];
        const ordered_json& place = v.contains("extensions") ? v["extensions"]["EXT_meshopt_compression"] : v;
        EXPECT_EQ(place["buffer"], 0);
        const std::size_t at = place.value("byteOffset", 0);
        return std::string(glb.binary.begin() + long(at),
                           glb.binary.begin() + long(at + place["byteLength"].get<std::size_t>()));
    };
    EXPECT_EQ(viewed(0), "1234");
    EXPECT_EQ(viewed(1), "ABC");
    EXPECT_EQ(viewed(2), "ABC");
    EXPECT_EQ(glb.document["bufferViews"][1]["buffer"], 1);  // the fallback, which has no bytes
    EXPECT_EQ(glb.document["buffers"].size(), 2u);
    const ordered_json& images = glb.document["images"];
    EXPECT_EQ(images[0]["mimeType"], "image/png");
    EXPECT_EQ(viewed(images[0]["bufferView"]), "\x89PNG picture");
    EXPECT_EQ(images[1]["uri"], "penumbra_gone.png");
    EXPECT_EQ(images[2]["uri"], "data:image/png;base64,QUJD");
    ASSERT_EQ(glb.notes.size(), 2u);
    EXPECT_THAT(glb.notes[0], HasSubstr("penumbra_gone.png"));
}

TEST(GrowingGlb, RefusesEveryBeginningOfAFile) {
    const std::string whole = samples::readText(samples::samplePath("swing"));
    for (std::size_t n = 0; n < whole.size(); n += n < 100 ? 1 : 97) {
        const std::filesystem::path cut = inTemporary("penumbra_growing_cut.glb", whole.substr(0, n));
        EXPECT_THROW(openGrowingGlb(cut), InvalidInput) << "first " << n << " bytes";
    }
    const std::string deep = std::string(100, '[') + std::string(100, ']');
    EXPECT_THROW(openGrowingGlb(inTemporary("penumbra_growing_deep.gltf", R"({"a":)" + deep + "}")), InvalidInput);
    EXPECT_THROW(openGrowingGlb("/nowhere/x.glb"), IoError);
}

}  // namespace penumbra::test_growing_glb
