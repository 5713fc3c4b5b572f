// Each wrong or damaged rig is refused with the file's name and the node or field, and none crashes the reader.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>

#include "formats/common/errors.h"
#include "formats/source/source_readers.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::test_rig_hostile {
namespace {

using nlohmann::json;
using samples::EditableGlb;
using testing::HasSubstr;

std::filesystem::path scratch(const std::string& name) {
    return std::filesystem::path(testing::TempDir()) / ("penumbra_rig_" + name);
}

// Returns what reading `bytes` as NAME.glb says. The test fails where it is read, or refused with something else than
// Error.
template <class Error = InvalidInput>
std::string refusal(const std::string& bytes, const std::string& name) {
    const std::filesystem::path path = scratch(name + ".glb");
    samples::writeText(path, bytes);
    try {
        readRig({path});
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr(path.string()));
        EXPECT_THAT(error.what(), testing::Not(HasSubstr("\n")));
        return error.what();
    } catch (const std::exception& error) {
        ADD_FAILURE() << name << ": another kind of error: " << error.what();
        return {};
    }
    ADD_FAILURE() << name << " was read";
    return {};
}

template <class T>
void store(EditableGlb& glb, int accessor, std::size_t index, T value) {
    std::memcpy(&glb.binary[glb.offsetOf(accessor) + index * sizeof(T)], &value, sizeof(T));
}

struct Case {
    std::string name;
    std::function<void(EditableGlb&)> damage;
    std::vector<std::string> message;
};

json& positions(EditableGlb& glb) { return glb.json["accessors"][glb.attributes()["POSITION"].get<std::size_t>()]; }
int samplerInput(const EditableGlb& glb) { return glb.json["animations"][0]["samplers"][0]["input"]; }
int samplerOutput(const EditableGlb& glb) { return glb.json["animations"][0]["samplers"][0]["output"]; }

// The sample is a tube (nodes "lower", "upper", "tube") with one clip, "swing", and weights as normalised ushorts.
const std::vector<Case> kMeshCases = {
    {"nan_position",
     [](EditableGlb& g) { store(g, g.attributes()["POSITION"], 4, std::numeric_limits<float>::quiet_NaN()); },
     {"node 'tube'", "POSITION", "not finite"}},
    {"index_out_of_range",
     [](EditableGlb& g) { store(g, g.json["meshes"][0]["primitives"][0]["indices"], 7, std::uint16_t(74)); },
     {"node 'tube'", "index 74 of 74"}},
    {"weights_missing", [](EditableGlb& g) { g.attributes().erase("WEIGHTS_0"); }, {"node 'tube'", "WEIGHTS_0"}},
    {"skin_without_attributes",
     [](EditableGlb& g) {
         g.attributes().erase("WEIGHTS_0");
         g.attributes().erase("JOINTS_0");
     },
     {"node 'tube'", "no JOINTS_0 and WEIGHTS_0"}},
    {"joint_out_of_range",
     [](EditableGlb& g) { store(g, g.attributes()["JOINTS_0"], 5, std::uint32_t(0x02020202)); },
     {"node 'tube'", "vertex 5", "joint 2 of 2"}},
    {"position_missing", [](EditableGlb& g) { g.attributes().erase("POSITION"); }, {"node 'tube'", "POSITION"}},
    {"position_of_two", [](EditableGlb& g) { positions(g)["type"] = "VEC2"; }, {"node 'tube'", "POSITION"}},
    {"points_only", [](EditableGlb& g) { g.json["meshes"][0]["primitives"][0]["mode"] = 0; }, {"no triangles"}},
    {"mode_unknown", [](EditableGlb& g) { g.json["meshes"][0]["primitives"][0]["mode"] = 7; }, {"node 'tube'", "mode"}},
    {"one_vertex",
     [](EditableGlb& g) {
         g.json["meshes"][0]["primitives"][0].erase("indices");
         for (const auto& a : g.attributes()) g.json["accessors"][a.get<std::size_t>()]["count"] = 1;
     },
     {"node 'tube'", "multiple of 3"}},
    {"one_vertex_thrice",
     [](EditableGlb& g) {
         json& primitive = g.json["meshes"][0]["primitives"][0];
         for (std::size_t i = 0; i < 3; ++i) store(g, primitive["indices"], i, std::uint16_t(0));
         g.json["accessors"][primitive["indices"].get<std::size_t>()]["count"] = 3;
         for (const auto& a : g.attributes()) g.json["accessors"][a.get<std::size_t>()]["count"] = 1;
     },
     {"at one place"}},
    {"no_area",
     [](EditableGlb& g) {
         for (std::size_t i = 0; i < 432; ++i)
             store(g, g.json["meshes"][0]["primitives"][0]["indices"], i, std::uint16_t(i % 2));
     },
     {"no triangle with an area"}},
    {"mesh_missing", [](EditableGlb& g) { g.json["nodes"][2]["mesh"] = 9; }, {"node 'tube'", "mesh"}},
    {"skin_missing", [](EditableGlb& g) { g.json["nodes"][2]["skin"] = 9; }, {"node 'tube'", "skin"}},
    {"skin_of_no_node", [](EditableGlb& g) { g.json["skins"][0]["joints"][1] = 99; }, {"skin 0", "node 99"}},
    {"few_bind_matrices", [](EditableGlb& g) { g.json["skins"][0]["joints"].push_back(2); }, {"skin 0", "fewer"}},
    {"accessor_too_long", [](EditableGlb& g) { positions(g)["count"] = 75; }, {"POSITION", "beyond"}},
    {"accessor_huge", [](EditableGlb& g) { positions(g)["count"] = 4294967295u; }, {"POSITION", "beyond"}},
    {"accessor_huge_without_data",
     [](EditableGlb& g) {
         positions(g)["count"] = 4000000000u;
         positions(g).erase("bufferView");
     },
     {"POSITION", "too many"}},
    {"view_too_long", [](EditableGlb& g) { g.json["bufferViews"][0]["byteLength"] = 1 << 20; }, {"buffer view 0"}},
    {"view_offset_wraps",
     [](EditableGlb& g) { g.json["bufferViews"][0]["byteOffset"] = 0xFFFFFFFFFFFFFFF0u; },
     {"buffer view 0"}},
    {"buffer_too_long",
     [](EditableGlb& g) { g.json["buffers"][0]["byteLength"] = 1 << 20; },
     {"buffer 0", "cut short"}},
    {"view_of_no_buffer",
     [](EditableGlb& g) { g.json["bufferViews"][0]["buffer"] = 3; },
     {"buffer view 0", "buffer 3"}},
};

const std::vector<Case> kSceneCases = {
    {"node_cycle", [](EditableGlb& g) { g.json["nodes"][1]["children"] = {0}; }, {"node 'lower'", "its own ancestor"}},
    {"node_in_itself", [](EditableGlb& g) { g.json["nodes"][2]["children"] = {2}; }, {"node 'tube'"}},
    {"two_parents", [](EditableGlb& g) { g.json["nodes"][2]["children"] = {1}; }, {"'upper'", "two parents"}},
    {"child_missing", [](EditableGlb& g) { g.json["nodes"][2]["children"] = {77}; }, {"node 'tube'", "child"}},
    {"scene_missing", [](EditableGlb& g) { g.json["scene"] = 4; }, {"scene 4"}},
    {"scene_of_no_node", [](EditableGlb& g) { g.json["scenes"][0]["nodes"] = {99}; }, {"scene"}},
    {"rotation_of_three",
     [](EditableGlb& g) {
         g.json["nodes"][1]["rotation"] = {0, 0, 1};
     },
     {"node 'upper'", "rotation"}},
    {"rotation_zero",
     [](EditableGlb& g) {
         g.json["nodes"][1]["rotation"] = {0, 0, 0, 0};
     },
     {"node 'upper'", "rotation"}},
    {"matrix_not_affine",
     [](EditableGlb& g) { g.json["nodes"][2]["matrix"] = {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; },
     {"node 'tube'", "affine"}},
    {"overflowing_scale",
     [](EditableGlb& g) {
         g.json["nodes"][0]["scale"] = {1e25, 1e25, 1e25};
         g.json["nodes"][1]["scale"] = {1e25, 1e25, 1e25};
     },
     {"node 'upper'", "not finite"}},
    {"clip_without_keys",
     [](EditableGlb& g) { g.json["accessors"][std::size_t(samplerInput(g))]["count"] = 0; },
     {"clip 'swing'", "node 'upper'", "empty"}},
    {"fewer_values_than_keys",
     [](EditableGlb& g) { g.json["accessors"][std::size_t(samplerOutput(g))]["count"] = 5; },
     {"clip 'swing'", "node 'upper'", "do not fit"}},
    {"keys_out_of_order", [](EditableGlb& g) { store(g, samplerInput(g), 2, 0.1f); }, {"clip 'swing'", "key 2"}},
    {"key_nan",
     [](EditableGlb& g) { store(g, samplerOutput(g), 9, std::numeric_limits<float>::infinity()); },
     {"clip 'swing'", "node 'upper'", "not finite"}},
    {"key_quaternion_zero",
     [](EditableGlb& g) {
         for (std::size_t i = 8; i < 12; ++i) store(g, samplerOutput(g), i, 0.f);
     },
     {"clip 'swing'", "node 'upper'", "key 2"}},
    {"sampler_missing", [](EditableGlb& g) { g.json["animations"][0]["channels"][0]["sampler"] = 8; }, {"'upper'"}},
    {"target_missing", [](EditableGlb& g) { g.json["animations"][0]["channels"][0]["target"]["node"] = 8; }, {"swing"}},
    {"path_unknown",
     [](EditableGlb& g) { g.json["animations"][0]["channels"][0]["target"]["path"] = "colour"; },
     {"clip 'swing'", "colour"}},
    {"interpolation_unknown",
     [](EditableGlb& g) { g.json["animations"][0]["samplers"][0]["interpolation"] = "BEZIER"; },
     {"clip 'swing'", "BEZIER"}},
    {"nodes_of_wrong_type", [](EditableGlb& g) { g.json["nodes"] = 5; }, {""}},
    {"asset_missing", [](EditableGlb& g) { g.json.erase("asset"); }, {"not valid glTF"}},
};

TEST(RigHostile, WrongMeshesNameTheFileAndTheNode) {
    for (const Case& c : kMeshCases) {
        EditableGlb glb = EditableGlb::of("weights_u16");
        c.damage(glb);
        const std::string message = refusal(glb.bytes(), c.name);
        for (const std::string& part : c.message) EXPECT_THAT(message, HasSubstr(part)) << c.name;
    }
}

TEST(RigHostile, WrongScenesAndClipsNameTheFileAndTheNode) {
    for (const Case& c : kSceneCases) {
        EditableGlb glb = EditableGlb::of("weights_u16");
        c.damage(glb);
        const std::string message = refusal(glb.bytes(), c.name);
        for (const std::string& part : c.message) EXPECT_THAT(message, HasSubstr(part)) << c.name;
    }
}

// Returns the rig, and in `notes` what is said of it.
Rig readChanged(const std::function<void(EditableGlb&)>& change, std::string& notes) {
    EditableGlb glb = EditableGlb::of("weights_u16");
    change(glb);
    samples::writeText(scratch("odd.glb"), glb.bytes());
    Rig rig = readRig({scratch("odd.glb")});
    notes.clear();
    for (const RigNote& note : rig.notes) notes += textOf(note) + "\n";
    return rig;
}

// Others read these files. So do we, and say what is odd.
TEST(RigHostile, OddClipsAndMatricesAreReadAndSaid) {
    std::string notes;
    const auto clipOf = [&](const std::function<void(EditableGlb&)>& change) {
        const Rig rig = readChanged(change, notes);
        EXPECT_EQ(rig.clips.size(), 1u);
        return rig.clips.at(0);
    };
    const Clip whole = clipOf([](EditableGlb&) {});
    EXPECT_EQ(notes, "");
    const Clip early = clipOf([](EditableGlb& g) { store(g, samplerInput(g), 0, -0.1f); });
    EXPECT_THAT(notes, HasSubstr("clip 'swing': begins at -0.1 s, its keys are moved to begin at 0 s"));
    EXPECT_EQ(early.channels[0].times[0], 0);
    EXPECT_FLOAT_EQ(float(early.duration), float(whole.duration + 0.1f));
    const Clip jump =
        clipOf([](EditableGlb& g) { store(g, samplerInput(g), 2, 0.0f), store(g, samplerInput(g), 1, 0.0f); });
    EXPECT_THAT(notes, HasSubstr("clip 'swing': has two keys at one time"));
    EXPECT_EQ(jump.channels[0].times.size(), whole.channels[0].times.size() - 2);
    EXPECT_EQ(jump.channels[0].values[0], whole.channels[0].values[8]);
    clipOf([](EditableGlb& g) {
        g.json["animations"].push_back({{"name", "none"}, {"channels", json::array()}, {"samplers", json::array()}});
    });
    EXPECT_THAT(notes, HasSubstr("clip 'none': has no channel, left out"));
    const auto matrix = [](double shear) {
        return [=](EditableGlb& g) {
            const json at = g.json["nodes"][1]["translation"];
            g.json["nodes"][1].erase("translation");
            g.json["nodes"][1]["matrix"] = {1, 0, 0, 0, shear, 1, 0, 0, 0, 0, 1, 0, at[0], at[1], at[2], 1};
        };
    };
    EXPECT_EQ(clipOf(matrix(0)).channels[0].values, whole.channels[0].values);
    EditableGlb sheared = EditableGlb::of("weights_u16");
    matrix(.5)(sheared);
    EXPECT_THAT(refusal(sheared.bytes(), "shear"), HasSubstr("node 'upper': has a matrix with shear"));
}

TEST(RigHostile, ASparseIndexOutOfRangeIsRefused) {
    EditableGlb glb = EditableGlb::of("sparse");
    const std::size_t view = positions(glb)["sparse"]["indices"]["bufferView"];
    const std::uint16_t beyond = positions(glb)["count"];
    std::memcpy(&glb.binary[glb.json["bufferViews"][view].value("byteOffset", std::size_t(0))], &beyond, 2);
    EXPECT_THAT(refusal(glb.bytes(), "sparse_index"), HasSubstr("POSITION: has a sparse index out of range"));
}

TEST(RigHostile, RequiredExtensionsThatWeLackAreNamed) {
    EditableGlb glb = EditableGlb::of("weights_u16");
    glb.json["extensionsRequired"] = {"KHR_mesh_quantization", "KHR_materials_unlit", "KHR_draco_mesh_compression"};
    EXPECT_THAT(refusal<Unsupported>(glb.bytes(), "draco"), HasSubstr("KHR_draco_mesh_compression"));
    glb.json["extensionsRequired"] = {"KHR_mesh_quantization", "KHR_materials_unlit"};
    samples::writeText(scratch("harmless.glb"), glb.bytes());
    EXPECT_NO_THROW(readRig({scratch("harmless.glb")}));
    glb.json["asset"]["version"] = "1.0";
    EXPECT_THAT(refusal<Unsupported>(glb.bytes(), "version"), HasSubstr("1.0"));
    glb.json["asset"] = {{"version", "2.1"}, {"minVersion", "2.1"}};
    EXPECT_THAT(refusal<Unsupported>(glb.bytes(), "version"), HasSubstr("asks for a reader of glTF 2.1"));
}

// The library passes over such an index, and with it over what it names.
TEST(RigHostile, IndicesThatAreNoWholeNumbers) {
    const EditableGlb whole = EditableGlb::of("weights_u16");
    const auto said = [&](const std::string& pointer) {
        EditableGlb glb = whole;
        glb.json[nlohmann::json::json_pointer(pointer)] = "0";
        return refusal(glb.bytes(), "index");
    };
    std::size_t node = 0;
    while (!whole.json["nodes"][node].contains("mesh")) ++node;
    const std::string drawn = "/nodes/" + std::to_string(node);
    EXPECT_THAT(said(drawn + "/mesh"), HasSubstr("]: mesh is \"0\", no whole number"));
    EXPECT_THAT(said(drawn + "/skin"), HasSubstr("]: skin is \"0\", no whole number"));
    EXPECT_THAT(said("/meshes/0/primitives/0/indices"), HasSubstr("meshes[0]: a primitive: indices is \"0\""));
    EXPECT_THAT(said("/meshes/0/primitives/0/material"), HasSubstr("meshes[0]: a primitive: material is \"0\""));
    EXPECT_THAT(said("/meshes/0/primitives/0/mode"), HasSubstr("meshes[0]: a primitive: mode is \"0\""));
}

TEST(RigHostile, EveryTruncationIsRefused) {
    const std::string whole = samples::readText(samples::samplePath("weights_u16"));
    for (std::size_t n = 0; n < whole.size(); n += n < 64 ? 1 : 37) refusal(whole.substr(0, n), "cut");
    // Now the header claims the cut length, so that the chunks do not fit, or the buffer is short.
    for (std::size_t n = 20; n < whole.size(); n += 53) {
        std::string cut = whole.substr(0, n);
        const std::uint32_t length = std::uint32_t(n);
        std::memcpy(&cut[8], &length, 4);
        refusal(cut, "cut_with_length");
    }
}

TEST(RigHostile, NestingAndNonsenseInJson) {
    EditableGlb glb = EditableGlb::of("weights_u16");
    std::string deep = std::string(100000, '[') + std::string(100000, ']');
    std::string text = glb.json.dump();
    text.insert(1, "\"extras\":" + deep + ",");
    samples::writeText(scratch("deep.gltf"), text);
    EXPECT_THROW(readRig({scratch("deep.gltf")}), InvalidInput);
    for (const char* nonsense : {"[]", "3", "{}", "{\"asset\":3}", "{\"asset\":{\"version\":\"2.0\"}}", "{\"asset\""}) {
        samples::writeText(scratch("nonsense.gltf"), nonsense);
        EXPECT_THROW(readRig({scratch("nonsense.gltf")}), InvalidInput) << nonsense;
    }
}

TEST(RigHostile, ZeroAreaTrianglesAreDroppedAndTheRestIsKept) {
    EditableGlb glb = EditableGlb::of("weights_u16");
    for (std::size_t i = 0; i < 3; ++i)
        store(glb, glb.json["meshes"][0]["primitives"][0]["indices"], i, std::uint16_t(5));
    samples::writeText(scratch("sliver.glb"), glb.bytes());
    const Rig rig = readRig({scratch("sliver.glb")});
    EXPECT_EQ(rig.mesh.triangles.size(), 143u);
    EXPECT_EQ(rig.mesh.vertexCount(), 74u);
}

std::string base64Of(const std::string& bytes) {
    const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : digits[bits >> (18 - 6 * k) & 63];
    }
    return text;
}

std::string percentEncoded(const std::string& bytes) {
    std::string text;
    for (const char c : bytes) {
        char code[4];
        std::snprintf(code, sizeof code, "%%%02X", unsigned(std::uint8_t(c)));
        text += code;
    }
    return text;
}

// The buffer of a .gltf stands beside it, in a name with a blank, and in a data URI.
TEST(RigGltf, BuffersBesideTheFileAndInside) {
    EditableGlb glb = EditableGlb::of("weights_u16");
    const Rig expected = samples::readSample("weights_u16");
    samples::writeText(scratch("a buffer.bin"), glb.binary);
    glb.json["buffers"][0]["uri"] = "penumbra_rig_a%20buffer.bin";
    samples::writeText(scratch("beside.gltf"), glb.json.dump());
    const Rig beside = readRig({scratch("beside.gltf")});
    EXPECT_EQ(beside.mesh.rest_positions, expected.mesh.rest_positions);
    EXPECT_THAT(beside.files_read, testing::ElementsAre(scratch("beside.gltf"), scratch("a buffer.bin")));

    glb.json["buffers"][0]["uri"] = "nowhere.bin";
    samples::writeText(scratch("nowhere.gltf"), glb.json.dump());
    EXPECT_THROW(readRig({scratch("nowhere.gltf")}), IoError);
    glb.json["buffers"][0]["uri"] = "https://example.org/a.bin";
    samples::writeText(scratch("remote.gltf"), glb.json.dump());
    EXPECT_THROW(readRig({scratch("remote.gltf")}), Unsupported);
    for (const char* head : {"data:;base64,", "data:model/gltf-buffer;charset=x;base64,", "data:base64,", "data:,"}) {
        const bool plain = std::string(head) == "data:,";
        glb.json["buffers"][0]["uri"] = head + (plain ? percentEncoded(glb.binary) : base64Of(glb.binary));
        samples::writeText(scratch("inside.gltf"), glb.json.dump());
        EXPECT_EQ(readRig({scratch("inside.gltf")}).mesh.rest_positions, expected.mesh.rest_positions) << head;
    }
    for (const char* damaged : {"data:;base64", "data:;base64,A=A", "data:;base64,*"}) {
        glb.json["buffers"][0]["uri"] = damaged;
        samples::writeText(scratch("damaged.gltf"), glb.json.dump());
        EXPECT_THROW(readRig({scratch("damaged.gltf")}), InvalidInput) << damaged;
    }
    glb.json["buffers"][0]["uri"] = "data:application/octet-stream;base64,AAAA";
    samples::writeText(scratch("short.gltf"), glb.json.dump());
    EXPECT_THROW(readRig({scratch("short.gltf")}), InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_rig_hostile
