// Collada is rewritten so that assimp reads it as it is meant.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "formats/common/errors.h"
#include "formats/rig/assimp/collada_text.h"
#include "formats/rig/assimp/xml_tree.h"
#include "formats/source/source_readers.h"
#include "tests/formats/rig_samples.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_collada_text {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(XmlTree, ComesBackWithoutBlanksAndComments) {
    const std::string text =
        "<?xml version=\"1.0\"?>\n<!-- a --><a x='1' y=\"'&lt;\">\n <b>\n  1 2\t</b><!-- c --> <c/>\n</a >";
    const std::optional<XmlNode> root = parseXml(text);
    ASSERT_TRUE(root);
    EXPECT_THAT(textOf(*root), testing::EndsWith("\n<a x=\"1\" y=\"'&lt;\"><b>1 2</b><c/></a>"));
    for (std::size_t n = 0; n < text.size() - 1; ++n) EXPECT_FALSE(parseXml(std::string(text.data(), n))) << n;
    std::string deep;
    for (int i = 0; i < 100000; ++i) deep += "<a>";
    EXPECT_FALSE(parseXml(deep));
}

std::string arrayOf(const char* id, const char* kind, const std::string& list, int stride = 1) {
    const int count = int(std::count(list.begin(), list.end(), ' ')) + 1;
    return "<source id=\"" + std::string(id) + "\"><" + kind + " id=\"" + id + "-a\" count=\"" + std::to_string(count) +
           "\">" + list + "</" + kind + "><technique_common><accessor source=\"#" + id + "-a\" count=\"" +
           std::to_string(count / stride) + "\" stride=\"" + std::to_string(stride) +
           "\"><param name=\"ANGLE\" type=\"float\"/></accessor></technique_common></source>";
}

std::string animation(const std::string& kinds, const std::string& tangents = "") {
    std::string text = "<animation id=\"swing\">" + arrayOf("i", "float_array", "0 1") +
                       arrayOf("o", "float_array", "0 90") + arrayOf("n", "Name_array", kinds);
    std::string inputs;
    if (!tangents.empty()) {
        text += arrayOf("it", "float_array", "-0.5 0 0.5 90", 2) + arrayOf("ot", "float_array", tangents, 2);
        inputs = "<input semantic=\"IN_TANGENT\" source=\"#it\"/><input semantic=\"OUT_TANGENT\" source=\"#ot\"/>";
    }
    return "<COLLADA><library_animations>" + text +
           "<sampler id=\"s\"><input semantic=\"INPUT\" source=\"#i\"/><input semantic=\"OUTPUT\" "
           "source=\"#o\"/><input semantic=\"INTERPOLATION\" source=\"#n\"/>" +
           inputs +
           "</sampler><channel source=\"#s\" target=\"arm/r.ANGLE\"/></animation></library_animations></COLLADA>";
}

// Returns the numbers of the source that the sampler now names.
std::vector<double> numbersOf(const std::string& text, const char* what) {
    const std::string id = "penumbra-0-" + std::string(what) + "-array\"";
    const std::size_t at = text.find('>', text.find("id=\"" + id)) + 1;
    std::istringstream in(text.substr(at, text.find('<', at) - at));
    return {std::istream_iterator<double>(in), {}};
}

TEST(ColladaText, BezierCurvesAreSampled) {
    // Control points at a half: x = 1.5 u (1-u) + u^3 ... here the closed form of times 0, 0.5, 0.5, 1 and values 0, 0,
    // 90, 90 is asked at u = 1/2, where both are in their middle.
    const std::string text = prepareCollada(animation("BEZIER BEZIER", "0.5 0 1.5 90"), "a.dae").text;
    const std::vector<double> times = numbersOf(text, "input"), values = numbersOf(text, "output");
    ASSERT_EQ(times.size(), 61u);
    ASSERT_EQ(values.size(), 61u);
    for (std::size_t k = 0; k < times.size(); ++k) {
        EXPECT_NEAR(times[k], double(k) / 60, 1e-12);
        double low = 0, high = 1;  // u of the time, by bisection of t = 1.5 u (1-u)^2 + 1.5 u^2 (1-u) + u^3
        for (int i = 0; i < 60; ++i) {
            const double u = (low + high) / 2;
            (1.5 * u * (1 - u) + u * u * u < times[k] ? low : high) = u;
        }
        EXPECT_NEAR(values[k], 90 * (3 * low * low - 2 * low * low * low), 1e-9);
    }
}

// A turn of 360 degrees between two keys is one, and not none.
TEST(ColladaText, AnglesHaveKeysOnTheirWay) {
    std::string xml = animation("LINEAR LINEAR");
    const std::string text = prepareCollada(xml, "a.dae").text;
    const std::vector<double> times = numbersOf(text, "input"), values = numbersOf(text, "output");
    ASSERT_EQ(times.size(), 61u);
    ASSERT_EQ(values.size(), 61u);
    for (std::size_t k = 0; k < times.size(); ++k) EXPECT_NEAR(values[k], 90 * times[k], 1e-12);
    xml.replace(xml.find("arm/r.ANGLE"), 11, "arm/t.X");
    EXPECT_EQ(numbersOf(prepareCollada(xml, "a.dae").text, "input").size(), 0u);
}

TEST(ColladaText, StepsHoldTheirValue) {
    const std::string text = prepareCollada(animation("STEP STEP"), "a.dae").text;
    EXPECT_THAT(numbersOf(text, "input"), ElementsAre(0, 0.9999, 1));
    EXPECT_THAT(numbersOf(text, "output"), ElementsAre(0, 0, 90));
}

TEST(ColladaText, OtherCurvesAreRefusedByName) {
    try {
        prepareCollada(animation("HERMITE HERMITE", "0 0 0 0"), "a.dae");
        ADD_FAILURE() << "it was read";
    } catch (const Unsupported& error) {
        EXPECT_STREQ(error.what(), "a.dae: animation 'swing': HERMITE curves are not read: export it baked");
    }
    EXPECT_THROW(prepareCollada(animation("BEZIER BEZIER"), "a.dae"), InvalidInput);
    EXPECT_THROW(prepareCollada(animation("BEZIER"), "a.dae"), InvalidInput);
}

// --- Files ----------------------------------------------------------------------------------------------------------

std::string swing() { return samples::readText(samples::samplePath("swing").replace_extension(".dae")); }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

struct ColladaFile : testing::Test {
    samples::Folder folder{"collada"};
    std::filesystem::path dae = folder.path / "a.dae";
    Rig readText(const std::string& text) {
        samples::writeText(dae, text);
        return readRig({dae});
    }
};

TEST_F(ColladaFile, BlanksAroundListsChangeNothing) {
    const Rig plain = readText(swing());
    std::string text = swing();
    for (const char* list : {"<v>", "<vcount>", "<p>"}) text = replaced(text, list, std::string(list) + "\n    ");
    const Rig blanks = readText(text);
    EXPECT_EQ(plain.mesh.rest_positions.size(), blanks.mesh.rest_positions.size());
    EXPECT_EQ(plain.skin.weights, blanks.skin.weights);
    EXPECT_EQ(plain.mesh.triangles, blanks.mesh.triangles);
}

TEST_F(ColladaFile, ClipsAreThoseOfTheFile) {
    const std::string text = swing();
    const std::size_t at = text.find("<animation id=\"") + 15;
    ASSERT_LT(at, text.size());
    const std::string id = text.substr(at, text.find('"', at) - at);
    const auto clip = [&](const std::string& name, const std::string& times) {
        return "<animation_clip id=\"" + name + "\" " + times + "><instance_animation url=\"#" + id +
               "\"/></animation_clip>";
    };
    const Rig rig =
        readText(replaced(text, "</COLLADA>",
                          "<library_animation_clips>" + clip("first", "start=\"0\" end=\"0.25\"") +
                              clip("rest of it", "start=\"0.25\"") + "</library_animation_clips></COLLADA>"));
    ASSERT_EQ(rig.clips.size(), 2u);
    EXPECT_EQ(rig.clips[0].name, "first");
    EXPECT_NEAR(rig.clips[0].duration, 0.25, 1e-6);
    EXPECT_EQ(rig.clips[1].name, "rest of it");
    const Rig whole = readText(text);
    EXPECT_NEAR(rig.clips[1].duration, whole.clips[0].duration - 0.25, 1e-6);
    EXPECT_THROW(readText(replaced(text, "</COLLADA>",
                                   "<library_animation_clips><animation_clip id=\"a\"><instance_animation "
                                   "url=\"#none\"/></animation_clip></library_animation_clips></COLLADA>")),
                 InvalidInput);
}

TEST_F(ColladaFile, ASkinOverMorphTargetsIsReadAndSaid) {
    const std::string text = swing();
    const std::size_t at = text.find("<skin source=\"") + 14;
    const std::string mesh = text.substr(at, text.find('"', at) - at);
    std::string over = replaced(text, "<skin source=\"" + mesh + "\"", "<skin source=\"#mo\"");
    over = replaced(over, "<library_controllers>",
                    "<library_controllers><controller id=\"mo\"><morph source=\"" + mesh +
                        "\" method=\"NORMALIZED\"></morph></controller>");
    const Rig rig = readText(over);
    EXPECT_EQ(rig.mesh.triangles.size(), readText(text).mesh.triangles.size());
    ASSERT_EQ(rig.notes.size(), 1u);
    EXPECT_EQ(rig.notes[0].feature, "morph targets under a skin");
}

// A triangle with a material. `shader` stands in its shader, `beside` in its effect, `mesh` in its mesh and `extra` in
// its geometry.
struct ColladaParts {
    std::string shader = "", beside = "", mesh = "", extra = "";
};

std::string triangleText(const ColladaParts& parts) {
    return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_images><image id="img"><init_from>leaf.png</init_from></image></library_images>
<library_effects><effect id="fx"><profile_COMMON>
<newparam sid="s"><surface type="2D"><init_from>img</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="c"><lambert><diffuse><texture texture="t" texcoord="UV"/></diffuse>)" +
           parts.shader + "</lambert></technique></profile_COMMON>" + parts.beside +
           R"(</effect></library_effects>
<library_materials><material id="m" name="leaf"><instance_effect url="#fx"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/>
</vertices><triangles count="1" material="m"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>)" +
           parts.mesh + "</mesh>" + parts.extra + R"(</geometry></library_geometries>
<library_visual_scenes><visual_scene id="sc"><node id="n" name="n"><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="m" target="#m"/></technique_common></bind_material></instance_geometry>
</node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#sc"/></scene></COLLADA>)";
}

TEST_F(ColladaFile, TransparencyIsRead) {
    const auto materialOf = [&](const std::string& shader) {
        return readText(triangleText({.shader = shader})).part_colors.at(0).color.material;
    };
    EXPECT_EQ(materialOf("").alpha_mode, AlphaMode::kOpaque);
    const std::string share = "<transparency><float>0.4</float></transparency>";
    const MaterialColor one = materialOf("<transparent opaque=\"A_ONE\"><color>1 1 1 1</color></transparent>" + share);
    EXPECT_EQ(one.alpha_mode, AlphaMode::kBlend);
    EXPECT_FLOAT_EQ(one.alpha, 0.4f);
    const MaterialColor zero =
        materialOf("<transparent opaque=\"RGB_ZERO\"><color>0.25 0.25 0.25 1</color></transparent>");
    EXPECT_FLOAT_EQ(zero.alpha, 0.75f);
    const std::string picture = "<texture texture=\"t\" texcoord=\"UV\"/></transparent>";
    EXPECT_EQ(materialOf("<transparent opaque=\"A_ONE\">" + picture).alpha_mode, AlphaMode::kBlend);
    const Rig unread = readText(triangleText({.shader = "<transparent opaque=\"RGB_ZERO\">" + picture}));
    EXPECT_EQ(unread.part_colors.at(0).color.material.alpha_mode, AlphaMode::kOpaque);
    ASSERT_EQ(unread.notes.size(), 1u);
    EXPECT_EQ(unread.notes[0].feature, "transparency of effect 'fx'");
}

TEST_F(ColladaFile, SidesAndLinesAreReadOrSaid) {
    const std::string extra = "<extra><technique profile=\"MAX3D\"><double_sided>1</double_sided></technique></extra>";
    const Rig effect = readText(triangleText({.beside = extra}));
    EXPECT_TRUE(effect.part_colors.at(0).color.material.double_sided);
    EXPECT_TRUE(effect.notes.empty());
    const Rig mesh = readText(triangleText({.extra = extra}));
    EXPECT_FALSE(mesh.part_colors.at(0).color.material.double_sided);
    ASSERT_EQ(mesh.notes.size(), 1u);
    EXPECT_EQ(mesh.notes[0].feature, "double_sided of a mesh");
    const Rig lines = readText(triangleText(
        {.mesh = "<lines count=\"1\" material=\"m\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>"
                 "<p>0 1</p></lines>"}));
    EXPECT_EQ(lines.mesh.triangles.size(), 1u);
    ASSERT_EQ(lines.notes.size(), 1u);
    EXPECT_EQ(lines.notes[0].feature, "points or lines");
}

}  // namespace
}  // namespace penumbra::test_collada_text
