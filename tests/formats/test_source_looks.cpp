// The looks that source files describe: glTF's metallic-roughness model with its extensions, and what of Collada maps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/rig/rig_bytes.h"
#include "formats/rig/rig_gltf_look.h"
#include "formats/source/source_looks.h"
#include "tests/bake/shapes.h"
#include "tests/formats/glb_writer.h"

namespace penumbra {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

SourceLook lookOf(const char* text) { return readGltfLook(nlohmann::json::parse(text)); }

TEST(GltfLook, HasTheDefaultsOfGltf) {
    const SourceLook look = lookOf("{}");
    EXPECT_EQ(toString(look.principled), "principled:color=1/1/1,metallic=1,roughness=1,ior=1.5,specular=1");
    EXPECT_THAT(look.textures, IsEmpty());
    EXPECT_THAT(look.notes, IsEmpty());
    EXPECT_EQ(look.problem, "");
}

TEST(GltfLook, HasFactorsExtensionsAndTextures) {
    const SourceLook look = lookOf(R"({"name": "Brass", "emissiveFactor": [1, 0.5, 0], "normalTexture": {"index": 0},
        "emissiveTexture": {"index": 1}, "occlusionTexture": {"index": 2},
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.125, 0.75], "metallicFactor": 0.25,
            "roughnessFactor": 0.625, "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0}},
        "extensions": {"KHR_materials_ior": {"ior": 1.25}, "KHR_materials_emissive_strength": {"emissiveStrength": 4},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [1, 2, 0.5]},
            "KHR_materials_clearcoat": {"clearcoatFactor": 1}}})");
    EXPECT_EQ(toString(look.principled),
              "principled:color=0.5/0.25/0.125,metallic=0.25,roughness=0.625,ior=1.25,"
              "specular=0.5,specular-color=1/2/0.5,emission=4/2/0");
    EXPECT_THAT(look.textures, ElementsAre("emissive", "base color", "metallic-roughness", "normal", "occlusion"));
    EXPECT_THAT(look.notes, ElementsAre("KHR_materials_clearcoat is not read"));
    EXPECT_EQ(look.material, "Brass");
    EXPECT_EQ(shownLook(look).emission, Vec3d{}) << "the texture is not read";
}

// Of the older extension the specular colour is the reflectance at normal incidence.
TEST(GltfLook, ReadsSpecularGlossiness) {
    const SourceLook look = lookOf(R"({"extensions": {"KHR_materials_pbrSpecularGlossiness":
        {"diffuseFactor": [0.5, 0.5, 0.5, 1], "specularFactor": [0.25, 0.5, 0.125], "glossinessFactor": 0.75}}})");
    EXPECT_EQ(splitOf(look.principled).f0, (Vec3d{0.25, 0.5, 0.125}));
    EXPECT_EQ(look.principled.roughness, 0.25);
    EXPECT_THAT(look.notes, ElementsAre(HasSubstr("KHR_materials_pbrSpecularGlossiness is read as")));
}

TEST(GltfLook, NumbersOutOfRangeAreClampedAndDamageIsNamed) {
    const SourceLook look = lookOf(R"({"pbrMetallicRoughness": {"metallicFactor": 2, "roughnessFactor": -1}})");
    EXPECT_EQ(look.principled.metallic, 1);
    EXPECT_EQ(look.principled.roughness, 0);
    EXPECT_THAT(look.notes, ElementsAre(HasSubstr("metallicFactor is out of range"), HasSubstr("roughnessFactor")));
    for (const char* text :
         {R"({"pbrMetallicRoughness": {"baseColorFactor": [1]}})",
          R"({"pbrMetallicRoughness": {"baseColorFactor": 1}})", R"({"pbrMetallicRoughness": 3})",
          R"({"pbrMetallicRoughness": {"metallicFactor": "a"}})", R"({"extensions": []})",
          R"({"extensions": {"KHR_materials_ior": 3}})", R"({"name": 3})", R"({"emissiveFactor": [1, 1]})",
          R"({"extensions": {"KHR_materials_specular": {"specularFactor": null}}})"})
        EXPECT_NE(lookOf(text).problem, "") << text;
}

// Two parts of one node, one without a material.
TEST(SourceLooks, GiveEverySlotItsOwn) {
    samples::GlbWriter file;
    const int mesh = file.mesh(shapes::square({0, 0, 0}, {0, 0, 1}, 1));
    auto& primitives = file.glb.json["meshes"][std::size_t(mesh)]["primitives"];
    primitives.push_back(primitives[0]);
    primitives[0]["material"] = 0;
    file.glb.json["materials"] = {{{"name", "Red"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 0, 0, 1}}}}}};
    file.node("Body", mesh);
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "looks.glb";
    const std::string bytes = file.glb.bytes();
    writeWholeFile(path, std::as_bytes(std::span(bytes)));
    const SourceLooks looks = readSourceLooks(path);
    ASSERT_EQ(looks.slots.size(), 2u);
    EXPECT_EQ(looks.slots[0].slot, "Body/Red");
    EXPECT_EQ(findLook(looks, "Body/Red")->principled.color, (Vec3d{1, 0, 0}));
    EXPECT_EQ(findLook(looks, "Body/default")->principled, lookOf("{}").principled);
    EXPECT_EQ(findLook(looks, "Body/Blue"), nullptr);
    EXPECT_EQ(findLook(looks, ""), nullptr) << "two slots, and no way to tell which";
    EXPECT_THAT(looks.files_read, ElementsAre(path));
    EXPECT_THROW(readSourceLooks("looks.obj"), Unsupported);
    EXPECT_THROW(readSourceLooks("/no/such.glb"), IoError);
}

// What the importer of FBX and Collada sends from its own process is what it read.
TEST(SourceLooks, SurviveTheWayFromAnotherProcess) {
    RigSource source;
    source.parts.resize(1);
    source.parts[0].look = lookOf(R"({"name": "a", "emissiveFactor": [1, 0, 0], "normalTexture": {},
                                      "extensions": {"KHR_materials_sheen": {}}})");
    source.parts[0].look.problem = "p";
    EXPECT_EQ(rigFromBytes(bytesOf(source)).parts[0].look, source.parts[0].look);
}

}  // namespace
}  // namespace penumbra
