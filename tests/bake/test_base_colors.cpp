// Tests the albedo that a rig's own materials give: where texels land, what a vertex averages, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bake/source/base_colors.h"
#include "bake/source/surface_colors.h"
#include "formats/common/errors.h"
#include "formats/image/texture_file.h"
#include "formats/rig/rig_surface.h"
#include "formats/source/source_readers.h"
#include "tests/formats/textured_rig.h"
#include "tests/formats/tiny_jpeg.h"

namespace penumbra::test_base_colors {
namespace {

using samples::EditableGlb;
using samples::greyPng;
using samples::TexturedTriangle;
using samples::triangleAt;
using samples::Uv;
using testing::HasSubstr;

std::filesystem::path placed(const std::string& name, const std::string& bytes) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / name;
    samples::writeText(path, bytes);
    return path;
}

BaseColors colorsOf(const EditableGlb& glb) {
    const std::filesystem::path path = placed("base_colors.glb", glb.bytes());
    return readBaseColors(readRig({path}), "rig");
}

std::string problemOf(const EditableGlb& glb) {
    try {
        colorsOf(glb);
    } catch (const std::exception& error) {
        return error.what();
    }
    return "";
}

// Four texels a side keep the middle of each quarter clear of its neighbours.
std::string quarters() { return greyPng(4, {10, 10, 90, 90, 10, 10, 90, 90, 170, 170, 250, 250, 170, 170, 250, 250}); }

TexturedTriangle pointedAt(float x, Uv uv) { return {triangleAt(x), {uv, uv, uv}}; }

float grey(int value) { return linearFromSrgb(float(value) / 255); }

void expectGrey(const BaseColors& out, std::size_t triangle, float expected) {
    for (std::size_t k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(out.colors.at(3 * triangle + k)[c], expected, 1e-6f) << triangle << " " << k;
}

TEST(BaseColors, UvZeroIsTheTopLeftOfThePicture) {
    const BaseColors out = colorsOf(samples::texturedRig({pointedAt(0, {0.25f, 0.25f}), pointedAt(2, {0.75f, 0.25f}),
                                                          pointedAt(4, {0.25f, 0.75f}), pointedAt(6, {0.75f, 0.75f})},
                                                         quarters()));
    EXPECT_TRUE(out.textured);
    EXPECT_TRUE(out.pictures.empty());
    for (std::size_t i = 0; i < 4; ++i) expectGrey(out, i, grey(10 + 80 * int(i)));
}

// The texels at the crossing of 4 x 4 are read half-way between four of them: bilinear, in linear light.
TEST(BaseColors, BetweenTexelsLightIsInterpolated) {
    const BaseColors out = colorsOf(samples::texturedRig({pointedAt(0, {0.5f, 0.5f})}, quarters()));
    expectGrey(out, 0, (grey(10) + grey(90) + grey(170) + grey(250)) / 4);
}

TEST(BaseColors, FactorTexelAndVertexColourMultiply) {
    EditableGlb glb = samples::texturedRig({pointedAt(0, {0.75f, 0.75f})}, quarters());
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 0.25, 1, 1};
    samples::addAttribute(glb, "COLOR_0", "VEC4", 4, {0.5, 1, 0.5, 1, 0.5, 1, 0.5, 1, 0.5, 1, 0.5, 1});
    for (const Vec3 color : colorsOf(glb).colors) {
        EXPECT_NEAR(color.x, grey(250) * 0.25f, 1e-6f);
        EXPECT_NEAR(color.y, grey(250) * 0.25f, 1e-6f);
        EXPECT_NEAR(color.z, grey(250) * 0.5f, 1e-6f);
    }
    glb.json["meshes"][0]["primitives"][0].erase("material");  // vertex colours alone
    EXPECT_NEAR(colorsOf(glb).colors[0].x, 0.5f, 1e-6f);
}

// White for u > 1/2 on a right triangle: the hat functions of its corners have 1/8, 1/2 and 1/8 of their integrals
// there. Sums over 64 pieces an edge are within 0.01.
TEST(BaseColors, VertexHasTheMeanOfItsHatFunction) {
    std::vector<int> half(64);
    for (std::size_t i = 32; i < 64; ++i) half[i] = 255;
    const BaseColors out =
        colorsOf(samples::texturedRig({{triangleAt(0), {Uv{0, 0}, Uv{1, 0}, Uv{0, 1}}}}, greyPng(64, half)));
    const float expected[] = {0.125f, 0.5f, 0.125f};
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(out.colors[k].x, expected[k], 0.01f) << k;
}

// Vertices of two triangles at one place are one shading point. Its colour weighs them by area, 1 to 3.
TEST(BaseColors, SeamsAverageBothSidesByArea) {
    const TexturedTriangle small{{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}},
                                 {Uv{.25f, .25f}, Uv{.25f, .25f}, Uv{.25f, .25f}}};
    const TexturedTriangle large{{Vec3{1, 0, 0}, Vec3{0, 0, 0}, Vec3{0, -3, 0}},
                                 {Uv{.75f, .75f}, Uv{.75f, .75f}, Uv{.75f, .75f}}};
    const BaseColors out = colorsOf(samples::texturedRig({small, large}, quarters()));
    ASSERT_EQ(out.colors.size(), 4u);
    for (const std::size_t v : {0u, 1u}) EXPECT_NEAR(out.colors[v].x, (grey(10) + 3 * grey(250)) / 4, 1e-6f);
    EXPECT_NEAR(out.colors[2].x, grey(10), 1e-6f);
    EXPECT_NEAR(out.colors[3].x, grey(250), 1e-6f);
}

TEST(BaseColors, SamplerSaysWhatLiesBeyondThePicture) {
    for (const auto& [mode, expected] : {std::pair(10497, 10), std::pair(33648, 90), std::pair(33071, 90)}) {
        EditableGlb glb = samples::texturedRig({pointedAt(0, {1.25f, -0.75f})}, quarters());
        glb.json["samplers"] = {{{"wrapS", mode}}};
        glb.json["textures"][0]["sampler"] = 0;
        expectGrey(colorsOf(glb), 0, grey(expected));  // v = -0.75 is 0.25
    }
    EditableGlb glb = samples::texturedRig({pointedAt(0, {0.25f, -0.25f})}, quarters());
    expectGrey(colorsOf(glb), 0, grey(170));
    glb.json["samplers"] = {{{"wrapT", 33648}}};
    glb.json["textures"][0]["sampler"] = 0;
    expectGrey(colorsOf(glb), 0, grey(10));
}

// A quarter turn takes (u, v) to (v, -u), as all viewers of KHR_texture_transform have it.
TEST(BaseColors, TextureTransformScalesTurnsAndMovesTheChosenCoordinates) {
    EditableGlb glb = samples::texturedRig({pointedAt(0, {9, 9})}, quarters());
    samples::addAttribute(glb, "TEXCOORD_1", "VEC2", 2, {.5f, 1.5f, .5f, 1.5f, .5f, 1.5f});
    auto& info = glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    info["extensions"]["KHR_texture_transform"] = {
        {"scale", {0.5, 0.5}}, {"rotation", std::acos(-1.0) / 2}, {"offset", {0.0, 0.5}}, {"texCoord", 1}};
    glb.json["extensionsUsed"] = {"KHR_texture_transform"};
    expectGrey(colorsOf(glb), 0, grey(90));  // (.25, .75) turns to (.75, -.25) and moves to (.75, .25)
    info.erase("extensions");
    info["texCoord"] = 1;
    expectGrey(colorsOf(glb), 0, (grey(10) + grey(90) + grey(170) + grey(250)) / 4);  // (.5, 1.5)
}

TEST(BaseColors, PicturesLieInsideInUrisOrBesideTheFile) {
    EditableGlb glb = samples::texturedRig({pointedAt(0, {0.25f, 0.5f})}, quarters());
    const std::vector<std::byte> jpeg = samples::tinyJpeg();
    placed("skin 1.jpg", std::string(reinterpret_cast<const char*>(jpeg.data()), jpeg.size()));
    glb.json["images"] = {{{"uri", "skin%201.jpg"}}};
    const BaseColors out = colorsOf(glb);
    ASSERT_EQ(out.pictures.size(), 1u);
    EXPECT_EQ(out.pictures[0].filename(), "skin 1.jpg");
    EXPECT_NEAR(out.colors[0].x, grey(200), 0.02f);
    EXPECT_NEAR(out.colors[0].z, grey(40), 0.01f);
    // One white pixel.
    glb.json["images"] = {{{"uri",
                            "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4"
                            "DwABAQEAsTj2FAAAAABJRU5ErkJggg=="}}};
    EXPECT_EQ(colorsOf(glb).colors[0].y, 1);
}

TEST(BaseColors, DamageIsToldWhereTheColoursAreNeededAndTheRigIsReadAllTheSame) {
    const EditableGlb good = samples::texturedRig({pointedAt(0, {0.25f, 0.25f})}, quarters());
    const auto problem = [&](const char* pointer, const nlohmann::json& value) {
        EditableGlb glb = good;
        glb.json[nlohmann::json::json_pointer(pointer)] = value;
        return problemOf(glb);
    };
    const char* const info = "/materials/0/pbrMetallicRoughness/baseColorTexture";
    const std::string index = info + std::string("/index"), set = info + std::string("/texCoord");
    EXPECT_THAT(problem(index.c_str(), 7), HasSubstr("materials[0] 'paint': texture 7 does not exist"));
    EXPECT_THAT(problem(index.c_str(), "x"), HasSubstr("texture \"x\" does not exist"));
    EXPECT_THAT(problem(set.c_str(), 3), HasSubstr("node 'sheet': has no TEXCOORD_3"));
    EXPECT_THAT(problem("/textures/0/source", 2), HasSubstr("image 2 does not exist"));
    EXPECT_THAT(problem("/textures/0", nlohmann::json::object()), HasSubstr("no PNG or JPEG picture"));
    EXPECT_THAT(problem("/images/0/bufferView", 99), HasSubstr("images[0].bufferView 99 does not exist"));
    EXPECT_THAT(problem("/images/0", {{"uri", "gone.png"}}), HasSubstr("gone.png: cannot read"));
    EXPECT_THAT(problem("/images/0", {{"uri", "https://a/b.png"}}), HasSubstr("images[0].uri is at https://a/b.png"));
    EXPECT_THAT(problem("/images/0/bufferView", 0),
                HasSubstr("slot 'sheet/paint': images[0]: neither a PNG nor a JPEG"));
    EXPECT_THAT(problem("/bufferViews/2/byteLength", 60),
                HasSubstr("slot 'sheet/paint': images[0]: PNG: is cut short"));
    EXPECT_THAT(problem("/materials/0/pbrMetallicRoughness/baseColorFactor", {1, 2}), HasSubstr("has 2 numbers"));
    EXPECT_THAT(problem("/materials/0/pbrMetallicRoughness", 5), HasSubstr("materials[0] 'paint'"));
    EXPECT_THAT(problem("/accessors/1/count", 2), HasSubstr("TEXCOORD_0 does not have 2 numbers for every vertex"));
    EditableGlb sampler = good;
    sampler.json["samplers"] = {{{"wrapS", 1}}};
    sampler.json["textures"][0]["sampler"] = 0;
    EXPECT_THAT(problemOf(sampler), HasSubstr("sampler.wrapS is 1"));
    EXPECT_THAT(problemOf(samples::texturedRig({pointedAt(0, {1e7f, 0})}, quarters())), HasSubstr("out of range"));
}

// The rule of --albedo holds for textures too: a vertex that reflects all light is refused.
TEST(BaseColors, WhiteIsRefusedAsItIsWithAnOption) {
    const EditableGlb glb = samples::texturedRig({pointedAt(0, {0.5f, 0.5f})}, greyPng(2, {255, 255, 255, 255}));
    BakeSource source;
    source.rig = readRig({placed("white.glb", glb.bytes())});
    TransferOptions options;
    options.bounces = 1;
    try {
        surfaceColors(source, source.rig->mesh, options);
        FAIL();
    } catch (const UsageError& error) {
        EXPECT_THAT(error.what(), HasSubstr("white.glb: the rig's base colours and textures: albedo 1.000000 at "
                                            "vertex 0, not in [0, 1)"));
    }
}

// --- Formats that assimp reads --------------------------------------------------------------------------------------

// A triangle whose corners point at the lower left quarter of the picture, in formats whose v points up.
constexpr const char* kCollada = R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><up_axis>Y_UP</up_axis></asset>
<library_images><image id="img"><init_from>C:\work\quarters.png</init_from></image></library_images>
<library_effects><effect id="fx"><profile_COMMON>
<newparam sid="s"><surface type="2D"><init_from>img</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="c"><lambert><diffuse><texture texture="t" texcoord="UV"/></diffuse></lambert></technique>
</profile_COMMON></effect></library_effects>
<library_materials><material id="paint" name="paint"><instance_effect url="#fx"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<source id="u"><float_array id="ua" count="2">0.25 0.25</float_array><technique_common>
<accessor source="#ua" count="1" stride="2"><param name="S" type="float"/><param name="T" type="float"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1" material="m"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#u" offset="1" set="0"/><p>0 0 1 0 2 0</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="sc"><node id="n" name="n"><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="m" target="#paint"><bind_vertex_input semantic="UV"
input_semantic="TEXCOORD" input_set="0"/></instance_material></technique_common></bind_material></instance_geometry>
</node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#sc"/></scene></COLLADA>
)";

// DirectX has v pointing down, and multiplies the colour.
constexpr const char* kDirectX = R"(xof 0303txt 0032
Frame n { FrameTransformMatrix { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;; }
Mesh { 3; 0;0;0;, 1;0;0;, 0;1;0;; 1; 3;0,1,2;;
MeshTextureCoords { 3; 0.25;0.75;, 0.25;0.75;, 0.25;0.75;; }
MeshMaterialList { 1; 1; 0;; Material paint { 0.5;0.5;0.5;1.0;; 0.0; 0.0;0.0;0.0;; 0.0;0.0;0.0;;
TextureFilename { "quarters.png"; } } } } }
)";

constexpr const char* kFbx = R"(; FBX 7.4.0 project file
FBXHeaderExtension: { FBXHeaderVersion: 1003
FBXVersion: 7400
}
Objects: {
Geometry: 100, "Geometry::g", "Mesh" {
Vertices: *9 { a: 0,0,0,1,0,0,0,1,0 }
PolygonVertexIndex: *3 { a: 0,1,-3 }
LayerElementUV: 0 { Version: 101
Name: "uv"
MappingInformationType: "ByPolygonVertex"
ReferenceInformationType: "IndexToDirect"
UV: *2 { a: 0.25,0.25 }
UVIndex: *3 { a: 0,0,0 } }
LayerElementMaterial: 0 { Version: 101
MappingInformationType: "AllSame"
ReferenceInformationType: "IndexToDirect"
Materials: *1 { a: 0 } }
Layer: 0 { Version: 100
LayerElement: { Type: "LayerElementUV"
TypedIndex: 0 }
LayerElement: { Type: "LayerElementMaterial"
TypedIndex: 0 } } }
Model: 200, "Model::n", "Mesh" { Version: 232
}
Material: 300, "Material::paint", "" { Version: 102
ShadingModel: "lambert"
Properties70: {
P: "DiffuseColor", "Color", "", "A",0.8,0.8,0.8
} }
Texture: 400, "Texture::t", "" { Type: "TextureVideoClip"
Version: 202
FileName: "D:\art\quarters.png"
RelativeFilename: "..\art\quarters.png" }
}
Connections: {
C: "OO",100,200
C: "OO",200,0
C: "OO",300,200
C: "OP",400,300,"DiffuseColor"
}
)";

TEST(BaseColors, DiffuseTexturesOfColladaDirectXAndFbxLieBesideTheFile) {
    placed("quarters.png", quarters());
    for (const auto& [name, text, factor] :
         {std::tuple("paint.dae", kCollada, 1.0f), std::tuple("paint.x", kDirectX, 0.5f),
          std::tuple("paint.fbx", kFbx, 1.0f)}) {
        const std::filesystem::path path = placed(name, text);
        const BaseColors out = readBaseColors(readRig({path}), name);
        ASSERT_EQ(out.pictures.size(), 1u) << name;
        EXPECT_EQ(out.pictures[0], path.parent_path() / "quarters.png") << name;
        for (const Vec3 color : out.colors) EXPECT_NEAR(color.x, factor * grey(170), 1e-6f) << name;
    }
    std::filesystem::remove(std::filesystem::path(testing::TempDir()) / "quarters.png");
    const Rig rig = readRig({placed("paint.x", kDirectX)});
    EXPECT_THROW(readBaseColors(rig, "paint.x"), IoError);
}

// Returns the text with these lines cut out that begin so.
std::string withoutLine(std::string text, const std::string& begin) {
    const std::size_t at = text.find(begin);
    return text.erase(at, text.find('\n', at) + 1 - at);
}

TEST(BaseColors, APictureWithoutCoordinatesOrFarOnesIsToldAndLeftOut) {
    const std::string bare = withoutLine(kDirectX, "MeshTextureCoords"), collada = kCollada;
    std::string far = kCollada;
    far.replace(far.find("0.25 0.25"), 9, "0.25 1e30");
    std::string none = collada;
    none.replace(none.find("<input semantic=\"TEXCOORD\""), 58, "<p>0 1 2</p></triangles>\n<!--");
    none.replace(none.find("<p>0 0 1 0 2 0</p></triangles>"), 30, "-->");
    for (const auto& [name, text, said] :
         {std::tuple("bare.x", bare, "no texture coordinates"), std::tuple("none.dae", none, "no texture coordinates"),
          std::tuple("far.dae", far, "out of range")}) {
        const RigSurface out = surfaceOf(readRig({placed(name, text.c_str())}), name);
        EXPECT_TRUE(out.surface.textures.empty()) << name;
        ASSERT_EQ(out.notes.size(), 1u) << name;
        EXPECT_NE(out.notes[0].find(said), std::string::npos) << out.notes[0];
    }
}

}  // namespace
}  // namespace penumbra::test_base_colors
