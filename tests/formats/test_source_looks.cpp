// The looks that source files describe: glTF's metallic-roughness model with its extensions, and what of Collada maps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/rig/gltf/rig_gltf_look.h"
#include "formats/rig/rig_bytes.h"
#include "formats/source/source_looks.h"
#include "formats/source/source_readers.h"
#include "tests/bake/shapes.h"
#include "tests/formats/glb_writer.h"

namespace penumbra::test_source_looks {
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
    EXPECT_THAT(look.notes, ElementsAre("KHR_materials_clearcoat is not read: its clear coat does not shine"));
    EXPECT_EQ(look.material, "Brass");
    EXPECT_EQ(shownLook(look).emission, Vec3d{}) << "the texture is not read";
}

// A factor of 0 switches an extension off. Of one that nobody knows, only the name can be told.
TEST(GltfLook, TellsWhatIsNotSeenOfExtensions) {
    const SourceLook look = lookOf(R"({"extensions": {"KHR_materials_sheen": {"sheenColorFactor": [0, 0, 0.5]},
        "KHR_materials_anisotropy": {"anisotropyStrength": 0}, "KHR_materials_iridescence": {},
        "KHR_materials_unlit": {}, "ACME_glitter": {"glitter": 1}}})");
    EXPECT_THAT(look.notes, ElementsAre("ACME_glitter is not read: what it changes is not seen",
                                        "KHR_materials_sheen is not read: it does not shine as cloth does",
                                        "KHR_materials_unlit is not read: it is shaded as any other surface"));
}

// The older extension's specular colour is the reflectance at normal incidence.
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
    const std::filesystem::path path = file.save("looks");
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

// Lights are no part of materials, so a bake tells of them. What it tells is not told twice.
TEST(SourceLooks, AreListedWithVariantsAndLightsOfTheFile) {
    samples::GlbWriter file;
    const int mesh = file.mesh(shapes::square({0, 0, 0}, {0, 0, 1}, 1));
    auto& primitive = file.glb.json["meshes"][std::size_t(mesh)]["primitives"][0];
    primitive["material"] = 0;
    primitive["extensions"]["KHR_materials_variants"]["mappings"] = nlohmann::json::array();
    file.glb.json["materials"] = {
        {{"name", "Red"},
         {"extensions",
          {{"KHR_materials_unlit", nlohmann::json::object()}, {"KHR_materials_clearcoat", {{"clearcoatFactor", 1}}}}}}};
    file.glb.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_variants"};
    file.node("Body", mesh);
    const Rig rig = readRig({file.save("variants")});
    std::vector<std::string> baked, looks;
    for (const RigNote& note : rig.notes) baked.push_back(textOf(note));
    for (const RigNote& note : lookNotes(rig)) looks.push_back(textOf(note));
    EXPECT_THAT(baked, testing::UnorderedElementsAre(HasSubstr("KHR_materials_unlit: material 'Red'"),
                                                     HasSubstr("KHR_lights_punctual: its lights are not used")));
    EXPECT_THAT(looks, ElementsAre(HasSubstr("node 'Body/Red': material 'Red': KHR_materials_clearcoat is not read: "),
                                   HasSubstr("KHR_materials_variants is not read: the part keeps this material")));
}

// A shiny and a dull part of one node, as Collada has them.
constexpr const char* kCollada = R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="common"><phong>
<emission><color>0.5 0.25 0 1</color></emission><diffuse><color>0.8 0.4 0.2 1</color></diffuse>
<specular><color>0.5 0.5 0.5 1</color></specular><shininess><float>30</float></shininess>
<transparency><float>0.5</float></transparency><index_of_refraction><float>1.4</float></index_of_refraction>
</phong></technique></profile_COMMON></effect>
<effect id="l"><profile_COMMON><technique sid="common"><lambert><diffuse><color>0.1 0.2 0.3 1</color></diffuse></lambert></technique></profile_COMMON></effect>
</library_effects>
<library_materials><material id="m" name="Shiny"><instance_effect url="#e"/></material><material id="n" name="Dull"><instance_effect url="#l"/></material></library_materials>
<library_geometries><geometry id="g" name="G"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles material="s" count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
<triangles material="t" count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="vs"><node id="nd" name="Body"><instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="s" target="#m"/><instance_material symbol="t" target="#n"/></technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#vs"/></scene>
</COLLADA>
)";

TEST(SourceLooks, OfColladaMapWhatOursHas) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "looks.dae";
    writeWholeFile(path, std::as_bytes(std::span(std::string_view(kCollada))));
    const SourceLooks looks = readSourceLooks(path);
    ASSERT_EQ(looks.slots.size(), 2u);
    EXPECT_EQ(toString(looks.slots[0].look.principled),
              "principled:color=0.8/0.4/0.2,metallic=0,roughness=0.5,ior=1.4,specular=1,emission=0.5/0.25/0")
        << "(2 / (30 + 2))^(1/4) is 0.5";
    EXPECT_THAT(looks.slots[0].look.notes, ElementsAre(HasSubstr("specular color is not read")));
    EXPECT_EQ(toString(looks.slots[1].look.principled),
              "principled:color=0.1/0.2/0.3,metallic=0,roughness=1,ior=1.5,specular=0");
    EXPECT_THAT(looks.slots[1].look.notes, IsEmpty());
}

// The looks survive the way from the process in which FBX and Collada files are imported.
TEST(SourceLooks, SurviveTheWayFromAnotherProcess) {
    RigSource source;
    source.parts.resize(1);
    source.parts[0].look = lookOf(R"({"name": "a", "emissiveFactor": [1, 0, 0], "normalTexture": {},
                                      "extensions": {"KHR_materials_sheen": {}}})");
    source.parts[0].look.problem = "p";
    EXPECT_EQ(rigFromBytes(bytesOf(source)).parts[0].look, source.parts[0].look);
}

}  // namespace
}  // namespace penumbra::test_source_looks
